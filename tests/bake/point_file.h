// Files of floats for tests of bakes.
#pragma once

#include <cstring>
#include <string>
#include <vector>

#include "pelage/types.h"

namespace pelage::test {

/// Floats as the bytes of a file.
inline std::string bytesOfFloats(const std::vector<float>& floats) {
  std::string bytes(floats.size() * sizeof(float), '\0');
  if (!floats.empty()) std::memcpy(bytes.data(), floats.data(), bytes.size());
  return bytes;
}

/// The bytes of a .pc2 file. \param samples [sample][point]
inline std::string pointFile(int32_t points, float framesPerSample,
                             const std::vector<std::vector<Float3>>& samples) {
  const auto put = [](std::string& bytes, auto value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  std::string bytes("POINTCACHE2\0", 12);
  put(bytes, int32_t{1});
  put(bytes, points);
  put(bytes, 1.0f);
  put(bytes, framesPerSample);
  put(bytes, static_cast<int32_t>(samples.size()));
  for (const auto& sample : samples)
    for (const Float3& p : sample)
      for (const float coordinate : {p.x, p.y, p.z}) put(bytes, coordinate);
  return bytes;
}

}  // namespace pelage::test
