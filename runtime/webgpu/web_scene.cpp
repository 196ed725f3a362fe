#include "web_scene.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <variant>

#include "pelage/demo/character.h"
#include "pelage/demo/groom.h"

namespace pelage::webgpu {

namespace {

constexpr float kCell = 0.01f;  // of SDFs [m]
constexpr Float3 kSkin = {0.42f, 0.24f, 0.17f};

Float3 transformed(const AffineTransform& transform, Float3 v, float w) {
  const auto row = [&](const Float4& r) { return r.x * v.x + r.y * v.y + r.z * v.z + r.w * w; };
  return {row(transform.rows[0]), row(transform.rows[1]), row(transform.rows[2])};
}

void add(Float3& sum, float weight, Float3 v) {
  sum.x += weight * v.x;
  sum.y += weight * v.y;
  sum.z += weight * v.z;
}

// The head turns from side to side.
std::vector<AffineTransform> turnedHead(double seconds) {
  const float angle = 0.3f * static_cast<float>(std::sin(1.5 * seconds));
  const AffineTransform head = rigidTransform({0, std::sin(angle), 0, std::cos(angle)}, {});
  return {head, head};
}

nlohmann::json valueOf(const ParameterValue& value) {
  struct Visitor {
    nlohmann::json operator()(bool v) const { return v ? 1 : 0; }
    nlohmann::json operator()(uint64_t v) const { return v; }
    nlohmann::json operator()(float v) const { return v; }
    nlohmann::json operator()(const Float3& v) const { return {v.x, v.y, v.z}; }
    nlohmann::json operator()(const ParameterCurve& v) const {
      nlohmann::json factors = nlohmann::json::array();
      for (const float factor : v) factors.push_back(factor);
      return factors;
    }
  };
  return std::visit(Visitor{}, value);
}

const char* nameOf(ParameterType type) {
  switch (type) {
    case ParameterType::kBool:
      return "bool";
    case ParameterType::kCount:
      return "count";
    case ParameterType::kFloat:
      return "float";
    case ParameterType::kVector:
      return "vector";
    case ParameterType::kColor:
      return "color";
    case ParameterType::kCurve:
      return "curve";
    case ParameterType::kChoice:
      return "choice";
  }
  return "";
}

// A value of the type of another one. Nothing if the numbers are not as many as it has.
std::optional<ParameterValue> valueLike(const ParameterValue& other,
                                        std::span<const double> numbers) {
  const auto number = [&](size_t i) { return static_cast<float>(numbers[i]); };
  if (std::holds_alternative<Float3>(other)) {
    if (numbers.size() != 3) return std::nullopt;
    return Float3{number(0), number(1), number(2)};
  }
  if (std::holds_alternative<ParameterCurve>(other)) {
    ParameterCurve curve;
    if (numbers.size() != curve.size()) return std::nullopt;
    for (size_t i = 0; i < numbers.size(); ++i) curve[i] = number(i);
    return curve;
  }
  if (numbers.size() != 1) return std::nullopt;
  if (std::holds_alternative<bool>(other)) return numbers[0] != 0;
  if (std::holds_alternative<float>(other)) return number(0);
  if (!(numbers[0] >= 0 && numbers[0] < 1e15)) return std::nullopt;
  return static_cast<uint64_t>(numbers[0]);
}

}  // namespace

Result<void> WebScene::addHair(HairAsset asset, HairDef def, const FollowDef* follow) {
  if (Result<void> done = asset.process(); !done) return done;
  std::vector<FollowHair> follows;
  if (follow != nullptr) {
    auto made = asset.generateFollowHairs(*follow);
    if (!made) return made.error();
    follows = std::move(*made);
    def.followHairs = {follows.data(), follows.size()};
  }
  const auto added = scene_.addHair(asset, def);
  if (!added) return added.error();
  hairs_.push_back(*added);
  return {};
}

Result<void> WebScene::addCollider(const CollisionMesh& mesh, std::string_view name) {
  const auto bones = static_cast<uint32_t>(motion_(0).size());
  const auto added =
      scene_.addCollider(mesh, {.name = std::string(name), .cellSize = kCell, .boneCount = bones});
  if (!added) return added.error();
  colliders_.push_back(*added);
  return {};
}

Result<std::unique_ptr<WebScene>> WebScene::character() {
  auto made = generateCharacter();
  if (!made) return made.error();
  std::unique_ptr<WebScene> result(new WebScene);
  result->motion_ = [skeleton = made->skeleton](double seconds) {
    const CharacterCycle cycle = characterCycle(CharacterMotion::kWalk);
    const double length = cycle.end - cycle.start;
    const double at = length > 0 ? cycle.start + std::fmod(seconds, length) : cycle.start;
    return skinningTransforms(skeleton, poseCharacter(CharacterMotion::kWalk, at));
  };
  const auto bones = static_cast<uint32_t>(made->skeleton.bones.size());
  for (const CharacterGroom& groom : made->grooms) {
    HairDef def;
    def.name = groom.name;
    def.settings = groom.settings;
    def.material = groom.material;
    def.influences = {groom.bones.strands.data(), groom.bones.strands.size()};
    def.boneCount = bones;
    if (Result<void> added = result->addHair(groom.hair, def, &groom.follow); !added)
      return added.error();
  }
  for (const CharacterCollider& collider : made->colliders)
    if (Result<void> added = result->addCollider(collider.mesh, collider.name); !added)
      return added.error();
  result->colors_.assign(made->mesh.positions.size(), kSkin);
  for (const CharacterPart& part : made->parts)
    for (uint32_t i = 0; i < part.indexCount; ++i)
      result->colors_[made->mesh.indices[part.firstIndex + i]] = part.color;
  result->mesh_ = std::move(made->mesh);
  return result;
}

Result<std::unique_ptr<WebScene>> WebScene::head(uint32_t strands, uint64_t seed) {
  auto groom = generateGroom({.seed = seed, .strandCount = strands});
  if (!groom) return groom.error();
  std::unique_ptr<WebScene> result(new WebScene);
  result->motion_ = turnedHead;
  HairDef def;
  def.influences = {groom->bones.strands.data(), groom->bones.strands.size()};
  def.boneCount = 2;
  if (Result<void> added = result->addHair(groom->hair, def, nullptr); !added) return added.error();
  if (Result<void> added = result->addCollider(groom->head, "head"); !added) return added.error();
  result->colors_.assign(groom->head.positions.size(), kSkin);
  result->mesh_ = std::move(groom->head);
  return result;
}

Result<std::unique_ptr<WebScene>> WebScene::hair(std::span<const std::byte> tfx,
                                                 std::string_view name) {
  auto asset = loadTfx(tfx, name);
  if (!asset) return asset.error();
  std::unique_ptr<WebScene> result(new WebScene);
  result->motion_ = [](double seconds) { return std::vector{turnedHead(seconds)[0]}; };
  if (Result<void> added = result->addHair(std::move(*asset), {}, nullptr); !added)
    return added.error();
  return result;
}

void WebScene::pose() {
  const std::vector<AffineTransform> bones = motion_(time_);
  const std::span<const AffineTransform> all(bones.data(), bones.size());
  for (const HairId hair : hairs_) scene_.hair(hair).setBones(all);
  for (const ColliderId collider : colliders_) scene_.collider(collider).setBones(all);
  body_.resize(mesh_.positions.size());
  for (size_t v = 0; v < body_.size(); ++v) {
    BodyVertex& vertex = body_[v];
    vertex = BodyVertex{};
    vertex.color = colors_[v];
    float sum = 0;
    const BoneInfluences& influences = mesh_.influences[v];
    for (size_t i = 0; i < 4; ++i) {
      const float weight = influences.weights[i];
      if (!(weight > 0)) continue;
      const AffineTransform& bone = bones[influences.bones[i]];
      add(vertex.position, weight, transformed(bone, mesh_.positions[v], 1));
      add(vertex.normal, weight, transformed(bone, mesh_.normals[v], 0));
      sum += weight;
    }
    const Float3 p = vertex.position;
    vertex.position = {p.x / sum, p.y / sum, p.z / sum};
  }
}

void WebScene::setArea(uint32_t width, uint32_t height) {
  if (width == width_ && height == height_) return;
  if (depth_ != BufferId::kInvalid) scene_.resources().remove(depth_);
  width_ = width;
  height_ = height;
  // The farthest depth.
  depth_ = scene_.resources().add("opaque depth", std::vector<float>(size_t{width} * height, 1.0f));
}

Result<void> WebScene::step(float seconds, const WebCamera& camera) {
  if (camera.width == 0 || camera.height == 0 || camera.width > 16384 || camera.height > 16384)
    return Error{ErrorCode::kInvalidArgument, "a picture has 1 to 16384 pixels an edge"};
  time_ += seconds;
  pose();
  setArea(camera.width, camera.height);
  if (Result<void> done = scene_.simulate(seconds, simulated_); !done) return done;
  scene_.finish(simulated_);

  View view;
  view.eye = camera.eye;
  view.width = camera.width;
  view.height = camera.height;
  view.worldToClip =
      lookAt(camera.eye, camera.target, {0, 1, 0}, camera.verticalFov,
             static_cast<float>(camera.width) / static_cast<float>(camera.height), 0.05f, 20);
  TransparencySettings settings;
  settings.method = Transparency::kTiles;
  settings.opaqueDepth = depth_;
  if (!drawn_.empty()) drawn_[0].clear();
  if (Result<void> done = scene_.draw(view, {lights_.data(), lights_.size()}, settings, drawn_);
      !done)
    return done;
  lists_ = {&simulated_};
  for (PassList& list : drawn_) {
    scene_.finish(list);
    lists_.push_back(&list);
  }
  return {};
}

Result<std::span<const std::byte>> WebScene::frame(float seconds, const WebCamera& camera) {
  if (Result<void> done = step(seconds, camera); !done) return done.error();
  auto words = writer_.write(scene_.resources(), lists());
  if (!words) return words.error();
  for (const PassList* list : lists_) setDelivered(list->run);
  return words;
}

std::vector<void*> WebScene::objectsOf(std::string_view section) {
  std::vector<void*> objects;
  if (section == "lights")
    for (Light& light : lights_) objects.push_back(&light);
  for (const HairId id : hairs_) {
    HairObject& hair = scene_.hair(id);
    if (section == "simulation") objects.push_back(&hair.settings);
    if (section == "material") objects.push_back(&hair.material);
  }
  return objects;
}

std::string WebScene::parameters() {
  nlohmann::json all = nlohmann::json::array();
  for (const SettingsSection& section : settingsSections()) {
    const std::vector<void*> objects = objectsOf(section.key);
    if (objects.empty()) continue;
    for (const Parameter& parameter : section.parameters) {
      nlohmann::json choices = nlohmann::json::array();
      for (const std::string_view choice : parameter.choices) choices.push_back(choiceName(choice));
      all.push_back({{"section", section.key},
                     {"title", section.title},
                     {"path", parameter.path},
                     {"type", nameOf(parameter.type)},
                     {"unit", parameter.unit},
                     {"range", parameter.range},
                     {"meaning", plainText(parameter.meaning)},
                     {"choices", choices},
                     {"slider",
                      {parameter.sliderLow, parameter.sliderHigh,
                       parameter.scale == ParameterScale::kLog ? 1 : 0}},
                     {"value", valueOf(parameter.get(objects[0]))}});
    }
  }
  return all.dump();
}

Result<void> WebScene::set(std::string_view section, std::string_view path,
                           std::span<const double> values) {
  const std::string name = std::string(section) + "." + std::string(path);
  const std::vector<void*> objects = objectsOf(section);
  for (const SettingsSection& known : settingsSections()) {
    if (known.key != section || objects.empty()) continue;
    for (const Parameter& parameter : known.parameters) {
      if (parameter.path != path) continue;
      const auto value = valueLike(parameter.defaultValue, values);
      if (!value) {
        return Error{ErrorCode::kInvalidArgument, name + " takes other values than the " +
                                                      std::to_string(values.size()) +
                                                      " that were given"};
      }
      if (Result<void> checked = check(parameter, *value, name); !checked) return checked;
      for (void* object : objects) parameter.set(object, *value);
      return {};
    }
  }
  return Error{ErrorCode::kInvalidArgument, "there is no parameter " + name};
}

}  // namespace pelage::webgpu
