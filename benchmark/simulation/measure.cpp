#include "measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

#include "csv_file.h"
#include "simulation/median.h"

namespace bench {

using pelage::Float4;
using pelage::PassList;
using pelage::PassTiming;
using pelage::Result;
using pelage::rod::Vector3d;

namespace {

// Frames of a chaotic scene whose stretch is read back: from this one on, every so many.
constexpr int kFirstSample = 59, kSampleEvery = 30;
// Compiling, first touches and clocks that rise are over after this many frames.
constexpr int kWarmUpFrames = 5;

double least(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::min_element(values.begin(), values.end());
}

/// GPU times of frames.
class FrameTimes {
 public:
  void add(const std::vector<PassTiming>& timings) {
    if (++frames_ <= kWarmUpFrames) return;
    double frame = 0, solve = 0;
    for (const PassTiming& timing : timings) {
      if (timing.milliseconds < 0) return;
      frame += 1000 * timing.milliseconds;
      if (std::string_view(timing.name) != "skin_roots") solve += 1000 * timing.milliseconds;
    }
    frame_.push_back(frame);
    solve_.push_back(solve);
  }
  void store(Measurement& row) const {
    row.medianFrame = medianOf(frame_);
    row.leastFrame = least(frame_);
    row.medianSolve = medianOf(solve_);
    row.leastSolve = least(solve_);
  }

 private:
  int frames_ = 0;
  std::vector<double> frame_, solve_;
};

/// How far edges are from their lengths, and strands from the reference.
class Errors {
 public:
  Errors(const BenchScene& scene, const SceneReference& reference)
      : asset_(scene.asset), reference_(reference) {}

  /// \param positions  of the first strands, whole ones
  void addStretch(const std::vector<Float4>& positions) {
    const size_t n = asset_.verticesPerStrand;
    broken_ = 0;
    for (size_t s = 0; (s + 1) * n <= positions.size(); ++s) {
      bool finite = true;
      for (size_t v = 0; v < n; ++v) {
        const Float4& p = positions[s * n + v];
        finite = finite && std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
      }
      if (!finite) {
        ++broken_;
        continue;
      }
      for (size_t v = 1; v + 1 < n; ++v) addEdge(positions, s * n + v);
    }
  }

  /// \param frame  of the reference
  void addError(const std::vector<Float4>& strand, size_t frame) {
    const Points& expected = reference_.reference->frames[frame];
    const std::vector<int>& chosen = reference_.reference->vertices;
    const size_t count = chosen.empty() ? expected.size() : chosen.size();
    for (size_t k = 0; k < count; ++k) {
      const size_t v = chosen.empty() ? k : static_cast<size_t>(chosen[k]);
      const Vector3d d = toVector(strand[v]) - expected[v];
      errorSum_ += dot(d, d);
      ++errorCount_;
    }
  }

  void store(Measurement& row) const {
    const auto rms = [](double sum, uint64_t count) {
      return count > 0 ? 100 * std::sqrt(sum / static_cast<double>(count)) : 0;
    };
    if (errorCount_ > 0) row.error = rms(errorSum_, errorCount_) / reference_.length;
    row.maxStretch = 100 * largest_;
    row.rmsStretch = rms(stretchSum_, edges_);
    row.brokenStrands = broken_;
  }

 private:
  void addEdge(const std::vector<Float4>& positions, size_t at) {
    const auto rest = static_cast<double>(asset_.restLengths[at]);
    if (rest < kShortestEdge) return;
    const double size = length(toVector(positions[at + 1]) - toVector(positions[at]));
    const double stretch = std::abs(size / rest - 1);
    largest_ = std::max(largest_, stretch);
    stretchSum_ += stretch * stretch;
    ++edges_;
  }

  const pelage::HairAsset& asset_;
  const SceneReference& reference_;
  double errorSum_ = 0, stretchSum_ = 0, largest_ = 0;
  uint64_t errorCount_ = 0, edges_ = 0, broken_ = 0;
};

Result<std::vector<Float4>> readPositions(Workbench& workbench, pelage::BufferId buffer,
                                          uint64_t vertices) {
  const auto raw = workbench.device.read(buffer, 0, vertices * sizeof(Float4));
  if (!raw) return raw.error();
  std::vector<Float4> positions(vertices);
  std::memcpy(positions.data(), raw->data(), raw->size());
  return positions;
}

// Strands that are copies of each other are read once.
Result<void> sample(Workbench& workbench, const BenchScene& scene, const SceneReference& reference,
                    const StrandSolver& solver, int frame, Errors& errors) {
  const uint64_t n = scene.asset.verticesPerStrand;
  if (!reference.reference) {
    if (frame < kFirstSample || (frame - kFirstSample) % kSampleEvery != 0) return {};
    const auto all = readPositions(workbench, solver.positions(), n * scene.asset.strandCount);
    if (!all) return all.error();
    errors.addStretch(*all);
    return {};
  }
  const auto compared = static_cast<int>(reference.reference->frames.size());
  if (frame < scene.frames - compared) return {};
  const auto strand = readPositions(workbench, solver.positions(), n);
  if (!strand) return strand.error();
  errors.addStretch(*strand);
  errors.addError(*strand, static_cast<size_t>(frame - (scene.frames - compared)));
  return {};
}

constexpr const char* kCsvHeader =
    "commit,api,scene,solver,effort,setting,strands,vertices_per_strand,frames,error_rms_percent,"
    "stretch_max_percent,stretch_rms_percent,broken_strands,frame_us_median,frame_us_min,"
    "solve_us_median,solve_us_min,bytes,gb_per_s,floor_us,ratio_to_baseline,"
    "reference_us_before,reference_us_after,runs,device,driver\n";

std::string csvRow(const Measurement& m, const pelage::DeviceInfo& device,
                   const std::string& commit) {
  const bool timed = m.medianFrame > 0;
  const double rate = timed ? static_cast<double>(m.bytes) / (1e3 * m.medianFrame) : 0;
  // Names of devices hold commas; they come last and are quoted.
  return fmt::format(
      "{},{},{},{},{},{},{},{},{},{},{:.6g},{:.6g},{},{},{},{},{},{},{},{},{},{},{},{},\"{}\",\"{}"
      "\"\n",
      commit, pelage::apiName(device.api), m.scene, m.solver, m.effort, m.setting, m.strands,
      m.vertices, m.frames, csvNumber(m.error, m.error >= 0), m.maxStretch, m.rmsStretch,
      m.brokenStrands, csvNumber(m.medianFrame, timed), csvNumber(m.leastFrame, timed),
      csvNumber(m.medianSolve, timed), csvNumber(m.leastSolve, timed), m.bytes,
      csvNumber(rate, rate > 0), csvNumber(m.floor, m.floor > 0),
      csvNumber(m.ratioToBaseline, m.ratioToBaseline > 0),
      csvNumber(m.copies.before, m.copies.before > 0),
      csvNumber(m.copies.after, m.copies.after > 0), m.copies.runs, device.name, device.driver);
}

/// One run of a scene, from its first frame.
class SceneRound {
 public:
  SceneRound(Workbench& workbench, const BenchScene& scene, const SceneReference& reference,
             const SolverChoice& choice)
      : workbench_(workbench),
        scene_(scene),
        reference_(reference),
        choice_(choice),
        errors_(scene, reference) {}

  Result<Measurement> measure(CopyReference& copies) {
    auto solver = makeSolver(workbench_, scene_, choice_);
    if (!solver) return solver.error();
    // One frame in the bind pose, then the scene settles, then it is measured.
    for (int frame = -1 - scene_.settleFrames; frame < 0; ++frame)
      if (const auto timings = advance(**solver, frame); !timings) return timings.error();
    const auto beside = copies.around([&] { return measureFrames(**solver); });
    if (!beside) return beside.error();
    Measurement row = describe();
    row.copies = *beside;
    return row;
  }

 private:
  Result<std::vector<PassTiming>> advance(StrandSolver& solver, int frame) {
    const double time = std::max(0, frame + 1) * kFrameSeconds;
    if (Result<void> done = solver.advance(scene_.motion(time), list_); !done) return done.error();
    return workbench_.run(list_);
  }
  Result<void> measureFrames(StrandSolver& solver) {
    for (int frame = 0; frame < scene_.frames; ++frame) {
      const auto timings = advance(solver, frame);
      if (!timings) return timings.error();
      times_.add(*timings);
      if (Result<void> done = sample(workbench_, scene_, reference_, solver, frame, errors_); !done)
        return done;
    }
    return {};
  }
  Measurement describe() const {
    Measurement row;
    row.scene = scene_.name;
    row.solver = solverName(choice_.kind);
    row.setting = choice_.setting();
    row.effort = choice_.effort;
    row.strands = scene_.asset.strandCount;
    row.vertices = scene_.asset.verticesPerStrand;
    row.frames = scene_.frames;
    // How many bytes sleeping strands save is not known.
    for (const pelage::Pass& pass : list_.passes) row.bytes += scene_.sleeps ? 0 : pass.bytes;
    times_.store(row);
    errors_.store(row);
    return row;
  }

  Workbench& workbench_;
  const BenchScene& scene_;
  const SceneReference& reference_;
  const SolverChoice& choice_;
  PassList list_;
  FrameTimes times_;
  Errors errors_;
};

}  // namespace

SceneReference::SceneReference(const BenchScene& scene) : reference(scene.reference()) {
  for (uint32_t v = 0; v + 1 < scene.asset.verticesPerStrand; ++v)
    length += static_cast<double>(scene.asset.restLengths[v]);
}

Result<Measurement> measure(Workbench& workbench, CopyReference& copies, const BenchScene& scene,
                            const SceneReference& reference, const SolverChoice& choice) {
  auto row = steadiest(copies.clocks(), [&] {
    return SceneRound(workbench, scene, reference, choice).measure(copies);
  });
  if (!row || row->bytes == 0) return row;
  const auto floor = copyFloor(workbench, row->strands * row->vertices, row->bytes);
  if (!floor) return floor.error();
  row->floor = *floor;
  return row;
}

Result<void> appendCsv(const std::string& path, const std::vector<Measurement>& rows,
                       const pelage::DeviceInfo& device, const std::string& commit) {
  std::vector<std::string> lines;
  for (const Measurement& row : rows) lines.push_back(csvRow(row, device, commit));
  return appendLines(path, kCsvHeader, lines);
}

}  // namespace bench
