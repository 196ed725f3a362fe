// Hair and shadow maps of it on a device.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "reference/shadow/strand_shadow_reference.h"
#include "shadow/strand_shadow.h"
#include "shadow_test/gpu_structs.h"
#include "shadow_test/kernels.h"
#include "support/strand_run.h"

namespace pelage::test {

using detail::ShadowedHair;
using detail::StrandShadowDef;
using detail::StrandShadowPlan;
using reference::LightAxes;
using reference::ShadowFiber;

/// Strands that are all stored.
struct Hair {
  uint32_t vertices = 2;
  std::vector<Float4> positions;
  std::vector<float> thickness;
  float radius = 100e-6f, tipRatio = 1, opacity = 1;

  uint32_t strands() const { return static_cast<uint32_t>(positions.size()) / vertices; }
  ShadowedHair shadowed() const {
    ShadowedHair hair;
    hair.vertexCount = vertices;
    hair.strandCount = hair.guideCount = strands();
    hair.fiberRadius = radius;
    hair.tipRadiusRatio = tipRatio;
    hair.opacity = opacity;
    double length = 0;
    for (size_t i = 1; i < positions.size(); ++i)
      if (i % vertices > 0) length += (toVector(positions[i]) - toVector(positions[i - 1])).norm();
    hair.strandLength = static_cast<float>(length / strands());
    hair.volume = static_cast<float>(detail::hairVolume(positions, vertices));
    if (!thickness.empty()) {
      hair.maxThickness = *std::max_element(thickness.begin(), thickness.end());
      hair.meanThickness = std::accumulate(thickness.begin(), thickness.end(), 0.0f) /
                           static_cast<float>(thickness.size());
    }
    return hair;
  }
  std::vector<ShadowFiber> fibers() const {
    std::vector<ShadowFiber> result;
    const auto radiusAt = [&](uint32_t strand, uint32_t v) {
      const double factor = thickness.empty() ? 1 : static_cast<double>(thickness[strand]);
      return static_cast<double>(radius) * factor *
             (1 + (static_cast<double>(tipRatio) - 1) * v / (vertices - 1));
    };
    for (uint32_t s = 0; s < strands(); ++s)
      for (uint32_t v = 0; v + 1 < vertices; ++v)
        result.push_back({toVector(positions[s * vertices + v]),
                          toVector(positions[s * vertices + v + 1]), radiusAt(s, v),
                          radiusAt(s, v + 1), static_cast<double>(opacity)});
    return result;
  }
};

/// A head of about 0.2 m with curled hair that falls.
inline Hair headOfHair(uint32_t strands, uint32_t vertices, double size = 1) {
  Hair hair;
  hair.vertices = vertices;
  hair.radius = static_cast<float>(150e-6 * size);
  hair.tipRatio = 0.4f;
  hair.opacity = 0.8f;
  Random random(3);
  for (uint32_t s = 0; s < strands; ++s) {
    Vector3d out = random.vector(1).normalized();
    out.y() = std::abs(out.y());
    const double curl = random.between(0, 0.012), phase = random.between(0, 7);
    const double fall = random.between(0.12, 0.22), spread = random.between(0.05, 0.12);
    for (uint32_t v = 0; v < vertices; ++v) {
      const double t = static_cast<double>(v) / (vertices - 1), angle = phase + 9 * t;
      const Vector3d p = out * (0.09 + spread * t) + Vector3d(0, -fall * t * t, 0) +
                         Vector3d(std::cos(angle), 0, std::sin(angle)) * (curl * t);
      hair.positions.push_back(toFloat4(p * size));
    }
  }
  return hair;
}

inline Vector3d vectorOf(const Float3& v) { return toVector(Float4{v.x, v.y, v.z, 0}); }
inline Float3 floatsOf(const Vector3d& v) {
  const Float4 f = toFloat4(v);
  return {f.x, f.y, f.z};
}
inline Eigen::Vector4d rowOf(const Float4& r) {
  return {static_cast<double>(r.x), static_cast<double>(r.y), static_cast<double>(r.z),
          static_cast<double>(r.w)};
}

inline StrandShadowDef headDef(uint32_t size, uint32_t layers, double scale = 1) {
  StrandShadowDef def;
  def.toLight = {0.35f, 0.75f, 0.55f};
  def.center = {0, static_cast<float>(0.02 * scale), 0};
  def.radius = static_cast<float>(0.28 * scale);
  def.size = size;
  def.layers = layers;
  def.firstWord = 64;
  return def;
}

inline StrandShadowPlan planFor(const StrandShadowDef& def,
                                const std::vector<ShadowedHair>& hairs) {
  Result<StrandShadowPlan> plan = detail::planStrandShadow(def, hairs);
  if (plan) return *plan;
  ADD_FAILURE() << plan.error().message;
  return {};
}

inline LightAxes axesOf(const StrandShadowView& view) {
  const auto unit = [](const Float4& row) -> Vector3d { return toVector(row).normalized(); };
  return {unit(view.mapX), unit(view.mapY), -unit(view.mapZ)};
}

/// A map seen along z, around the origin; positions in it are in texels.
struct FlatMap {
  FlatMap(uint32_t size, uint32_t layers) : def(headDef(size, layers)), middle(size / 2.0) {
    def.toLight = {0, 0, 1};
    def.center = {0, 0, 0};
    const StrandShadowView view = planFor(def, {}).view;
    texel = static_cast<double>(view.texelSize);
    axes = axesOf(view);
  }
  Float4 at(double x, double y) const {
    return toFloat4((axes.x * (x - middle) + axes.y * (y - middle)) * texel);
  }
  StrandShadowDef def;
  double middle, texel;
  LightAxes axes;
};

/// The words of a map.
struct MapWords {
  std::vector<uint32_t> words;
  uint32_t texels = 0, layers = 0;  ///< of a face

  /// \param texel of all faces.
  uint32_t nearest(size_t texel) const { return words[faceOf(texel) + texel % texels]; }
  bool hasHair(size_t texel) const { return nearest(texel) != 0xffffffffu; }
  /// Optical depth up to the end of a layer; 0 without hair [quanta].
  uint32_t depth(size_t texel, uint32_t layer) const {
    return hasHair(texel) ? words[faceOf(texel) + texels + texel % texels * layers + layer] : 0;
  }
  size_t count() const { return words.size() / (1 + layers); }

 private:
  size_t faceOf(size_t texel) const { return texel / texels * texels * (1 + layers); }
};

/// A map on a device, with words of another one on both sides.
class MapRun {
 public:
  MapRun(Gpu& gpu, const StrandShadowPlan& plan)
      : gpu_(gpu),
        plan_(plan),
        words_(gpu, "shadowWords",
               std::vector<uint32_t>(plan.view.firstWord + plan.words + kAround, kPattern)),
        views_(gpu, "shadowViews", std::vector<StrandShadowView>(2)) {
    buffers_.views = views_.id();
    buffers_.viewCount = 2;
    buffers_.view = 1;
    buffers_.words = words_.id();
    buffers_.wordCount = plan.view.firstWord + plan.words + kAround;
  }

  void draw(const std::vector<ShadowedHair>& hairs) {
    PassList list;
    expectOk(detail::addStrandShadow(list, plan_, buffers_, hairs));
    gpu_.execute(list);
  }
  void draw(const Hair& hair) {
    const GuardedBuffer<Float4> positions(gpu_, "shadowPositions", hair.positions);
    const GuardedBuffer<float> thickness(gpu_, "shadowThickness", hair.thickness);
    ShadowedHair shadowed = hair.shadowed();
    shadowed.positions = positions.id();
    if (!hair.thickness.empty()) shadowed.thickness = thickness.id();
    draw({shadowed});
  }

  /// The map's words; checks those around it.
  std::vector<uint32_t> words() const {
    const std::vector<uint32_t> all = words_.read();
    const auto begin = all.begin() + plan_.view.firstWord, end = begin + plan_.words;
    const auto isPattern = [](uint32_t word) { return word == kPattern; };
    EXPECT_TRUE(std::all_of(all.begin(), begin, isPattern)) << "words before the map";
    EXPECT_TRUE(std::all_of(end, all.end(), isPattern)) << "words behind the map";
    return {begin, end};
  }
  MapWords map() const {
    return {words(), plan_.view.width * plan_.view.height, plan_.view.layerCount};
  }
  /// Over all texels and layers.
  double sumOfDepths() const {
    double sum = 0;
    const MapWords all = map();
    for (size_t i = 0; i < all.count(); ++i)
      sum += static_cast<double>(all.depth(i, all.layers - 1)) /
             static_cast<double>(plan_.view.tauScale);
    return sum;
  }

  std::vector<float> transmittance(const std::vector<Float4>& points, bool soft = false) {
    const GuardedBuffer<Float4> pointBuffer(gpu_, "readPoints", points);
    const GuardedBuffer<float> results(gpu_, "readResults", std::vector<float>(points.size(), -1));
    shadow_test::ReadShadowConstants constants = {};
    constants.readCount = static_cast<uint32_t>(points.size());
    constants.readView = 1;
    constants.readSoft = soft ? 1 : 0;
    dispatch(gpu_, shadow_test::readStrandShadowVariant({}), points.size(), [&](PassBuilder& pass) {
      pointBuffer.bindTo(pass, "g_readPoints");
      words_.bindTo(pass, "g_readWords");
      views_.bindTo(pass, "g_readViews");
      results.bindTo(pass, "g_readResults");
      pass.constants("ReadShadowConstants", constants);
    });
    return results.read();
  }

 private:
  static constexpr uint32_t kPattern = 0x5a17c0deu;
  static constexpr uint32_t kAround = 64;

  Gpu& gpu_;
  StrandShadowPlan plan_;
  GuardedBuffer<uint32_t> words_;
  GuardedBuffer<StrandShadowView> views_;
  detail::StrandShadowBuffers buffers_;
};

inline double texelArea(const StrandShadowPlan& plan) {
  return std::pow(static_cast<double>(plan.view.texelSize), 2);
}

}  // namespace pelage::test
