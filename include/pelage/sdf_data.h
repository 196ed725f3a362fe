// An SDF that was built in advance, for colliders that do not change their shape.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "pelage/export.h"
#include "pelage/result.h"
#include "pelage/sdf_collider.h"
#include "pelage/stream.h"

namespace pelage {

/// An SDF as the kernels store it. kernels/sdf/layouts/sdf.hlsli and kernels/sdf/sdf_key.hlsli
/// describe the layout.
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

/// Saves an SDF (.psdf, little endian): "PSDF", version, header, keys, records.
PELAGE_API Result<void> saveSdf(const SdfData& data, const std::filesystem::path& path);
/// Loads an SDF. Errors name the file and the byte: another kind of file or version, sizes that do
/// not match the file, a grid or numbers out of range, a key or a record that refers to a triangle
/// that does not exist.
PELAGE_API Result<SdfData> loadSdf(const std::filesystem::path& path);
/// The same from memory, or from a stream, which is read at once; `name` names it in errors.
PELAGE_API Result<SdfData> loadSdf(std::span<const std::byte> bytes, std::string_view name);
PELAGE_API Result<SdfData> loadSdf(ByteSource& source, std::string_view name);

}  // namespace pelage
