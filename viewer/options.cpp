#include "options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <map>

#include "canvas/canvas.h"
#include "program_messages.h"

namespace viewer {

namespace {

constexpr int kBadArguments = 2;
constexpr uint32_t kMaxPictureSize = 16384;

constexpr Choice<pelage::Api> kApis[] = {{"vulkan", pelage::Api::kVulkan},
                                         {"gl", pelage::Api::kGl}};

// Adds an option that takes one of the names; an error lists them.
template <class T, size_t N>
CLI::Option* addChoice(CLI::App& app, const char* option, const char* type, T& value,
                       const Choice<T> (&choices)[N], const std::string& text) {
  std::map<std::string, T> named;
  for (const Choice<T>& choice : choices) named.emplace(choice.name, choice.value);
  return app.add_option(option, value, text)
      ->transform(CLI::CheckedTransformer(named, CLI::ignore_case).description(""))
      ->type_name(type);
}

// "1280x800" -> width and height. Errors: CLI::ValidationError.
void parseSize(const std::string& text, Options& options) {
  const char* end = text.data() + text.size();
  const auto [cross, first] = std::from_chars(text.data(), end, options.screen.width);
  bool ok = first == std::errc() && cross != end && *cross == 'x';
  if (ok) {
    const auto [stop, second] = std::from_chars(cross + 1, end, options.screen.height);
    ok = second == std::errc() && stop == end;
  }
  const auto fits = [](uint32_t size) { return size >= 16 && size <= kMaxPictureSize; };
  if (!ok || !fits(options.screen.width) || !fits(options.screen.height))
    throw CLI::ValidationError(
        "--size", fmt::format("is WIDTHxHEIGHT, each 16..{}, such as 1280x800", kMaxPictureSize));
}

struct Given {
  std::string size, cache = "user";
  pelage::Api api = pelage::Api::kVulkan;
  pelage::Transparency transparency = pelage::Transparency::kWindowed;
  pelage::HairShadow shadow = pelage::HairShadow::kDeep;
  float strandShare = 1;
  uint32_t coarseness = 1;
  pelage::Solver compared = pelage::Solver::kExact;
  CLI::Option *apiOption = nullptr, *presetOption = nullptr, *comparedOption = nullptr,
              *strandsOption = nullptr, *coarseOption = nullptr, *transparencyOption = nullptr,
              *shadowOption = nullptr;
};

void addCaptureOptions(CLI::App& app, Options& options) {
  CLI::Option* frames = app.add_option("--frames", options.captures.frames,
                                       "write a picture of each frame: DIR/00001.png and so on")
                            ->type_name("DIR");
  app.add_option("--video", options.captures.video,
                 "make a video of all frames by ffmpeg, such as a.mp4")
      ->excludes(frames)
      ->type_name("FILE");
  app.add_option("--times", options.captures.times, "write the GPU times of all passes as CSV")
      ->type_name("FILE");
}

void addScreenOptions(CLI::App& app, Options& options, Given& given) {
  app.add_option("FILES", options.source.files,
                 "hair to show: .tfx with .tfxbone, .tfxfollow and .tfxmesh, .pelage, .hair, .obj, "
                 ".gltf, .glb, .hairtxt, .usda (a generated character)");
  given.apiOption = addChoice(app, "--api", "API", given.api, kApis,
                              "vulkan or gl (vulkan, or gl where there is no Vulkan)");
  app.add_option("--device", options.screen.device,
                 "number of the Vulkan device (the fastest kind)")
      ->check(CLI::Range(0, 63).description(""))
      ->type_name("N");
  app.add_flag("--validation", options.screen.validation,
               "check every call of the API; messages make the exit status 1");
  app.add_option("--size", given.size, "of the window (1280x800)")->type_name("WxH");
}

void addSourceOptions(CLI::App& app, Options& options, Given& given) {
  app.add_option("--scale", options.source.scale,
                 "meters per unit of the files (found from the hair's size)")
      ->check(CLI::Range(1e-9f, 1e9f).description(""))
      ->type_name("X");
  app.add_option("--clip", options.source.clip, "animation of a .gltf or .glb file (the first one)")
      ->type_name("NAME");
  given.presetOption = addChoice(app, "--groom", "NAME", options.source.preset, kGrooms,
                                 "a generated head with this hair: " + namesOf(kGrooms));
  addChoice(app, "--motion", "NAME", options.motion, kMotions,
            "of the character: " + namesOf(kMotions));
  addChoice(app, "--solver", "NAME", options.source.solver, kSolvers, namesOf(kSolvers));
  given.comparedOption = addChoice(app, "--compare", "SOLVER", given.compared, kSolvers,
                                   "show it once more at the right, with a solver");
  addChoice(app, "--head-collider", "KIND", options.source.headCollider, kHeadColliders,
            "what the hair of --groom collides with: " + namesOf(kHeadColliders));
}

void addLookOptions(CLI::App& app, Options& options, Given& given) {
  given.transparencyOption =
      addChoice(app, "--transparency", "METHOD", given.transparency, kTransparencies,
                namesOf(kTransparencies) + " (windowed; shortcut on the CPU)");
  given.shadowOption = addChoice(app, "--shadow", "KIND", given.shadow, kShadows,
                                 "of hair: " + namesOf(kShadows) + " (deep)");
  given.strandsOption = app.add_option("--strands", given.strandShare,
                                       "share of the strands that are drawn, 0.02..1 (1)")
                            ->check(CLI::Range(0.02f, 1.0f).description(""))
                            ->type_name("X");
  app.add_option("--detail", options.detailPixels,
                 "draw fewer, wider fibers where they are narrower than this [pixels]; 0 draws all "
                 "(0.25)")
      ->check(CLI::Range(0.0f, 4.0f).description(""))
      ->type_name("X");
  given.coarseOption =
      app.add_option("--coarse", given.coarseness,
                     "edge of a pixel of the hair [pixels of the window], 1..4 (1; 2 on the CPU)")
          ->check(CLI::Range(1u, 4u).description(""))
          ->type_name("N");
  app.add_option("--settings", options.settings, "of the hair, its look and the lights, as JSON")
      ->check(CLI::ExistingFile.description(""))
      ->type_name("FILE");
}

void addSessionOptions(CLI::App& app, Options& options, Given& given) {
  app.add_flag("--fixed-clock", options.fixedClock,
               "every frame takes 1/60 s of the scene's time, however long it really takes");
  app.add_flag("!--no-vsync", options.screen.vsync, "draw as many frames as the device can");
  app.add_flag("--print-start", options.printsStart,
               "print how long the start took, and what the interface takes, to stderr");
  app.add_option("--script", options.script,
                 "replay recorded input on a fixed clock, and quit at its end")
      ->check(CLI::ExistingFile.description(""))
      ->type_name("FILE");
  app.add_option("--record", options.record, "write what is done to a script")->type_name("FILE");
  app.add_option("--kernels", options.kernels,
                 "compile kernels of this folder, again when they change (what the build has)")
      ->check(CLI::ExistingDirectory.description(""))
      ->type_name("DIR");
  addCaptureOptions(app, options);
  app.add_option("--cache", given.cache,
                 "folder of compiled pipelines, or 'none' (that of the user)")
      ->type_name("DIR");
}

// Errors: CLI::ValidationError.
void take(const Given& given, Options& options) {
  if (!given.size.empty()) parseSize(given.size, options);
  if (*given.apiOption) options.screen.api = given.api;
  if (*given.comparedOption) options.compared = given.compared;
  if (*given.transparencyOption) options.transparency = given.transparency;
  if (*given.strandsOption) options.strandShare = given.strandShare;
  if (*given.coarseOption) options.coarseness = given.coarseness;
  if (*given.shadowOption) options.shadow = given.shadow;
  if (*given.presetOption && !options.source.files.empty())
    throw CLI::ValidationError("--groom", "is for the generated head, not for files");
  if (*given.presetOption) options.source.kind = StageKind::kHead;
  if (!options.source.files.empty()) options.source.kind = StageKind::kFiles;
  if (!options.script.empty() || !options.record.empty() || !options.captures.frames.empty() ||
      !options.captures.video.empty())
    options.fixedClock = true;
  if (!options.script.empty()) options.screen.vsync = false;
  if (given.cache == "user")
    options.screen.cache = cacheFolder();
  else if (given.cache != "none")
    options.screen.cache = given.cache;
}

}  // namespace

std::variant<Options, int> parseOptions(int argc, const char* const* argv) {
  Options options;
  Given given;
  CLI::App app(
      "Shows hair that moves, in a window: a generated character, a generated head (--groom), or "
      "files,\nwhich can be dropped on the window as well. docs/viewer.md has the keys.",
      kProgram);
  app.set_version_flag("--version", PELAGE_VIEWER_VERSION);
  app.get_formatter()->column_width(34);
  addScreenOptions(app, options, given);
  addSourceOptions(app, options, given);
  addLookOptions(app, options, given);
  addSessionOptions(app, options, given);
  try {
    app.parse(argc, argv);
    take(given, options);
  } catch (const CLI::Success& answered) {  // --help or --version
    return app.exit(answered);
  } catch (const CLI::ParseError& error) {
    pelage::program::printError(kProgram, error.what());
    return kBadArguments;
  }
  return options;
}

}  // namespace viewer
