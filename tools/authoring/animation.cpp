// glTF 2.0: Khronos, "glTF 2.0 Specification", 3.11 (animations), 3.5.3 (transformations),
// appendix C (interpolation).
#include "pelage/authoring/animation.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "binary_file.h"
#include "common/errors.h"
#include "gltf_file.h"

namespace pelage {
namespace {

using nlohmann::json;

constexpr size_t kNamesListed = 16;
// Channels may share keys: numbers that a small file may make of that, and those for each of its
// bytes.
constexpr uint64_t kFreeNumbers = 1 << 16, kNumbersPerByte = 16;

class AnimationReader {
 public:
  AnimationReader(std::span<const std::byte> bytes, std::string_view name,
                  const std::filesystem::path& folder)
      : file_(bytes, name, folder) {}

  Result<SkeletonAnimation> read(std::string_view clip) {
    if (auto r = file_.parse(); !r) return r.error();
    if (auto r = readNodes(); !r) return r.error();
    auto index = findClip(clip);
    if (!index) return index.error();
    if (auto r = readClip(*index); !r) return r.error();
    return std::move(animation_);
  }

 private:
  const json* arrayOf(const json& object, const char* member) const {
    const auto found = object.find(member);
    return found != object.end() && found->is_array() ? &*found : nullptr;
  }

  // `count` numbers of a member into `out`, which stays as it is when it is missing.
  Result<void> numbers(const json& node, const char* member, const std::string& path, size_t count,
                       float* out) const {
    const auto found = node.find(member);
    if (found == node.end()) return {};
    if (!found->is_array() || found->size() != count)
      return file_.fail(path + "." + member, fmt::format("not {} numbers", count));
    for (size_t i = 0; i < count; ++i) {
      if (!(*found)[i].is_number() || !std::isfinite((*found)[i].get<float>()))
        return file_.fail(path + "." + member, fmt::format("not {} numbers", count));
      out[i] = (*found)[i].get<float>();
    }
    return {};
  }

  Result<AnimatedNode> readNode(const json& object, size_t index) const {
    const std::string path = fmt::format("nodes[{}]", index);
    if (!object.is_object()) return file_.fail(path, "not an object");
    AnimatedNode node;
    const auto name = object.find("name");
    node.name = name != object.end() && name->is_string() ? name->get<std::string>()
                                                          : fmt::format("node {}", index);
    float m[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};  // column by column
    float t[3] = {0, 0, 0}, r[4] = {0, 0, 0, 1}, s[3] = {1, 1, 1};
    const std::pair<const char*, std::span<float>> members[] = {
        {"matrix", m}, {"translation", t}, {"rotation", r}, {"scale", s}};
    for (const auto& [member, out] : members)
      if (auto done = numbers(object, member, path, out.size(), out.data()); !done)
        return done.error();
    for (int row = 0; row < 3; ++row)
      node.matrix.rows[row] = {m[row], m[4 + row], m[8 + row], m[12 + row]};
    node.translation = {t[0], t[1], t[2]};
    node.rotation = {r[0], r[1], r[2], r[3]};
    node.scale = {s[0], s[1], s[2]};
    return node;
  }

  // The parent of each node of the file; -1 for none.
  Result<std::vector<int64_t>> readParents(const json& nodes) const {
    std::vector<int64_t> parents(nodes.size(), -1);
    for (size_t i = 0; i < nodes.size(); ++i) {
      if (!nodes[i].is_object()) return file_.fail(fmt::format("nodes[{}]", i), "not an object");
      const json* children = arrayOf(nodes[i], "children");
      for (size_t k = 0; children != nullptr && k < children->size(); ++k) {
        const json& child = (*children)[k];
        const std::string path = fmt::format("nodes[{}].children[{}]", i, k);
        if (!child.is_number_unsigned() || child.get<uint64_t>() >= nodes.size())
          return file_.fail(path, "not the number of a node");
        int64_t& parent = parents[child.get<size_t>()];
        if (parent >= 0)
          return file_.fail(path, fmt::format("node {} has two parents", child.get<size_t>()));
        parent = static_cast<int64_t>(i);
      }
    }
    return parents;
  }

  // Parents before their children, whatever the order of the file is.
  Result<void> readNodes() {
    const json* nodes = arrayOf(file_.root(), "nodes");
    if (nodes == nullptr || nodes->empty()) return file_.fail("nodes", "there are none");
    auto parents = readParents(*nodes);
    if (!parents) return parents.error();
    std::vector<size_t> waiting;
    for (size_t i = nodes->size(); i-- > 0;)
      if ((*parents)[i] < 0) waiting.push_back(i);
    slots_.assign(nodes->size(), -1);
    while (!waiting.empty()) {
      const size_t i = waiting.back();
      waiting.pop_back();
      auto node = readNode((*nodes)[i], i);
      if (!node) return node.error();
      if ((*parents)[i] >= 0)
        node->parent = static_cast<int32_t>(slots_[static_cast<size_t>((*parents)[i])]);
      slots_[i] = static_cast<int64_t>(animation_.nodes.size());
      animation_.nodes.push_back(std::move(*node));
      if (const json* children = arrayOf((*nodes)[i], "children"))
        for (size_t k = children->size(); k-- > 0;) waiting.push_back((*children)[k].get<size_t>());
    }
    const auto lost = std::find(slots_.begin(), slots_.end(), -1);
    if (lost != slots_.end())
      return file_.fail(fmt::format("nodes[{}]", lost - slots_.begin()),
                        "it is below itself; nodes are trees");
    return {};
  }

  Result<size_t> findClip(std::string_view clip) {
    const json* clips = arrayOf(file_.root(), "animations");
    if (clips == nullptr || clips->empty()) return file_.fail("animations", "there are none");
    std::string names;
    for (size_t i = 0; i < clips->size(); ++i) {
      if (!(*clips)[i].is_object())
        return file_.fail(fmt::format("animations[{}]", i), "not an object");
      const auto found = (*clips)[i].find("name");
      const std::string name = found != (*clips)[i].end() && found->is_string()
                                   ? found->get<std::string>()
                                   : fmt::format("animation {}", i);
      if (clip.empty() || name == clip) {
        animation_.name = name;
        return i;
      }
      if (i < kNamesListed) names += (names.empty() ? "" : ", ") + name;
    }
    return file_.fail("animations", fmt::format("there is no '{}'; there are: {}", clip, names));
  }

  Result<void> readClip(size_t index) {
    const std::string path = fmt::format("animations[{}]", index);
    const json& clip = (*arrayOf(file_.root(), "animations"))[index];
    const json* channels = arrayOf(clip, "channels");
    const json* samplers = arrayOf(clip, "samplers");
    if (channels == nullptr || samplers == nullptr)
      return file_.fail(path, "it needs channels and samplers");
    bool moves = false;
    for (size_t i = 0; i < channels->size(); ++i) {
      auto used = readChannel((*channels)[i], *samplers, fmt::format("{}.channels[{}]", path, i));
      if (!used) return used.error();
      moves |= *used;
    }
    if (!moves) return file_.fail(path, "it moves no node");
    return {};
  }

  // False for channels that move no node: morph targets, and extensions.
  Result<bool> readChannel(const json& channel, const json& samplers, const std::string& path) {
    if (!channel.is_object() || !channel.contains("target") || !channel["target"].is_object())
      return file_.fail(path, "no 'target'");
    const json& target = channel["target"];
    if (!target.contains("node")) return false;
    auto node = file_.whole(target, "node", path + ".target");
    if (!node) return node.error();
    if (*node >= slots_.size())
      return file_.fail(path + ".target.node", fmt::format("there is no node {}", *node));
    AnimatedNode& moved = animation_.nodes[static_cast<size_t>(slots_[*node])];
    const auto found = target.find("path");
    const std::string property =
        found != target.end() && found->is_string() ? found->get<std::string>() : "";
    AnimationKeys* keys = property == "translation" ? &moved.translations
                          : property == "rotation"  ? &moved.rotations
                          : property == "scale"     ? &moved.scales
                                                    : nullptr;
    if (keys == nullptr) return false;
    if (!(moved.matrix == AffineTransform{}))
      return file_.fail(path, fmt::format("node {} has a matrix and cannot be animated", *node));
    if (!keys->times.empty())
      return file_.fail(path, fmt::format("{} of node {} is animated twice", property, *node));
    auto sampler = file_.whole(channel, "sampler", path);
    if (!sampler) return sampler.error();
    if (*sampler >= samplers.size() || !samplers[*sampler].is_object())
      return file_.fail(path + ".sampler", fmt::format("there is no sampler {}", *sampler));
    auto read = readKeys(samplers[*sampler], path, property == "rotation" ? 4 : 3);
    if (!read) return read.error();
    *keys = std::move(*read);
    animation_.seconds = std::max(animation_.seconds, double{keys->times.back()});
    return true;
  }

  Result<AnimationKeys> readKeys(const json& sampler, const std::string& path,
                                 uint32_t components) {
    AnimationKeys keys;
    const auto found = sampler.find("interpolation");
    const std::string kind =
        found != sampler.end() && found->is_string() ? found->get<std::string>() : "LINEAR";
    if (kind != "LINEAR" && kind != "STEP" && kind != "CUBICSPLINE")
      return file_.fail(path, fmt::format("the interpolation '{}' is none", kind.substr(0, 40)));
    keys.interpolation = kind == "STEP"     ? KeyInterpolation::kStep
                         : kind == "LINEAR" ? KeyInterpolation::kLinear
                                            : KeyInterpolation::kCubic;
    auto input = file_.whole(sampler, "input", path + ".sampler");
    if (!input) return input.error();
    auto output = file_.whole(sampler, "output", path + ".sampler");
    if (!output) return output.error();
    auto times = file_.floats(*input, 1);
    if (!times) return times.error();
    auto values = file_.floats(*output, components);
    if (!values) return values.error();
    const size_t perKey = components * (keys.interpolation == KeyInterpolation::kCubic ? 3u : 1u);
    if (values->size() != times->size() * perKey)
      return file_.fail(path, fmt::format("{} keys have {} numbers instead of {}", times->size(),
                                          values->size(), times->size() * perKey));
    float before = -1;
    for (const float time : *times) {
      if (!std::isfinite(time) || !(time > before) || time < 0)
        return file_.fail(path, fmt::format("the time {} s follows {} s; times must ascend from 0",
                                            time, before));
      before = time;
    }
    for (const float value : *values)
      if (!std::isfinite(value)) return file_.fail(path, "a key is not finite");
    numberCount_ += times->size() + values->size();
    if (numberCount_ > kFreeNumbers + kNumbersPerByte * file_.bytesRead())
      return file_.fail(path, "too many channels share their keys");
    keys.times = *std::move(times);
    keys.values = *std::move(values);
    return keys;
  }

  detail::GltfFile file_;
  SkeletonAnimation animation_;
  uint64_t numberCount_ = 0;    // of the keys so far
  std::vector<int64_t> slots_;  // [node of the file] its index in the animation
};

using Values = Eigen::Vector4d;

Values valueAt(const AnimationKeys& keys, size_t index, size_t components) {
  Values value = Values::Zero();
  for (size_t c = 0; c < components; ++c)
    value(static_cast<Eigen::Index>(c)) = double{keys.values[index * components + c]};
  return value;
}

// Appendix C of the specification.
Values cubic(const AnimationKeys& keys, size_t key, double share, double step, size_t components) {
  const auto at = [&](size_t which, size_t k) {
    return valueAt(keys, (key + k) * 3 + which, components);
  };
  const double t = share, t2 = t * t, t3 = t2 * t;
  return (2 * t3 - 3 * t2 + 1) * at(1, 0) + step * (t3 - 2 * t2 + t) * at(2, 0) +
         (-2 * t3 + 3 * t2) * at(1, 1) + step * (t3 - t2) * at(0, 1);
}

// The property at a time; `rest` without keys.
Values evaluate(const AnimationKeys& keys, double seconds, size_t components, const Values& rest) {
  if (keys.times.empty()) return rest;
  const bool isCubic = keys.interpolation == KeyInterpolation::kCubic;
  const auto key = [&](size_t i) {
    return isCubic ? valueAt(keys, i * 3 + 1, components) : valueAt(keys, i, components);
  };
  if (!(seconds > double{keys.times.front()})) return key(0);
  if (seconds >= double{keys.times.back()}) return key(keys.times.size() - 1);
  const auto after = std::upper_bound(keys.times.begin(), keys.times.end(), seconds,
                                      [](double s, float time) { return s < double{time}; });
  const auto right = static_cast<size_t>(after - keys.times.begin()), left = right - 1;
  if (keys.interpolation == KeyInterpolation::kStep) return key(left);
  const double step = double{keys.times[right]} - double{keys.times[left]};
  const double share = (seconds - double{keys.times[left]}) / step;
  if (isCubic) return cubic(keys, left, share, step, components);
  if (components == 3) return key(left) + share * (key(right) - key(left));
  const Eigen::Quaterniond a(key(left).normalized()), b(key(right).normalized());
  return a.slerp(share, b).coeffs();  // on the shortest arc
}

AffineTransform localTransform(const AnimatedNode& node, double seconds) {
  const Values t = evaluate(
      node.translations, seconds, 3,
      {double{node.translation.x}, double{node.translation.y}, double{node.translation.z}, 0});
  const Values r = evaluate(node.rotations, seconds, 4,
                            {double{node.rotation.x}, double{node.rotation.y},
                             double{node.rotation.z}, double{node.rotation.w}});
  const Values s = evaluate(node.scales, seconds, 3,
                            {double{node.scale.x}, double{node.scale.y}, double{node.scale.z}, 0});
  AffineTransform result = rigidTransform(
      {static_cast<float>(r(0)), static_cast<float>(r(1)), static_cast<float>(r(2)),
       static_cast<float>(r(3))},
      {static_cast<float>(t(0)), static_cast<float>(t(1)), static_cast<float>(t(2))});
  for (Float4& row : result.rows)
    row = {row.x * static_cast<float>(s(0)), row.y * static_cast<float>(s(1)),
           row.z * static_cast<float>(s(2)), row.w};
  return node.matrix == AffineTransform{} ? result : multiply(node.matrix, result);
}

std::vector<AffineTransform> toScene(const SkeletonAnimation& animation,
                                     const std::vector<AffineTransform>& locals) {
  std::vector<AffineTransform> result(locals.size());
  for (size_t i = 0; i < locals.size(); ++i) {
    const int32_t parent = animation.nodes[i].parent;
    result[i] = parent < 0 ? locals[i] : multiply(result[static_cast<size_t>(parent)], locals[i]);
  }
  return result;
}

}  // namespace

Result<SkeletonAnimation> loadAnimation(const std::filesystem::path& path, std::string_view clip) {
  return tools::guarded([&]() -> Result<SkeletonAnimation> {
    auto bytes = tools::readFile(path);
    if (!bytes) return bytes.error();
    const std::string name = path.string();
    return AnimationReader(*bytes, name, path.parent_path().empty() ? "." : path.parent_path())
        .read(clip);
  });
}

Result<SkeletonAnimation> loadAnimation(std::span<const std::byte> bytes, std::string_view name,
                                        std::string_view clip) {
  return tools::guarded([&] { return AnimationReader(bytes, name, {}).read(clip); });
}

Skeleton skeletonOf(const SkeletonAnimation& animation) {
  std::vector<AffineTransform> locals;
  for (AnimatedNode node : animation.nodes) {
    node.translations = node.rotations = node.scales = {};
    locals.push_back(localTransform(node, 0));
  }
  const std::vector<AffineTransform> bind = toScene(animation, locals);
  Skeleton skeleton;
  for (size_t i = 0; i < animation.nodes.size(); ++i)
    skeleton.bones.push_back({animation.nodes[i].name, animation.nodes[i].parent, bind[i]});
  return skeleton;
}

std::vector<AffineTransform> poseAt(const SkeletonAnimation& animation, double seconds) {
  std::vector<AffineTransform> locals;
  locals.reserve(animation.nodes.size());
  for (const AnimatedNode& node : animation.nodes) locals.push_back(localTransform(node, seconds));
  return toScene(animation, locals);
}

}  // namespace pelage
