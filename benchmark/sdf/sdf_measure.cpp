#include "sdf/sdf_measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

#include "baseline/gpu_structs.h"
#include "baseline/kernels.h"
#include "simulation/csv_file.h"
#include "simulation/median.h"

namespace bench {

using pelage::BufferId;
using pelage::Float4;
using pelage::PassBuilder;
using pelage::PassList;
using pelage::PassTiming;
using pelage::Result;
using pelage::reference::DistanceOracle;
using pelage::reference::Vector3d;

namespace {

// Even, for those that move there and back.
constexpr int kWarmUpFrames = 6, kSoftwareWarmUpFrames = 2;
constexpr uint32_t kJudgedVertices = 10000;
constexpr double kDeep = -0.05, kResolved = -0.02;  // cell
constexpr const char* kCopyPass = "copy_state";

// Times of lists that have the same passes.
class PassTimes {
 public:
  void add(const std::vector<PassTiming>& timings) {
    names_.resize(timings.size());
    passes_.resize(timings.size());
    double all = 0, surface = 0, interior = 0;
    for (size_t i = 0; i < timings.size(); ++i) {
      const std::string_view name = timings[i].name;
      if (timings[i].milliseconds < 0) return;
      if (name == kCopyPass) continue;
      const double us = 1000 * timings[i].milliseconds;
      names_[i] = name;
      passes_[i].push_back(us);
      all += us;
      if (name == "update_surface") surface += us;
      if (name == "fill_interior") interior += us;
    }
    all_.push_back(all);
    surface_.push_back(surface);
    interior_.push_back(interior);
  }

  void store(SdfRow& row, bool parts) const {
    row.median = medianOf(all_);
    row.least = all_.empty() ? 0 : *std::min_element(all_.begin(), all_.end());
    if (parts) row.surface = medianOf(surface_);
    if (parts) row.interior = medianOf(interior_);
    for (size_t i = 0; i < names_.size(); ++i)
      if (!names_[i].empty())
        row.passes += fmt::format("{}{} {:.2f}", row.passes.empty() ? "" : "; ", names_[i],
                                  medianOf(passes_[i]));
  }

 private:
  std::vector<double> all_, surface_, interior_;
  std::vector<std::string> names_;
  std::vector<std::vector<double>> passes_;
};

// Hair that starts at the same places in every run.
class Hair {
 public:
  Hair(Workbench& workbench, const std::vector<Float4>& start)
      : workbench_(workbench), start_(start) {
    from_ = workbench.add("hairStart", start);
    buffers_.positions = workbench.add("hairPositions", start);
    buffers_.before = workbench.add("hairBefore", start);
    buffers_.count = static_cast<uint32_t>(start.size());
  }
  ~Hair() {
    for (const BufferId buffer : {from_, buffers_.positions, buffers_.before})
      workbench_.scene.resources().remove(buffer);
  }
  Hair(const Hair&) = delete;
  Hair& operator=(const Hair&) = delete;

  const CollidingVertices& buffers() const { return buffers_; }

  Result<void> addStart(PassList& list) const {
    for (const BufferId to : {buffers_.positions, buffers_.before}) {
      baseline::CopyConstants constants = {};
      constants.elementCount = buffers_.count;
      constants.sets = 1;
      const uint64_t bytes = start_.size() * sizeof(Float4);
      PassBuilder builder(list);
      builder.dispatch(baseline::copyStateVariant({}), buffers_.count)
          .bind("g_copyFrom", from_, bytes)
          .bind("g_copyTo", to, bytes)
          .constants("CopyConstants", constants);
      if (Result<void> done = builder.finish(); !done) return done;
    }
    return {};
  }

  /// Share of these vertices that are outside now; negative without any.
  Result<double> resolved(const std::vector<uint32_t>& deep, const DistanceOracle& oracle,
                          double cell) const {
    if (deep.empty()) return -1.0;
    const auto raw = workbench_.device.read(buffers_.positions);
    if (!raw) return raw.error();
    uint64_t out = 0;
    for (const uint32_t i : deep) {
      Float4 p;
      std::memcpy(&p, raw->data() + i * sizeof p, sizeof p);
      if (oracle.signedDistance(Vector3d(p.x, p.y, p.z)) > kResolved * cell) ++out;
    }
    return static_cast<double>(out) / static_cast<double>(deep.size());
  }

 private:
  Workbench& workbench_;
  const std::vector<Float4>& start_;
  BufferId from_;
  CollidingVertices buffers_;
};

// Times of a list and of the copies beside it.
struct TimedList {
  PassTimes times;
  CopyTimes copies;
};

// Runs what `add` adds so many times.
template <class Add>
Result<void> runList(Workbench& workbench, int frames, const Add& add, PassTimes* times) {
  for (int frame = 0; frame < frames; ++frame) {
    PassList list;
    if (Result<void> done = add(list); !done) return done;
    workbench.scene.finish(list);
    const auto timings = workbench.run(list);
    if (!timings) return timings.error();
    if (times != nullptr) times->add(*timings);
  }
  return {};
}

// Times what `add` adds, but for the first frames. A software driver gets fewer of those.
template <class Add>
Result<TimedList> timeList(Workbench& workbench, CopyReference& copies, int frames,
                           const Add& add) {
  const int untimed = workbench.device.info().software ? kSoftwareWarmUpFrames : kWarmUpFrames;
  if (Result<void> done = runList(workbench, untimed, add, nullptr); !done) return done.error();
  return steadiest(copies.clocks(), [&]() -> Result<TimedList> {
    TimedList timed;
    const auto beside =
        copies.around([&] { return runList(workbench, frames, add, &timed.times); });
    if (!beside) return beside.error();
    timed.copies = *beside;
    return timed;
  });
}

Result<void> measureCollisions(Workbench& workbench, CopyReference& copies, SdfBuild& sdf,
                               const SdfRow& base, const HairSet& set, const DistanceOracle& oracle,
                               int frames, std::vector<SdfRow>& rows) {
  const Hair hair(workbench, set.start);
  for (const Response response : sdf.responses()) {
    const auto timed = timeList(workbench, copies, frames, [&](PassList& list) {
      Result<void> done = hair.addStart(list);
      return done ? sdf.addCollision(list, hair.buffers(), response) : done;
    });
    if (!timed) return timed.error();
    SdfRow row = base;
    row.what = set.name;
    row.response = responseName(response);
    row.vertices = hair.buffers().count;
    row.copies = timed->copies;
    const auto resolved = hair.resolved(set.deep, oracle, static_cast<double>(base.cellSize));
    if (!resolved) return resolved.error();
    row.resolved = *resolved;
    timed->times.store(row, false);
    rows.push_back(row);
  }
  return {};
}

constexpr const char* kCsvHeader =
    "commit,api,shape,triangles,cells,cell_m,what,method,response,us_median,us_min,surface_us,"
    "interior_us,"
    "wrong_signs,near_error_max_cells,near_error_rms_cells,unset_interior_percent,"
    "far_error_max_cells,far_error_rms_cells,vertices,resolved_percent,nodes,field_bytes,bytes,"
    "ratio_to_classic,reference_us_before,reference_us_after,runs,passes,device,driver\n";

std::string csvRow(const SdfRow& r, const pelage::DeviceInfo& device, const std::string& commit) {
  const SdfErrors& e = r.errors;
  const auto error = [&](double value) { return csvNumber(value, r.hasErrors); };
  // Names of devices hold commas; they come last and are quoted.
  return fmt::format(
      "{},{},{},{},{},{:.6g},{},\"{}\",\"{}\",{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}"
      ",{},\"{}"
      "\",\"{}\","
      "\"{}\"\n",
      commit, pelage::apiName(device.api), r.shape, r.triangles, r.cells, r.cellSize, r.what,
      r.method, r.response, csvNumber(r.median, r.median > 0), csvNumber(r.least, r.median > 0),
      csvNumber(r.surface, r.surface >= 0), csvNumber(r.interior, r.interior >= 0),
      r.hasErrors ? std::to_string(e.wrongSigns) : "", error(e.nearMax), error(e.nearRms),
      error(100 * e.unsetInterior), error(e.farMax), error(e.farRms), r.vertices,
      csvNumber(100 * r.resolved, r.resolved >= 0), r.nodes, r.sdfBytes, r.bytes,
      csvNumber(r.ratioToClassic, r.ratioToClassic > 0),
      csvNumber(r.copies.before, r.copies.before > 0),
      csvNumber(r.copies.after, r.copies.after > 0), r.copies.runs, r.passes, device.name,
      device.driver);
}

}  // namespace

const char* responseName(Response response) {
  switch (response) {
    case Response::kClassic:
      return "forward differences";
    case Response::kTrilinear:
      return "trilinear";
    case Response::kClosestFeature:
      return "closest feature";
  }
  return "unknown";
}

Result<std::unique_ptr<SdfBuild>> makeSdf(Workbench& workbench, const SdfShape& shape,
                                          const NodeGrid& compared, const SdfMethod& method) {
  if (method.classic) return makeClassicSdf(workbench, shape, compared, method.ownGrid);
  return makePelageSdf(workbench, shape, compared, method);
}

HairSet makeHairSet(const SdfShape& shape, const DistanceOracle& oracle, std::string name,
                    uint32_t vertices, float from, float to, float cellSize) {
  HairSet set;
  set.name = std::move(name);
  set.start = hairVertices(shape, vertices, from * cellSize, to * cellSize);
  const auto step = std::max<size_t>(set.start.size() / kJudgedVertices, 1) | 1;
  for (size_t i = 0; i < set.start.size(); i += step) {
    const Float4& p = set.start[i];
    if (oracle.signedDistance(Vector3d(p.x, p.y, p.z)) < kDeep * static_cast<double>(cellSize))
      set.deep.push_back(static_cast<uint32_t>(i));
  }
  return set;
}

Result<std::vector<SdfRow>> measureSdf(Workbench& workbench, CopyReference& copies,
                                       const SdfCase& what, const SdfMethod& method,
                                       const DistanceOracle& oracle, int frames) {
  auto sdf = makeSdf(workbench, what.shape, what.grid, method);
  if (!sdf) return sdf.error();
  const auto timed =
      timeList(workbench, copies, frames, [&](PassList& list) { return (*sdf)->addBuild(list); });
  if (!timed) return timed.error();
  SdfRow row;
  row.shape = what.shape.name;
  row.what = "build";
  row.method = method.name;
  row.triangles = what.shape.mesh.triangleCount();
  row.cells = what.cells;
  row.cellSize = what.grid.cellSize;
  row.nodes = (*sdf)->nodeCount();
  row.sdfBytes = (*sdf)->sdfBytes();
  row.bytes = (*sdf)->bytes();
  std::vector<SdfRow> rows = {row};
  const auto values = (*sdf)->nodes();
  if (!values) return values.error();
  rows[0].errors = compareSdf(*values, what.truth);
  rows[0].hasErrors = true;
  rows[0].copies = timed->copies;
  timed->times.store(rows[0], !method.classic);
  if (!method.collides) return rows;
  for (const HairSet& set : what.hair)
    if (Result<void> done =
            measureCollisions(workbench, copies, **sdf, row, set, oracle, frames, rows);
        !done)
      return done.error();
  return rows;
}

Result<void> appendSdfCsv(const std::string& path, const std::vector<SdfRow>& rows,
                          const pelage::DeviceInfo& device, const std::string& commit) {
  std::vector<std::string> lines;
  for (const SdfRow& row : rows) lines.push_back(csvRow(row, device, commit));
  return appendLines(path, kCsvHeader, lines);
}

}  // namespace bench
