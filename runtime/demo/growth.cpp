// Roots by dart throwing; strands grown step by step, then gathered in locks and curled.
#include "growth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "base/portable_math.h"

namespace pelage::detail {
namespace {

// Points of the grown path for each segment of the strand.
constexpr uint32_t kPointsPerSegment = 3;

// Darts that find no gap before the spacing shrinks, at most. 1000 find nearly all gaps that there
// are; a number that grows with the roots' takes a time that grows with its square.
constexpr size_t kMostMisses = 1000;

// Streams of the generator: one for the roots, then one a strand.
constexpr uint64_t kFirstStrandStream = 1;

// Draws points of the ground's triangles where hair grows, uniform in area.
class GroundDarts {
 public:
  GroundDarts(const CollisionMesh& mesh, const HairGround& ground) : mesh_(mesh) {
    double area = 0;
    for (size_t t = 0; t + 2 < mesh.indices.size(); t += 3) {
      const Vector a = corner(t), b = corner(t + 1), c = corner(t + 2);
      if (!ground.grows(a) && !ground.grows(b) && !ground.grows(c)) continue;
      area += length(cross(b - a, c - a)) / 2;
      triangles_.push_back({t, area});
    }
  }

  bool empty() const { return triangles_.empty(); }
  double area() const { return triangles_.back().areaUpToHere; }

  Vector next(Random& random) const {
    const double target = random.uniformDouble() * area();
    const auto found =
        std::upper_bound(triangles_.begin(), triangles_.end() - 1, target,
                         [](double value, const Triangle& t) { return value < t.areaUpToHere; });
    // Uniform in a triangle: Turk 1990, "Generating Random Points in Triangles".
    const double s = std::sqrt(random.uniformDouble()), t = random.uniformDouble();
    const size_t i = found->firstIndex;
    return corner(i) * (1 - s) + corner(i + 1) * (s * (1 - t)) + corner(i + 2) * (s * t);
  }

 private:
  struct Triangle {
    size_t firstIndex;
    double areaUpToHere;
  };

  Vector corner(size_t index) const { return toVector(mesh_.positions[mesh_.indices[index]]); }

  const CollisionMesh& mesh_;
  std::vector<Triangle> triangles_;
};

// A hash grid of roots with cells of the spacing's size: a neighbor is in one of 27 cells.
class RootGrid {
 public:
  RootGrid(const std::vector<HairRoot>& roots, uint32_t wanted, double spacing)
      : spacing_(spacing), heads_(std::max<size_t>(64, 2 * size_t{wanted}), kEnd) {
    for (const HairRoot& root : roots) insert(root.position);
  }

  void insert(const Vector& p) {
    const auto c = cellOf(p);
    uint32_t& head = heads_[bucket(c[0], c[1], c[2])];
    next_.push_back(std::exchange(head, static_cast<uint32_t>(next_.size())));
  }

  bool isFree(const Vector& p, const std::vector<HairRoot>& roots) const {
    const auto c = cellOf(p);
    for (int64_t z = -1; z <= 1; ++z)
      for (int64_t y = -1; y <= 1; ++y)
        for (int64_t x = -1; x <= 1; ++x)
          for (uint32_t i = heads_[bucket(c[0] + x, c[1] + y, c[2] + z)]; i != kEnd; i = next_[i])
            if (length(roots[i].position - p) < spacing_) return false;
    return true;
  }

 private:
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

  double spacing_;
  std::vector<uint32_t> heads_, next_;
};

Vector unitVector(Random& random) {
  const double z = 2 * random.uniformDouble() - 1;
  const SinCos rotation = sinCos(kTwoPi * random.uniformDouble());
  const double radius = std::sqrt(std::max(1 - z * z, 0.0));
  return {radius * rotation.cosine, radius * rotation.sine, z};
}

// Points of a strand's path before it is resampled.
uint32_t pointCountOf(const GroomDef& def) {
  return (def.verticesPerStrand - 1) * kPointsPerSegment + 1;
}

// Moves a point out of the ground.
Vector pushOut(const HairGround& ground, Vector p) {
  for (int step = 0; step < 64; ++step) {
    const double d = ground.surface(p);
    if (d >= kHairClearance) break;
    p += ground.normal(p) * (kHairClearance - d + 1e-5);
  }
  return p;
}

struct Wave {
  Vector direction;
  double amplitude, frequency, phase;
};

Wave waveOf(Random& random, double octave) {
  return {unitVector(random), 1 / octave, octave * 9 * (1 + random.uniformDouble()),
          kTwoPi * random.uniformDouble()};
}

// The smooth path before locks, curls and noise. `layer` 0..1: how far out in the layer of hair.
// Hair from below lies under the hair that falls over it from above.
Path grow(const GroomDef& def, const HairGround& ground, const HairRoot& root, double length,
          double layer) {
  const uint32_t points = pointCountOf(def);
  const double above = ground.height(root.position);
  const SinCos lift = sinCos(def.lift * (0.3 + 0.7 * above));
  const double volume = def.volume * (0.1 + 0.9 * above) * (0.4 + 0.6 * layer);
  const double step = length / (points - 1);
  Vector direction = normalizeOr(
      root.normal * lift.sine + ground.combDirection(root.position, root.normal) * lift.cosine,
      root.normal);
  // Near an ear the root is under the smoothed surface; the hair comes out of it by and by.
  const double rootClearance = std::min(ground.combedSurface(root.position), kHairClearance);
  Path path(points);
  path[0] = root.position;
  for (uint32_t k = 1; k < points; ++k) {
    const Vector& p = path[k - 1];
    const double near =
        1 - smoothStep(0.005, 0.04, ground.combedSurface(p));  // only the ground combs
    Vector bend = Vector{0, -1, 0} * def.droop;
    if (near > 0) bend += ground.combDirection(p, ground.rootNormal(p)) * (def.comb * near);
    direction = normalizeOr(direction + bend * step, direction);
    Vector next = p + direction * step;
    const double reached = smoothStep(0, 0.04, step * k);
    const double clearance = rootClearance + (kHairClearance + volume - rootClearance) * reached;
    const double gap = clearance - ground.combedSurface(next);
    if (gap > 0) {
      const Vector normal = ground.combedNormal(next);
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
Clumps findClumps(const GroomDef& def, const HairGround& ground,
                  const std::vector<HairRoot>& roots) {
  const uint32_t count = def.strandCount;
  Clumps clumps;
  clumps.of.resize(count);
  for (uint32_t i = 0; i < count; ++i) clumps.of[i] = i;
  clumps.curlOf.assign(count, 0);
  clumps.fromCenter.assign(count, 0);
  if (def.clumpCount == 0) {
    for (uint32_t i = 0; i < count; ++i) clumps.curlOf[i] = i;
    clumps.centers = clumps.of;
    return clumps;
  }
  std::vector<Vector> combs(count);
  for (uint32_t i = 0; i < count; ++i)
    combs[i] = ground.combDirection(roots[i].position, roots[i].normal);
  std::vector<double> nearest(count, 1e9), spread(count, 1e9);
  uint32_t center = 0;
  for (uint32_t c = 0; c < std::min(def.clumpCount, count); ++c) {
    clumps.curlOf[center] = c;
    clumps.centers.push_back(center);
    uint32_t farthest = 0;
    for (uint32_t i = 0; i < count; ++i) {
      const double distance = length(roots[i].position - roots[center].position);
      spread[i] = std::min(spread[i], distance);
      if (spread[i] > spread[farthest]) farthest = i;
      const double weighted = distance * (1 + 4 * (1 - dot(combs[i], combs[center])));
      if (weighted < nearest[i]) {
        nearest[i] = weighted;
        clumps.of[i] = center;
      }
    }
    center = farthest;
  }
  std::vector<double> reach(count, 0);  // [center]
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t of = clumps.of[i];
    clumps.fromCenter[i] = length(roots[i].position - roots[of].position);
    reach[of] = std::max(reach[of], clumps.fromCenter[i]);
  }
  for (uint32_t i = 0; i < count; ++i)
    if (reach[clumps.of[i]] > 0) clumps.fromCenter[i] /= reach[clumps.of[i]];
  return clumps;
}

// The helix of a lock around its central strand, in a frame carried along that.
Path curlAround(const GroomDef& def, uint32_t center, const Path& path, double length) {
  Path curl(path.size());
  Random random(def.seed, kFirstStrandStream + 2 * uint64_t{def.strandCount} + center);
  const double phase = kTwoPi * random.uniformDouble();
  const double frequency = def.curlFrequency * (0.8 + 0.4 * random.uniformDouble());
  Vector tangent = {1, 0, 0};
  UnitQuaternion<double> frame;
  for (size_t k = 0; k < path.size(); ++k) {
    const Vector next = k + 1 < path.size() ? normalizeOr(path[k + 1] - path[k], tangent) : tangent;
    frame = normalized(shortestArc(tangent, next) * frame);
    tangent = next;
    const double share = static_cast<double>(k) / static_cast<double>(path.size() - 1);
    const SinCos rotation = sinCos(phase + kTwoPi * frequency * share * length);
    const double radius = def.curlRadius * smoothStep(0, 0.5, share);
    curl[k] = rotate(frame, Vector{0, radius * rotation.cosine, radius * rotation.sine});
  }
  return curl;
}

// Vertices at equal distances along the path, `length` apart in all where the path is that long.
Path resample(const GroomDef& def, const HairGround& ground, const Path& path, double length) {
  double total = 0;
  for (size_t k = 1; k < path.size(); ++k) total += detail::length(path[k] - path[k - 1]);
  const double segment = std::min(length, total) / (def.verticesPerStrand - 1);
  Path vertices = {path[0]};
  double walked = 0;
  for (size_t k = 1; k < path.size() && vertices.size() < def.verticesPerStrand; ++k) {
    const double piece = detail::length(path[k] - path[k - 1]);
    while (vertices.size() < def.verticesPerStrand) {
      const double wanted = segment * static_cast<double>(vertices.size());
      if (wanted > walked + piece) break;
      const double t = piece > 0 ? (wanted - walked) / piece : 0;
      vertices.push_back(pushOut(ground, lerp(path[k - 1], path[k], saturate(t))));
    }
    walked += piece;
  }
  // Rounding may leave the tip over.
  while (vertices.size() < def.verticesPerStrand) vertices.push_back(path.back());
  return vertices;
}

}  // namespace

// Dart throwing (Cook 1986, "Stochastic Sampling in Computer Graphics") on an area-weighted choice
// of triangles. When darts no longer find a gap the spacing shrinks, so that the wanted number is
// always reached.
HairRoots sampleRoots(const CollisionMesh& mesh, const HairGround& ground, uint32_t count,
                      Random& random) {
  const GroundDarts darts(mesh, ground);
  if (darts.empty()) return {};
  HairRoots result;
  std::vector<HairRoot>& roots = result.roots;
  // A dense triangular lattice has area * 2 / sqrt(3) / spacing^2 points; start above it.
  result.spacing = std::sqrt(darts.area() * 1.1547 / count);
  RootGrid grid(roots, count, result.spacing);
  uint32_t misses = 0;
  while (roots.size() < count) {
    const Vector p = darts.next(random);
    if (ground.grows(p) && grid.isFree(p, roots)) {
      grid.insert(p);
      roots.push_back({p, ground.rootNormal(p)});
      misses = 0;
    } else if (++misses > 40 + std::min(roots.size() / 4, kMostMisses)) {
      result.spacing *= 0.97;
      grid = RootGrid(roots, count, result.spacing);
      misses = 0;
    }
  }
  return result;
}

HairGrower::HairGrower(const GroomDef& def, const HairGround& ground,
                       const std::vector<HairRoot>& roots)
    : def_(def), ground_(ground) {
  const uint32_t count = def.strandCount;
  lengths_.resize(count);
  paths_.resize(count);
  thickness_.resize(count);
  clumps_ = findClumps(def, ground, roots);
  for (uint32_t i = 0; i < count; ++i) {
    Random random(def.seed, kFirstStrandStream + i);
    const double edge = edgeShare(roots[i].position);
    lengths_[i] = def.length * (1 - def.lengthVariation * random.uniformDouble()) *
                  ground.lengthShare(roots[i].position) * edge * clumpShare(i);
    thickness_[i] = edge;
    paths_[i] = grow(def, ground, roots[i], lengths_[i], random.uniformDouble());
  }
  for (const uint32_t center : clumps_.centers)
    curls_.push_back(curlAround(def, center, paths_[center], lengths_[center]));
}

// Factor on length and thickness of a strand at the edge of the hair.
double HairGrower::edgeShare(const Vector& root) const {
  if (!(def_.hairlineFade > 0)) return 1;
  return 0.4 + 0.6 * smoothStep(0, def_.hairlineFade, ground_.insideEdge(root));
}

// Factor on the length of a strand by its lock, which ends in a point.
double HairGrower::clumpShare(uint32_t strand) const {
  Random random(def_.seed,
                kFirstStrandStream + 4 * uint64_t{def_.strandCount} + clumps_.of[strand]);
  return (1 - def_.clumpLengthVariation * random.uniformDouble()) *
         (1 - def_.clumpTaper * clumps_.fromCenter[strand]);
}

float HairGrower::thickness(uint32_t index) const {
  Random random(def_.seed, kFirstStrandStream + 3 * uint64_t{def_.strandCount} + index);
  return (1 - def_.thicknessVariation * random.uniform()) * static_cast<float>(thickness_[index]);
}

Path HairGrower::strand(uint32_t index) const {
  const uint32_t center = clumps_.of[index];
  Random random(def_.seed, kFirstStrandStream + def_.strandCount + index);
  const std::array<Wave, 3> waves = {waveOf(random, 1), waveOf(random, 2), waveOf(random, 4)};
  Path path = paths_[index];
  for (size_t k = 1; k < path.size(); ++k) {
    const double share = static_cast<double>(k) / static_cast<double>(path.size() - 1);
    const double meters = share * lengths_[index];
    Vector p = path[k];
    const double pull = def_.clumpStrength * share * std::sqrt(share);
    p = lerp(p, paths_[center][k], pull);
    p += curls_[clumps_.curlOf[center]][k];
    for (const Wave& w : waves)
      p += w.direction *
           (w.amplitude * def_.noise * share * sinCos(w.phase + w.frequency * meters).sine);
    path[k] = pushOut(ground_, p);
  }
  return resample(def_, ground_, path, lengths_[index]);
}

}  // namespace pelage::detail
