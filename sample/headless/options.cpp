#include "options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "messages.h"
#include "modeling_files.h"

namespace sample {

namespace {

// Composites fragments instead of samples.
bool isSorted(pelage::Transparency method) {
  return method != pelage::Transparency::kAlphaTest && method != pelage::Transparency::kStochastic;
}

}  // namespace

bool showsFiles(const Options& options) {
  return !options.files.hairs.empty() || !options.files.cache.empty();
}

bool showsCharacter(const Options& options) {
  return !showsFiles(options) && options.scene == GeneratedScene::kCharacter;
}

uint32_t samplesOf(const Options& options) {
  return options.samples.value_or(isSorted(options.transparency) ? 1 : 4);
}

void chooseQuality(Options& options, bool software) {
  if (!options.quality) options.quality = software ? Quality::kFast : Quality::kFull;
  const bool fast = options.quality == Quality::kFast;
  if (!options.every) options.every = fast ? std::max(options.frames / 6, 10u) : 10;
  if (!options.supersample) options.supersample = fast ? 1 : 2;
}

namespace {

constexpr double kFastestWind = 1000;  // m/s

// Refuses options of files that do not go together.
void checkFiles(const Options& options) {
  const pelage::program::AssetFiles& files = options.files;
  if (!showsFiles(options)) {
    if (!files.bones.empty() || !files.followHairs.empty() || !files.meshes.empty())
      throw CLI::ValidationError("--bones, --follow-file and --mesh", "need --asset or --pelage");
    if (!options.animation.empty())
      throw CLI::ValidationError("--animation", "needs --asset or --pelage");
    return;
  }
  if (files.bones.size() > files.hairs.size() || files.followHairs.size() > files.hairs.size())
    throw CLI::ValidationError("--bones and --follow-file",
                               "are for --asset, in the same order; there are more of them");
  if (!options.files.followHairs.empty() && options.repeat != 1)
    throw CLI::ValidationError("--repeat", "is without --follow-file");
  const bool onlyTfx = std::none_of(files.hairs.begin(), files.hairs.end(), [](const auto& path) {
    return isModelingFile(pelage::program::lowerExtension(path));
  });
  if (!options.clip.empty() && options.animation.empty() && onlyTfx)
    throw CLI::ValidationError("--clip", "needs --animation");
  if (options.drawSdf && files.meshes.empty() && files.cache.empty() && onlyTfx)
    throw CLI::ValidationError("--draw-sdf", "needs --mesh with --asset");
  if (options.guides)
    throw CLI::ValidationError("--guides", "is for the generated groom, not for files");
  if (!options.writeAsset.empty())
    throw CLI::ValidationError("--write-asset",
                               "is for what is generated; pelage-convert writes other files");
}

// Refuses what CLI11's own checks cannot see.
void checkTogether(const Options& options, const std::vector<float>& wind) {
  for (const float speed : wind)
    if (!(std::abs(static_cast<double>(speed)) <= kFastestWind))
      throw CLI::ValidationError("--wind", "takes speeds of at most 1000 m/s");
  checkFiles(options);
  if (options.drawSdf && !showsFiles(options) && !showsCharacter(options) &&
      options.headCollider == HeadCollider::kCapsules)
    throw CLI::ValidationError("--draw-sdf", "needs --colliders sdf with --scene head");
  if (options.drawContacts && !options.images)
    throw CLI::ValidationError("--draw-contacts", "needs pictures, which --no-images leaves out");
  if (isSorted(options.transparency) && samplesOf(options) != 1)
    throw CLI::ValidationError(
        "--samples", "is 1 but with --transparency alpha-test and --transparency stochastic");
  if (options.repeat != 1 && showsCharacter(options))
    throw CLI::ValidationError("--repeat", "is for --scene head and --asset");
  Options largest = options;
  chooseQuality(largest, false);
  for (const uint32_t size : {options.width, options.height})
    if (size * *largest.supersample > 16384)
      throw CLI::ValidationError("--supersample",
                                 "makes the picture larger than 16384 pixels on a side");
}

// Turns a name into its value, and says which names there are when it is none of them.
template <class T>
CLI::Validator oneOf(const std::map<std::string, T>& values) {
  const auto transform = [values](std::string& text) {
    const auto found = values.find(text);
    if (found != values.end()) {
      text = std::to_string(static_cast<int>(found->second));
      return std::string();
    }
    std::string names;
    for (const auto& [name, value] : values) names += (names.empty() ? "" : ", ") + name;
    return "'" + text + "' is none of: " + names;
  };
  return CLI::Validator(transform, "");
}

}  // namespace

namespace {

// Values of options that are not in Options.
struct Given {
  std::vector<float> wind = {0, 0, 0};
  uint32_t guides = 0, follow = 0, samples = 0, subSteps = 1;
  pelage::Solver solver = pelage::Solver::kExact;
  std::filesystem::path settings;
  bool noImages = false;
  std::vector<float> camera, lookAt;
  std::vector<unsigned> background;
  float fov = 0;
  CLI::Option* fovOption = nullptr;
  CLI::Option *solverOption = nullptr, *subStepsOption = nullptr, *windOption = nullptr;
  CLI::Option *followFileOption = nullptr, *collidersOption = nullptr;
  CLI::Option *sceneOption = nullptr, *motionOption = nullptr, *presetOption = nullptr;
  CLI::Option *skinningOption = nullptr, *transparencyOption = nullptr, *shadowOption = nullptr;
  CLI::Option *scaleOption = nullptr, *guidesOption = nullptr, *followOption = nullptr,
              *samplesOption = nullptr;
};

void addDeviceOptions(CLI::App& app, Options& options) {
  const std::map<std::string, pelage::Api> apis = {
      {"vulkan", pelage::Api::kVulkan}, {"gl", pelage::Api::kGl}, {"gles", pelage::Api::kGles}};
  app.add_option("--api", options.api, "vulkan, gl or gles (vulkan)")
      ->transform(oneOf(apis))
      ->type_name("API");
  app.add_option("--device", options.device, "number of the device in --list-devices")
      ->check(CLI::Range(0, 63).description(""))
      ->type_name("N");
  const std::map<std::string, pelage::Tier> tiers = {
      {"es", pelage::Tier::kEs}, {"base", pelage::Tier::kBase}, {"wide", pelage::Tier::kWide}};
  app.add_option("--tier", options.tier,
                 "take the device for one of at most this tier: es, base or wide (wide)")
      ->transform(oneOf(tiers))
      ->type_name("TIER");
  app.add_flag("--list-devices", options.listDevices, "list the devices of --api and stop");
  app.add_flag("--validation", options.validation,
               "validation layer or debug context; a message is a failure");
}

void addFileOptions(CLI::App& app, Options& options, Given& given) {
  pelage::program::AssetFiles& files = options.files;
  app.add_option("--asset", files.hairs,
                 "hair: .tfx" + std::string(modelingExtensions()) + "; any number")
      ->allow_extra_args(false)
      ->type_name("FILE");
  app.add_option("--bones", files.bones,
                 "bone weights: the first of the first --asset, and so on; - for none")
      ->allow_extra_args(false)
      ->type_name("FILE.tfxbone");
  given.followFileOption = app.add_option("--follow-file", files.followHairs,
                                          "follow hairs, likewise; without it they are generated")
                               ->allow_extra_args(false)
                               ->type_name("FILE.tfxfollow");
  app.add_option("--mesh", files.meshes, "mesh that is drawn and collides; any number")
      ->allow_extra_args(false)
      ->type_name("FILE.tfxmesh");
  app.add_option("--pelage", files.cache, "cache of grooms and meshes, of pelage-convert")
      ->type_name("FILE.pelage");
  app.add_option("--animation", options.animation,
                 "moves the bones of these files, by their names; without it they follow a head "
                 "that looks around")
      ->type_name("FILE.gltf");
  app.add_option("--clip", options.clip, "name of an animation in that file (the first one)")
      ->type_name("NAME");
  given.scaleOption =
      app.add_option("--scale", files.scale,
                     "meters a unit of these files, but for --animation: 0.01 for centimeters, "
                     "0.0254 for inches (1)")
          ->check(CLI::Range(1e-9, 1e9).description(""))
          ->type_name("X");
}

void addHairOptions(CLI::App& app, Options& options, Given& given) {
  const std::map<std::string, GeneratedScene> scenes = {{"character", GeneratedScene::kCharacter},
                                                        {"head", GeneratedScene::kHead}};
  given.sceneOption = app.add_option("--scene", options.scene,
                                     "what is made without files: character, or head, which "
                                     "--groom implies (character)")
                          ->transform(oneOf(scenes))
                          ->type_name("SCENE");
  const std::map<std::string, pelage::CharacterMotion> motions = {
      {"bind", pelage::CharacterMotion::kBind}, {"idle", pelage::CharacterMotion::kIdle},
      {"walk", pelage::CharacterMotion::kWalk}, {"shake", pelage::CharacterMotion::kHeadShake},
      {"jump", pelage::CharacterMotion::kJump}, {"all", pelage::CharacterMotion::kAll}};
  given.motionOption =
      app.add_option("--motion", options.motion,
                     "of the character: bind, idle, walk, shake, jump, or all of the last three "
                     "(all)")
          ->transform(oneOf(motions))
          ->type_name("MOTION");
  app.add_option("--seed", options.seed, "of the generated groom and the follow hairs (1)")
      ->type_name("N");
  const std::map<std::string, GroomPreset> presets = {{"parted", GroomPreset::kParted},
                                                      {"straight", GroomPreset::kStraight},
                                                      {"curly", GroomPreset::kCurly},
                                                      {"fur", GroomPreset::kFur},
                                                      {"mohawk", GroomPreset::kMohawk}};
  given.presetOption =
      app.add_option("--groom", options.preset,
                     "of the generated head: parted, straight, curly, fur or mohawk (parted)")
          ->transform(oneOf(presets))
          ->type_name("KIND");
  given.guidesOption =
      app.add_option(
             "--guides", given.guides,
             "guides of the generated groom; of the character's long hair, its other grooms "
             "have more or less in proportion")
          ->check(CLI::Range(1u, 1u << 20).description(""))
          ->type_name("N");
  app.add_option("--repeat", options.repeat,
                 "copies of the guides, all at one place, for measurements (1)")
      ->check(CLI::Range(1u, 65536u).description(""))
      ->type_name("N");
  given.followOption = app.add_option("--follow", given.follow,
                                      "follow hairs a guide, in place of those of --pelage")
                           ->check(CLI::Range(0u, 64u).description(""))
                           ->type_name("N");
}

void addSimulationOptions(CLI::App& app, Options& options, Given& given) {
  const std::map<std::string, pelage::SkinningMethod> methods = {
      {"matrices", pelage::SkinningMethod::kMatrices},
      {"dual-quaternions", pelage::SkinningMethod::kDualQuaternions}};
  const std::map<std::string, HeadCollider> colliders = {{"capsules", HeadCollider::kCapsules},
                                                         {"sdf", HeadCollider::kMesh}};
  given.collidersOption =
      app.add_option("--colliders", options.headCollider,
                     "of the generated head: capsules, or sdf, the field of its mesh (capsules)")
          ->transform(oneOf(colliders))
          ->type_name("KIND");
  app.add_option("--settings", given.settings,
                 "JSON of settings for all hair and lights: {\"simulation\": {\"bendLength\": "
                 "0.1}}; see docs/settings.md")
      ->type_name("FILE.json");
  given.skinningOption =
      app.add_option("--skinning", options.skinning, "matrices or dual-quaternions (matrices)")
          ->transform(oneOf(methods))
          ->type_name("METHOD");
  const std::map<std::string, pelage::Solver> solvers = {{"exact", pelage::Solver::kExact},
                                                         {"classic", pelage::Solver::kClassic}};
  given.solverOption = app.add_option("--solver", given.solver, "exact or classic (exact)")
                           ->transform(oneOf(solvers))
                           ->type_name("SOLVER");
  given.subStepsOption = app.add_option("--sub-steps", given.subSteps,
                                        "steps of the exact solver in a frame, 1..32 (1)")
                             ->check(CLI::Range(1u, 32u).description(""))
                             ->type_name("N");
  given.windOption = app.add_option("--wind", given.wind, "velocity of the air [m/s] (0,0,0)")
                         ->delimiter(',')
                         ->expected(3)
                         ->type_name("X,Y,Z");
}

void addPictureOptions(CLI::App& app, Options& options, Given& given) {
  app.add_option("--frames", options.frames, "frames of 1/60 s to simulate (240)")
      ->check(CLI::Range(1u, 1u << 20).description(""))
      ->type_name("N");
  const std::map<std::string, Quality> qualities = {{"full", Quality::kFull},
                                                    {"fast", Quality::kFast}};
  app.add_option("--quality", options.quality,
                 "full: --every 10 --supersample 2; fast: 6 pictures, --supersample 1, and half of "
                 "the fur's guides with more follow hairs (fast on software drivers, else full)")
      ->transform(oneOf(qualities))
      ->type_name("QUALITY");
  app.add_option("--every", options.every, "render every Nth frame")
      ->check(CLI::Range(1u, 1u << 20).description(""))
      ->type_name("N");
  app.add_option("--width", options.width, "of the pictures [pixels] (640)")
      ->check(CLI::Range(16u, 16384u).description(""))
      ->type_name("N");
  app.add_option("--height", options.height, "of the pictures [pixels] (640)")
      ->check(CLI::Range(16u, 16384u).description(""))
      ->type_name("N");
  app.add_option("--camera", given.camera, "position of the camera [m] (sees all that is drawn)")
      ->delimiter(',')
      ->expected(3)
      ->type_name("X,Y,Z");
  app.add_option("--look-at", given.lookAt, "point that --camera looks at [m] (the middle)")
      ->delimiter(',')
      ->expected(3)
      ->type_name("X,Y,Z");
  given.fovOption = app.add_option("--fov", given.fov, "vertical field of view [degrees] (24)")
                        ->check(CLI::Range(1.0f, 150.0f).description(""))
                        ->type_name("X");
  app.add_option("--background", given.background,
                 "color of the pictures where nothing is, sRGB 0 to 255 (a gradient)")
      ->delimiter(',')
      ->expected(3)
      ->check(CLI::Range(0u, 255u).description(""))
      ->type_name("R,G,B");
}

void addDrawingOptions(CLI::App& app, Options& options, Given& given) {
  const std::map<std::string, pelage::Transparency> transparencies = {
      {"alpha-test", pelage::Transparency::kAlphaTest},
      {"stochastic", pelage::Transparency::kStochastic},
      {"windowed", pelage::Transparency::kWindowed},
      {"hybrid4", pelage::Transparency::kHybrid4},
      {"hybrid8", pelage::Transparency::kHybrid8},
      {"hybrid16", pelage::Transparency::kHybrid16},
      {"shortcut", pelage::Transparency::kShortCut},
      {"tiles", pelage::Transparency::kTiles}};
  given.transparencyOption =
      app.add_option(
             "--transparency", options.transparency,
             "alpha-test, stochastic, windowed, hybrid4, hybrid8, hybrid16, shortcut or tiles "
             "(windowed)")
          ->transform(oneOf(transparencies))
          ->type_name("METHOD");
  const std::map<std::string, pelage::HairShadow> shadows = {{"none", pelage::HairShadow::kNone},
                                                             {"depth", pelage::HairShadow::kDepth},
                                                             {"deep", pelage::HairShadow::kDeep}};
  given.shadowOption = app.add_option("--shadow", options.shadow,
                                      "of hair, and of meshes on it: none, depth or deep (deep)")
                           ->transform(oneOf(shadows))
                           ->type_name("KIND");
  given.samplesOption =
      app.add_option(
             "--samples", given.samples,
             "samples a pixel: 1, 2, 4 or 8 (4 with --transparency alpha-test or stochastic, "
             "else 1)")
          ->check(CLI::IsMember({1u, 2u, 4u, 8u}).description(""))
          ->type_name("N");
  app.add_option("--supersample", options.supersample,
                 "render N times larger and average in linear light, 1..4")
      ->check(CLI::Range(1u, 4u).description(""))
      ->type_name("N");
  app.add_option("--detail", options.detailPixels,
                 "draw fewer, wider fibers where they are narrower than this [pixels]; 0 draws all "
                 "(0.25)")
      ->check(CLI::Range(0.0f, 4.0f).description(""))
      ->type_name("X");
  app.add_flag("--draw-sdf", options.drawSdf,
               "draw the surfaces of the signed distance fields that hair collides with");
  app.add_flag(
      "--draw-contacts", options.drawContacts,
      "draw where guides touch colliders: blue apart, green touching, yellow to red deeper");
  app.add_flag("--no-images", given.noImages, "simulate only");
  app.add_option("--out", options.out, "folder of the pictures (out)")->type_name("DIR");
}

void addOutputOptions(CLI::App& app, Options& options) {
  app.add_option("--write-asset", options.writeAsset,
                 "write grooms as .tfx and .tfxbone, colliders as .tfxmesh, and the character as "
                 "glTF into a folder")
      ->type_name("DIR");
  app.add_option("--csv", options.csv, "append the figures to a file")->type_name("FILE");
  app.add_option("--commit", options.commit, "commit to name in --csv")->type_name("TEXT");
  app.add_flag("--quiet", options.quiet, "print errors and warnings only");
}

// Errors: CLI::ValidationError for options of another scene.
void checkScene(const Given& given, const Options& options) {
  if (*given.presetOption && showsFiles(options))
    throw CLI::ValidationError("--groom", "is for the generated groom, not for files");
  if (*given.presetOption && *given.sceneOption && showsCharacter(options))
    throw CLI::ValidationError("--groom", "is for --scene head");
  if (*given.sceneOption && showsFiles(options))
    throw CLI::ValidationError("--scene", "is for what is generated, not for files");
}

// Takes values of the settings file for which there are options; options that are given go first.
// Errors: CLI::ValidationError for the file.
void takeSettings(const Given& given, Options& options) {
  if (given.settings.empty()) return;
  auto settings = pelage::SettingsFile::load(given.settings);
  if (!settings) throw CLI::ValidationError("--settings", settings.error().message);
  pelage::SceneSettings scene;
  settings->apply(scene);
  if (scene.view.reversedDepth)
    throw CLI::ValidationError(
        "--settings",
        "'view.reversedDepth' is not for this program: it has depth 0 at the "
        "near plane");
  if (settings->sets("view.samples") && !*given.samplesOption) options.samples = scene.view.samples;
  if (settings->sets("creation.skinning") && !*given.skinningOption)
    options.skinning = scene.creation.skinning;
  if (settings->sets("transparency.method") && !*given.transparencyOption)
    options.transparency = scene.transparency.method;
  if (settings->sets("lights[0].shadow") && !*given.shadowOption)
    options.shadow = scene.lights[0].shadow;
  options.settings = *std::move(settings);
}

// Errors: CLI::ValidationError for positions that no camera has.
void takeCamera(const Given& given, Options& options) {
  constexpr float kDegrees = 3.14159265f / 180;
  for (const std::vector<float>* point : {&given.camera, &given.lookAt})
    for (const float x : *point)
      if (!(std::abs(x) <= pelage::kMaxCoordinate))
        throw CLI::ValidationError("--camera and --look-at", "take coordinates within 1e6 m");
  const auto pointOf = [](const std::vector<float>& p) { return pelage::Float3{p[0], p[1], p[2]}; };
  if (!given.camera.empty()) options.camera.eye = pointOf(given.camera);
  if (!given.lookAt.empty() && given.camera.empty())
    throw CLI::ValidationError("--look-at", "needs --camera");
  if (!given.lookAt.empty()) options.camera.target = pointOf(given.lookAt);
  if (!given.lookAt.empty() && given.lookAt == given.camera)
    throw CLI::ValidationError("--look-at", "is where --camera is");
  if (*given.fovOption) options.camera.verticalFov = given.fov * kDegrees;
  const std::vector<unsigned>& rgb = given.background;
  if (!rgb.empty())
    options.background = {static_cast<uint8_t>(rgb[0]), static_cast<uint8_t>(rgb[1]),
                          static_cast<uint8_t>(rgb[2])};
}

// Errors: CLI::ValidationError for options that do not go together.
void take(const Given& given, Options& options) {
  if (*given.guidesOption) options.guides = given.guides;
  if (*given.followOption) options.follow = given.follow;
  checkScene(given, options);
  if (*given.presetOption) options.scene = GeneratedScene::kHead;
  if (*given.motionOption && !showsCharacter(options))
    throw CLI::ValidationError("--motion", "is for --scene character");
  if (*given.collidersOption && (showsFiles(options) || showsCharacter(options)))
    throw CLI::ValidationError("--colliders", "is for --scene head");
  if (*given.scaleOption && !showsFiles(options))
    throw CLI::ValidationError("--scale", "is for files, not for what is generated");
  if (*given.followOption && *given.followFileOption)
    throw CLI::ValidationError("--follow", "is without --follow-file");
  if (*given.samplesOption) options.samples = given.samples;
  if (*given.solverOption) options.solver = given.solver;
  if (*given.subStepsOption) options.subSteps = given.subSteps;
  if (*given.windOption) options.wind = {given.wind[0], given.wind[1], given.wind[2]};
  options.images = !given.noImages;
  takeCamera(given, options);
  options.files.repair = true;
  takeSettings(given, options);
  checkTogether(options, given.wind);
}

}  // namespace

std::variant<Options, int> parseOptions(int argc, const char* const* argv) {
  Options options;
  Given given;
  CLI::App app(
      "Simulates hair and renders it without a window: a generated character with long hair, fur "
      "and a\n"
      "mohawk, a generated head (--scene head), or grooms from files (--asset, --pelage). "
      "Writes PNG frames, a\n"
      "contact sheet, and what each kernel cost.",
      kProgram);
  app.set_version_flag("--version", PELAGE_SAMPLE_VERSION);
  app.get_formatter()->column_width(34);
  addDeviceOptions(app, options);
  addFileOptions(app, options, given);
  addHairOptions(app, options, given);
  addSimulationOptions(app, options, given);
  addPictureOptions(app, options, given);
  addDrawingOptions(app, options, given);
  addOutputOptions(app, options);
  try {
    app.parse(argc, argv);
    take(given, options);
  } catch (const CLI::CallForHelp& help) {
    return app.exit(help);
  } catch (const CLI::CallForVersion& version) {
    return app.exit(version);
  } catch (const CLI::ParseError& error) {
    printError(error.what());
    return kBadArguments;
  }
  return options;
}

}  // namespace sample
