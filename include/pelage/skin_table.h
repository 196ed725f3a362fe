// Where on a mesh each root sits, so that hair can follow blend shapes and any other deformation
// that bones do not have; and its file, .tfxskin.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/bone_weights.h"
#include "pelage/result.h"
#include "pelage/stream.h"
#include "pelage/types.h"

namespace pelage {

/// A mesh of the file that hair was bound to, as an engine finds it again.
struct SkinPart {
  std::string name;      ///< of the node, UTF-8
  std::string mesh;      ///< of the mesh; may be empty
  std::string material;  ///< may be empty
  uint32_t vertexCount = 0, triangleCount = 0;
  bool operator==(const SkinPart&) const = default;
};

/// A root on a triangle. Its bind position is the weighted mean of the corners in `bind`, plus
/// `offset` in the triangle's frame: x along the edge from corner 0 to 1, z along the normal
/// (x edge to corner 2), y = z cross x.
struct SurfaceRoot {
  uint32_t part = 0;
  uint32_t triangle = 0;            ///< of the part
  uint32_t corners[3] = {0, 0, 0};  ///< vertices of the part
  Float3 barycentric;               ///< weights of the corners, 0..1, their sum 1
  Float3 offset;                    ///< [m]
  Float3 bind[3];                   ///< corners when the hair was bound [m]; they span an area
  bool operator==(const SurfaceRoot&) const = default;
};

/// Contents of a .tfxskin file.
struct SkinTable {
  std::vector<SkinPart> parts;
  std::vector<SurfaceRoot> roots;  ///< [strand]
  bool operator==(const SkinTable&) const = default;
};

/// Checks what loadTfxSkin() checks. Errors name the part or the root.
Result<void> validate(const SkinTable& table);

/// Loads a .tfxskin file. `strandCount` is the number of strands that the hair has; 0 takes what
/// the file says. Errors name the byte offset: truncation, another magic or version, a part, a
/// triangle or a corner out of range, a name that is too long or has a NUL, barycentric coordinates
/// outside of 0..1 or that do not sum to 1, a coordinate that is not finite or beyond +-1e6
/// (an offset: 4e6), corners without area, bytes after the last root.
Result<SkinTable> loadTfxSkin(const std::filesystem::path& path, uint32_t strandCount = 0);
/// The same from memory, or from a stream, all of which is read at once; `name` is what errors call
/// it.
Result<SkinTable> loadTfxSkin(std::span<const std::byte> bytes, std::string_view name,
                              uint32_t strandCount = 0);
Result<SkinTable> loadTfxSkin(ByteSource& source, std::string_view name, uint32_t strandCount = 0);

/// The bytes of a .tfxskin file. Loading them and saving again gives the same bytes.
Result<std::vector<std::byte>> saveTfxSkin(const SkinTable& table);
Result<void> saveTfxSkin(const SkinTable& table, const std::filesystem::path& path);

/// Bind position of a root [m].
Float3 bindPosition(const SurfaceRoot& root);

/// The rigid motions that carry the roots along with a deformed mesh, for HairObject::setBones() of
/// a hair object whose influences are those of oneBoneAStrand(): from bind space to the space of
/// `vertices`. A root's surface point goes with its triangle; the rotation is that of the triangle
/// (the rotation of its normal and the orthogonal polar factor in its plane), so stretch and shear
/// do not turn hair to one side.
/// \param vertices    [part][vertex of the part] deformed positions [m]. Parts that no root sits on
///                    may be empty.
/// \param transforms  [strand]. Those of roots whose triangle now has no area or is not finite stay
///                    as they are: keep the array from frame to frame.
/// Errors: another number of parts or strands than the table has, a part that has roots and too few
/// vertices.
Result<void> rootTransforms(const SkinTable& table,
                            std::span<const std::span<const Float3>> vertices,
                            std::span<AffineTransform> transforms);

/// [strand] strand i follows bone i alone; HairDef::boneCount is then the number of strands.
std::vector<BoneInfluences> oneBoneAStrand(uint32_t strandCount);

}  // namespace pelage
