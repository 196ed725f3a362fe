// A small skinned character as a glTF file, for tests of mesh readers.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace pelage::test {

/// Writes tube.gltf and tube.bin: a closed tube of square rings along y, from y = 0 to 4, 2 wide,
/// in an object "body" with the materials "cloth" (y < 2) and "skin" (y > 2), each with vertices of
/// its own; the rings hang on "hip" at y = 0, on "chest" at y = 4, and on both between, linearly.
/// An object "hat" of the material "cloth", one triangle in the plane y = 5, hangs on no bone.
inline std::filesystem::path writeTube(const std::filesystem::path& folder) {
  std::string bytes, views, accessors;
  int count = 0;
  const auto add = [&](const auto& values, int componentType, const char* type, size_t perItem,
                       const std::string& extra = {}) {
    const size_t size = values.size() * sizeof(values[0]);
    const std::string comma = count > 0 ? ",\n" : "";
    views += comma + R"({"buffer":0,"byteOffset":)" + std::to_string(bytes.size()) +
             R"(,"byteLength":)" + std::to_string(size) + "}";
    accessors += comma + R"({"bufferView":)" + std::to_string(count) + R"(,"componentType":)" +
                 std::to_string(componentType) + R"(,"count":)" +
                 std::to_string(values.size() / perItem) + R"(,"type":")" + type + "\"" + extra +
                 "}";
    bytes.append(reinterpret_cast<const char*>(values.data()), size);
    while (bytes.size() % 4 != 0) bytes.push_back('\0');
    return count++;
  };
  constexpr int kFloat = 5126, kByte = 5121, kShort = 5123;
  std::string primitives;
  for (int half = 0; half < 2; ++half) {
    std::vector<float> positions, weights;
    std::vector<uint8_t> joints;
    std::vector<uint16_t> indices;
    for (int ring = 0; ring < 3; ++ring)
      for (int corner = 0; corner < 4; ++corner) {
        const auto y = static_cast<float>(2 * half + ring);
        positions.insert(positions.end(), {corner == 1 || corner == 2 ? 1.0f : -1.0f, y,
                                           corner >= 2 ? -1.0f : 1.0f});
        joints.insert(joints.end(), {0, 1, 0, 0});
        weights.insert(weights.end(), {1 - y / 4, y / 4, 0, 0});
      }
    for (int ring = 0; ring < 2; ++ring)
      for (int corner = 0; corner < 4; ++corner) {
        const auto a = static_cast<uint16_t>(4 * ring + corner);
        const auto b = static_cast<uint16_t>(4 * ring + (corner + 1) % 4);
        const auto c = static_cast<uint16_t>(b + 4), d = static_cast<uint16_t>(a + 4);
        indices.insert(indices.end(), {a, b, c, a, c, d});
      }
    if (half == 0)
      indices.insert(indices.end(), {0, 3, 2, 0, 2, 1});
    else
      indices.insert(indices.end(), {8, 9, 10, 8, 10, 11});
    const int p = add(positions, kFloat, "VEC3", 3, R"(,"min":[-1,0,-1],"max":[1,4,1])");
    const int j = add(joints, kByte, "VEC4", 4), w = add(weights, kFloat, "VEC4", 4);
    const int i = add(indices, kShort, "SCALAR", 1);
    primitives += std::string(half > 0 ? "," : "") + R"({"attributes":{"POSITION":)" +
                  std::to_string(p) + R"(,"JOINTS_0":)" + std::to_string(j) + R"(,"WEIGHTS_0":)" +
                  std::to_string(w) + R"(},"indices":)" + std::to_string(i) + R"(,"material":)" +
                  std::to_string(half) + "}";
  }
  const int hat = add(std::array<float, 9>{0, 0, 0, 0, 0, 1, 1, 0, 0}, kFloat, "VEC3", 3,
                      R"(,"min":[0,0,0],"max":[1,0,1])");
  const int hatIndices = add(std::array<uint16_t, 3>{0, 1, 2}, kShort, "SCALAR", 1);
  std::array<float, 32> inverseBind{};
  for (size_t bone = 0; bone < 2; ++bone) {
    for (size_t k = 0; k < 4; ++k) inverseBind[16 * bone + 5 * k] = 1;
    inverseBind[16 * bone + 13] = bone == 0 ? 0.0f : -4.0f;
  }
  const int bind = add(inverseBind, kFloat, "MAT4", 16);
  const std::string text =
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,2,3]}],"nodes":[
      {"name":"hip","children":[1]},{"name":"chest","translation":[0,4,0]},
      {"name":"body","mesh":0,"skin":0},{"name":"hat","mesh":1,"translation":[0,5,0]}],
      "skins":[{"joints":[0,1],"inverseBindMatrices":)" +
      std::to_string(bind) + R"(}],"materials":[{"name":"cloth"},{"name":"skin"}],"meshes":[
      {"name":"bodyMesh","primitives":[)" +
      primitives + R"(]},{"name":"hatMesh","primitives":[{"attributes":{"POSITION":)" +
      std::to_string(hat) + R"(},"indices":)" + std::to_string(hatIndices) +
      R"(,"material":0}]}],"accessors":[)" + accessors + R"(],"bufferViews":[)" + views +
      R"(],"buffers":[{"uri":"tube.bin","byteLength":)" + std::to_string(bytes.size()) + "}]}";
  std::ofstream(folder / "tube.bin", std::ios::binary) << bytes;
  std::ofstream(folder / "tube.gltf", std::ios::binary) << text;
  return folder / "tube.gltf";
}

}  // namespace pelage::test
