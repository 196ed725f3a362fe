#include "oit/oit_measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <string_view>

#include "simulation/csv_file.h"
#include "simulation/median.h"

namespace bench {

using pelage::BufferId;
using pelage::PassList;
using pelage::PassTiming;
using pelage::Result;
using pelage::Transparency;

namespace {

constexpr OitMethod kMethods[] = {
    {"classic8", {}},
    {"windowed", Transparency::kWindowed},
    {"hybrid4", Transparency::kHybrid4},
    {"hybrid8", Transparency::kHybrid8},
    {"hybrid16", Transparency::kHybrid16},
    {"shortcut", Transparency::kShortCut, 1, true},
    {"tiles", Transparency::kTiles},
    {"alpha-test", Transparency::kAlphaTest, 1, true},
    {"stochastic", Transparency::kStochastic, 1, true},
    {"stochastic", Transparency::kStochastic, 4, true},
};

// Passes that light fragments, or composite them. What is neither these nor a shadow is the build.
constexpr std::string_view kResolvePasses[] = {
    "classic_list_read",     "ppll_read",
    "hybrid_colors",         "hybrid_read",
    "short_cut_fill_colors", "short_cut_resolve_color",
    "shade_strand_tiles",    "gather_strand_tiles",
    "show_strand_tiles",     "strand_pixel",
};
constexpr std::string_view kShadowPasses[] = {"clear_strand_shadow", "splat_strand_depths",
                                              "splat_strand_opacity", "accumulate_strand_shadow"};
constexpr std::string_view kMeshPass = "mesh_pixel";
// Names of buffers that a method has, begin so.
constexpr std::string_view kOwnBuffers[] = {"transparency/", "classic/", "opaque depth"};

constexpr int kWarmUpFrames = 3;
constexpr int kGrowths = 4;  // of pools, until all fits
// After this time there are no more frames, for software drivers.
constexpr std::chrono::seconds kLongest(3);

template <size_t N>
bool isOneOf(std::string_view name, const std::string_view (&names)[N]) {
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

class FrameTimes {
 public:
  void add(std::span<const PassTiming> timings) {
    double build = 0, resolve = 0, shadow = 0;
    for (const PassTiming& timing : timings) {
      if (timing.milliseconds < 0) return;
      if (timing.name == kMeshPass) continue;
      (isOneOf(timing.name, kResolvePasses)  ? resolve
       : isOneOf(timing.name, kShadowPasses) ? shadow
                                             : build) += timing.milliseconds;
    }
    build_.push_back(build);
    resolve_.push_back(resolve);
    shadow_.push_back(shadow);
    total_.push_back(build + resolve + shadow);
  }
  void store(OitRow& row) const {
    row.build = medianOf(build_, -1);
    row.resolve = medianOf(resolve_, -1);
    row.shadow = medianOf(shadow_, -1);
    row.total = medianOf(total_, -1);
  }

 private:
  std::vector<double> build_, resolve_, shadow_, total_;
};

// Draws frames of one method, with pools that hold all its fragments where the device lets them.
class OitFrames {
 public:
  OitFrames(const OitCase& what, const OitMethod& method)
      : what_(what), scene_(what.scene), method_(method), classic_(what.scene), view_(what.view) {
    view_.samples = method.samples;
    const uint64_t limit = scene_.device().info().maxBufferBytes;
    const uint64_t fitting = limit / sizeof(pelage::Uint4);
    nodes_ = static_cast<uint32_t>(std::min<uint64_t>(
        std::max<uint64_t>(what.exact.fragments + what.exact.fragments / 16, 1), fitting));
    if (!method.kind) return;
    settings_.method = *method.kind;
    settings_.maxBytes = uint64_t{32} << 30;
    settings_.maxBufferBytes = limit;
    if (method.kind == Transparency::kWindowed)
      settings_.nodeCount = std::min(nodes_, pelage::kMaxListNodes);
    if (method.kind == Transparency::kTiles)
      settings_.opaqueDepth =
          scene_.resources().add({.name = "opaque depth",
                                  .size = uint64_t{view_.width} * view_.height * sizeof(float),
                                  .stride = sizeof(float)});
  }
  ~OitFrames() {
    if (settings_.opaqueDepth != BufferId::kInvalid)
      scene_.resources().remove(settings_.opaqueDepth);
  }
  OitFrames(const OitFrames&) = delete;
  OitFrames& operator=(const OitFrames&) = delete;

  /// \param times that the frame is drawn without a pause.
  Result<pelage::RenderedImage> render(std::vector<PassTiming>* timings, int times = 1) {
    Result<void> drawn =
        method_.kind ? scene_.draw(view_, settings_, lists_) : classic_.draw(view_, nodes_, lists_);
    if (!drawn) return drawn.error();
    return scene_.render(lists_, view_, settings_.opaqueDepth, timings, times);
  }

  /// Whether the next frames have more room than the last one.
  Result<bool> grow(uint64_t& spilled) {
    spilled = 0;
    if (!method_.kind) {
      spilled = what_.exact.fragments - std::min<uint64_t>(what_.exact.fragments, nodes_);
      return false;
    }
    const bool counts =
        method_.kind == Transparency::kWindowed || method_.kind == Transparency::kTiles;
    if (!counts) return false;
    const auto words = scene_.device().read(scene_.transparencyCounters());
    if (!words) return words.error();
    const pelage::HairObject& hair = scene_.hair();
    const auto plan =
        pelage::planTransparency(view_.width, view_.height, settings_,
                                 uint64_t{hair.strandCount()} * hair.verticesPerStrand());
    if (!plan) return plan.error();
    const auto counters = pelage::readTransparencyCounters(*words, plan->nodeCount);
    spilled = counters.spilled;
    if (spilled == 0) return false;
    settings_.nodeCount = pelage::growNodes(counters, plan->nodeCount);
    return true;
  }

  /// Total size of the buffers that the method bound in the last frame.
  uint64_t bytes() const {
    // The bound part counts: a buffer may be larger since an earlier method.
    std::map<BufferId, uint64_t> buffers;
    for (const PassList& list : lists_)
      for (const pelage::Pass& pass : list.passes)
        for (const pelage::PassBinding& binding : list.bindingsOf(pass))
          buffers[binding.buffer] = std::max(buffers[binding.buffer], binding.size);
    uint64_t sum = 0;
    for (const auto& [buffer, size] : buffers) {
      const pelage::BufferDesc* desc = scene_.resources().find(buffer);
      if (desc == nullptr) continue;
      const auto starts = [&](std::string_view name) { return desc->name.starts_with(name); };
      if (std::any_of(std::begin(kOwnBuffers), std::end(kOwnBuffers), starts)) sum += size;
    }
    return sum;
  }

 private:
  const OitCase& what_;
  HairScene& scene_;
  const OitMethod& method_;
  ClassicList classic_;
  pelage::View view_;
  pelage::TransparencySettings settings_;
  uint32_t nodes_ = 0;
  std::vector<PassList> lists_;
};

// Times of frames and of the copies beside them.
struct TimedFrames {
  FrameTimes times;
  CopyTimes copies;
};

Result<void> drawFrames(OitFrames& drawn, int together, int frames, FrameTimes& times) {
  const auto start = std::chrono::steady_clock::now();
  for (int timed = 0; timed < frames; timed += together) {
    if (timed > 0 && std::chrono::steady_clock::now() - start > kLongest) break;
    std::vector<PassTiming> timings;
    const auto image = drawn.render(&timings, together);
    if (!image) return image.error();
    const size_t passes = timings.size() / static_cast<size_t>(together);
    for (int i = 0; i < together; ++i)
      times.add(std::span(timings).subspan(static_cast<size_t>(i) * passes, passes));
  }
  return {};
}

Result<TimedFrames> timeFrames(OitFrames& drawn, const OitCase& what, const OitMethod& method,
                               const OitFrameCounts& counts) {
  const int together = method.writesDepth ? 1 : std::max(counts.together, 1);
  if (!what.scene.device().info().software) {
    FrameTimes untimed;
    if (Result<void> done = drawFrames(drawn, together, kWarmUpFrames, untimed); !done)
      return done.error();
  }
  return steadiest(what.copies.clocks(), [&]() -> Result<TimedFrames> {
    TimedFrames timed;
    const auto beside =
        what.copies.around([&] { return drawFrames(drawn, together, counts.frames, timed.times); });
    if (!beside) return beside.error();
    timed.copies = *beside;
    return timed;
  });
}

std::string number(double value, bool known) { return known ? fmt::format("{:.5g}", value) : ""; }

constexpr const char* kCsvHeader =
    "commit,api,scene,view,width,height,opacity,method,samples,psnr_db,error_max,off_percent,"
    "build_ms,resolve_ms,shadow_ms,total_ms,resolve_ratio_to_classic,bytes_a_pixel,bytes,fragments,"
    "spilled,layers_mean,layers_max,hair_pixels,row_step,"
    "reference_us_before,reference_us_after,runs,device,driver,version\n";

}  // namespace

std::span<const OitMethod> oitMethods() { return kMethods; }

Result<void> measureOit(const OitCase& what, const OitMethod& method, const OitFrameCounts& counts,
                        OitRow& row) {
  OitFrames drawn(what, method);
  auto image = drawn.render(nullptr);
  if (!image) return image.error();
  for (int i = 0; i < kGrowths; ++i) {
    const auto grown = drawn.grow(row.spilled);
    if (!grown) return grown.error();
    if (!*grown) break;
    image = drawn.render(nullptr);
    if (!image) return image.error();
  }
  row.error = comparePicture(*image, what.exact);

  const auto timed = timeFrames(drawn, what, method, counts);
  if (!timed) return timed.error();
  timed->times.store(row);
  row.copies = timed->copies;
  row.method = method.name;
  row.samples = method.samples;
  row.width = what.view.width;
  row.height = what.view.height;
  row.bytes = drawn.bytes();
  row.fragments = what.exact.fragments;
  row.layersMean = what.exact.layersMean;
  row.layersMax = what.exact.layersMax;
  row.rowStep = what.exact.rowStep;
  row.hairPixels = what.exact.pixels.size();
  return {};
}

Result<void> appendOitCsv(const std::string& path, const OitRow& r,
                          const pelage::DeviceInfo& device, const std::string& commit) {
  const double pixels = static_cast<double>(r.width) * r.height;
  const std::string line = fmt::format(
      "{},{},{},{},{},{},{},{},{},{:.2f},{:.5f},{:.4f},{},{},{},{},{},{:.1f},{},{},{},{:.2f},{},{},"
      "{},{},{},{},\"{}\",\"{}\",\"{}\"\n",
      commit, pelage::apiName(device.api), r.scene, r.viewName, r.width, r.height, r.opacity,
      r.method, r.samples, r.error.psnr, r.error.largest, 100 * r.error.off,
      number(r.build, r.build >= 0), number(r.resolve, r.resolve >= 0),
      number(r.shadow, r.shadow >= 0), number(r.total, r.total >= 0),
      number(r.resolveRatio, r.resolveRatio > 0), static_cast<double>(r.bytes) / pixels, r.bytes,
      r.fragments, r.spilled, r.layersMean, r.layersMax, r.hairPixels, r.rowStep,
      number(r.copies.before, r.copies.before > 0), number(r.copies.after, r.copies.after > 0),
      r.copies.runs, device.name, device.driver, device.version);
  return appendLines(path, kCsvHeader, {line});
}

}  // namespace bench
