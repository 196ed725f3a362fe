// The rows of hair objects and colliders.
#include <algorithm>
#include <cmath>
#include <string>

#include "groups.h"

namespace sample {

using pelage::CapsuleCollider;
using pelage::ColliderLook;
using pelage::ColorTexture;
using pelage::Float3;
using pelage::FollowDef;
using pelage::HairDef;
using pelage::HairObject;
using pelage::ProcessDef;
using pelage::SdfCollider;
using pelage::SdfColliderDef;
using pelage::StrandFactors;

namespace {

// The root is drawn back, so that the lock slides over the ball.
Setup sliding(Setup setup, uint32_t frames) {
  setup.frames = frames;
  setup.motion = [](double seconds) {
    const auto t = static_cast<float>(std::max(seconds - 1.5, 0.0));
    return pelage::rigidTransform({0, 0, 0, 1}, {-0.07f * t, 0.02f * t, 0});
  };
  setup.center = {0.04f, -0.05f, 0};
  setup.extent = 0.3f;
  return setup;
}

// The head turns fast.
Setup swinging() {
  Setup setup = headSetup();
  setup.hair.settings = {};
  setup.hair.settings.vspCoefficient = 0;
  setup.hair.settings.bendLength = 0.08f;
  setup.groom.style = pelage::HairStyle::kSweptBack;
  setup.groom.length = 0.28f;
  setup.frames = 30;
  setup.motion = [](double seconds) {
    const auto half = static_cast<float>(0.9 * seconds * seconds);
    return pelage::rigidTransform({0, std::sin(half), 0, std::cos(half)}, {});
  };
  setup.center = {0, 0.17f, 0};
  setup.extent = 0.42f;
  return setup;
}

Setup drawnField() {
  Setup setup = headSetup();
  setup.hasField = setup.drawsField = true;
  setup.collider.cellSize = 0.006f;
  setup.collider.band = 5;
  setup.groom.strandCount = 300;
  setup.groom.length = 0.06f;
  setup.groom.headCellSize = 0.004f;
  return setup;
}

// Every second guide of a lock is another one.
template <class Apply>
Picture factors(Setup base, Apply apply, std::string caption) {
  base.lock.fan = 0.05f;
  return show(std::move(base), std::vector{0.0f, 1.0f, 10.0f}, apply, std::move(caption));
}

std::vector<Parameter> objectRows() {
  return {
      {PELAGE_FIELD(HairObject, settings),
       "",
       "see SimulationSettings",
       "Settings of the simulation; Scene::simulate() checks them.",
       {}},
      {PELAGE_FIELD(HairObject, material), "", "see StrandMaterial", "Look of the hair.", {}},
      {PELAGE_FIELD(HairObject, strandTexture),
       "",
       "see StrandTexture",
       "A texture of your engine that colors the strands, in place of HairDef::baseTexture; costs "
       "a "
       "pass in each view. Needs HairDef::strandUvs.",
       {}},
      tuned("HairObject", "simulatedShare",
            show(
                swinging(), std::vector{0.004f, 0.05f, 1.0f},
                [](Setup& s, float v) { s.simulatedShare = v; },
                "0.5 s into a fast rotation: 8, 100 and all 2,000 guides.")),
      tuned("HairObject", "simulated"),
      tuned("HairObject", "blendTime"),
      tuned("HairObject", "usesMeshColliders",
            show(
                fieldSetup(), std::vector{false, true},
                [](Setup& s, bool v) { s.usesMeshColliders = v; },
                "The lock falls through the mesh, or lies on it.")),
      tuned("HairObject", "visible"),
      tuned("HairObject", "drawnStrands",
            [] {
              Picture picture = show(
                  headSetup(), std::vector{0.03f, 0.2f, 1.0f},
                  [](Setup& s, float v) { s.drawnStrands = v; },
                  "Fewer strands of the same width: hair gets thin.");
              picture.values = {"420", "2800", "all (14000)"};
              return picture;
            }()),
      tuned(
          "HairObject", "drawnShare",
          show(
              headSetup(), std::vector{0.03f, 0.2f, 1.0f},
              [](Setup& s, float v) { s.drawnShare = v; }, "As many strands as above, but wider.")),
      tuned("HairObject", "tracksMotion"),
      tuned("HairObject", "interpolates"),
  };
}

std::vector<Parameter> bindingRows() {
  return {
      {PELAGE_FIELD(HairDef, name),
       "",
       "",
       "Name of the object, in errors and names of buffers.",
       {}},
      {PELAGE_FIELD(HairDef, settings), "", "see SimulationSettings", "The first settings.", {}},
      {PELAGE_FIELD(HairDef, material), "", "see StrandMaterial", "The first material.", {}},
      tuned("HairDef", "skinning",
            show(
                sleeveSetup(),
                std::vector{pelage::SkinningMethod::kMatrices,
                            pelage::SkinningMethod::kDualQuaternions},
                [](Setup& s, pelage::SkinningMethod v) { s.hair.skinning = v; },
                "Fur on a tube whose right half is rotated by 170 degrees: blended matrices "
                "collapse.")),
      {PELAGE_FIELD(HairDef, influences),
       "",
       "one per guide",
       "Bones and weights of the roots, from mapBones(); if empty, all roots are bound to bone 0.",
       {}},
      {PELAGE_FIELD(HairDef, boneCount),
       "",
       ">= 1",
       "Number of transforms that setBones() takes.",
       {}},
      {PELAGE_FIELD(HairDef, skeleton),
       "",
       "of the scene",
       "A skeleton to follow instead of setBones().",
       {}},
      {PELAGE_FIELD(HairDef, strandFactors),
       "",
       "one per guide; see StrandFactors",
       "Factors of every guide; if empty, all are 1.",
       {}},
  };
}

std::vector<Parameter> strandRows() {
  return {
      tuned("HairDef", "levelOfDetail"),
      {PELAGE_FIELD(HairDef, followHairs),
       "",
       "existing guides; see FollowDef",
       "Follow hairs, from generateFollowHairs().",
       {}},
      {PELAGE_FIELD(HairDef, baseTexture),
       "",
       "see ColorTexture",
       "Texture of the base color, sampled at HairAsset::strandUv of the roots.",
       {}},
      {PELAGE_FIELD(HairDef, strandUvs),
       "",
       "needs HairAsset::strandUv",
       "Puts the UV of the roots on the GPU, for HairObject::strandTexture, engine lights and your "
       "own shaders; costs 16 bytes per guide.",
       {}},
      tuned("HairDef", "storeFollowHairs"),
      tuned(
          "HairDef", "collidingHair",
          show(
              with(fieldSetup(),
                   [](Setup& s) {
                     s.lock.guides = 6;
                     s.follow = {.countPerGuide = 40, .maxRadius = 0.02f};
                     s.hair.material.fiberRadius = 120e-6f;
                     s.center = {0.085f, -0.03f, 0};
                     s.extent = 0.14f;
                   }),
              std::vector{pelage::CollidingHair::kGuides, pelage::CollidingHair::kGuidesAndFollows},
              [](Setup& s, pelage::CollidingHair v) { s.hair.collidingHair = v; },
              "Wide bundles: follow hairs go through the mesh, or are moved out.")),
  };
}

std::vector<Parameter> factorRows() {
  return {
      {PELAGE_FIELD(StrandFactors, stiffness), "factor", ">= 0", "Factor on bending and twist.",
       factors(
           lockSetup(), [](Setup& s, float v) { s.strandStiffness = v; },
           "At rest; every second guide has the factor, the others have 1.")},
      {PELAGE_FIELD(StrandFactors, globalStiffness), "factor", ">= 0",
       "Factor on the spring to the bind pose.",
       factors(
           with(lockSetup(),
                [](Setup& s) {
                  s.hair.settings.globalStiffness = 0.01f;
                  s.hair.settings.globalRange = 1;
                }),
           [](Setup& s, float v) { s.strandGlobalStiffness = v; },
           "The same with a globalStiffness of 0.01 on the whole strand.")},
      {PELAGE_FIELD(StrandFactors, damping), "factor", ">= 0", "Factor on the air drag.",
       factors(
           with(lockSetup(), [](Setup& s) { s.frames = 22; }),
           [](Setup& s, float v) { s.strandDamping = v; },
           "0.37 s after the lock was released; every second guide has the factor.")},
  };
}

std::vector<Parameter> textureRows() {
  Picture picture = show(
      swatchSetup(), std::vector{0u, 2u, 8u}, [](Setup& s, uint32_t v) { s.textureSize = v; },
      "No texture, and stripes of 2 and 8 texels over the roots: a strand has one color.");
  return {
      {PELAGE_FIELD(ColorTexture, width), "texels", "0..16384", "Width of the texture.", picture},
      {PELAGE_FIELD(ColorTexture, height), "texels", "0..16384", "Height of the texture.", {}},
      {PELAGE_FIELD(ColorTexture, texels),
       "linear RGBA",
       "0..1",
       "Rows from y = 0 on; A multiplies the opacity. The texture repeats beyond 0..1.",
       {}},
  };
}

std::vector<Parameter> strandTextureRows() {
  return {
      {PELAGE_FIELD(StrandTexture, texture),
       "",
       "of newTextureId()",
       "The texture, registered with the runtime with its sampler; none colors nothing.",
       {}},
      {PELAGE_FIELD(StrandTexture, width), "texels", "1..65536", "Width of mip level 0.", {}},
      {PELAGE_FIELD(StrandTexture, height), "texels", "1..65536", "Height of mip level 0.", {}},
      {PELAGE_FIELD(StrandTexture, mipLevels),
       "levels",
       "1..17",
       "Levels that are chosen from, by distances between roots and pixels of the view.",
       {}},
      {PELAGE_FIELD(StrandTexture, lodBias),
       "levels",
       "-16..16",
       "Added to the level; -1 takes one of twice the texels an edge.",
       {}},
  };
}

std::vector<Parameter> followRows() {
  const Setup few = with(lockSetup(), [](Setup& s) {
    s.lock.guides = 6;
    s.hair.settings.bendLength = 0.1f;
    s.follow = {.countPerGuide = 24, .maxRadius = 0.006f};
    s.extent = 0.2f;
    s.center = {0.085f, -0.03f, 0};
  });
  const auto separation = [](Setup& s, float v) { s.follow.tipSeparation = v; };
  return {
      tuned("FollowDef", "countPerGuide",
            show(
                few, std::vector{0u, 8u, 40u},
                [](Setup& s, uint32_t v) { s.follow.countPerGuide = v; }, "Six guides.")),
      tuned("FollowDef", "guidesPerHair",
            show(
                with(headSetup(),
                     [](Setup& s) {
                       s.groom.strandCount = 70;
                       s.groom.length = 0.24f;
                       s.groom.clumpCount = 0;
                       s.groom.noise = 0.012f;
                       s.follow = {.countPerGuide = 64, .maxRadius = 0.02f};
                     }),
                std::vector{1u, 2u, 3u}, [](Setup& s, uint32_t v) { s.follow.guidesPerHair = v; },
                "70 guides with 64 wide follow hairs each: bundles dissolve.")),
      tuned("FollowDef", "maxRadius",
            show(
                few, std::vector{0.0015f, 0.004f, 0.02f},
                [](Setup& s, float v) { s.follow.maxRadius = v; },
                "Six guides with 24 follow hairs each.")),
      tuned("FollowDef", "tipSeparation",
            show(few, std::vector{0.0f, 1.0f, 4.0f}, separation,
                 "The same guides: gathered at the tip, parallel, spread.")),
      tuned(
          "FollowDef", "flyaways",
          show(
              few, std::vector{0.0f, 0.1f, 0.5f}, [](Setup& s, float v) { s.follow.flyaways = v; },
              "The same guides: none, a tenth, half.")),
      tuned("FollowDef", "seed"),
  };
}

std::vector<Parameter> capsuleRows() {
  return {
      {PELAGE_FIELD(CapsuleCollider, head), "m", "", "Center of one end in world space.", {}},
      {PELAGE_FIELD(CapsuleCollider, headRadius), "m", ">= 0", "Radius of this end.",
       show(
           capsuleSetup(), std::vector{0.01f, 0.03f, 0.045f},
           [](Setup& s, float v) { s.capsules[0].headRadius = s.capsules[0].tailRadius = v; },
           "At rest on a capsule with two equal radii.")},
      {PELAGE_FIELD(CapsuleCollider, tail),
       "m",
       "",
       "Center of the other end; equal to the head for a sphere.",
       {}},
      {PELAGE_FIELD(CapsuleCollider, tailRadius), "m", ">= 0", "Radius of the other end.", {}},
      {PELAGE_FIELD(CapsuleCollider, friction), "", ">= 0", "Coulomb coefficient.",
       show(
           sliding(capsuleSetup(), 138), std::vector{0.0f, 0.3f, 1.5f},
           [](Setup& s, float v) { s.capsules[0].friction = v; },
           "The root is drawn back to the left: friction holds the lock.")},
      {PELAGE_FIELD(CapsuleCollider, angularVelocity),
       "rad/s",
       "",
       "Angular velocity in world space: drags hair along by friction, but does not move the "
       "collider.",
       {}},
  };
}

std::vector<Parameter> fieldRows() {
  return {
      {PELAGE_FIELD(SdfColliderDef, name), "", "", "Name of the collider.", {}},
      {PELAGE_FIELD(SdfColliderDef, cellSize), "m", "> 0; 0 means a 50th of the longest side",
       "Distance between the nodes of the SDF. Parts thinner than about a cell let fast hair "
       "through.",
       show(
           drawnField(), std::vector{0.024f, 0.012f, 0.004f},
           [](Setup& s, float v) { s.collider.cellSize = v; },
           "The head as its SDF stores it (Scene::drawCollider()).")},
      {PELAGE_FIELD(SdfColliderDef, band),
       "cells",
       "1..8",
       "Nodes within this distance of the surface have exact distances.",
       {}},
      {PELAGE_FIELD(SdfColliderDef, memoryCap),
       "bytes",
       "",
       "Maximum memory of the SDF; an error names the cell size that would fit.",
       {}},
      {PELAGE_FIELD(SdfColliderDef, motionTolerance),
       "cells",
       "0..1",
       "Vertices that moved by less than this keep their position in the SDF.",
       {}},
      {PELAGE_FIELD(SdfColliderDef, skinning),
       "",
       "kMatrices, kDualQuaternions",
       "As HairDef::skinning.",
       {}},
      {PELAGE_FIELD(SdfColliderDef, boneCount),
       "",
       "> 0",
       "Number of transforms that setBones() takes.",
       {}},
      {PELAGE_FIELD(SdfColliderDef, skeleton),
       "",
       "of the scene",
       "A skeleton to follow instead of setBones().",
       {}},
      {PELAGE_FIELD(SdfColliderDef, vertices),
       "",
       "",
       "A vertex buffer of your engine in world space, instead of bones.",
       {}},
      {PELAGE_FIELD(SdfColliderDef, vertexStride),
       "floats",
       ">= 3",
       "Distance from vertex to vertex.",
       {}},
      {PELAGE_FIELD(SdfColliderDef, vertexOffset), "floats", "", "Offset of the first x.", {}},
  };
}

std::vector<Parameter> colliderRows() {
  return {
      tuned("SdfCollider", "margin",
            show(
                fieldSetup(), std::vector{0.001f, 0.006f, 0.015f},
                [](Setup& s, float v) { s.margin = v; }, "At rest on a mesh: the gap grows.")),
      tuned("SdfCollider", "friction",
            show(
                sliding(fieldSetup(), 150), std::vector{0.0f, 0.3f, 1.5f},
                [](Setup& s, float v) { s.friction = v; },
                "The root is drawn back to the left: friction holds the lock.")),
      tuned("SdfCollider", "enabled"),
  };
}

std::vector<Parameter> lookRows() {
  return {
      tuned("ColliderLook", "isoLevel",
            show(
                drawnField(), std::vector{-4.0f, 0.0f, 4.0f},
                [](Setup& s, float v) { s.colliderLook.isoLevel = v; },
                "Inside, on, and outside of the head, with cells of 6 mm and a band of 5.")),
      tuned(
          "ColliderLook", "color",
          show(
              drawnField(),
              std::vector<Float3>{{0.10f, 0.20f, 0.32f}, {0.35f, 0.08f, 0.05f}, {0.5f, 0.5f, 0.5f}},
              [](Setup& s, const Float3& v) { s.colliderLook.color = v; }, "Three colors.")),
      tuned(
          "ColliderLook", "opacity",
          show(
              with(drawnField(), [](Setup& s) { s.colliderLook.isoLevel = 4; }),
              std::vector{0.2f, 0.6f, 1.0f}, [](Setup& s, float v) { s.colliderLook.opacity = v; },
              "A surface 4 cells outside of the head, with hair behind it; its inside is drawn in "
              "red.")),
  };
}

std::vector<Parameter> contactLookRows() {
  return {
      tuned("ContactLook", "length"),
      tuned("ContactLook", "width"),
      tuned("ContactLook", "deepestDepth"),
  };
}

}  // namespace

std::vector<ParameterGroup> hairGroups() {
  const std::string object = "pelage/hair_object.h", asset = "pelage/hair_asset.h";
  return {
      {"HairObject", object, "Scene::hair(); may change at any time. [scene.md](scene.md)",
       objectRows()},
      {"HairDef", object, "Argument of Scene::addHair(); cannot change later.",
       joined(bindingRows(), strandRows())},
      {"StrandFactors", object, "HairDef::strandFactors", factorRows()},
      {"ColorTexture", object, "HairDef::baseTexture", textureRows()},
      {"StrandTexture", "pelage/strand_texture.h",
       "HairObject::strandTexture. [shading.md](shading.md#an-engines-texture-on-strands)",
       strandTextureRows()},
      {"FollowDef", asset, "HairAsset::generateFollowHairs()", followRows()},
      {"ProcessDef",
       asset,
       "HairAsset::process()",
       {{PELAGE_FIELD(ProcessDef, tipThickness),
         "share",
         "0..1",
         "Thickness of the tip relative to the root in HairAsset::vertexThickness, for your own "
         "renderer.",
         {}}}},
  };
}

std::vector<ParameterGroup> colliderGroups() {
  const std::string sdf = "pelage/sdf_collider.h";
  return {
      {"CapsuleCollider", "pelage/collider.h",
       "HairObject::setColliders(). [contact.md](contact.md)", capsuleRows()},
      {"SdfColliderDef", sdf, "Argument of Scene::addCollider(); cannot change later.",
       fieldRows()},
      {"SdfCollider", sdf, "Scene::collider(); may change at any time.", colliderRows()},
      {"ColliderLook", sdf, "Scene::drawCollider(), for debugging.", lookRows()},
      {"ContactLook", "pelage/hair_object.h",
       "Scene::drawContacts(), for debugging. [contact.md](contact.md)", contactLookRows()},
  };
}

}  // namespace sample
