// The table's rows of hair objects and colliders.
#include "parameter_row.h"

namespace pelage::settings {
namespace {

constexpr std::string_view kSkinningMethods[] = {"kMatrices", "kDualQuaternions"};
constexpr std::string_view kCollidingHair[] = {"kGuides", "kGuidesAndFollows"};

}  // namespace

std::vector<Parameter> objectParameters() {
  return {
      PELAGE_PARAMETER_AS("HairObject", HairObjectSettings, simulatedShare)
          .says("share of the guides", "0..1",
                "With HairDef::levelOfDetail: fraction of the guides that is simulated; at least "
                "one is. Each other guide takes the shape of a simulated one near it.")
          .within(0, 1)
          .log()
          .ofSolver("exact")
          .pictured(),
      PELAGE_PARAMETER_AS("HairObject", HairObjectSettings, simulated)
          .says(
              "", "",
              "If false, the hair is moved rigidly with its bones, without a solver and contacts."),
      PELAGE_PARAMETER_AS("HairObject", HairObjectSettings, blendTime)
          .says("s", ">= 0",
                "Time in which gravity, wind and forces rise after `simulated` has become true "
                "again.")
          .atLeast(0)
          .slider(0, 5),
      PELAGE_PARAMETER_AS("HairObject", HairObjectSettings, usesMeshColliders)
          .says("", "",
                "If true, the hair collides with mesh colliders: with those of setMeshColliders(), "
                "or all.")
          .pictured(),
      PELAGE_PARAMETER_AS("HairObject", HairObjectSettings, visible)
          .says("", "", "A hidden object is simulated, but not drawn."),
      PELAGE_PARAMETER_AS("HairObject", HairObjectSettings, drawnStrands)
          .says("strands", "0..strandCount()",
                "Number of strands that are drawn, from the first. Decreasing it removes follow "
                "hairs first.")
          .logSlider(0, 1e6)
          .pictured(),
      PELAGE_PARAMETER_AS("HairObject", HairObjectSettings, drawnShare)
          .says("share of drawnStrands", "0..1",
                "Level of detail: fewer, wider strands cover the same area. See "
                "Scene::shareForView().")
          .within(0, 1)
          .log()
          .pictured(),
      PELAGE_PARAMETER_AS("HairObject", HairObjectSettings, tracksMotion)
          .says("", "",
                "Keeps the positions of the last frame for motion vectors; costs a pass and a "
                "buffer. [shading_depth.md](shading_depth.md)"),
      PELAGE_PARAMETER_AS("HairObject", HairObjectSettings, interpolates)
          .says("", "",
                "Keeps the state before each simulation, so that Frame::interpolate() can draw "
                "between fixed steps; costs a pass and three buffers. "
                "[scene.md](scene.md#fixed-steps)"),
  };
}

std::vector<Parameter> creationParameters() {
  return {
      PELAGE_PARAMETER_AS("HairDef", HairCreation, skinning)
          .says("", "kMatrices, kDualQuaternions",
                "Blending of the bones of a root; dual quaternions are for bones without scale.")
          .names(kSkinningMethods)
          .pictured(),
      PELAGE_PARAMETER_AS("HairDef", HairCreation, levelOfDetail)
          .says("", "", "Allows HairObject::simulatedShare below 1; costs one uint32 per guide.")
          .ofSolver("exact"),
      PELAGE_PARAMETER_AS("HairDef", HairCreation, storeFollowHairs)
          .says("", "", "Set this if your own pass reads the follow hairs from HairBuffers."),
      PELAGE_PARAMETER_AS("HairDef", HairCreation, collidingHair)
          .says("", "kGuides, kGuidesAndFollows",
                "Strands that collide. Follow hairs cost four passes and 96 bytes per vertex.")
          .names(kCollidingHair)
          .pictured(),
  };
}

std::vector<Parameter> followParameters() {
  return {
      PELAGE_PARAMETER(FollowDef, countPerGuide)
          .says("hairs per guide", "0..64", "Number of follow hairs per guide.")
          .within(0, 64)
          .pictured(),
      PELAGE_PARAMETER(FollowDef, guidesPerHair)
          .says("guides", "1..3",
                "Number of guides that shape each hair: its own, and those with the nearest roots.")
          .within(1, 3)
          .pictured(),
      PELAGE_PARAMETER(FollowDef, maxRadius)
          .says("m", "0..1", "Radius of the disc around the guide's root.")
          .within(0, 1)
          .logSlider(0, 0.1)
          .pictured(),
      PELAGE_PARAMETER(FollowDef, tipSeparation)
          .says("factor", "0..100",
                "Distance from the guide at the tip relative to that at the root; 1 keeps the hair "
                "parallel.")
          .within(0, 100)
          .slider(0, 4)
          .pictured(),
      PELAGE_PARAMETER(FollowDef, flyaways)
          .says("share", "0..1", "Share of hairs whose tips stand off, up to 4 radii farther.")
          .within(0, 1)
          .slider(0, 0.3)
          .pictured(),
      PELAGE_PARAMETER(FollowDef, seed)
          .says("", "", "Another seed gives other hairs.")
          .slider(0, 100),
  };
}

std::vector<Parameter> colliderParameters() {
  return {
      PELAGE_PARAMETER_AS("SdfCollider", ColliderSettings, margin)
          .says("m", ">= 0, at most about a band", "Distance that hair keeps from the surface.")
          .atLeast(0)
          .logSlider(0, 0.02)
          .pictured(),
      PELAGE_PARAMETER_AS("SdfCollider", ColliderSettings, friction)
          .says("", ">= 0", "Coulomb coefficient.")
          .atLeast(0)
          .slider(0, 2)
          .pictured(),
      PELAGE_PARAMETER_AS("SdfCollider", ColliderSettings, enabled)
          .says("", "", "A disabled collider is neither built nor applied."),
  };
}

std::vector<Parameter> colliderLookParameters() {
  return {
      PELAGE_PARAMETER(ColliderLook, isoLevel)
          .says("cells", "-band..band", "Distance of the drawn surface from the mesh.")
          .within(-8, 8)
          .pictured(),
      PELAGE_PARAMETER(ColliderLook, color)
          .says("linear RGB", "0..1", "Color of the drawn surface.")
          .within(0, 1)
          .color()
          .pictured(),
      PELAGE_PARAMETER(ColliderLook, opacity)
          .says("", "0..1", "Below 1, hair behind it is visible.")
          .within(0, 1)
          .pictured(),
  };
}

std::vector<Parameter> contactLookParameters() {
  return {
      PELAGE_PARAMETER(ContactLook, length)
          .says("m", "> 0", "Length of the needle of a sticking contact; sliding ones have half.")
          .above(0)
          .logSlider(1e-4, 0.1),
      PELAGE_PARAMETER(ContactLook, width)
          .says("pixels", "> 0", "Width of a needle at the vertex.")
          .above(0)
          .slider(1, 20),
      PELAGE_PARAMETER(ContactLook, deepestDepth)
          .says("m", "> 0", "A vertex this deep is red.")
          .above(0)
          .logSlider(1e-5, 0.01),
  };
}

}  // namespace pelage::settings
