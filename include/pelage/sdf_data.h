// A signed distance field that was built before, for colliders that do not change their shape.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "pelage/result.h"
#include "pelage/sdf_collider.h"
#include "pelage/stream.h"

namespace pelage {

/// A field as the kernels have it: kernels/layouts/sdf_field.hlsli and kernels/sdf/sdf_key.hlsli
/// say what is where.
struct SdfData {
  SdfGrid grid;
  float band = 2;      ///< [cells]
  float farRange = 0;  ///< [cells]
  uint32_t triangleBits = 0;
  uint32_t triangleCount = 0;
  std::vector<uint32_t> keys;     ///< [node], x fastest
  std::vector<uint32_t> surface;  ///< [triangle][16], records without motion
  bool operator==(const SdfData&) const = default;
};

/// Saves a field (.psdf, little endian): "PSDF", version, header, keys, records.
Result<void> saveSdf(const SdfData& data, const std::filesystem::path& path);
/// Loads one. Errors name the file and the byte: another kind of file or version, sizes that do not
/// fit the file, a grid or numbers out of range, a key or a record that refers to a triangle that
/// is not there.
Result<SdfData> loadSdf(const std::filesystem::path& path);
/// The same from memory, or from a stream, all of which is read at once; `name` is what errors call
/// it.
Result<SdfData> loadSdf(std::span<const std::byte> bytes, std::string_view name);
Result<SdfData> loadSdf(ByteSource& source, std::string_view name);

}  // namespace pelage
