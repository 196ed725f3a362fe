// A procedural groom: a head with hair, generated from a few numbers, so that samples, tests and
// benchmarks need no file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

#include "pelage/bone_weights.h"
#include "pelage/collision_mesh.h"
#include "pelage/export.h"
#include "pelage/hair_asset.h"
#include "pelage/result.h"
#include "pelage/skeleton.h"
#include "pelage/types.h"

namespace pelage {

/// The direction in which the hair is combed.
enum class HairStyle : uint8_t {
  kSideParting,  ///< to both sides of a parting, then down
  kSweptBack,    ///< from the forehead to the back
};

/// The definition of a groom. The defaults are medium-long, slightly wavy hair with a side parting.
/// Values out of range are errors that name the field.
struct GroomDef {
  uint64_t seed = 1;                ///< another seed gives different hair of the same kind
  uint32_t strandCount = 2000;      ///< 1..1,000,000
  uint32_t verticesPerStrand = 24;  ///< 2..256
  HairStyle style = HairStyle::kSideParting;

  float length = 0.18f;           ///< along the hair [m], 0.002..2
  float lengthVariation = 0.15f;  ///< strands are shorter by up to this fraction, 0..0.95

  /// Angle between scalp and hair at the roots on top of the head [rad], 0..1.5; less below.
  float lift = 0.65f;
  float volume = 0.008f;  ///< thickness of the layer of hair on the head [m], 0..0.1
  float comb = 25.0f;     ///< how sharply hair bends to the combed direction [1/m], 0..1000
  float droop = 22.0f;    ///< how sharply it bends downwards [1/m], 0..1000

  float curlRadius = 0.003f;       ///< radius of the curls [m], 0..0.1
  float curlFrequency = 14.0f;     ///< turns per meter of hair, 0..500
  uint32_t clumpCount = 240;       ///< number of locks, 0..4096; 0 = none
  float clumpStrength = 0.4f;      ///< 0 = none, 1 = all tips of a lock meet
  float clumpLengthVariation = 0;  ///< locks are shorter by up to this fraction, 0..0.95
  float clumpTaper = 0;  ///< strands are shorter by up to this fraction at a lock's edge, 0..0.95
  float noise = 0.004f;  ///< random displacement of tips [m], 0..0.1

  float hairline = 0.0f;   ///< moves the edge of the hair up (> 0: less hair) [m], -0.03..0.05
  float hairlineFade = 0;  ///< width of shorter and thinner hair around the face [m], 0..0.05
  float stripWidth =
      0.0f;  ///< > 0: width of a strip along the middle with hair [m]; 0..0.3, 0 = all
  float thicknessVariation = 0.2f;  ///< strands are thinner by up to this fraction, 0..1; 0 = equal

  float headCellSize = 0.005f;  ///< size of the head mesh's cells [m], 0.002..0.007
};

/// A head with hair, in bind pose. Y is up, the face looks along +Z, +X is the head's left. The
/// neck ends in the plane y = 0; the chin is at y = 0.10 m, the top of the head at 0.33 m.
struct Groom {
  HairAsset hair;     ///< process() has not been called; vertices 0 and 1 of a strand are kinematic
  BoneWeights bones;  ///< of the strands; bone indices are those of `skeleton`
  CollisionMesh head;     ///< closed, outward oriented, unit normals; bone indices likewise
  Skeleton skeleton;      ///< 0: "neck", 1: "head" (its child)
  float rootSpacing = 0;  ///< no two roots are closer than this [m]
};

/// Makes a groom. Equal definitions give equal bits on every machine. Roots are a Poisson-disc
/// sample of the scalp in random order, so the first strands alone also cover all of it. The root
/// of a strand is on the mesh; its other vertices are outside of the head. Errors: a value out of
/// range, no scalp to place hair on.
PELAGE_DEMO_API Result<Groom> generateGroom(const GroomDef& def = {});

/// Makes brows and upper lashes of the same head, in bind pose: hair that moves with the bone
/// "head" as a whole (HairObject::simulated = false). The first strands alone cover all of them.
/// process() has not been called.
PELAGE_DEMO_API Result<HairAsset> generateFaceHair(uint64_t seed = 1);

/// Makes the bald head. `cellSize` is that of GroomDef::headCellSize.
PELAGE_DEMO_API Result<CollisionMesh> generateHead(float cellSize = 0.005f);
PELAGE_DEMO_API Skeleton headSkeleton();

/// Returns the distance [m] from the head's surface, negative inside: the function that generates
/// the mesh. It is exact at the surface and approximate elsewhere.
PELAGE_DEMO_API float headDistance(const Float3& point);

/// Writes `NAME.tfx`, `NAME.tfxbone` and `NAME.tfxmesh` into a folder, which must exist.
PELAGE_DEMO_API Result<void> writeGroom(const Groom& groom, const std::filesystem::path& directory,
                                        std::string_view name);

}  // namespace pelage
