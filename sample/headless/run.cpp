#include "run.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "demo_assets.h"
#include "demo_scene.h"
#include "device.h"
#include "figures.h"
#include "messages.h"
#include "modeling_files.h"
#include "picture_writer.h"

namespace sample {

using pelage::DeviceInfo;
using pelage::Error;
using pelage::ErrorCode;
using pelage::HeadlessDevice;
using pelage::Result;

namespace {

// The face is smooth at 640 pixels.
constexpr float kHeadCellSize = 0.0025f, kCharacterCellSize = 0.003f;  // m

std::string describe(const DeviceInfo& info) {
  return fmt::format("{} ({}), {} {}", info.name, info.driver, pelage::apiName(info.api),
                     info.version);
}

Result<void> printDevices(pelage::Api api) {
  const auto devices = listDevices(api);
  if (!devices) return devices.error();
  for (size_t i = 0; i < devices->size(); ++i)
    fmt::print("{}: {}, tier {}{}\n", i, describe((*devices)[i]),
               pelage::tierName((*devices)[i].tier), (*devices)[i].software ? ", on the CPU" : "");
  return {};
}

Result<DemoAssets> makeHead(const Options& options) {
  pelage::GroomDef def = presetLook(options.preset).groom;
  def.seed = options.seed;
  def.headCellSize = kHeadCellSize;
  if (options.guides) def.strandCount = *options.guides;
  return generateAssets(def);
}

Result<std::unique_ptr<HeadlessDevice>> makeDevice(const Options& options) {
  pelage::HeadlessDef def;
  def.api = options.api;
  def.validation = options.validation;
  def.deviceIndex = options.device;
  def.maxTier = options.tier;
  auto device = createDevice(def);
  if (device && options.images && ((*device)->info().sampleCounts & samplesOf(options)) == 0)
    return Error{
        ErrorCode::kUnsupported,
        fmt::format("{} has no target with {} samples a pixel; use --samples {}",
                    (*device)->info().name, samplesOf(options), (*device)->info().maxSamples)};
  return device;
}

// One frame: simulated, and rendered when a picture is wanted.
class FrameLoop {
 public:
  FrameLoop(const Options& options, DemoScene& demo, HeadlessDevice& device)
      : demo_(demo), device_(device), detailPixels_(options.detailPixels) {
    const uint32_t width = options.width * *options.supersample;
    const uint32_t height = options.height * *options.supersample;
    const Camera camera = demo.camera(
        static_cast<float>(options.width) / static_cast<float>(options.height), options.camera);
    view_ = makeView(camera, width, height, samplesOf(options));
    target_.width = width;
    target_.height = height;
    target_.samples = samplesOf(options);
    settings_.maxBytes = uint64_t{4} << 30;
    settings_.maxBufferBytes = device.info().maxBufferBytes;
    if (options.settings) takeSettings(*options.settings);
    settings_.method = options.transparency;
    if (options.transparency == pelage::Transparency::kTiles) {
      settings_.opaqueDepth = demo.addDepthBuffer(width, height);
      target_.depthCopy = settings_.opaqueDepth;
    }
    demo.setShadow(options.shadow);
  }

  Result<void> simulate() {
    if (Result<void> done = prepare(false); !done) return done;
    if (Result<void> done = device_.execute(lists_[0], &timings_); !done) return done;
    figures_.add(lists_, timings_);
    return {};
  }

  Result<pelage::RenderedImage> render() {
    if (Result<void> done = prepare(true); !done) return done.error();
    std::vector<const pelage::PassList*> lists;
    for (const pelage::PassList& list : lists_) lists.push_back(&list);
    auto image = device_.render(lists, target_, &timings_);
    if (!image) return image;
    figures_.add(lists_, timings_);
    if (Result<void> done = growLists(); !done) return done.error();
    if (Result<void> done = demo_.checkDraw(device_); !done) return done.error();
    return image;
  }

  // Counts the pixels of hair in a picture of the last frame.
  Result<HairPixels> hairPixels(const pelage::RenderedImage& image) {
    if (!demo_.drawsMeshes()) return sample::hairPixels(image, nullptr);
    pelage::PassList list;
    if (Result<void> done = demo_.drawMeshes(view_, list); !done) return done.error();
    demo_.finish(list);
    if (Result<void> done = device_.update(demo_.resources()); !done) return done.error();
    pelage::RenderTargetDef target = target_;
    target.depthCopy = pelage::BufferId::kInvalid;
    const auto without = device_.render(list, target);
    if (!without) return without.error();
    return sample::hairPixels(image, &*without);
  }

  const Figures& figures() const { return figures_; }

 private:
  // Transparency and view of a file.
  void takeSettings(const pelage::SettingsFile& file) {
    pelage::SceneSettings scene;
    scene.transparency = settings_;
    file.apply(scene);
    settings_ = scene.transparency;
    view_.seed = scene.view.seed;
    mostShare_ = scene.object.drawnShare;
  }

  Result<void> prepare(bool draw) {
    lists_.resize(1);
    if (Result<void> done = demo_.advance(lists_[0]); !done) return done;
    if (draw) {
      if (Result<void> done = demo_.castOpaqueShadow(device_); !done) return done;
      demo_.setDetail(view_, detailPixels_, mostShare_);
      if (Result<void> done = demo_.draw(view_, settings_, lists_); !done) return done;
    }
    for (pelage::PassList& list : lists_) demo_.finish(list);
    return device_.update(demo_.resources());
  }

  // The next picture's lists have the capacity that this picture wanted.
  Result<void> growLists() {
    const pelage::BufferId counters = demo_.transparencyCounters();
    const bool grows = settings_.method == pelage::Transparency::kWindowed ||
                       settings_.method == pelage::Transparency::kTiles;
    if (!grows || counters == pelage::BufferId::kInvalid) return {};
    const auto words = device_.read(counters);
    if (!words) return words.error();
    const auto plan =
        pelage::planTransparency(view_.width, view_.height, settings_, demo_.vertexCount());
    if (!plan) return plan.error();
    settings_.nodeCount = pelage::growNodes(
        pelage::readTransparencyCounters(*words, plan->nodeCount), plan->nodeCount);
    return {};
  }

  DemoScene& demo_;
  HeadlessDevice& device_;
  const float detailPixels_;
  float mostShare_ = 1;  ///< HairObject::drawnShare near by
  pelage::View view_;
  pelage::RenderTargetDef target_;
  pelage::TransparencySettings settings_;
  std::vector<pelage::PassList> lists_;
  std::vector<pelage::PassTiming> timings_;
  Figures figures_;
};

struct CheckedPicture {
  uint32_t frame = 0;
  HairPixels hair;
};

struct RunResult {
  uint32_t frames = 0;
  std::vector<CheckedPicture> pictures;
};

// Runs the frames.
Result<RunResult> runFrames(const Options& options, FrameLoop& loop, Progress& progress) {
  std::optional<PictureWriter> pictures;
  const uint32_t pictureCount = options.frames / *options.every;
  if (options.images && pictureCount > 0) {
    auto writer = PictureWriter::create(
        options.out, pictureCount, options.width, options.height, *options.supersample,
        options.background ? flatBackdrop(*options.background) : Backdrop{});
    if (!writer) return writer.error();
    pictures = std::move(*writer);
  }
  progress.begin("compiling kernels and simulating the first frame");
  RunResult result;
  uint32_t& frame = result.frames;
  while (frame < options.frames && !interrupted()) {
    ++frame;
    if (pictures && frame % *options.every == 0) {
      const uint32_t number = frame / *options.every;
      progress.begin(fmt::format("{}drawing picture {} of {}, frame {} of {}",
                                 number == 1 ? "compiling kernels and " : "", number, pictureCount,
                                 frame, options.frames));
      const auto image = loop.render();
      if (!image) return image.error();
      if (Result<void> done = pictures->add(frame, *image); !done) return done.error();
      const auto hair = loop.hairPixels(*image);
      if (!hair) return hair.error();
      result.pictures.push_back({frame, *hair});
    } else if (Result<void> done = loop.simulate(); !done) {
      return done.error();
    }
    progress.update(fmt::format("simulated frame {} of {}", frame, options.frames));
  }
  progress.clear();
  if (pictures)
    if (Result<void> done = pictures->finish(); !done) return done.error();
  return result;
}

std::string frameList(const std::vector<uint32_t>& frames) {
  constexpr size_t kListed = 8;
  std::string text = frames.size() == 1 ? "frame" : "frames";
  for (size_t i = 0; i < std::min(frames.size(), kListed); ++i)
    text += fmt::format("{} {}", i == 0 ? "" : ",", frames[i]);
  return frames.size() > kListed ? text + ", ..." : text;
}

// A picture without hair, or no picture at all, is never left without a word.
void reportPictures(const Options& options, const std::vector<CheckedPicture>& pictures) {
  if (options.images && options.frames < *options.every)
    printWarning(fmt::format("there is no picture: --frames {} is less than --every {}",
                             options.frames, *options.every));
  std::vector<uint32_t> empty, invalid;
  for (const auto& [frame, hair] : pictures) {
    const bool isEnd = frame == pictures.front().frame || frame == pictures.back().frame;
    if (isEnd && !options.quiet)
      fmt::print("hair:   {:.2f} % of the pixels of frame {}, mean luminance {:.4f}\n",
                 100 * hair.share, frame, hair.meanLight);
    if (hair.count == 0) empty.push_back(frame);
    if (hair.invalidCount > 0) invalid.push_back(frame);
  }
  if (!empty.empty())
    printWarning(
        fmt::format("no hair can be seen in {}: it is too thin for the picture, behind a "
                    "mesh or out of view; is the scale right (--scale)?",
                    frameList(empty)));
  if (!invalid.empty())
    printWarning(fmt::format("pixels are NaN or infinite in {}", frameList(invalid)));
}

void printGrooms(const Options& options, const DemoScene& demo) {
  for (const pelage::HairId id : demo.hairs()) {
    const pelage::HairObject& hair = demo.scene().hair(id);
    fmt::print("groom:  {}, {} guides x {} vertices, {} follow hairs, {} bones\n", hair.name(),
               hair.guideCount(), hair.verticesPerStrand(), hair.followCount(), hair.boneCount());
  }
  if (options.images)
    fmt::print("images: {}, every {} of {} frames, {} x {}, {} samples, {} quality\n",
               options.out.string(), *options.every, options.frames, options.width, options.height,
               samplesOf(options) * *options.supersample * *options.supersample,
               options.quality == Quality::kFast ? "fast" : "full");
}

// Prints the contacts of follow hairs in the last frame.
void printFollowContacts(const pelage::HairObject& hair, HeadlessDevice& device) {
  if (hair.buffers().followContactWords == pelage::BufferId::kInvalid) return;
  const auto words = device.read(hair.buffers().followContactWords);
  if (!words) return;
  const pelage::FollowContactCounters counters = pelage::readFollowContactCounters(*words);
  fmt::print("follow contacts: {}, {} records, {} strands walked again\n", hair.name(),
             counters.records, counters.strandsWalkedAgain);
}

// Prints the contacts of the last frame, and the deepest vertex that they left.
Result<void> printContacts(const DemoScene& demo, HeadlessDevice& device) {
  constexpr float kMillimeters = 1000;
  for (const pelage::HairId id : demo.hairs()) {
    printFollowContacts(demo.scene().hair(id), device);
    const auto figures = demo.contactFigures(id, device);
    if (!figures) return figures.error();
    if (!*figures) continue;
    const pelage::ContactCounters& counters = (*figures)->counters;
    fmt::print("contacts: {}, {} records, {} strands solved again, {:.3f} mm deep\n",
               demo.scene().hair(id).name(), counters.records, counters.strandsSolvedAgain,
               (*figures)->deepest * kMillimeters);
  }
  return {};
}

// Sums over all grooms, and the maximum of vertices per strand.
RunInfo runInfo(const Options& options, const DemoScene& demo, std::string name, uint32_t frames) {
  RunInfo info = {options.commit, std::move(name), 0, 0, 0, frames};
  for (const pelage::HairId id : demo.hairs()) {
    const pelage::HairObject& hair = demo.scene().hair(id);
    info.guides += hair.guideCount();
    info.follow += hair.followCount();
    info.verticesPerStrand = std::max(info.verticesPerStrand, hair.verticesPerStrand());
  }
  return info;
}

DemoDef demoDef(const Options& options) {
  DemoDef def;
  def.followPerGuide = options.follow;
  def.seed = options.seed;
  def.skinning = options.skinning;
  pelage::SceneSettings settings;
  if (options.settings) options.settings->apply(settings);
  def.solver = options.solver.value_or(settings.simulation.solver);
  def.collidingHair = settings.creation.collidingHair;
  def.settings = options.settings;
  def.subSteps = options.subSteps;
  def.wind = options.wind;
  def.headCollider = options.headCollider;
  def.drawSdf = options.drawSdf;
  def.drawContacts = options.drawContacts;
  def.preset = options.preset;
  def.motion = options.motion;
  return def;
}

Result<DemoScene> makeCharacterScene(const Options& options) {
  pelage::CharacterDef def;
  def.seed = options.seed;
  def.cellSize = kCharacterCellSize;
  if (options.guides) {
    const double share = static_cast<double>(*options.guides) / def.longHair.strandCount;
    for (uint32_t* count :
         {&def.longHair.strandCount, &def.fur.strandCount, &def.mohawk.strandCount})
      *count = static_cast<uint32_t>(std::clamp(std::round(share * *count), 1.0, 1e6));
  }
  // The contacts of the fur's guides take longest. Half of them with more follow hairs look alike.
  const bool halvesFur = options.quality == Quality::kFast && !options.guides && !options.follow &&
                         options.writeAsset.empty();
  if (halvesFur) def.fur.strandCount /= 2;
  auto character = pelage::generateCharacter(def);
  if (!character) return character.error();
  if (halvesFur) {
    pelage::FollowDef& follow = character->grooms[1].follow;
    follow.countPerGuide = 2 * follow.countPerGuide + 1;
    follow.maxRadius *= std::sqrt(2.0f);
  }
  if (!options.writeAsset.empty())
    if (Result<void> done = writeAssets(*character, options.writeAsset); !done) return done.error();
  return DemoScene::create(*character, demoDef(options));
}

Result<DemoScene> makeHeadScene(const Options& options) {
  auto assets = makeHead(options);
  if (!assets) return assets.error();
  if (!options.writeAsset.empty())
    if (Result<void> done = writeAssets(*assets, options.writeAsset); !done) return done.error();
  if (Result<void> done = repeatGuides(assets->hair, assets->weights.strands, options.repeat);
      !done)
    return done.error();
  return DemoScene::create(*assets, demoDef(options));
}

// Takes the hair of modeling programs out of the files. Errors: bones or follow hairs for it.
Result<std::vector<std::filesystem::path>> takeModelingFiles(pelage::program::AssetFiles& files) {
  const pelage::program::AssetFiles all = files;
  files.hairs.clear();
  files.bones.clear();
  files.followHairs.clear();
  std::vector<std::filesystem::path> modeling;
  for (size_t i = 0; i < all.hairs.size(); ++i) {
    const auto of = [i](const std::vector<std::filesystem::path>& paths) {
      return i < paths.size() ? paths[i] : "-";
    };
    const std::filesystem::path bones = of(all.bones), followHairs = of(all.followHairs);
    if (!isModelingFile(pelage::program::lowerExtension(all.hairs[i]))) {
      files.hairs.push_back(all.hairs[i]);
      files.bones.push_back(bones);
      files.followHairs.push_back(followHairs);
    } else if (bones == "-" && followHairs == "-") {
      modeling.push_back(all.hairs[i]);
    } else {
      return Error{ErrorCode::kInvalidArgument,
                   all.hairs[i].string() +
                       ": --bones and --follow-file are for .tfx; pelage-convert groom makes one"};
    }
  }
  return modeling;
}

Result<FileAssets> loadFiles(const Options& options, Progress& progress) {
  progress.begin("loading files");
  pelage::program::AssetFiles own = options.files;
  const auto modeling = takeModelingFiles(own);
  if (!modeling) return modeling.error();
  std::vector<std::string> warnings;
  auto loaded = pelage::program::loadAssetFiles(own, warnings);
  if (!loaded) return loaded.error();
  FileAssets files = {*std::move(loaded), {}};
  if (!options.animation.empty()) {
    // --scale is not for it.
    auto motion = loadMotion(options.animation, {.clip = options.clip});
    if (!motion) return motion.error();
    files.motion = *std::move(motion);
  }
  if (Result<void> added =
          addModelingFiles(*modeling, {.scale = own.scale, .clip = options.clip}, files, warnings);
      !added)
    return added.error();
  progress.clear();
  for (const std::string& warning : warnings) printWarning(warning);
  for (const std::string& warning : pelage::program::unitWarnings(files.assets, own.scale))
    printWarning(warning);
  for (pelage::CachedHair& hair : files.assets.hairs) {
    // The follow hairs of a cache; --follow-file excludes --follow.
    if (options.follow) hair.followHairs.clear();
    std::vector<pelage::BoneInfluences> none;
    if (Result<void> done =
            repeatGuides(hair.asset, hair.bones ? hair.bones->strands : none, options.repeat);
        !done)
      return done.error();
  }
  return files;
}

// \param files nullptr generates hair and meshes.
Result<DemoScene> makeScene(const Options& options, const FileAssets* files, Progress& progress) {
  if (files != nullptr) return DemoScene::create(*files, demoDef(options));
  progress.begin("generating hair and meshes");
  return showsCharacter(options) ? makeCharacterScene(options) : makeHeadScene(options);
}

Result<void> checkMessages(const Options& options, const HeadlessDevice& device) {
  const uint32_t count = device.messageCount();
  if (!options.validation || count == 0) return {};
  return Error{ErrorCode::kDevice,
               fmt::format("validation reported {} messages (printed above)", count)};
}

}  // namespace

Result<void> run(Options options) {
  if (options.listDevices) return printDevices(options.api);

  Progress progress(options.quiet);
  // Errors of files come before a device is opened.
  std::optional<FileAssets> files;
  if (showsFiles(options)) {
    auto loaded = loadFiles(options, progress);
    if (!loaded) return loaded.error();
    files = *std::move(loaded);
  }
  const auto device = makeDevice(options);
  if (!device) return device.error();
  chooseQuality(options, (*device)->info().software);
  auto demo = makeScene(options, files ? &*files : nullptr, progress);
  if (!demo) return demo.error();
  demo->setTier((*device)->info().tier);
  progress.clear();
  if (!options.quiet) {
    fmt::print("device: {}\n", describe((*device)->info()));
    printGrooms(options, *demo);
  }

  const auto start = std::chrono::steady_clock::now();
  FrameLoop loop(options, *demo, **device);
  const auto result = runFrames(options, loop, progress);
  if (!result) return result.error();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;

  if (!options.quiet)
    fmt::print("\n{}\n{} frames in {:.1f} s{}\n", loop.figures().table(), result->frames,
               seconds.count(), interrupted() ? ", interrupted" : "");
  reportPictures(options, result->pictures);
  if (!options.quiet)
    if (Result<void> done = printContacts(*demo, **device); !done) return done;
  if (!options.csv.empty()) {
    const std::string name =
        showsCharacter(options) ? "character" : demo->scene().hair(demo->hairs()[0]).name();
    const RunInfo info = runInfo(options, *demo, name, result->frames);
    if (Result<void> done =
            appendCsv(options.csv.string(), loop.figures(), (*device)->info(), info);
        !done)
      return done;
  }
  return checkMessages(options, **device);
}

}  // namespace sample
