// Hair grown on the implicit head.
#include "pelage/groom.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "guard.h"
#include "head.h"
#include "pelage/random.h"
#include "portable_math.h"

namespace pelage {
namespace {

using detail::combedNormal;
using detail::combedSurface;
using detail::headNormal;
using detail::headSurface;
using detail::saturate;
using detail::SinCos;
using detail::sinCos;
using detail::skullNormal;
using detail::smoothStep;
using detail::Vector;

// Points of the grown path for each segment of the strand.
constexpr uint32_t kPointsPerSegment = 3;
// How far outside the head every vertex but the root stays [m].
constexpr double kClearance = 0.0006;
// Finding the locks takes time in proportion to strands times locks.
constexpr uint32_t kMaxClumpCount = 4096;

// Streams of the generator: one for the roots, then one a strand.
constexpr uint64_t kRootStream = 0, kFirstStrandStream = 1;

struct Root {
  Vector position;
  Vector normal;
};

Vector toVector(const Float3& p) { return {p.x, p.y, p.z}; }

// Points on the scalp, no two closer than spacing(): dart throwing (Cook 1986, "Stochastic Sampling
// in Computer Graphics") on an area-weighted choice of triangles. When darts no longer find a gap
// the spacing shrinks, so that the wanted number is always reached.
class RootSampler {
 public:
  RootSampler(const CollisionMesh& mesh, const GroomDef& def) : mesh_(mesh), def_(def) {
    double area = 0;
    for (size_t t = 0; t + 2 < mesh.indices.size(); t += 3) {
      const Vector a = corner(t), b = corner(t + 1), c = corner(t + 2);
      if (!grows(a) && !grows(b) && !grows(c)) continue;
      area += length(cross(b - a, c - a)) / 2;
      triangles_.push_back({t, area});
    }
  }

  bool empty() const { return triangles_.empty(); }
  double spacing() const { return spacing_; }

  std::vector<Root> sample(uint32_t count, Random& random) {
    // A dense triangular lattice has area * 2 / sqrt(3) / spacing^2 points; start above it.
    const double area = triangles_.back().areaUpToHere;
    spacing_ = std::sqrt(area * 1.1547 / count);
    std::vector<Root> roots;
    rebuild(roots);
    uint32_t misses = 0;
    while (roots.size() < count) {
      const Vector p = throwDart(random);
      if (grows(p) && isFree(p, roots)) {
        insert(p, static_cast<uint32_t>(roots.size()));
        roots.push_back({p, skullNormal(p)});
        misses = 0;
      } else if (++misses > 40 + roots.size() / 4) {
        spacing_ *= 0.97;
        rebuild(roots);
        misses = 0;
      }
    }
    return roots;
  }

 private:
  struct Triangle {
    size_t firstIndex;
    double areaUpToHere;
  };

  Vector corner(size_t index) const { return toVector(mesh_.positions[mesh_.indices[index]]); }

  bool grows(const Vector& p) const {
    if (def_.stripWidth > 0 && std::abs(p.x) > def_.stripWidth / 2) return false;
    return detail::isScalp(p, def_.hairline);
  }

  Vector throwDart(Random& random) const {
    const double target = random.uniformDouble() * triangles_.back().areaUpToHere;
    const auto found =
        std::upper_bound(triangles_.begin(), triangles_.end() - 1, target,
                         [](double value, const Triangle& t) { return value < t.areaUpToHere; });
    // Uniform in a triangle: Turk 1990, "Generating Random Points in Triangles".
    const double s = std::sqrt(random.uniformDouble()), t = random.uniformDouble();
    const size_t i = found->firstIndex;
    return corner(i) * (1 - s) + corner(i + 1) * (s * (1 - t)) + corner(i + 2) * (s * t);
  }

  // A hash grid with cells of the spacing's size: a neighbour is in one of 27 cells.
  static constexpr uint32_t kEnd = 0xffffffffu;

  size_t bucket(int64_t x, int64_t y, int64_t z) const {
    const uint64_t h = static_cast<uint64_t>(x) * 0x9e3779b97f4a7c15u ^
                       static_cast<uint64_t>(y) * 0xc2b2ae3d27d4eb4fu ^
                       static_cast<uint64_t>(z) * 0x165667b19e3779f9u;
    return (h ^ h >> 29) % heads_.size();
  }
  std::array<int64_t, 3> cellOf(const Vector& p) const {
    return {static_cast<int64_t>(std::floor(p.x / spacing_)),
            static_cast<int64_t>(std::floor(p.y / spacing_)),
            static_cast<int64_t>(std::floor(p.z / spacing_))};
  }

  void rebuild(const std::vector<Root>& roots) {
    heads_.assign(std::max<size_t>(64, 2 * size_t{def_.strandCount}), kEnd);
    next_.clear();
    for (size_t i = 0; i < roots.size(); ++i) insert(roots[i].position, static_cast<uint32_t>(i));
  }

  void insert(const Vector& p, uint32_t index) {
    const auto c = cellOf(p);
    uint32_t& head = heads_[bucket(c[0], c[1], c[2])];
    next_.push_back(head);
    head = index;
  }

  bool isFree(const Vector& p, const std::vector<Root>& roots) const {
    const auto c = cellOf(p);
    for (int64_t z = -1; z <= 1; ++z)
      for (int64_t y = -1; y <= 1; ++y)
        for (int64_t x = -1; x <= 1; ++x)
          for (uint32_t i = heads_[bucket(c[0] + x, c[1] + y, c[2] + z)]; i != kEnd; i = next_[i])
            if (length(roots[i].position - p) < spacing_) return false;
    return true;
  }

  const CollisionMesh& mesh_;
  const GroomDef& def_;
  std::vector<Triangle> triangles_;
  std::vector<uint32_t> heads_, next_;
  double spacing_ = 0;
};

// Where hair at a point is combed to; a unit vector along the head's surface.
Vector combDirection(const Vector& p, const Vector& normal, HairStyle style) {
  Vector flow;
  if (style == HairStyle::kSideParting) {
    // Away from the parting, a line from the forehead to the crown, and around its end.
    constexpr double kPartX = 0.022, kCrownZ = -0.045, kFrontZ = 0.13;
    const Vector fromParting = {p.x - kPartX, 0, p.z - std::min(std::max(p.z, kCrownZ), kFrontZ)};
    // Under the widest part of the head, outwards becomes down.
    const double top = smoothStep(0.21, 0.30, p.y);
    flow = normalizeOr(fromParting, Vector{1, 0, 0}) * (0.1 + 0.9 * top);
    flow.z -= smoothStep(-0.03, 0.07, p.z);  // off the face
    flow.y -= 0.35 + 0.65 * (1 - top);
  } else {
    // At the back of the head backwards becomes down.
    const double back = 1 - smoothStep(-0.09, 0.0, p.z);
    flow = {4.0 * p.x * (1 - back), -0.25 - back, back - 1};
  }
  return normalizeOr(flow - normal * dot(flow, normal), Vector{0, 0, -1});
}

// Moves a point out of the head, to `clearance` at least.
Vector pushOut(Vector p, double clearance) {
  for (int step = 0; step < 64; ++step) {
    const double d = headSurface(p);
    if (d >= clearance) break;
    p += headNormal(p) * (clearance - d + 1e-5);
  }
  return p;
}

using Path = std::vector<Vector>;

class Grower {
 public:
  Grower(const GroomDef& def, const std::vector<Root>& roots)
      : def_(def), roots_(roots), pointCount_((def.verticesPerStrand - 1) * kPointsPerSegment + 1) {
    const uint32_t count = def.strandCount;
    lengths_.resize(count);
    paths_.resize(count);
    for (uint32_t i = 0; i < count; ++i) {
      Random random(def.seed, kFirstStrandStream + i);
      lengths_[i] = def.length * (1 - def.lengthVariation * random.uniformDouble());
      paths_[i] = grow(roots[i], lengths_[i], random.uniformDouble());
    }
    findClumps();
    makeCurls();
  }

  /// The vertices of a strand.
  Path strand(uint32_t index) const {
    const uint32_t center = clumpOf_[index];
    Random random(def_.seed, kFirstStrandStream + def_.strandCount + index);
    const std::array<Wave, 3> waves = {wave(random, 1), wave(random, 2), wave(random, 4)};
    Path path = paths_[index];
    for (uint32_t k = 1; k < pointCount_; ++k) {
      const double share = static_cast<double>(k) / (pointCount_ - 1);
      const double meters = share * lengths_[index];
      Vector p = path[k];
      const double pull = def_.clumpStrength * share * std::sqrt(share);
      p = lerp(p, paths_[center][k], pull);
      p += curls_[curlOf_[center]][k];
      for (const Wave& w : waves)
        p += w.direction *
             (w.amplitude * def_.noise * share * sinCos(w.phase + w.frequency * meters).sine);
      path[k] = pushOut(p, kClearance);
    }
    return resample(path, lengths_[index]);
  }

 private:
  struct Wave {
    Vector direction;
    double amplitude, frequency, phase;
  };

  static Wave wave(Random& random, double octave) {
    return {unitVector(random), 1 / octave, octave * 9 * (1 + random.uniformDouble()),
            detail::kTwoPi * random.uniformDouble()};
  }

  static Vector unitVector(Random& random) {
    const double z = 2 * random.uniformDouble() - 1;
    const SinCos turn = sinCos(detail::kTwoPi * random.uniformDouble());
    const double radius = std::sqrt(std::max(1 - z * z, 0.0));
    return {radius * turn.cosine, radius * turn.sine, z};
  }

  // The smooth path before locks, curls and noise. `layer` 0..1: how far out in the layer of hair.
  // Hair from below lies under the hair that falls over it from above.
  Path grow(const Root& root, double length, double layer) const {
    const double above = smoothStep(0.15, 0.30, root.position.y);
    const SinCos lift = sinCos(def_.lift * (0.3 + 0.7 * above));
    const double volume = def_.volume * (0.1 + 0.9 * above) * (0.4 + 0.6 * layer);
    const double step = length / (pointCount_ - 1);
    Vector direction =
        normalizeOr(root.normal * lift.sine +
                        combDirection(root.position, root.normal, def_.style) * lift.cosine,
                    root.normal);
    // Near an ear the root is under the smoothed surface; the hair comes out of it by and by.
    const double rootClearance = std::min(combedSurface(root.position), kClearance);
    Path path(pointCount_);
    path[0] = root.position;
    for (uint32_t k = 1; k < pointCount_; ++k) {
      const Vector& p = path[k - 1];
      const double near = 1 - smoothStep(0.005, 0.04, combedSurface(p));  // only the head combs
      Vector bend = Vector{0, -1, 0} * def_.droop;
      if (near > 0) bend += combDirection(p, skullNormal(p), def_.style) * (def_.comb * near);
      direction = normalizeOr(direction + bend * step, direction);
      Vector next = p + direction * step;
      const double reached = smoothStep(0, 0.04, step * k);
      const double clearance = rootClearance + (kClearance + volume - rootClearance) * reached;
      const double gap = clearance - combedSurface(next);
      if (gap > 0) {
        const Vector normal = combedNormal(next);
        next += normal * gap;
        direction =
            normalizeOr(direction - normal * std::min(dot(direction, normal), 0.0), direction);
      }
      path[k] = next;
    }
    return path;
  }

  // Centres of the locks by farthest-point sampling; each strand joins the nearest one that is
  // combed alike.
  void findClumps() {
    const uint32_t count = def_.strandCount;
    clumpOf_.resize(count);
    for (uint32_t i = 0; i < count; ++i) clumpOf_[i] = i;
    curlOf_.assign(count, 0);
    if (def_.clumpCount == 0) {
      for (uint32_t i = 0; i < count; ++i) curlOf_[i] = i;
      centers_ = clumpOf_;
      return;
    }
    std::vector<Vector> combs(count);
    for (uint32_t i = 0; i < count; ++i)
      combs[i] = combDirection(roots_[i].position, roots_[i].normal, def_.style);
    std::vector<double> nearest(count, 1e9), spread(count, 1e9);
    uint32_t center = 0;
    for (uint32_t c = 0; c < std::min(def_.clumpCount, count); ++c) {
      curlOf_[center] = c;
      centers_.push_back(center);
      uint32_t farthest = 0;
      for (uint32_t i = 0; i < count; ++i) {
        const double distance = length(roots_[i].position - roots_[center].position);
        spread[i] = std::min(spread[i], distance);
        if (spread[i] > spread[farthest]) farthest = i;
        const double weighted = distance * (1 + 4 * (1 - dot(combs[i], combs[center])));
        if (weighted < nearest[i]) {
          nearest[i] = weighted;
          clumpOf_[i] = center;
        }
      }
      center = farthest;
    }
  }

  // One helix a lock, in a frame carried along the lock's central strand.
  void makeCurls() {
    curls_.resize(centers_.size());
    for (size_t c = 0; c < centers_.size(); ++c) {
      const uint32_t center = centers_[c];
      Random random(def_.seed, kFirstStrandStream + 2 * uint64_t{def_.strandCount} + center);
      const double phase = detail::kTwoPi * random.uniformDouble();
      const double frequency = def_.curlFrequency * (0.8 + 0.4 * random.uniformDouble());
      const Path& path = paths_[center];
      curls_[c].resize(pointCount_);
      Vector tangent = {1, 0, 0};
      detail::UnitQuaternion<double> frame;
      for (uint32_t k = 0; k < pointCount_; ++k) {
        const Vector next =
            k + 1 < pointCount_ ? normalizeOr(path[k + 1] - path[k], tangent) : tangent;
        frame = normalized(shortestArc(tangent, next) * frame);
        tangent = next;
        const double share = static_cast<double>(k) / (pointCount_ - 1);
        const SinCos turn = sinCos(phase + detail::kTwoPi * frequency * share * lengths_[center]);
        const double radius = def_.curlRadius * smoothStep(0, 0.5, share);
        curls_[c][k] = rotate(frame, Vector{0, radius * turn.cosine, radius * turn.sine});
      }
    }
  }

  // Vertices at equal distances along the path, `length` apart in all where the path is that long.
  Path resample(const Path& path, double length) const {
    double total = 0;
    for (size_t k = 1; k < path.size(); ++k) total += detail::length(path[k] - path[k - 1]);
    const double segment = std::min(length, total) / (def_.verticesPerStrand - 1);
    Path vertices = {path[0]};
    double walked = 0;
    for (size_t k = 1; k < path.size() && vertices.size() < def_.verticesPerStrand; ++k) {
      const double piece = detail::length(path[k] - path[k - 1]);
      while (vertices.size() < def_.verticesPerStrand) {
        const double wanted = segment * static_cast<double>(vertices.size());
        if (wanted > walked + piece) break;
        const double t = piece > 0 ? (wanted - walked) / piece : 0;
        vertices.push_back(pushOut(lerp(path[k - 1], path[k], saturate(t)), kClearance));
      }
      walked += piece;
    }
    // Rounding may leave the tip over.
    while (vertices.size() < def_.verticesPerStrand) vertices.push_back(path.back());
    return vertices;
  }

  const GroomDef& def_;
  const std::vector<Root>& roots_;
  uint32_t pointCount_;
  std::vector<double> lengths_;
  std::vector<Path> paths_;
  std::vector<uint32_t> clumpOf_;  // central strand of each strand's lock
  std::vector<uint32_t> centers_;
  std::vector<uint32_t> curlOf_;  // index into curls_, of central strands
  std::vector<Path> curls_;
};

Result<void> check(const GroomDef& def) {
  const auto outside = [](const char* field, auto value, auto low, auto high) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("GroomDef::{} is {}; it must be {} to {}", field, value, low, high)};
  };
  const auto bad = [](float value, float low, float high) {
    return !(value >= low && value <= high);  // true for NaN
  };
  if (def.strandCount < 1 || def.strandCount > 1'000'000)
    return outside("strandCount", def.strandCount, 1, 1'000'000);
  if (def.verticesPerStrand < kMinVerticesPerStrand ||
      def.verticesPerStrand > kMaxVerticesPerStrand)
    return outside("verticesPerStrand", def.verticesPerStrand, 2, 256);
  if (def.clumpCount > kMaxClumpCount)
    return outside("clumpCount", def.clumpCount, 0u, kMaxClumpCount);
  struct Range {
    const char* field;
    float value, low, high;
  };
  for (const Range& r : {Range{"length", def.length, 0.002f, 2},
                         {"lengthVariation", def.lengthVariation, 0, 0.95f},
                         {"lift", def.lift, 0, 1.5f},
                         {"volume", def.volume, 0, 0.1f},
                         {"comb", def.comb, 0, 1000},
                         {"droop", def.droop, 0, 1000},
                         {"curlRadius", def.curlRadius, 0, 0.1f},
                         {"curlFrequency", def.curlFrequency, 0, 500},
                         {"clumpStrength", def.clumpStrength, 0, 1},
                         {"noise", def.noise, 0, 0.1f},
                         {"hairline", def.hairline, -0.03f, 0.05f},
                         {"stripWidth", def.stripWidth, 0, 0.3f},
                         {"thicknessVariation", def.thicknessVariation, 0, 1}})
    if (bad(r.value, r.low, r.high)) return outside(r.field, r.value, r.low, r.high);
  if (def.style != HairStyle::kSideParting && def.style != HairStyle::kSweptBack)
    return outside("style", static_cast<int>(def.style), 0, 1);
  return {};
}

Result<Groom> generate(const GroomDef& def) {
  if (auto r = check(def); !r) return r.error();
  Groom groom;
  auto head = generateHead(def.headCellSize);
  if (!head) return head.error();
  groom.head = std::move(*head);
  groom.skeleton = headSkeleton();
  groom.bones.bones = groom.head.bones;

  RootSampler sampler(groom.head, def);
  if (sampler.empty())
    return Error{ErrorCode::kInvalidArgument,
                 "no scalp is left; lower GroomDef::hairline or widen GroomDef::stripWidth"};
  Random random(def.seed, kRootStream);
  const std::vector<Root> roots = sampler.sample(def.strandCount, random);
  // Roots are rounded to float: keep the promise all the same.
  groom.rootSpacing = static_cast<float>(sampler.spacing() - 1e-7);

  const Grower grower(def, roots);
  HairAsset& hair = groom.hair;
  hair.strandCount = def.strandCount;
  hair.verticesPerStrand = def.verticesPerStrand;
  hair.positions.reserve(size_t{def.strandCount} * def.verticesPerStrand);
  for (uint32_t i = 0; i < def.strandCount; ++i) {
    const Path vertices = grower.strand(i);
    for (uint32_t k = 0; k < def.verticesPerStrand; ++k) {
      const Vector& p = vertices[k];
      hair.positions.push_back({static_cast<float>(p.x), static_cast<float>(p.y),
                                static_cast<float>(p.z), k < 2 ? 0.0f : 1.0f});
    }
    const Vector& root = roots[i].position;
    // The scalp from above, the forehead at v = 1.
    hair.strandUv.push_back({static_cast<float>(saturate(0.5 + root.x / 0.18)),
                             static_cast<float>(saturate(0.5 + (root.z + 0.012) / 0.24))});
    if (def.thicknessVariation > 0) {
      Random own(def.seed, kFirstStrandStream + 3 * uint64_t{def.strandCount} + i);
      hair.strandThickness.push_back(1 - def.thicknessVariation * own.uniform());
    }
    const auto share = static_cast<float>(detail::headBoneShare(root));
    groom.bones.strands.push_back({{1, 0, 0, 0}, {share, 1 - share, 0, 0}});
  }
  return groom;
}

}  // namespace

Result<Groom> generateGroom(const GroomDef& def) {
  return detail::guarded([&] { return generate(def); });
}

Result<void> writeGroom(const Groom& groom, const std::filesystem::path& directory,
                        std::string_view name) {
  return detail::guarded([&]() -> Result<void> {
    const auto path = [&](const char* extension) {
      return directory / (std::string(name) + extension);
    };
    if (auto r = saveTfx(groom.hair, path(".tfx")); !r) return r;
    if (auto r = saveTfxBone(groom.bones, path(".tfxbone")); !r) return r;
    return saveTfxMesh(groom.head, path(".tfxmesh"));
  });
}

}  // namespace pelage
