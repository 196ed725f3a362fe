// All settings of a scene that a user tunes, as one plain value: to edit, to undo, to store.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "pelage/hair_asset.h"
#include "pelage/hair_object.h"
#include "pelage/sdf_collider.h"
#include "pelage/settings/parameter.h"
#include "pelage/simulation_settings.h"
#include "pelage/transparency.h"
#include "pelage/view.h"

namespace pelage {

/// HairObjectSettings::drawnStrands: all strands.
inline constexpr uint32_t kAllStrands = 0xffffffffu;

/// Members of HairObject beside its simulation and material: level of detail above all. They may
/// change at any time.
struct HairObjectSettings {
  float simulatedShare = 1;
  bool simulated = true;
  float blendTime = 0.5f;  ///< [s]
  bool usesMeshColliders = true;
  bool visible = true;
  uint32_t drawnStrands = kAllStrands;
  float drawnShare = 1;
  bool tracksMotion = false;
  bool interpolates = false;
};

/// Members of HairDef: they cannot change later; an editor has to add the hair again.
struct HairCreation {
  SkinningMethod skinning = SkinningMethod::kMatrices;
  bool levelOfDetail = false;
  bool storeFollowHairs = false;
  CollidingHair collidingHair = CollidingHair::kGuides;
};

/// Members of SdfCollider. They may change at any time.
struct ColliderSettings {
  float margin = 0.001f;  ///< [m]
  float friction = 0.3f;
  bool enabled = true;
};

/// Members of View that do not depend on camera and window.
struct ViewSettings {
  uint32_t samples = 1;
  bool reversedDepth = false;
  uint32_t seed = 0;
};

/// The settings of a scene. What is no setting stays as it is: the map of Light::opaque, and
/// TransparencySettings::opaqueDepth and engineLights, which only a renderer knows.
struct SceneSettings {
  SimulationSettings simulation;
  StrandMaterial material;
  HairObjectSettings object;
  HairCreation creation;
  FollowDef follow;  ///< cannot change later, as `creation`
  ColliderSettings collider;
  ColliderLook colliderLook;  ///< for Scene::drawCollider()
  ContactLook contactLook;    ///< for Scene::drawContacts()
  std::vector<Light> lights = {Light{}};
  TransparencySettings transparency;
  ViewSettings view;
};

/// Sets the members of an object, or takes them from it. Drawing takes no more strands than there
/// are.
void apply(const HairObjectSettings& settings, HairObject& hair);
HairObjectSettings settingsOf(const HairObject& hair);
void apply(const HairCreation& creation, HairDef& def);
void apply(const ColliderSettings& settings, SdfCollider& collider);
ColliderSettings settingsOf(const SdfCollider& collider);
void apply(const ViewSettings& settings, View& view);

/// The parameters of one struct, in the order of the documentation: SimulationSettings (with wind,
/// curves, sleep and contact), StrandMaterial, HairObjectSettings, HairCreation, FollowDef,
/// ColliderSettings, ColliderLook, ContactLook, Light, TransparencySettings or ViewSettings.
template <class Settings>
std::span<const Parameter> parametersOf();
template <>
std::span<const Parameter> parametersOf<SimulationSettings>();
template <>
std::span<const Parameter> parametersOf<StrandMaterial>();
template <>
std::span<const Parameter> parametersOf<HairObjectSettings>();
template <>
std::span<const Parameter> parametersOf<HairCreation>();
template <>
std::span<const Parameter> parametersOf<FollowDef>();
template <>
std::span<const Parameter> parametersOf<ColliderSettings>();
template <>
std::span<const Parameter> parametersOf<ColliderLook>();
template <>
std::span<const Parameter> parametersOf<ContactLook>();
template <>
std::span<const Parameter> parametersOf<Light>();
template <>
std::span<const Parameter> parametersOf<TransparencySettings>();
template <>
std::span<const Parameter> parametersOf<ViewSettings>();

/// A member of SceneSettings, and the parameters of its struct.
struct SettingsSection {
  std::string_view key;    ///< name of the member, and in files: "simulation"
  std::string_view title;  ///< for people: "Simulation"
  bool isList = false;     ///< any number of structs: lights
  std::span<const Parameter> parameters;
  /// How many structs there are; 1 where it is no list.
  size_t (*count)(const SceneSettings& settings) = nullptr;
  /// One of them, for Parameter::get() and set(). Asserts on an index of count() or more.
  void* (*object)(SceneSettings& settings, size_t index) = nullptr;

  ParameterValue get(const SceneSettings& settings, const Parameter& parameter,
                     size_t index = 0) const;
  void set(SceneSettings& settings, const Parameter& parameter, const ParameterValue& value,
           size_t index = 0) const;
};

/// All sections in the order of SceneSettings.
std::span<const SettingsSection> settingsSections();

/// Largest number of lights that settings have.
inline constexpr size_t kMaxLights = kMaxStrandLights;

/// Whether all parameters have the same bits, and there are as many lights.
bool haveSameSettings(const SceneSettings& a, const SceneSettings& b);

/// Checks all parameters against their ranges, the number of lights, and the angles of spot lights
/// against each other. Error: names the first that is out of range: "lights[0].shadowSize".
Result<void> validate(const SceneSettings& settings);

}  // namespace pelage
