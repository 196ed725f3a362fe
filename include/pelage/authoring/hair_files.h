// Readers of hair curves: the formats of modeling programs and other hair libraries, and pelage's
// own text format. docs/assets_formats.md describes each format.
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
  kTfx,       ///< .tfx of TressFX 1 to 4
  kHair,      ///< .hair of Cem Yuksel
  kObj,       ///< polylines of a Wavefront .obj
  kGltf,      ///< lines of a .gltf or .glb
  kHairText,  ///< .hairtxt of pelage
  kUsd        ///< BasisCurves of a .usda
};

/// The report of a reader.
struct HairFileReport {
  HairFileKind kind = HairFileKind::kTfx;
  std::string format;     ///< format and version to print: "TressFX 2.0 text"
  uint64_t fileSize = 0;  ///< [byte]
  /// Sentences about contents of the file that the curves do not have, and about assumptions.
  std::vector<std::string> notes;
};

// All readers return the curves as they are in the file: they change no unit or axis (but those of
// .usda, which says its own: its curves are in meters with y up), and a curve may have a single
// vertex or a coordinate that is not finite. prepareCurves() (hair_curves.h) repairs them and
// counts what it drops. Errors name the file with its line or byte. Counts are checked against the
// file's size before memory is allocated. `report` may be null.

/// Reads any of the formats. The magic number at the start of the file determines the format,
/// otherwise the extension. Errors: those of the reader, and a file in none of the formats.
Result<HairCurves> loadHairCurves(const std::filesystem::path& path,
                                  HairFileReport* report = nullptr);
/// The same from memory; `name` names it in errors, and its extension counts.
Result<HairCurves> loadHairCurves(std::span<const std::byte> bytes, std::string_view name,
                                  HairFileReport* report = nullptr);

/// Returns the format of a file; nothing if neither its start nor its name determines it.
std::optional<HairFileKind> hairFileKind(std::span<const std::byte> bytes, std::string_view name);

/// Reads .hair: Cem Yuksel's HAIR format, http://www.cemyuksel.com/research/hairmodels. Thickness
/// is interpreted as the diameter; transparency becomes opacity. Defaults of the header fill the
/// arrays that the file lacks, but for thickness 1, opaque and white, which stand for "not set".
Result<HairCurves> loadYukselHair(std::span<const std::byte> bytes, std::string_view name,
                                  HairFileReport* report = nullptr);

/// Reads the `l` elements of a Wavefront .obj. Lines of two vertices are joined where exactly two
/// share a vertex; each longer line is a curve. Vertex colors (x y z r g b) and texture coordinates
/// are kept.
Result<HairCurves> loadObjCurves(std::span<const std::byte> bytes, std::string_view name,
                                 HairFileReport* report = nullptr);

/// Reads the primitives LINE_STRIP, LINE_LOOP and LINES of the default scene of a glTF 2.0 file,
/// text or binary, transformed by their nodes; LINES are joined where exactly two share a vertex.
/// COLOR_0 and TEXCOORD_0 are kept. Sparse and compressed accessors are errors.
/// \param folder folder of the buffers that the file names; if empty, such buffers are an error.
Result<HairCurves> loadGltfCurves(std::span<const std::byte> bytes, std::string_view name,
                                  const std::filesystem::path& folder = {},
                                  HairFileReport* report = nullptr);

/// Reads .tfx of all known versions: text of TressFX 1 and 2, binary 3.0 and 4.0. A strand's
/// thickness t becomes the radius t x kUnitFiberRadius. Values of 4.0 that are not numbers are
/// repaired as described at TfxLoadOptions::repair, and noted. Strands without any usable position
/// are left for prepareCurves() to drop.
Result<HairCurves> loadTfxCurves(std::span<const std::byte> bytes, std::string_view name,
                                 HairFileReport* report = nullptr);

/// Reads .hairtxt: `hairtxt 1`, the columns, and one vertex per line; a blank line ends a curve.
Result<HairCurves> loadHairText(std::span<const std::byte> bytes, std::string_view name,
                                HairFileReport* report = nullptr);

/// Reads the BasisCurves of a .usda file, in meters with y up: those that are defined, active and
/// visible, transformed by their prims. Cubic curves become polylines that are off by 1/1000 of
/// their length at most, or have 16 vertices a segment. The widths are diameters. Of animated
/// values, the first time sample counts; references, sublayers and variants are not read. Errors
/// name the prim; .usdc and .usdz are errors that say how to convert them.
Result<HairCurves> loadUsdCurves(std::span<const std::byte> bytes, std::string_view name,
                                 HairFileReport* report = nullptr);

/// Returns the text of a .usda file with one prim, "hair", of linear curves in meters, y up, with
/// the primvars of Unreal's grooms; loadUsdCurves() gives the same curves, bit by bit. Errors:
/// curves that validate() refuses, no curves, an id of 2^63 or more, a group of 2^24 or more, a
/// radius above 1e30.
Result<std::string> saveUsdCurves(const HairCurves& curves);
/// The same as a file. \param prim  the prim's name: letters, digits and _, no digit first, 1..255
Result<void> saveUsdCurves(const HairCurves& curves, const std::filesystem::path& path,
                           std::string_view prim = "hair");

/// Returns the text of a .hairtxt file; loadHairText() gives the same curves, bit by bit. Errors:
/// curves that validate() refuses.
Result<std::string> saveHairText(const HairCurves& curves);
Result<void> saveHairText(const HairCurves& curves, const std::filesystem::path& path);

/// Returns the bytes of a .hair file: positions, radii, colors and vertex UV (the array that
/// LuxCore added to the format), without inverse masses and strand UV. Errors: curves that
/// validate() refuses, a curve of more than 65536 vertices, more than 2^32 - 1 vertices.
Result<std::vector<std::byte>> saveYukselHair(const HairCurves& curves);
Result<void> saveYukselHair(const HairCurves& curves, const std::filesystem::path& path);

/// Returns the usual name of the kind: "TressFX", ".hair", ...
const char* toString(HairFileKind kind);

}  // namespace pelage
