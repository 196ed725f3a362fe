// The pipelines that a program will need, before it has anything to show.
#pragma once

#include <vector>

#include "pelage/export.h"
#include "pelage/hair_depth.h"
#include "pelage/hair_object.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/simulation_settings.h"
#include "pelage/tier.h"
#include "pelage/transparency.h"

namespace pelage {

/// The features of the library that a program will use, at the start or later. They decide which
/// pipelines a scene needs; its size does not.
struct SceneFeatures {
  /// One for each kind of object: what differs between them (solver, contact between hairs, global
  /// stiffness, velocity shock propagation, ...) and may be switched on later.
  std::vector<SimulationSettings> settings = {SimulationSettings{}};
  bool capsules = true;               ///< HairObject::setColliders()
  bool meshColliders = true;          ///< Scene::addCollider()
  bool forces = false;                ///< HairObject::setForces()
  bool denseSdfs = false;             ///< Scene::addCollider() with a DenseSdf
  bool forceField = false;            ///< HairObject::setForceField()
  bool boneBuffers = false;           ///< BoneSource::kBuffer
  bool boneSurfaces = false;          ///< BoneSource::kSurface
  bool followHairs = true;            ///< HairDef::followHairs, not stored
  bool storedFollowHairs = false;     ///< HairDef::storeFollowHairs
  bool collidingFollowHairs = false;  ///< CollidingHair::kGuidesAndFollows
  bool levelOfDetail = false;         ///< HairDef::levelOfDetail
  bool attributes = false;  ///< HairAsset::strandThickness, vertexColor, HairDef::baseTexture
  /// HairObject::strandTexture; HairDef::strandUvs with engineLights that read them.
  bool strandTextures = false;
  bool skinnedHair = false;    ///< HairObject::simulated = false
  bool givenHair = false;      ///< HairObject::setPositions(), CachePlayer
  bool originShifts = false;   ///< Scene::shiftOrigin()
  bool teleports = false;      ///< Scene::teleport()
  bool motion = false;         ///< HairObject::tracksMotion
  bool interpolation = false;  ///< HairObject::interpolates
  bool shadows = true;         ///< Light::shadow, Scene::castShadows()
  bool opaqueShadows = false;  ///< Light::opaque
  /// One for each method that views use; TransparencySettings::opaqueDepth counts as given where it
  /// is not kInvalid. Empty: nothing is drawn.
  std::vector<TransparencySettings> transparency = {TransparencySettings{}};
  /// One for each HairDepthSettings::color that Frame::drawDepth() writes; empty: it is not called.
  std::vector<HairDepthSettings> depth = {};
  bool reversedDepth = false;  ///< View::reversedDepth
  Tier tier = Tier::kWide;     ///< Scene::setTier()
};

/// The features of hair objects that a view draws, for listToDraw().
struct DrawnFeatures {
  bool followHairs = false;     ///< HairDef::followHairs, not stored
  bool attributes = false;      ///< as SceneFeatures::attributes
  bool strandTextures = false;  ///< as SceneFeatures::strandTextures
};

/// Returns a list with a pass for each pipeline that a scene with these features needs, now or once
/// one of them is switched on. It is for vulkan::Runtime::prepare() and gl::Runtime::prepare()
/// alone, and cannot run:
///
///     auto list = listToPrepare({.settings = {game.hair}, .levelOfDetail = true});
///     if (list) ready = runtime.prepare(*list, &formats);  // while loading
///
/// Errors: settings out of range.
PELAGE_API Result<PassList> listToPrepare(const SceneFeatures& features);

/// Returns the same of the views alone, without what moves hair and without shadows: what
/// Scene::draw() adds for a method. For the runtimes' supports(). \param tier  as Scene::setTier()
/// is told. Errors: settings out of range.
PELAGE_API Result<PassList> listToDraw(const TransparencySettings& settings,
                                       const DrawnFeatures& hair, Tier tier);

}  // namespace pelage
