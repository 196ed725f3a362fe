#include "web_scene.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>
#include <variant>

#include "demo_assets.h"
#include "head_motion.h"
#include "pelage/demo/character.h"
#include "pelage/settings/settings_file.h"

namespace pelage::webgpu {

namespace {

constexpr float kNear = 0.05f, kFar = 20;  // [m]

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

Result<std::unique_ptr<WebScene>> WebScene::character() {
  const auto character = generateCharacter();
  if (!character) return character.error();
  std::unique_ptr<WebScene> result(new WebScene);
  sample::DemoDef def;
  def.scene = &result->scene_;
  auto demo = sample::DemoScene::create(*character, def);
  if (!demo) return demo.error();
  result->demo_.emplace(std::move(*demo));
  result->demo_->setShadow(HairShadow::kDeep);
  return result;
}

Result<std::unique_ptr<WebScene>> WebScene::head(const WebHead& def) {
  GroomDef groom = sample::presetLook(def.groom).groom;
  groom.seed = def.seed;
  groom.strandCount = def.strands.value_or(groom.strandCount);
  const auto assets = sample::generateAssets(groom);
  if (!assets) return assets.error();
  std::unique_ptr<WebScene> result(new WebScene);
  sample::DemoDef demoDef;
  demoDef.scene = &result->scene_;
  demoDef.preset = def.groom;
  demoDef.followPerGuide = def.followPerGuide;
  demoDef.seed = def.seed;
  demoDef.headCollider = sample::HeadCollider::kMesh;
  auto demo = sample::DemoScene::create(*assets, demoDef);
  if (!demo) return demo.error();
  result->demo_.emplace(std::move(*demo));
  result->demo_->setShadow(HairShadow::kDeep);
  return result;
}

Result<std::unique_ptr<WebScene>> WebScene::hair(std::span<const std::byte> tfx,
                                                 std::string_view name) {
  auto asset = loadTfx(tfx, name);
  if (!asset) return asset.error();
  if (Result<void> done = asset->process(); !done) return done.error();
  std::unique_ptr<WebScene> result(new WebScene);
  const auto added = result->scene_.addHair(*asset, {});
  if (!added) return added.error();
  result->hair_ = *added;
  for (const Float4& p : asset->positions) result->points_.push_back({p.x, p.y, p.z});
  return result;
}

std::span<const HairId> WebScene::hairs() const {
  if (demo_) return demo_->hairs();
  return {&*hair_, 1};
}

sample::Camera WebScene::camera(float aspect) const {
  return demo_ ? demo_->camera(aspect) : sample::frameAll(points_, {}, aspect);
}

void WebScene::pose(double seconds) {
  time_ += seconds;
  if (!demo_) {
    const AffineTransform bone =
        sample::rotationAbout(sample::poseRotation(sample::headPose(time_)), {});
    return scene_.hair(*hair_).setBones({&bone, 1});
  }
  const auto [start, end] = demo_->cycle();
  if (time_ >= end) time_ = start + std::fmod(time_ - start, end - start);
  demo_->pose(time_);
}

void WebScene::setArea(uint32_t width, uint32_t height) {
  if (depth_ != BufferId::kInvalid) {
    if (width == camera_.width && height == camera_.height) return;
    scene_.resources().remove(depth_);
  }
  // The farthest depth.
  depth_ = scene_.resources().add("opaque depth", std::vector<float>(size_t{width} * height, 1.0f));
}

Result<void> WebScene::step(float seconds, const WebCamera& camera) {
  if (camera.width == 0 || camera.height == 0 || camera.width > 16384 || camera.height > 16384)
    return Error{ErrorCode::kInvalidArgument, "a picture has 1 to 16384 pixels an edge"};
  pose(seconds);
  setArea(camera.width, camera.height);
  camera_ = camera;
  view_ = sample::makeView({.eye = camera.eye,
                            .target = camera.target,
                            .verticalFov = camera.verticalFov,
                            .near = kNear,
                            .far = kFar},
                           camera.width, camera.height, 1);
  if (Result<void> done = scene_.simulate(seconds, simulated_); !done) return done;
  pulled_.clear();
  if (Result<void> done = pull_.record(scene_, pulled_); !done) return done;
  scene_.finish(pulled_);
  scene_.finish(simulated_);

  settings_.method = Transparency::kTiles;
  settings_.opaqueDepth = depth_;
  if (!drawn_.empty()) drawn_[0].clear();
  Result<void> drawn = demo_ ? demo_->draw(view_, settings_, drawn_)
                             : scene_.draw(view_, {&ownLight_, 1}, settings_, drawn_);
  if (!drawn) return drawn;
  lists_ = {&pulled_, &simulated_};
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

uint32_t WebScene::countersBuffer() const {
  const BufferId counters = scene_.transparencyCounters();
  return counters == BufferId::kInvalid ? 0 : writer_.numberOf(counters);
}

Result<void> WebScene::takeCounters(std::span<const std::byte> words) {
  if (words.size() < kCounterBytes)
    return Error{ErrorCode::kInvalidArgument, "counters have 32 bytes"};
  uint64_t vertices = 0;
  if (demo_)
    vertices = demo_->vertexCount();
  else
    vertices =
        uint64_t{scene_.hair(*hair_).strandCount()} * scene_.hair(*hair_).verticesPerStrand();
  const auto plan = planTransparency(camera_.width, camera_.height, settings_, vertices);
  if (!plan) return plan.error();
  settings_.nodeCount =
      growNodes(readTransparencyCounters(words, plan->nodeCount), plan->nodeCount);
  return {};
}

size_t WebScene::guideBytes(size_t hair) const {
  const HairObject& object = scene_.hair(hairs()[hair]);
  return size_t{object.guideCount()} * object.verticesPerStrand() * sizeof(Float4);
}

Result<bool> WebScene::pull(float x, float y, std::span<const std::byte> guides) {
  size_t bytes = 0;
  for (size_t i = 0; i < hairs().size(); ++i) bytes += guideBytes(i);
  if (guides.size() != bytes) {
    return Error{ErrorCode::kInvalidArgument,
                 "the guides have " + std::to_string(bytes) + " bytes of positions, not the " +
                     std::to_string(guides.size()) + " that were given"};
  }
  const Float3 e = camera_.eye, t = camera_.target;
  const float half =
      std::hypot(e.x - t.x, e.y - t.y, e.z - t.z) * std::tan(camera_.verticalFov / 2);
  pull_.ask(view_, x, y, sample::kLockRadius * half);
  const auto read = [&](BufferId buffer) -> Result<std::vector<std::byte>> {
    size_t at = 0, i = 0;
    for (; scene_.hair(hairs()[i]).buffers().positions != buffer; ++i) at += guideBytes(i);
    const auto own = guides.subspan(at, guideBytes(i));
    return std::vector<std::byte>(own.begin(), own.end());
  };
  if (Result<void> taken = pull_.take(scene_, hairs(), read); !taken) return taken.error();
  return pull_.holds();
}

void WebScene::dragTo(float x, float y) {
  const auto width = static_cast<float>(camera_.width), height = static_cast<float>(camera_.height);
  const sample::Camera camera = {
      .eye = camera_.eye, .target = camera_.target, .verticalFov = camera_.verticalFov};
  pull_.dragTo(sample::pointAt(camera, x / width, y / height, width / height, pull_.point()));
}

std::vector<void*> WebScene::objectsOf(std::string_view section) {
  if (section == "lights") return {demo_ ? &demo_->light : &ownLight_};
  std::vector<void*> objects;
  for (const HairId id : hairs()) {
    HairObject& hair = scene_.hair(id);
    if (section == "simulation") objects.push_back(&hair.settings);
    if (section == "material") objects.push_back(&hair.material);
  }
  return objects;
}

std::string WebScene::presets() {
  nlohmann::json all = nlohmann::json::array();
  for (const SettingsPreset& preset : settingsPresets())
    all.push_back({{"name", preset.name}, {"meaning", preset.meaning}});
  return all.dump();
}

Result<void> WebScene::takePreset(std::string_view name) {
  const auto preset = presetSettings(name);
  if (!preset) return preset.error();
  release();
  for (size_t i = 0; i < hairs().size(); ++i) {
    if (demo_) {
      sample::DemoScene::HairMaking making = demo_->making(i);
      making.follow = preset->follow;
      if (Result<void> made = demo_->makeHairAgain(i, making); !made) return made;
    }
    HairObject& hair = scene_.hair(hairs()[i]);
    hair.settings = preset->simulation;
    hair.material = preset->material;
  }
  return {};
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
