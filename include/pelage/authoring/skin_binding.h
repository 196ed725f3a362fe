// Binds hair to a skinned mesh: bones and weights of each root, and its position on the surface.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pelage/authoring/skinned_mesh.h"
#include "pelage/bone_weights.h"
#include "pelage/hair_asset.h"
#include "pelage/result.h"
#include "pelage/skin_table.h"
#include "pelage/types.h"

namespace pelage {

struct BindDef {
  /// Roots farther from the mesh than this [m], >= 0, are bound, too, and reported.
  float maxDistance = 0.005f;
  uint32_t maxBones = 4;  ///< 1..4; the heaviest are kept
};

struct FarStrand {
  uint32_t strand = 0;
  float distance = 0;  ///< [m]
  bool operator==(const FarStrand&) const = default;
};

struct BindReport {
  float maxDistance = 0, meanDistance = 0;  ///< of the roots from the mesh [m]
  std::vector<FarStrand> farStrands;        ///< beyond BindDef::maxDistance, ascending strands
  /// Triangles without area; no root is bound to one.
  uint32_t degenerateTriangles = 0;
  /// Maximum sum of the weights that a root lost by BindDef::maxBones, 0..1.
  float maxLostWeight = 0;
};

struct SkinBinding {
  /// Weights of the closest point, interpolated over its triangle; the heaviest bones, with a sum
  /// of 1. Only bones that a root follows are kept, in the order of the mesh: an engine needs no
  /// others, and bones for other purposes in the artist's file do no harm.
  BoneWeights weights;
  SkinTable table;
  BindReport report;
};

/// Binds each root to the closest point of the mesh; of several equally close triangles, to that
/// with the lowest index. Roots and mesh are in the same space, in meters. Errors: no roots, a root
/// that is not finite or beyond kMaxCoordinate, a mesh that validate() refuses or that has no area,
/// a value of `def` out of range.
Result<SkinBinding> bindRoots(std::span<const Float3> roots, const SkinnedMesh& mesh,
                              const BindDef& def = {});

/// Returns vertex 0 of each strand. Empty if the asset has fewer positions than its counts say.
std::vector<Float3> rootsOf(const HairAsset& asset);

/// The difference of the weights of two files for one groom. The difference of a strand is the sum
/// over all bones, by name, of |a - b|, with the weights of each side scaled to the sum 1: 0 is
/// equal, 2 means no bone in common.
struct WeightComparison {
  float mean = 0, max = 0;        ///< 0..2
  float shareAboveTenth = 0;      ///< share of the strands with a difference above 0.1, 0..1
  std::vector<float> difference;  ///< [strand]
};

/// Compares the weights of two files. Errors: different numbers of strands, a bone index out of
/// range.
Result<WeightComparison> compareWeights(const BoneWeights& a, const BoneWeights& b);

}  // namespace pelage
