// Names and numbers of the JSON are those of the Khronos "glTF 2.0 Specification": 3.6 (buffers and
// accessors), 3.7 (meshes and skins), 3.11 (animations).
#include "gltf_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "names.h"
#include "pelage/skeleton.h"

namespace sample {

using nlohmann::json;
using pelage::CharacterMotion;

namespace {

enum ComponentType : uint32_t { kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126 };
enum BufferTarget : uint32_t { kNoTarget = 0, kArrayBuffer = 34962, kElementArrayBuffer = 34963 };

constexpr double kRate = 30;  // Hz

// The binary file and the accessors into it.
class Binary {
 public:
  /// \param width components an element.
  uint32_t addFloats(const std::vector<float>& values, uint32_t width, const char* type,
                     BufferTarget target = kNoTarget) {
    const size_t offset = bytes_.size();
    for (const float value : values) put(std::bit_cast<uint32_t>(value), 4);
    return addAccessor(offset, values.size() / width, kFloat, type, target);
  }
  uint32_t addIndices(std::span<const uint32_t> values) {
    const size_t offset = bytes_.size();
    for (const uint32_t value : values) put(value, 4);
    return addAccessor(offset, values.size(), kUnsignedInt, "SCALAR", kElementArrayBuffer);
  }
  uint32_t addShorts(const std::vector<uint32_t>& values, uint32_t width, const char* type) {
    const size_t offset = bytes_.size();
    for (const uint32_t value : values) put(value, 2);
    return addAccessor(offset, values.size() / width, kUnsignedShort, type, kArrayBuffer);
  }
  /// Smallest and largest elements, which some accessors must name.
  void setBounds(uint32_t accessor, const std::vector<float>& values, uint32_t width) {
    std::vector<float> low(values.begin(), values.begin() + width), high = low;
    for (size_t i = 0; i < values.size(); ++i) {
      low[i % width] = std::min(low[i % width], values[i]);
      high[i % width] = std::max(high[i % width], values[i]);
    }
    accessors_[accessor]["min"] = low;
    accessors_[accessor]["max"] = high;
  }

  const std::vector<char>& bytes() const { return bytes_; }
  json views = json::array();
  const json& accessors() const { return accessors_; }

 private:
  void put(uint32_t value, int count) {
    for (int i = 0; i < count; ++i) bytes_.push_back(static_cast<char>(value >> 8 * i & 0xff));
  }

  uint32_t addAccessor(size_t offset, size_t count, ComponentType component, const char* type,
                       BufferTarget target) {
    json view = {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes_.size() - offset}};
    if (target != kNoTarget) view["target"] = target;
    views.push_back(view);
    accessors_.push_back({{"bufferView", views.size() - 1},
                          {"componentType", component},
                          {"count", count},
                          {"type", type}});
    while (bytes_.size() % 4 != 0) bytes_.push_back(0);
    return static_cast<uint32_t>(accessors_.size() - 1);
  }

  std::vector<char> bytes_;
  json accessors_ = json::array();
};

std::vector<float> flat(const std::vector<Float3>& vectors) {
  std::vector<float> values;
  values.reserve(3 * vectors.size());
  for (const Float3& v : vectors) values.insert(values.end(), {v.x, v.y, v.z});
  return values;
}

json meshOf(const Character& character, Binary& binary) {
  const pelage::CollisionMesh& mesh = character.mesh;
  std::vector<uint32_t> joints;
  std::vector<float> weights;
  for (const pelage::BoneInfluences& from : mesh.influences)
    for (int i = 0; i < 4; ++i) {
      // A joint without weight must be joint 0.
      joints.push_back(from.weights[i] > 0 ? from.bones[i] : 0);
      weights.push_back(from.weights[i]);
    }
  const std::vector<float> positions = flat(mesh.positions);
  const uint32_t positionAccessor = binary.addFloats(positions, 3, "VEC3", kArrayBuffer);
  binary.setBounds(positionAccessor, positions, 3);
  const json attributes = {
      {"POSITION", positionAccessor},
      {"NORMAL", binary.addFloats(flat(mesh.normals), 3, "VEC3", kArrayBuffer)},
      {"JOINTS_0", binary.addShorts(joints, 4, "VEC4")},
      {"WEIGHTS_0", binary.addFloats(weights, 4, "VEC4", kArrayBuffer)}};
  json primitives = json::array();
  for (size_t i = 0; i < character.parts.size(); ++i) {
    const pelage::CharacterPart& part = character.parts[i];
    if (part.indexCount == 0) continue;
    const uint32_t indices =
        binary.addIndices(std::span(mesh.indices).subspan(part.firstIndex, part.indexCount));
    primitives.push_back({{"attributes", attributes}, {"indices", indices}, {"material", i}});
  }
  return {{"name", "body"}, {"primitives", primitives}};
}

json materialsOf(const Character& character) {
  json materials = json::array();
  for (const pelage::CharacterPart& part : character.parts)
    materials.push_back({{"name", part.name},
                         {"pbrMetallicRoughness",
                          {{"baseColorFactor", {part.color.x, part.color.y, part.color.z, 1}},
                           {"metallicFactor", 0},
                           {"roughnessFactor", 0.7}}}});
  return materials;
}

Float3 translationOf(const AffineTransform& transform) {
  return {transform.rows[0].w, transform.rows[1].w, transform.rows[2].w};
}

// Rotation and translation of a bone relative to its parent. All of them are rigid.
struct LocalPose {
  Float4 rotation;
  Float3 translation;
};

LocalPose localPose(const pelage::Skeleton& skeleton, const std::vector<AffineTransform>& world,
                    size_t bone) {
  const int32_t parent = skeleton.bones[bone].parent;
  AffineTransform local = world[bone];
  if (parent >= 0)
    local = pelage::multiply(
        pelage::inverse(world[static_cast<size_t>(parent)]).value_or(AffineTransform{}), local);
  return {pelage::toDualQuaternion(local).real, translationOf(local)};
}

json nodesOf(const Character& character) {
  const pelage::Skeleton& skeleton = character.skeleton;
  std::vector<AffineTransform> bind;
  for (const pelage::Bone& bone : skeleton.bones) bind.push_back(bone.bind);
  json nodes = json::array();
  for (size_t i = 0; i < skeleton.bones.size(); ++i) {
    const Float3 t = localPose(skeleton, bind, i).translation;
    json node = {{"name", skeleton.bones[i].name}, {"translation", {t.x, t.y, t.z}}};
    for (size_t child = 0; child < skeleton.bones.size(); ++child)
      if (skeleton.bones[child].parent == static_cast<int32_t>(i))
        node["children"].push_back(child);
    nodes.push_back(node);
  }
  nodes.push_back({{"name", "body"}, {"mesh", 0}, {"skin", 0}});
  return nodes;
}

json skinOf(const Character& character, Binary& binary) {
  std::vector<float> inverses;  // column by column
  json joints = json::array();
  for (size_t i = 0; i < character.skeleton.bones.size(); ++i) {
    const AffineTransform inverse =
        pelage::inverse(character.skeleton.bones[i].bind).value_or(AffineTransform{});
    const auto& r = inverse.rows;
    inverses.insert(inverses.end(), {r[0].x, r[1].x, r[2].x, 0, r[0].y, r[1].y, r[2].y, 0,  //
                                     r[0].z, r[1].z, r[2].z, 0, r[0].w, r[1].w, r[2].w, 1});
    joints.push_back(i);
  }
  return {{"inverseBindMatrices", binary.addFloats(inverses, 16, "MAT4")},
          {"joints", joints},
          {"skeleton", 0}};
}

json animationOf(const char* name, CharacterMotion motion, const pelage::Skeleton& skeleton,
                 Binary& binary) {
  const pelage::CharacterCycle cycle = pelage::characterCycle(motion);
  const auto count = static_cast<int>(std::lround((cycle.end - cycle.start) * kRate)) + 1;
  const size_t bones = skeleton.bones.size();
  std::vector<float> times, translations;
  std::vector<std::vector<float>> rotations(bones);
  for (int i = 0; i < count; ++i) {
    times.push_back(static_cast<float>(i / kRate));
    const auto world = pelage::poseCharacter(motion, cycle.start + i / kRate);
    for (size_t bone = 0; bone < bones; ++bone) {
      const LocalPose pose = localPose(skeleton, world, bone);
      Float4 q = pose.rotation;
      // A rotation has two quaternions: take the one that is nearer to the key before.
      const std::vector<float>& before = rotations[bone];
      const size_t n = before.size();
      if (n >= 4 &&
          q.x * before[n - 4] + q.y * before[n - 3] + q.z * before[n - 2] + q.w * before[n - 1] < 0)
        q = {-q.x, -q.y, -q.z, -q.w};
      rotations[bone].insert(rotations[bone].end(), {q.x, q.y, q.z, q.w});
      if (bone == 0)
        translations.insert(translations.end(),
                            {pose.translation.x, pose.translation.y, pose.translation.z});
    }
  }
  const uint32_t input = binary.addFloats(times, 1, "SCALAR");
  binary.setBounds(input, times, 1);
  json samplers = json::array(), channels = json::array();
  const auto add = [&](size_t bone, const char* path, uint32_t output) {
    channels.push_back(
        {{"sampler", samplers.size()}, {"target", {{"node", bone}, {"path", path}}}});
    samplers.push_back({{"input", input}, {"interpolation", "LINEAR"}, {"output", output}});
  };
  add(0, "translation", binary.addFloats(translations, 3, "VEC3"));
  for (size_t bone = 0; bone < bones; ++bone)
    add(bone, "rotation", binary.addFloats(rotations[bone], 4, "VEC4"));
  return {{"name", name}, {"samplers", samplers}, {"channels", channels}};
}

Result<void> writeFile(const std::filesystem::path& path, std::span<const char> bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) return Error{ErrorCode::kFileNotFound, path.string() + ": cannot be written"};
  return {};
}

}  // namespace

Result<void> writeGltf(const Character& character, const std::filesystem::path& path) {
  std::filesystem::path binaryPath = path;
  binaryPath.replace_extension(".bin");
  Binary binary;
  json file = {{"asset", {{"version", "2.0"}, {"generator", "pelage-headless"}}},
               {"scene", 0},
               {"scenes", {{{"nodes", {0, character.skeleton.bones.size()}}}}},
               {"nodes", nodesOf(character)},
               {"meshes", {meshOf(character, binary)}},
               {"materials", materialsOf(character)},
               {"skins", {skinOf(character, binary)}}};
  file["animations"] = {
      animationOf("walk", CharacterMotion::kWalk, character.skeleton, binary),
      animationOf("headShake", CharacterMotion::kHeadShake, character.skeleton, binary),
      animationOf("jump", CharacterMotion::kJump, character.skeleton, binary)};
  file["accessors"] = binary.accessors();
  file["bufferViews"] = binary.views;
  file["buffers"] = {
      {{"uri", binaryPath.filename().string()}, {"byteLength", binary.bytes().size()}}};
  const std::string text = file.dump(1) + "\n";
  if (Result<void> done = writeFile(path, text); !done) return done;
  return writeFile(binaryPath, binary.bytes());
}

}  // namespace sample
