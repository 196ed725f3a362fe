#include "options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <map>

#include "canvas/cache_file.h"
#include "choices.h"
#include "program_messages.h"

namespace viewer {
namespace {

constexpr int kBadArguments = 2;
constexpr uint32_t kMaxPictureSize = 16384;

// Names of values, which an error lists.
template <class T>
CLI::Validator oneOf(const std::vector<Choice<T>>& choices) {
  std::map<std::string, T> named;
  for (const Choice<T>& choice : choices) named.emplace(choice.name, choice.value);
  return CLI::CheckedTransformer(named, CLI::ignore_case).description("");
}

// "1280x800" -> width and height. Errors: CLI::ValidationError.
void parseSize(const std::string& text, Options& options) {
  const char* end = text.data() + text.size();
  const auto [cross, first] = std::from_chars(text.data(), end, options.width);
  bool ok = first == std::errc() && cross != end && *cross == 'x';
  if (ok) {
    const auto [stop, second] = std::from_chars(cross + 1, end, options.height);
    ok = second == std::errc() && stop == end;
  }
  const auto fits = [](uint32_t size) { return size >= 16 && size <= kMaxPictureSize; };
  if (!ok || !fits(options.width) || !fits(options.height))
    throw CLI::ValidationError(
        "--size", fmt::format("is WIDTHxHEIGHT, each 16..{}, such as 1280x800", kMaxPictureSize));
}

struct Given {
  std::string size, cache = "user";
  pelage::Api api = pelage::Api::kVulkan;
  pelage::Transparency transparency = pelage::Transparency::kWindowed;
  pelage::HairShadow shadow = pelage::HairShadow::kDeep;
  float strandShare = 1;
  pelage::Solver compared = pelage::Solver::kExact;
  CLI::Option* comparedOption = nullptr;
  CLI::Option* apiOption = nullptr;
  CLI::Option* strandsOption = nullptr;
  CLI::Option* transparencyOption = nullptr;
  CLI::Option* shadowOption = nullptr;
  CLI::Option* presetOption = nullptr;
};

void addCaptureOptions(CLI::App& app, Options& options) {
  CLI::Option* frames = app.add_option("--frames", options.frames,
                                       "write a picture of each frame: DIR/00001.png and so on")
                            ->type_name("DIR");
  app.add_option("--video", options.video, "make a video of all frames by ffmpeg, such as a.mp4")
      ->excludes(frames)
      ->type_name("FILE");
  app.add_option("--times", options.times, "write the GPU times of all passes as CSV")
      ->type_name("FILE");
}

void addOptions(CLI::App& app, Options& options, Given& given) {
  app.add_option("FILES", options.source.files,
                 "hair to show: .tfx with .tfxbone, .tfxfollow and .tfxmesh, .pelage, .hair, .obj, "
                 ".gltf, .glb, .hairtxt (a generated character)");
  const std::map<std::string, pelage::Api> apis = {{"vulkan", pelage::Api::kVulkan},
                                                   {"gl", pelage::Api::kGl}};
  given.apiOption =
      app.add_option("--api", given.api, "vulkan or gl (vulkan, or gl where there is no Vulkan)")
          ->transform(CLI::CheckedTransformer(apis, CLI::ignore_case).description(""))
          ->type_name("API");
  app.add_option("--device", options.device, "number of the Vulkan device (the fastest kind)")
      ->check(CLI::Range(0, 63).description(""))
      ->type_name("N");
  app.add_flag("--validation", options.validation,
               "check every call of the API; messages make the exit status 1");
  app.add_option("--size", given.size, "of the window (1280x800)")->type_name("WxH");
  app.add_option("--scale", options.source.scale,
                 "meters per unit of the files (found from the hair's size)")
      ->check(CLI::Range(1e-9f, 1e9f).description(""))
      ->type_name("X");
  app.add_option("--clip", options.source.clip, "animation of a .gltf or .glb file (the first one)")
      ->type_name("NAME");
  given.presetOption = app.add_option("--groom", options.source.preset,
                                      "a generated head with this hair: " + namesOf(grooms()))
                           ->transform(oneOf(grooms()))
                           ->type_name("NAME");
  app.add_option("--motion", options.motion, "of the character: " + namesOf(motions()))
      ->transform(oneOf(motions()))
      ->type_name("NAME");
  app.add_option("--solver", options.source.solver, namesOf(solvers()))
      ->transform(oneOf(solvers()))
      ->type_name("NAME");
  given.comparedOption =
      app.add_option("--compare", given.compared, "show it once more at the right, with a solver")
          ->transform(oneOf(solvers()))
          ->type_name("SOLVER");
  app.add_option("--head-collider", options.source.headCollider,
                 "what the hair of --groom collides with: " + namesOf(headColliders()))
      ->transform(oneOf(headColliders()))
      ->type_name("KIND");
  given.transparencyOption =
      app.add_option("--transparency", given.transparency,
                     namesOf(transparencies()) + " (windowed; shortcut on the CPU)")
          ->transform(oneOf(transparencies()))
          ->type_name("METHOD");
  given.shadowOption = app.add_option("--shadow", given.shadow,
                                      "of hair: " + namesOf(shadows()) + " (deep; none on the CPU)")
                           ->transform(oneOf(shadows()))
                           ->type_name("KIND");
  given.strandsOption =
      app.add_option("--strands", given.strandShare,
                     "share of the strands that are drawn, 0.02..1 (1; 0.25 on the CPU)")
          ->check(CLI::Range(0.02f, 1.0f).description(""))
          ->type_name("X");
  app.add_option("--settings", options.settings, "of the hair, its look and the lights, as JSON")
      ->check(CLI::ExistingFile.description(""))
      ->type_name("FILE");
  app.add_flag("--fixed-clock", options.fixedClock,
               "every frame takes 1/60 s of the scene's time, however long it really takes");
  app.add_flag("!--no-vsync", options.vsync, "draw as many frames as the device can");
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
  if (*given.apiOption) options.api = given.api;
  if (*given.comparedOption) options.compared = given.compared;
  if (*given.transparencyOption) options.transparency = given.transparency;
  if (*given.strandsOption) options.strandShare = given.strandShare;
  if (*given.shadowOption) options.shadow = given.shadow;
  if (*given.presetOption && !options.source.files.empty())
    throw CLI::ValidationError("--groom", "is for the generated head, not for files");
  if (*given.presetOption) options.source.kind = StageKind::kHead;
  if (!options.source.files.empty()) options.source.kind = StageKind::kFiles;
  if (!options.script.empty() || !options.frames.empty() || !options.video.empty())
    options.fixedClock = true;
  if (given.cache == "user")
    options.cache = cacheFolder();
  else if (given.cache != "none")
    options.cache = given.cache;
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
  addOptions(app, options, given);
  try {
    app.parse(argc, argv);
    take(given, options);
  } catch (const CLI::CallForHelp& help) {
    return app.exit(help);
  } catch (const CLI::CallForVersion& version) {
    return app.exit(version);
  } catch (const CLI::ParseError& error) {
    pelage::program::printError(kProgram, error.what());
    return kBadArguments;
  }
  return options;
}

}  // namespace viewer
