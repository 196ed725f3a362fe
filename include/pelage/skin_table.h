// The position of each root on a mesh, so that hair can follow blend shapes and other deformations
// without bones; and its file, .tfxskin.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/bone_weights.h"
#include "pelage/export.h"
#include "pelage/result.h"
#include "pelage/stream.h"
#include "pelage/types.h"

namespace pelage {

/// A mesh of the file that hair was bound to; its names let an engine find it again.
struct SkinPart {
  std::string name;      ///< name of the node, UTF-8
  std::string mesh;      ///< name of the mesh; may be empty
  std::string material;  ///< name of the material; may be empty
  uint32_t vertexCount = 0, triangleCount = 0;
  bool operator==(const SkinPart&) const = default;
};

/// A root on a triangle. Its bind position is the weighted mean of the corners in `bind`, plus
/// `offset` in the triangle's frame: x along the edge from corner 0 to 1, z along the normal
/// (x edge to corner 2), y = z cross x.
struct SurfaceRoot {
  uint32_t part = 0;
  uint32_t triangle = 0;            ///< index in the part
  uint32_t corners[3] = {0, 0, 0};  ///< vertices of the part
  Float3 barycentric;               ///< weights of the corners, 0..1, their sum 1
  Float3 offset;                    ///< [m]
  Float3 bind[3];  ///< corners when the hair was bound [m]; their triangle has an area
  bool operator==(const SurfaceRoot&) const = default;
};

/// Contents of a .tfxskin file.
struct SkinTable {
  std::vector<SkinPart> parts;
  std::vector<SurfaceRoot> roots;  ///< [strand]
  bool operator==(const SkinTable&) const = default;
};

/// Makes the checks of loadTfxSkin(). Errors name the part or the root.
PELAGE_API Result<void> validate(const SkinTable& table);

/// Loads a .tfxskin file. `strandCount` is the number of strands of the hair; 0 accepts any number.
/// Errors name the byte offset: truncation, another magic or version, a part, a triangle or a
/// corner out of range, a name that is too long or has a NUL, barycentric coordinates outside of
/// 0..1 or that do not sum to 1, a coordinate that is not finite or beyond +-1e6 (an offset: 4e6),
/// corners without area, bytes after the last root.
PELAGE_API Result<SkinTable> loadTfxSkin(const std::filesystem::path& path,
                                         uint32_t strandCount = 0);
/// The same from memory, or from a stream, which is read at once; `name` names it in errors.
PELAGE_API Result<SkinTable> loadTfxSkin(std::span<const std::byte> bytes, std::string_view name,
                                         uint32_t strandCount = 0);
PELAGE_API Result<SkinTable> loadTfxSkin(ByteSource& source, std::string_view name,
                                         uint32_t strandCount = 0);

/// Returns the bytes of a .tfxskin file. Loading them and saving again gives the same bytes.
PELAGE_API Result<std::vector<std::byte>> saveTfxSkin(const SkinTable& table);
PELAGE_API Result<void> saveTfxSkin(const SkinTable& table, const std::filesystem::path& path);

/// Returns the bind position of a root [m].
PELAGE_API Float3 bindPosition(const SurfaceRoot& root);

/// Computes the rigid motion of each root on a deformed mesh, from bind space to the space of
/// `vertices`. Pass the result to HairObject::setBones() of a hair object whose influences are
/// those of oneBoneAStrand(). A root's surface point moves with its triangle. The rotation is that
/// of the triangle (the rotation of its normal and the orthogonal polar factor in its plane), so
/// stretch and shear do not tilt hair to one side.
/// \param vertices [part][vertex of the part] deformed positions [m]. Parts without roots may be
/// empty.
/// \param transforms [strand]. A root whose triangle has no area or is not finite keeps its
/// transform: keep the array from frame to frame.
/// Errors: a number of parts or strands that differs from the table's, a part that has roots and
/// too few vertices.
PELAGE_API Result<void> rootTransforms(const SkinTable& table,
                                       std::span<const std::span<const Float3>> vertices,
                                       std::span<AffineTransform> transforms);

/// Returns influences [strand] with which strand i follows bone i alone; HairDef::boneCount is then
/// the number of strands.
PELAGE_API std::vector<BoneInfluences> oneBoneAStrand(uint32_t strandCount);

}  // namespace pelage
