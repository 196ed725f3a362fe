// Draws the generated character in an engine's own lights.
// Usage: pelage-engine-lights FILE.png [vulkan|gl|gles] [METHOD]
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "device.h"
#include "image.h"
#include "lit_character.h"
#include "png_file.h"

namespace {

using pelage::Transparency;

int fail(const std::string& why) {
  std::fprintf(stderr, "pelage-engine-lights: error: %s\n", why.c_str());
  return 1;
}

std::optional<Transparency> parseMethod(std::string_view name) {
  for (const auto& [known, method] :
       {std::pair("alpha-test", Transparency::kAlphaTest),
        std::pair("stochastic", Transparency::kStochastic),
        std::pair("windowed", Transparency::kWindowed), std::pair("hybrid", Transparency::kHybrid8),
        std::pair("short-cut", Transparency::kShortCut), std::pair("tiles", Transparency::kTiles)})
    if (name == known) return method;
  return std::nullopt;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string usage =
      "usage: pelage-engine-lights FILE.png [vulkan|gl|gles] "
      "[alpha-test|stochastic|windowed|hybrid|short-cut|tiles]";
  if (argc == 2 && std::string_view(argv[1]) == "--help") return std::puts(usage.c_str()) < 0;
  if (argc < 2 || argc > 4 || argv[1][0] == '-') return fail(usage);
  const auto api = sample::parseApi(argc > 2 ? argv[2] : "vulkan");
  const auto method = parseMethod(argc > 3 ? argv[3] : "windowed");
  if (!api || !method) return fail(usage);
  pelage::HeadlessDef deviceDef;
  deviceDef.api = *api;
  const auto device = sample::createDevice(deviceDef);
  if (!device) return fail(device.error().message);
  auto character = engine_lights::LitCharacter::create(**device);
  if (!character) return fail(character.error().message);
  engine_lights::PictureDef def;
  def.method = *method;
  if (*method == Transparency::kStochastic) def.samples = (*device)->info().maxSamples;
  auto image = character->draw(def);
  if (!image) return fail(image.error().message);
  sample::compositeOver(*image, {});
  const auto written = sample::writePng(argv[1], sample::encodeSrgb(*image));
  if (!written) return fail(written.error().message);
}
