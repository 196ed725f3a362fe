// Lists every parameter, writes its page, and renders its pictures.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "device.h"
#include "image.h"
#include "palette_png.h"
#include "table.h"

namespace sample {

namespace {

using pelage::Error;
using pelage::ErrorCode;
using pelage::Result;

constexpr uint32_t kSize = 160;  // pixels of a picture's edge
constexpr uint32_t kGap = 4;     // pixels between pictures

struct Options {
  bool list = false, quiet = false;
  std::string page, pictures, only, api = "gl";
  int device = -1;
};

// Puts a picture beside those that are there.
void append(ByteImage& strip, const ByteImage& picture) {
  const uint32_t left = strip.width == 0 ? 0 : strip.width + kGap;
  ByteImage wider;
  wider.width = left + picture.width;
  wider.height = picture.height;
  wider.rgb.assign(size_t{wider.width} * wider.height * 3, 255);
  const auto copy = [&](const ByteImage& from, uint32_t x) {
    for (uint32_t y = 0; y < from.height; ++y)
      std::copy_n(from.rgb.begin() + static_cast<ptrdiff_t>(y) * from.width * 3, from.width * 3,
                  wider.rgb.begin() + (static_cast<ptrdiff_t>(y) * wider.width + x) * 3);
  };
  copy(strip, 0);
  copy(picture, left);
  strip = std::move(wider);
}

Result<void> renderStrip(const pelage::HeadlessDef& def, const Parameter& parameter,
                         const std::filesystem::path& folder) {
  ByteImage strip;
  for (size_t i = 0; i < parameter.picture->values.size(); ++i) {
    const auto image = render(def, parameter.picture->make(i), kSize);
    if (!image)
      return Error{image.error().code,
                   fmt::format("{}.{} = {}: {}", parameter.owner, parameter.field,
                               parameter.picture->values[i], image.error().message)};
    append(strip, encodeSrgb(*image));
  }
  return writePalettePng((folder / pictureFile(parameter)).string(), strip);
}

Result<void> renderAll(const Options& options) {
  pelage::HeadlessDef def;
  const auto api = parseApi(options.api);
  if (!api) return Error{ErrorCode::kInvalidArgument, "--api takes vulkan, gl or gles"};
  def.api = *api;
  def.deviceIndex = options.device;
  std::error_code failed;
  std::filesystem::create_directories(options.pictures, failed);
  if (failed) return Error{ErrorCode::kFileNotFound, options.pictures + ": " + failed.message()};

  std::vector<const Parameter*> wanted;
  for (const ParameterGroup& group : parameterTable())
    for (const Parameter& p : group.parameters)
      if (p.picture && (p.owner + "." + p.field).find(options.only) != std::string::npos)
        wanted.push_back(&p);
  if (wanted.empty())
    return Error{ErrorCode::kInvalidArgument, "no pictured parameter has '" + options.only + "'"};
  const bool terminal = isatty(STDOUT_FILENO) == 1;
  for (size_t i = 0; i < wanted.size(); ++i) {
    if (!options.quiet) {
      fmt::print("{}{}/{} {}.{}{}", terminal ? "\r\033[K" : "", i + 1, wanted.size(),
                 wanted[i]->owner, wanted[i]->field, terminal ? "" : "\n");
      std::fflush(stdout);
    }
    if (Result<void> done = renderStrip(def, *wanted[i], options.pictures); !done) return done;
  }
  if (!options.quiet && terminal) fmt::print("\n");
  return {};
}

Result<void> run(const Options& options) {
  if (options.list) fmt::print("{}", parameterList());
  if (!options.page.empty()) {
    std::ofstream file(options.page, std::ios::binary);
    file << parameterPage();
    if (!file.flush()) return Error{ErrorCode::kFileNotFound, options.page + ": not written"};
  }
  if (!options.pictures.empty()) return renderAll(options);
  return {};
}

}  // namespace

}  // namespace sample

int main(int argc, char** argv) {
  sample::Options options;
  CLI::App app("Every parameter of hair: a list, the page docs/parameters.md, its pictures.",
               "pelage-parameters");
  app.add_flag("--list", options.list, "print name, unit, range and default");
  app.add_option("--doc", options.page, "write the page")->type_name("FILE.md");
  app.add_option("--pictures", options.pictures, "render the pictures")->type_name("DIR");
  app.add_option("--only", options.only, "pictures of names with this in them")->type_name("TEXT");
  app.add_option("--api", options.api, "gl, gles or vulkan (gl)")->type_name("API");
  app.add_option("--device", options.device, "number of the device, as of pelage-headless")
      ->type_name("N");
  app.add_flag("--quiet", options.quiet, "print errors only");
  CLI11_PARSE(app, argc, argv);
  if (!options.list && options.page.empty() && options.pictures.empty()) {
    fmt::print("{}", app.help());
    return 2;
  }
  if (const auto done = sample::run(options); !done) {
    fmt::print(stderr, "pelage-parameters: error: {}\n", done.error().message);
    return 1;
  }
  return 0;
}
