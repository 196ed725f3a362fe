// Generates a groom on a head.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pelage/bone_weights.h"
#include "pelage/collision_mesh.h"
#include "pelage/demo/character.h"
#include "pelage/demo/groom.h"
#include "pelage/hair_asset.h"
#include "pelage/result.h"
#include "pelage/skeleton.h"

namespace sample {

struct DemoAssets {
  std::string name;
  pelage::HairAsset hair;  ///< processed
  pelage::BoneWeights weights;
  pelage::Skeleton skeleton;  ///< in the order of `weights`
  std::optional<pelage::CollisionMesh> mesh;
  float rootSpacing = 0;  ///< no two roots are closer than this [m]; 0 when that is not known

  /// Bones that the hair and the mesh together may refer to, at least 1.
  uint32_t boneCount() const;
};

/// Makes the head and its groom.
pelage::Result<DemoAssets> generateAssets(const pelage::GroomDef& def);

/// Puts the guides in `copies` times, one copy after the other and all at the same place: for
/// measurements at a larger size. \param influences [strand] of the hair, or empty. Errors: more
/// guides than 32 bits count.
pelage::Result<void> repeatGuides(pelage::HairAsset& hair,
                                  std::vector<pelage::BoneInfluences>& influences, uint32_t copies);

/// Writes NAME.tfx, NAME.tfxbone and, when there is one, NAME.tfxmesh into a folder, which is made
/// when it is not there.
pelage::Result<void> writeAssets(const DemoAssets& assets, const std::filesystem::path& folder);

/// The same of a character: NAME.tfx and NAME.tfxbone of each groom, NAME.tfxmesh of each collider,
/// and character.gltf with character.bin.
pelage::Result<void> writeAssets(const pelage::Character& character,
                                 const std::filesystem::path& folder);

/// [vertex of the mesh] how much of the colour under the hair it takes: 1 where roots are near,
/// falling to 0 at `range` [m] from the nearest root. Hair of less than 0.6 of the radius hides no
/// skin.
std::vector<float> coveredShares(const pelage::CollisionMesh& mesh, const pelage::HairAsset& hair,
                                 float range);

}  // namespace sample
