#include "pelage/authoring/hair_curves.h"
#include "pelage/authoring/hair_files.h"
#include "targets.h"

namespace pelage::fuzz {
namespace {

// Every reader of curves promises arrays that fit together, curves that can be prepared, and files
// of both kinds that load again.
Outcome check(const Result<HairCurves>& loaded) {
  if (!loaded) return refused(loaded.error());
  HairCurves curves = *loaded;
  uint64_t vertices = 0;
  for (const uint32_t count : curves.vertexCounts) vertices += count;
  const auto fits = [](const auto& array, uint64_t size) {
    return array.empty() || array.size() == size;
  };
  if (curves.positions.size() != vertices || !fits(curves.inverseMasses, vertices) ||
      !fits(curves.radii, vertices) || !fits(curves.colors, vertices) ||
      !fits(curves.vertexUv, vertices) || !fits(curves.strandUv, curves.curveCount()) ||
      !fits(curves.labels, curves.curveCount()))
    return broken("the arrays do not fit together");
  CurveImportReport report;
  // An error when nothing usable is left.
  if (!prepareCurves(curves, {.upAxis = UpAxis::kZ, .randomizeStrands = true}, &report))
    return {true, {}};
  if (report.curvesRead != report.curvesKept + report.curvesDropped())
    return broken("a curve is neither kept nor dropped");
  if (auto r = validate(curves); !r) return broken("not valid: " + r.error().message);

  const auto text = saveHairText(curves);
  if (!text) return broken("no .hairtxt: " + text.error().message);
  const auto again = loadHairText(std::as_bytes(std::span(*text)), kName);
  if (!again) return broken("the .hairtxt cannot be loaded: " + again.error().message);
  if (!sameBits(again->vertexCounts, curves.vertexCounts) ||
      !sameBits(again->positions, curves.positions) ||
      !sameBits(again->inverseMasses, curves.inverseMasses) ||
      !sameBits(again->radii, curves.radii) || !sameBits(again->colors, curves.colors) ||
      !sameBits(again->vertexUv, curves.vertexUv) || !sameBits(again->strandUv, curves.strandUv))
    return broken("the .hairtxt gives other curves");
  // Fails only where a radius is too large.
  if (const auto usd = saveUsdCurves(curves)) {
    const auto fromUsd = loadUsdCurves(std::as_bytes(std::span(*usd)), kName);
    if (!fromUsd) return broken("the .usda cannot be loaded: " + fromUsd.error().message);
    if (!sameBits(fromUsd->vertexCounts, curves.vertexCounts) ||
        !sameBits(fromUsd->positions, curves.positions) ||
        !sameBits(fromUsd->inverseMasses, curves.inverseMasses) ||
        !sameBits(fromUsd->radii, curves.radii) || !sameBits(fromUsd->colors, curves.colors) ||
        !sameBits(fromUsd->vertexUv, curves.vertexUv) ||
        !sameBits(fromUsd->strandUv, curves.strandUv) || fromUsd->labels != curves.labels)
      return broken("the .usda gives other curves");
  }
  const auto binary = saveYukselHair(curves);
  if (!binary) return broken("no .hair: " + binary.error().message);
  const auto fromBinary = loadYukselHair(*binary, kName);
  if (!fromBinary) return broken("the .hair cannot be loaded: " + fromBinary.error().message);
  if (!sameBits(fromBinary->vertexCounts, curves.vertexCounts) ||
      !sameBits(fromBinary->positions, curves.positions))
    return broken("the .hair gives other curves");
  return {true, {}};
}

}  // namespace

Outcome hair(std::span<const std::byte> bytes) { return check(loadYukselHair(bytes, kName)); }
Outcome hairtxt(std::span<const std::byte> bytes) { return check(loadHairText(bytes, kName)); }
Outcome obj(std::span<const std::byte> bytes) { return check(loadObjCurves(bytes, kName)); }
Outcome gltf(std::span<const std::byte> bytes) { return check(loadGltfCurves(bytes, kName)); }
Outcome usda(std::span<const std::byte> bytes) { return check(loadUsdCurves(bytes, kName)); }
Outcome tfxcurves(std::span<const std::byte> bytes) { return check(loadTfxCurves(bytes, kName)); }

}  // namespace pelage::fuzz
