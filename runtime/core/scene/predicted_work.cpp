// Predicts the cost of drawing a view's hair from its size on the screen alone.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "base/vector3.h"
#include "pelage/skeleton.h"
#include "scene/scene_parts.h"

namespace pelage::detail {

namespace {

constexpr double kEdge = pixel_tiles::kTileEdge;
// Mean length of the image of a unit vector, over all directions.
constexpr double kMeanImage = std::numbers::pi / 4;
constexpr size_t kSamples = 256;  // vertices of the bind shape that stand for all

double dot(const Float4& row, const Float3& p) {
  return toDouble(row.x) * toDouble(p.x) + toDouble(row.y) * toDouble(p.y) +
         toDouble(row.z) * toDouble(p.z) + toDouble(row.w);
}

// Means over an object's vertices; one outside of the view adds nothing.
struct HairImage {
  double ribbonMetre = 0, fiberMetre = 0;  // pixels of a metre of ribbon, of fiber
  double tiles = 0;                        // in the rectangle around them
};

// Strands one after the other, and from each to the next another vertex: multiples of the golden
// section, as steps that fit the strands' length would find the same vertex in all of them.
size_t sampleAt(size_t sample, size_t samples, size_t vertices, size_t verticesPerStrand) {
  if (samples == vertices) return sample;
  const size_t strands = vertices / verticesPerStrand;
  const double along = static_cast<double>(sample) * (std::numbers::phi - 1);
  const auto vertex =
      static_cast<size_t>((along - std::floor(along)) * static_cast<double>(verticesPerStrand));
  return sample * strands / samples * verticesPerStrand + vertex;
}

// \param fiber width of a fiber [m].
HairImage imageOf(const View& view, const HairInternals& hair, double fiber) {
  HairImage image;
  const std::vector<Float4>& positions = hair.rest.asset->positions;
  // All of the bind shape goes with one bone. Where hair follows several, the counters of the
  // frames put right what that misses.
  const AffineTransform bone =
      hair.bounds.empty() ? AffineTransform{} : hair.bones[hair.bounds.back().bone];
  const Float4* rows = view.worldToClip.rows;
  const double scale =
      0.5 * view.height * std::hypot(toDouble(rows[1].x), toDouble(rows[1].y), toDouble(rows[1].z));
  const size_t samples = std::min(positions.size(), kSamples);
  bool seen = false;
  double lowX = 1, highX = -1, lowY = 1, highY = -1;
  for (size_t sample = 0; sample < samples; ++sample) {
    const size_t i =
        sampleAt(sample, samples, positions.size(), hair.rest.asset->verticesPerStrand);
    const Float3 p = transformPoint(bone, {positions[i].x, positions[i].y, positions[i].z});
    const double w = dot(rows[3], p), z = dot(rows[2], p);
    const double x = dot(rows[0], p) / w, y = dot(rows[1], p) / w;
    if (!(w > 0 && z >= 0 && z <= w && std::abs(x) <= 1 && std::abs(y) <= 1)) continue;
    const double metre = scale / w;
    seen = true;
    image.ribbonMetre += metre * (fiber * metre + 1);
    image.fiberMetre += metre * (fiber * metre);
    lowX = std::min(lowX, x);
    highX = std::max(highX, x);
    lowY = std::min(lowY, y);
    highY = std::max(highY, y);
  }
  if (seen) {
    image.tiles = (0.5 * view.width * (highX - lowX) / kEdge + 1) *
                  (0.5 * view.height * (highY - lowY) / kEdge + 1);
  }
  for (double* sum : {&image.ribbonMetre, &image.fiberMetre})
    *sum /= static_cast<double>(std::max<size_t>(samples, 1));
  return image;
}

bool isDrawn(const DrawnView& view, const HairObject& object) {
  return std::any_of(view.hairs.begin(), view.hairs.end(),
                     [&](const DrawnHair& hair) { return hair.material == &object.material; });
}

}  // namespace

TransparencyWork ViewDrawing::predictWork(const View& view) {
  TransparencyWork work;
  const Result<DrawnView> frame = begin(view, {});
  if (!frame) return work;
  for (const HairObject& object : store_.hairs()) {
    if (!isDrawn(*frame, object)) continue;
    const HairInternals& hair = HairStore::of(object);
    const DrawnStrands strands = drawnStrandsOf(object);
    const StrandMaterial& m = object.material;
    const float fiber =
        m.fiberRadius * (1 + m.tipRadiusRatio) * hair.groom.meanThickness * strands.widening;
    const HairImage image = imageOf(view, hair, toDouble(fiber));
    const double metres = strands.count * toDouble(hair.rest.meanStrand);
    work.vertices += static_cast<double>(strands.count) * object.verticesPerStrand();
    work.fragments += metres * kMeanImage * image.ribbonMetre;
    work.tiles += image.tiles;
    work.alpha += metres * kMeanImage * toDouble(m.opacity) * image.fiberMetre;
  }
  if (!(work.fragments > 0) || !std::isfinite(work.fragments)) return {};
  work.alpha = std::clamp(work.alpha / work.fragments, 0.0, 1.0);
  work.tiles = std::max(work.tiles, 1.0);
  return work;
}

}  // namespace pelage::detail
