#include "table.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <variant>

#include "groups.h"
#include "pelage/assert.h"
#include "pelage/scene.h"
#include "pelage/settings/scene_settings.h"

namespace sample {

using pelage::HairObject;
using pelage::SdfCollider;

namespace {

// Objects that nobody has changed, of a scene without a device.
struct UntouchedScene {
  pelage::Scene scene;
  pelage::HairId hair;
  pelage::ColliderId collider;

  UntouchedScene() {
    pelage::HairAsset asset;
    asset.strandCount = 1;
    asset.verticesPerStrand = 2;
    asset.positions = {{0, 0, 0, 0}, {0, 0.1f, 0, 0}};
    const bool processed = static_cast<bool>(asset.process());
    PELAGE_ASSERT(processed, "the strand of the defaults is refused");
    const auto addedHair = scene.addHair(asset, {});
    pelage::CollisionMesh mesh;
    mesh.positions = {{0, 0, 0}, {0.1f, 0, 0}, {0, 0.1f, 0}};
    mesh.normals.assign(3, {0, 0, 1});
    mesh.influences.assign(3, {{0, 0, 0, 0}, {1, 0, 0, 0}});
    mesh.indices = {0, 1, 2};
    const auto addedCollider = scene.addCollider(mesh, {});
    PELAGE_ASSERT(static_cast<bool>(addedHair) && static_cast<bool>(addedCollider),
                  "the objects of the defaults are refused");
    hair = *addedHair;
    collider = *addedCollider;
  }
};

UntouchedScene& untouchedScene() {
  static UntouchedScene scene;
  return scene;
}

// In bold where it is the default.
std::string pictureValues(const Parameter& parameter) {
  std::string line;
  for (const std::string& value : parameter.picture->values) {
    const bool isDefault = value == parameter.defaultText;
    line += fmt::format("{}{}{}{}", line.empty() ? "" : ", ", isDefault ? "**" : "", value,
                        isDefault ? "**" : "");
  }
  return line;
}

constexpr const char* kPageTop =
    R"(# Parameters
All that a program can set of hair, and its effect in pictures. Values are from left to right, the default in
**bold**. A value out of range is an error that names the field. Files of them: [settings.md](settings.md); a
picture from your own groom: [artists.md](artists.md).

*exact* and *classic* name the solver that reads a field. Unless the text says otherwise, a picture "at rest" is
taken 3 to 4 s after the hair was released from its bind pose, the exact solver runs, and all else has its
default. `scripts/parameter_pictures.sh` renders this page from the table in `sample/parameters`, which a test
keeps in sync with the headers; `pelage-parameters --list` prints it.
)";

}  // namespace

template <>
const HairObject& untouched<HairObject>() {
  return untouchedScene().scene.hair(untouchedScene().hair);
}
template <>
const SdfCollider& untouched<SdfCollider>() {
  return untouchedScene().scene.collider(untouchedScene().collider);
}

std::string text(float value) { return fmt::format("{}", value); }
std::string text(bool value) { return value ? "true" : "false"; }
std::string text(uint32_t value) { return fmt::format("{}", value); }
std::string text(uint64_t value) {
  constexpr uint64_t kMebibyte = uint64_t{1} << 20;
  if (value >= kMebibyte && value % kMebibyte == 0) return fmt::format("{} MiB", value / kMebibyte);
  return fmt::format("{}", value);
}
std::string text(const std::string& value) { return '"' + value + '"'; }
std::string text(const pelage::Float2& value) { return fmt::format("({}, {})", value.x, value.y); }
std::string text(const pelage::Float3& value) {
  return fmt::format("({}, {}, {})", value.x, value.y, value.z);
}
std::string text(const pelage::Matrix4& value) {
  return value == pelage::Matrix4{} ? "identity" : "a matrix";
}
std::string text(const pelage::ParameterCurve& value) {
  const bool even = std::all_of(value.begin(), value.end(), [&](float x) { return x == value[0]; });
  return even ? fmt::format("{} everywhere", value[0])
              : fmt::format("{} at the root to {} at the tip", value.front(), value.back());
}
std::string text(pelage::Solver value) {
  return value == pelage::Solver::kExact ? "kExact" : "kClassic";
}
std::string text(pelage::SkinningMethod value) {
  return value == pelage::SkinningMethod::kMatrices ? "kMatrices" : "kDualQuaternions";
}
std::string text(pelage::CollidingHair value) {
  return value == pelage::CollidingHair::kGuides ? "kGuides" : "kGuidesAndFollows";
}
std::string text(pelage::HairShadow value) {
  constexpr const char* kNames[] = {"kNone", "kDepth", "kDeep"};
  return kNames[static_cast<size_t>(value)];
}
std::string text(pelage::ShadingModel value) {
  return value == pelage::ShadingModel::kKajiyaKay ? "kKajiyaKay" : "kFiber";
}
std::string text(pelage::Transparency value) {
  constexpr const char* kNames[] = {"kAlphaTest", "kStochastic", "kWindowed", "kHybrid4",
                                    "kHybrid8",   "kHybrid16",   "kShortCut", "kTiles"};
  return kNames[static_cast<size_t>(value)];
}
std::string text(pelage::HairDepthColor value) {
  constexpr const char* kNames[] = {"kNone", "kDepth", "kMotion"};
  return kNames[static_cast<size_t>(value)];
}
std::string text(pelage::HairStyle value) {
  return value == pelage::HairStyle::kSideParting ? "kSideParting" : "kSweptBack";
}
std::string text(pelage::BufferId value) {
  return value == pelage::BufferId::kInvalid ? "none" : "a buffer";
}
std::string text(pelage::SkeletonId value) {
  return value == pelage::SkeletonId::kInvalid ? "none" : "a skeleton";
}
std::string text(pelage::TextureId value) {
  return value == pelage::TextureId::kInvalid ? "none" : "a texture";
}
std::string text(const pelage::EngineLights* value) {
  return value == nullptr ? "none" : "lights of an engine";
}

namespace {

// As `text` of the member's own type.
std::string defaultText(const pelage::Parameter& parameter) {
  const pelage::ParameterValue& value = parameter.defaultValue;
  if (parameter.type == pelage::ParameterType::kChoice)
    return std::string(parameter.choices[std::get<uint64_t>(value)]);
  if (parameter.field == "drawnStrands") return "all";
  return std::visit([](const auto& of) { return text(of); }, value);
}

}  // namespace

Parameter tuned(std::string_view owner, std::string_view field, std::optional<Picture> picture) {
  for (const pelage::SettingsSection& section : pelage::settingsSections())
    for (const pelage::Parameter& p : section.parameters) {
      if (p.owner != owner || p.field != field) continue;
      PELAGE_ASSERT(p.hasPicture == picture.has_value(), "the table says something else");
      return {std::string(owner),  std::string(field),   defaultText(p),
              std::string(p.unit), std::string(p.range), std::string(p.meaning),
              std::move(picture),  std::string(p.solver)};
    }
  PELAGE_ASSERT(false, "no parameter of pelage::settings");
  return {};
}

const std::vector<ParameterGroup>& parameterTable() {
  static const std::vector<ParameterGroup> table = [] {
    std::vector<ParameterGroup> groups;
    for (auto* more : {&simulationGroups, &hairGroups, &colliderGroups, &materialGroups,
                       &viewGroups, &groomGroups})
      for (ParameterGroup& group : (*more)()) groups.push_back(std::move(group));
    return groups;
  }();
  return table;
}

std::string pictureFile(const Parameter& parameter) {
  return parameter.owner + "." + parameter.field + ".png";
}

std::string parameterList() {
  size_t names = 0, units = 0, ranges = 0;
  for (const ParameterGroup& group : parameterTable())
    for (const Parameter& p : group.parameters) {
      names = std::max(names, p.owner.size() + 1 + p.field.size());
      units = std::max(units, p.unit.size());
      ranges = std::max(ranges, p.range.size());
    }
  std::string lines;
  for (const ParameterGroup& group : parameterTable())
    for (const Parameter& p : group.parameters)
      lines += fmt::format("{:{}}  {:{}}  {:{}}  {}\n", p.owner + "." + p.field, names, p.unit,
                           units, p.range, ranges, p.defaultText);
  return lines;
}

std::string parameterPage() {
  std::string page = kPageTop;
  for (const ParameterGroup& group : parameterTable()) {
    page += fmt::format("\n## {}\n`include/{}`. {}\n\n", group.owner, group.header, group.intro);
    page += "| field | unit, range | default | meaning |\n|---|---|---|---|\n";
    for (const Parameter& p : group.parameters)
      page += fmt::format("| `{}` | {}{}{} | {} | {}{} |\n", p.field, p.unit,
                          p.unit.empty() || p.range.empty() ? "" : ", ", p.range, p.defaultText,
                          p.solver.empty() ? "" : "*" + p.solver + ".* ", p.meaning);
    for (const Parameter& p : group.parameters)
      if (p.picture)
        page += fmt::format("\n`{}`: {}. {}\n\n![{}](images/parameters/{})\n", p.field,
                            pictureValues(p), p.picture->caption, p.field, pictureFile(p));
  }
  return page;
}

}  // namespace sample
