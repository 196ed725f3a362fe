// Readers of hair curves: what modelling programs and other hair libraries write, and the text
// format of our own. docs/formats.md describes each format.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/authoring/hair_curves.h"
#include "pelage/result.h"

namespace pelage {

enum class HairFileKind {
  kTfx,      ///< .tfx of TressFX 1 to 4
  kHair,     ///< .hair of Cem Yuksel
  kObj,      ///< polylines of a Wavefront .obj
  kGltf,     ///< lines of a .gltf or .glb
  kHairText  ///< .hairtxt, ours
};

/// What a reader saw.
struct HairFileReport {
  HairFileKind kind = HairFileKind::kTfx;
  std::string format;     ///< format and version for people: "TressFX 2.0 text"
  uint64_t fileSize = 0;  ///< [byte]
  /// Sentences about what the file has and the curves have not, and what was assumed.
  std::vector<std::string> notes;
};

// All readers give the curves as they are in the file: no unit or axis is changed, and a curve may
// have a single vertex or a coordinate that is not finite. prepareCurves() (curve_import.h) makes
// them fit for everything else, and counts what it had to drop. Errors name the file with its line
// or byte; counts are held against the file's size before anything is allocated. `report` may be
// null.

/// Reads any of the formats. The magic number at its start tells the format, else the extension.
/// Errors also for a file that is none of them.
Result<HairCurves> loadHairCurves(const std::filesystem::path& path,
                                  HairFileReport* report = nullptr);
/// The same from memory; `name` is what errors call it, and its extension counts.
Result<HairCurves> loadHairCurves(std::span<const std::byte> bytes, std::string_view name,
                                  HairFileReport* report = nullptr);

/// Which reader a file is for; nothing when neither its start nor its name tells.
std::optional<HairFileKind> hairFileKind(std::span<const std::byte> bytes, std::string_view name);

/// .hair: Cem Yuksel's HAIR format, http://www.cemyuksel.com/research/hairmodels. Thickness is
/// taken as the diameter, transparency becomes opacity. A default of the header becomes no array.
Result<HairCurves> loadYukselHair(std::span<const std::byte> bytes, std::string_view name,
                                  HairFileReport* report = nullptr);

/// The `l` elements of a Wavefront .obj. Those of two vertices are joined where they meet in pairs;
/// longer ones are a curve each. Vertex colours (x y z r g b) and texture coordinates are kept.
Result<HairCurves> loadObjCurves(std::span<const std::byte> bytes, std::string_view name,
                                 HairFileReport* report = nullptr);

/// The primitives LINE_STRIP, LINE_LOOP and LINES of the default scene of a glTF 2.0 file, text or
/// binary, where its nodes put them; LINES are joined where they meet in pairs. COLOR_0 and
/// TEXCOORD_0 are kept. Sparse and compressed accessors are errors.
/// \param folder of the buffers that the file names; without it such buffers are an error.
Result<HairCurves> loadGltfCurves(std::span<const std::byte> bytes, std::string_view name,
                                  const std::filesystem::path& folder = {},
                                  HairFileReport* report = nullptr);

/// .tfx of any version that is known: text of TressFX 1 and 2, binary 3.0 and 4.0. A strand's
/// thickness t becomes the radius t x kUnitFibreRadius. Values of 4.0 that are no numbers are
/// repaired as TfxLoadOptions::repair says, and noted; strands without any usable position are left
/// for prepareCurves() to drop.
Result<HairCurves> loadTfxCurves(std::span<const std::byte> bytes, std::string_view name,
                                 HairFileReport* report = nullptr);
/// Fibre radius that a strand thickness of 1 stands for when .tfx becomes curves [m].
inline constexpr float kUnitFibreRadius = 4e-5f;

/// .hairtxt: `hairtxt 1`, the columns, and a vertex a line; a blank line ends a curve.
Result<HairCurves> loadHairText(std::span<const std::byte> bytes, std::string_view name,
                                HairFileReport* report = nullptr);

/// The text of a .hairtxt file; loadHairText() gives the same curves, bit by bit. Errors: curves
/// that validate() refuses.
Result<std::string> saveHairText(const HairCurves& curves);
Result<void> saveHairText(const HairCurves& curves, const std::filesystem::path& path);

/// The bytes of a .hair file: positions, radii, colours and vertex UV (the array that LuxCore added
/// to the format); it has no place for inverse masses and strand UV. Errors: curves that validate()
/// refuses, a curve of more than 65536 vertices, more than 2^32 - 1 vertices.
Result<std::vector<std::byte>> saveYukselHair(const HairCurves& curves);
Result<void> saveYukselHair(const HairCurves& curves, const std::filesystem::path& path);

/// "TressFX", ".hair", ...: what people call the kind.
const char* toString(HairFileKind kind);

}  // namespace pelage
