#include "stage/curve_files.h"

#include <algorithm>
#include <iterator>
#include <utility>

#ifdef PELAGE_VIEWER_AUTHORING
#include "pelage/authoring/curve_import.h"
#include "pelage/authoring/hair_files.h"
#include "pelage/authoring/resample.h"
#endif

namespace viewer {

using pelage::Error;
using pelage::ErrorCode;
using pelage::Result;

#ifdef PELAGE_VIEWER_AUTHORING

bool isCurveFile(std::string_view extension) {
  constexpr std::string_view kKnown[] = {".hair", ".obj", ".gltf", ".glb", ".hairtxt"};
  return std::find(std::begin(kKnown), std::end(kKnown), extension) != std::end(kKnown);
}

const char* curveExtensions() { return ", .hair, .obj, .gltf, .glb and .hairtxt"; }

Result<pelage::CachedHair> loadCurveFile(const std::filesystem::path& path, float scale,
                                         std::vector<std::string>& remarks) {
  const auto fail = [&](const Error& error) {
    return Error{error.code, path.string() + ": " + error.message};
  };
  pelage::HairFileReport file;
  auto curves = pelage::loadHairCurves(path, &file);
  if (!curves) return curves.error();
  for (const std::string& note : file.notes) remarks.push_back(path.string() + ": " + note);
  pelage::CurveImportReport imported;
  if (auto done = pelage::prepareCurves(*curves, {.scale = scale}, &imported); !done)
    return fail(done.error());
  if (imported.curvesDropped() > 0)
    remarks.push_back(path.string() + ": " + std::to_string(imported.curvesDropped()) +
                      " curves were dropped: too few vertices, or no length");
  auto resampled = pelage::resampleCurves(*curves);
  if (!resampled) return fail(resampled.error());
  pelage::CachedHair hair;
  hair.name = path.stem().string();
  hair.asset = std::move(resampled->asset);
  if (auto done = hair.asset.process(); !done) return fail(done.error());
  return hair;
}

#else

bool isCurveFile(std::string_view) { return false; }
const char* curveExtensions() { return ""; }
Result<pelage::CachedHair> loadCurveFile(const std::filesystem::path& path, float,
                                         std::vector<std::string>&) {
  return Error{ErrorCode::kUnsupported,
               path.string() + ": this viewer was built without PELAGE_AUTHORING"};
}

#endif

}  // namespace viewer
