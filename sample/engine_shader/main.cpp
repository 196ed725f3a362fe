// Draws a head with hair by an engine's own shaders.
// Usage: pelage-engine-shader FILE.png [vulkan|gl|gles]
#include <cstdio>
#include <string>
#include <string_view>

#include "device.h"
#include "engine_picture.h"
#include "image.h"
#include "png_file.h"

namespace {

int fail(const std::string& why) {
  std::fprintf(stderr, "pelage-engine-shader: error: %s\n", why.c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string usage = "usage: pelage-engine-shader FILE.png [vulkan|gl|gles]";
  if (argc == 2 && std::string_view(argv[1]) == "--help") return std::puts(usage.c_str()) < 0;
  if (argc < 2 || argc > 3 || argv[1][0] == '-') return fail(usage);
  const auto api = sample::parseApi(argc > 2 ? argv[2] : "vulkan");
  if (!api) return fail(usage);
  pelage::HeadlessDef deviceDef;
  deviceDef.api = *api;
  const auto device = sample::createDevice(deviceDef);
  if (!device) return fail(device.error().message);
  auto image = engine_shader::drawPicture(**device, {});
  if (!image) return fail(image.error().message);
  sample::compositeOver(*image, {});
  const auto written = sample::writePng(argv[1], sample::encodeSrgb(*image));
  if (!written) return fail(written.error().message);
}
