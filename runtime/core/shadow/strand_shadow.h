// Shadow maps that strands cast on strands: kernels/shadow, docs/shadow.md.
#pragma once

#include <cstdint>
#include <span>

#include "base/vector3.h"
#include "pelage/gpu_structs.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/types.h"

namespace pelage::detail {

/// A hair object as a shadow map takes it.
struct ShadowedHair {
  uint32_t vertexCount = 0;    ///< a strand, >= 2
  uint32_t strandCount = 0;    ///< that cast a shadow, from the first
  uint32_t guideCount = 0;     ///< guides; the strands from there on are follow strands
  bool storesFollows = false;  ///< positions has the follow strands, too
  float tipSeparation = 1;
  uint32_t fadingCount = 0;  ///< of the last strands, whose radius is multiplied with
  float fade = 1;            ///< this, 0..1
  float fiberRadius = 0;     ///< at the root [m]
  float tipRadiusRatio = 1;  ///< 0..1
  float opacity = 1;         ///< of a fiber, 0..1
  float strandLength = 0;    ///< mean [m]
  float volume = 0;          ///< hairVolume() [m3]; 0: not known
  float meanThickness = 1;   ///< of the factors in `thickness`
  float maxThickness = 1;    ///< likewise; what is thicker is taken to be this
  BufferId positions = BufferId::kInvalid;
  BufferId thickness = BufferId::kInvalid;          ///< [strand] float; kInvalid: all 1
  BufferId followHairRecords = BufferId::kInvalid;  ///< when follow strands are to be placed
  BufferRange rootTransforms;                       ///< likewise
  bool operator==(const ShadowedHair&) const = default;
};

struct StrandShadowDef {
  Float3 toLight = {0, 1, 0};  ///< towards a light whose rays are parallel; normalised on use
  bool hasPosition = false;    ///< a light at a point; toLight is against the axis of its cone
  Float3 position = {};        ///< of it [m]
  float coneAngle = 0;         ///< half angle of its cone [rad]; 0: it shines in all directions
  Float3 center = {};          ///< of a ball around all hair, in world space [m]
  /// Shift of the scene's origin [m]: texels stay where they are in the first world.
  Vector3<double> shifted;
  float radius = 0;          ///< of it [m]; keep it from frame to frame, texels depend on it
  uint32_t size = 1024;      ///< texels an edge, 4..8192
  uint32_t layers = 8;       ///< 1..16; 0: distances alone
  uint32_t firstWord = 0;    ///< of the map in the buffer of all maps
  float biasTexels = 0.35f;  ///< bias [texel], >= 0
  float layerRange = 0;      ///< [m] that the layers take up; 0: found from the hair
  float volume = 0;          ///< of all hair [m3]; 0: the sum, or where one is not known the ball
};

struct StrandShadowPlan {
  StrandShadowView view = {};
  float spacing = 0;   ///< mean way of a ray between two fibers [m]; infinity without hair
  uint32_t words = 0;  ///< of the map, from view.firstWord on
  uint64_t bytes() const { return uint64_t{words} * sizeof(uint32_t); }
};

/// Volume of the strands at the density that they have where they are, on average over their
/// length: (sum l)^2 / (sum l^2) cells, for lengths l in the cells of a grid of 16 along the
/// longest side of their box. Guides alone will do. \param positions [strand][vertex] [m], in any
/// one pose; those that are not finite are left out.
double hairVolume(std::span<const Float4> positions, uint32_t vertexCount);

/// Fits a map around the ball. Its texels stay where they are in the world, for one direction and
/// one radius: the shadow does not crawl when the ball moves. That of a point light is a map in
/// perspective around the narrower of the ball and the cone; where the ball is too close for one,
/// it is a cube with faces of half the size. Errors: a size, number of layers, ball or position
/// that is out of range; a hair object whose fibers are not finite; a map that ends beyond 2^32
/// words; too many segments for the sums.
Result<StrandShadowPlan> planStrandShadow(const StrandShadowDef& def,
                                          std::span<const ShadowedHair> hairs);

struct StrandShadowBuffers {
  BufferId views = BufferId::kInvalid;  ///< [map] StrandShadowView, with BufferUsage::kUpload
  uint32_t viewCount = 1;               ///< elements of it
  uint32_t view = 0;                    ///< which one is the map's
  BufferId words = BufferId::kInvalid;  ///< of all maps, uint32
  uint64_t wordCount = 0;               ///< elements of it
};

/// Adds the upload of the view and the passes that fill the map. Errors: those of
/// PassBuilder::finish().
Result<void> addStrandShadow(PassList& list, const StrandShadowPlan& plan,
                             const StrandShadowBuffers& buffers,
                             std::span<const ShadowedHair> hairs);

}  // namespace pelage::detail
