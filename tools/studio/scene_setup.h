// Shared by the demo scenes: the points that the camera shows, and the light.
#pragma once

#include <span>
#include <vector>

#include "pelage/bone_weights.h"
#include "pelage/collision_mesh.h"
#include "pelage/hair_asset.h"
#include "pelage/types.h"
#include "pelage/view.h"

namespace sample {

inline constexpr float kScalpRange = 2.4f;  ///< root spacings that the colour under hair reaches
inline constexpr double kSweptStep = 0.1;   ///< s between the poses that the camera looks at

/// Minimum global stiffness of the classic solver, on all of a strand: its local shape alone does
/// not carry the hair's weight. Hair sinks by about 9.81 / 60^2 / 0.157 m = 17 mm.
inline constexpr float kClassicGlobalStiffness = 0.157f;

/// A point of the bind pose in a pose: the weighted mean of where its bones put it; without
/// weights where bone 0 does.
pelage::Float3 blendedPoint(const std::vector<pelage::AffineTransform>& bones,
                            const pelage::BoneInfluences& influences, const pelage::Float3& point);
/// Adds some points of a groom in a pose. \param influences [strand]; empty for bone 0.
void sweepHair(const pelage::HairAsset& hair, std::span<const pelage::BoneInfluences> influences,
               const std::vector<pelage::AffineTransform>& bones,
               std::vector<pelage::Float3>& points);
/// Adds some vertices of a mesh in a pose.
void sweepMesh(const pelage::CollisionMesh& mesh, const std::vector<pelage::AffineTransform>& bones,
               std::vector<pelage::Float3>& points);

/// The key of a studio for a camera in this direction: a warm light from the upper left. Its
/// environment is the fill: a cool sky, and less light from the right.
pelage::Light studioLight(const pelage::Float3& camera);
/// The key, and a cool rim light from behind on the right.
std::vector<pelage::Light> studioLights(const pelage::Float3& camera);

/// A parallel view of these points from the light, on a map of size x size texels, with depth for
/// three times their extent in front of them.
pelage::View lightView(std::span<const pelage::Float3> points, const pelage::Float3& toLight,
                       uint32_t size);

}  // namespace sample
