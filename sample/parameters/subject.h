// The hair and the bodies of the small pictures.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "pelage/bone_weights.h"
#include "pelage/collision_mesh.h"
#include "pelage/hair_asset.h"
#include "pelage/result.h"
#include "setup.h"

namespace sample {

struct SubjectAssets {
  pelage::HairAsset hair;                          ///< processed
  std::vector<pelage::BoneInfluences> influences;  ///< of the guides; empty for bone 0
  uint32_t boneCount = 1;                          ///< the last one is what moves
  std::optional<pelage::CollisionMesh> body;
  std::vector<float> scalp;  ///< of the body's vertices, share of the colour under the hair
};

/// Makes what the setup shows. Errors: those of the groom and of process().
pelage::Result<SubjectAssets> makeSubject(const Setup& setup);

/// A capsule of triangles, closed, on bone 0: a ball where its ends are one.
pelage::CollisionMesh makeCapsule(const pelage::Float3& head, float headRadius,
                                  const pelage::Float3& tail, float tailRadius);

}  // namespace sample
