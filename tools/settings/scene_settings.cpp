#include "pelage/settings/scene_settings.h"

#include <fmt/format.h>

#include <algorithm>

#include "parameter_row.h"
#include "settings_names.h"

namespace pelage {
namespace {

size_t one(const SceneSettings&) { return 1; }
size_t lightCount(const SceneSettings& settings) { return settings.lights.size(); }

template <auto kMember>
void* memberObject(SceneSettings& settings, size_t index) {
  PELAGE_ASSERT(index == 0, "there is one of this section");
  return &(settings.*kMember);
}
void* lightObject(SceneSettings& settings, size_t index) {
  PELAGE_ASSERT(index < settings.lights.size(), "there is no light of this index");
  return &settings.lights[index];
}

template <auto kMember>
SettingsSection section(std::string_view key, std::string_view title) {
  using Struct = typename settings::MemberOf<decltype(kMember)>::Type;
  return {key, title, false, parametersOf<Struct>(), one, memberObject<kMember>};
}

}  // namespace

template <>
std::span<const Parameter> parametersOf<SimulationSettings>() {
  static const std::vector<Parameter> table = settings::simulationParameters();
  return table;
}
template <>
std::span<const Parameter> parametersOf<StrandMaterial>() {
  static const std::vector<Parameter> table = settings::materialParameters();
  return table;
}
template <>
std::span<const Parameter> parametersOf<HairObjectSettings>() {
  static const std::vector<Parameter> table = settings::objectParameters();
  return table;
}
template <>
std::span<const Parameter> parametersOf<HairCreation>() {
  static const std::vector<Parameter> table = settings::creationParameters();
  return table;
}
template <>
std::span<const Parameter> parametersOf<FollowDef>() {
  static const std::vector<Parameter> table = settings::followParameters();
  return table;
}
template <>
std::span<const Parameter> parametersOf<ColliderSettings>() {
  static const std::vector<Parameter> table = settings::colliderParameters();
  return table;
}
template <>
std::span<const Parameter> parametersOf<ColliderLook>() {
  static const std::vector<Parameter> table = settings::colliderLookParameters();
  return table;
}
template <>
std::span<const Parameter> parametersOf<ContactLook>() {
  static const std::vector<Parameter> table = settings::contactLookParameters();
  return table;
}
template <>
std::span<const Parameter> parametersOf<Light>() {
  static const std::vector<Parameter> table = settings::lightParameters();
  return table;
}
template <>
std::span<const Parameter> parametersOf<TransparencySettings>() {
  static const std::vector<Parameter> table = settings::transparencyParameters();
  return table;
}
template <>
std::span<const Parameter> parametersOf<ViewSettings>() {
  static const std::vector<Parameter> table = settings::viewParameters();
  return table;
}

std::span<const SettingsSection> settingsSections() {
  static const std::vector<SettingsSection> sections = {
      section<&SceneSettings::simulation>("simulation", "Simulation"),
      section<&SceneSettings::material>("material", "Material"),
      section<&SceneSettings::object>("object", "Level of detail"),
      section<&SceneSettings::creation>("creation", "Creation"),
      section<&SceneSettings::follow>("follow", "Follow hairs"),
      section<&SceneSettings::collider>("collider", "Mesh colliders"),
      section<&SceneSettings::colliderLook>("colliderLook", "Drawn collider"),
      section<&SceneSettings::contactLook>("contactLook", "Drawn contacts"),
      {"lights", "Light", true, parametersOf<Light>(), lightCount, lightObject},
      section<&SceneSettings::transparency>("transparency", "Transparency"),
      section<&SceneSettings::view>("view", "View"),
  };
  return sections;
}

ParameterValue SettingsSection::get(const SceneSettings& settings, const Parameter& parameter,
                                    size_t index) const {
  // object() of constant settings is only read.
  return parameter.get(object(const_cast<SceneSettings&>(settings), index));
}

void SettingsSection::set(SceneSettings& settings, const Parameter& parameter,
                          const ParameterValue& value, size_t index) const {
  parameter.set(object(settings, index), value);
}

void apply(const HairObjectSettings& settings, HairObject& hair) {
  hair.simulatedShare = settings.simulatedShare;
  hair.simulated = settings.simulated;
  hair.blendTime = settings.blendTime;
  hair.usesMeshColliders = settings.usesMeshColliders;
  hair.visible = settings.visible;
  hair.drawnStrands = std::min(settings.drawnStrands, hair.strandCount());
  hair.drawnShare = settings.drawnShare;
  hair.tracksMotion = settings.tracksMotion;
  hair.interpolates = settings.interpolates;
}

HairObjectSettings settingsOf(const HairObject& hair) {
  HairObjectSettings settings;
  settings.simulatedShare = hair.simulatedShare;
  settings.simulated = hair.simulated;
  settings.blendTime = hair.blendTime;
  settings.usesMeshColliders = hair.usesMeshColliders;
  settings.visible = hair.visible;
  settings.drawnStrands = hair.drawnStrands < hair.strandCount() ? hair.drawnStrands : kAllStrands;
  settings.drawnShare = hair.drawnShare;
  settings.tracksMotion = hair.tracksMotion;
  settings.interpolates = hair.interpolates;
  return settings;
}

void apply(const HairCreation& creation, HairDef& def) {
  def.skinning = creation.skinning;
  def.levelOfDetail = creation.levelOfDetail;
  def.storeFollowHairs = creation.storeFollowHairs;
  def.collidingHair = creation.collidingHair;
}

void apply(const ColliderSettings& settings, SdfCollider& collider) {
  collider.margin = settings.margin;
  collider.friction = settings.friction;
  collider.enabled = settings.enabled;
}

ColliderSettings settingsOf(const SdfCollider& collider) {
  return {collider.margin, collider.friction, collider.enabled};
}

void apply(const ViewSettings& settings, View& view) {
  view.samples = settings.samples;
  view.reversedDepth = settings.reversedDepth;
  view.seed = settings.seed;
}

bool haveSameSettings(const SceneSettings& a, const SceneSettings& b) {
  for (const SettingsSection& section : settingsSections()) {
    if (section.count(a) != section.count(b)) return false;
    for (size_t i = 0; i < section.count(a); ++i)
      for (const Parameter& parameter : section.parameters)
        if (!haveSameBits(section.get(a, parameter, i), section.get(b, parameter, i))) return false;
  }
  return true;
}

Result<void> validate(const SceneSettings& scene) {
  if (scene.lights.size() > kMaxLights)
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("'lights' has {} lights, but a view has at most {}",
                             scene.lights.size(), kMaxLights)};
  for (const SettingsSection& section : settingsSections())
    for (size_t i = 0; i < section.count(scene); ++i)
      for (const Parameter& parameter : section.parameters) {
        Result<void> checked = check(parameter, section.get(scene, parameter, i),
                                     settings::nameOf(section, i, parameter.path));
        if (!checked) return checked;
      }
  for (size_t i = 0; i < scene.lights.size(); ++i)
    if (!(scene.lights[i].innerConeAngle <= scene.lights[i].outerConeAngle))
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("'lights[{}].innerConeAngle' is {}, but must be at most its "
                               "outerConeAngle, {}",
                               i, scene.lights[i].innerConeAngle, scene.lights[i].outerConeAngle)};
  return {};
}

}  // namespace pelage
