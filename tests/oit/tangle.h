// Strands in every direction in a ball, seen from the front: pixels of many layers.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "oit/fragment_capture.h"
#include "pelage/random.h"
#include "pelage/scene.h"
#include "support/gpu_fixture.h"
#include "support/not_numbers.h"
#include "support/pictures.h"
#include "support/required_devices.h"
#include "support/scene_run.h"
#include "support/views.h"

namespace pelage::test {

struct TangleDef {
  uint32_t strands = 1800;
  uint32_t vertices = 6;
  float radius = 0.0012f;  ///< of the fibers [m]; 2.7 mm a pixel in the middle of tangleView(96), 4
                           ///< mm of tangleView(64)
  float opacity = 0.33f;
  uint64_t seed = 7;
  bool reversed = false;  ///< strands in the reverse order
};

/// Bent strands of 5 to 20 cm around the origin.
inline HairAsset tangle(const TangleDef& def) {
  pelage::Random random(def.seed);
  const auto between = [&](float low, float high) { return low + (high - low) * random.uniform(); };
  std::vector<std::vector<Float4>> strands(def.strands);
  for (std::vector<Float4>& strand : strands) {
    Float3 p = {between(-0.11f, 0.11f), between(-0.11f, 0.11f), between(-0.1f, 0.1f)};
    Float3 step = {between(-0.02f, 0.02f), between(-0.02f, 0.02f), between(-0.02f, 0.02f)};
    for (uint32_t v = 0; v < def.vertices; ++v) {
      strand.push_back({p.x, p.y, p.z, v < 2 ? 0.0f : 1.0f});
      step = {step.x + between(-0.008f, 0.008f), step.y + between(-0.008f, 0.008f),
              step.z + between(-0.008f, 0.008f)};
      p = {p.x + step.x, p.y + step.y, p.z + step.z};
    }
  }
  if (def.reversed) std::reverse(strands.begin(), strands.end());
  HairAsset asset;
  asset.strandCount = def.strands;
  asset.verticesPerStrand = def.vertices;
  for (const std::vector<Float4>& strand : strands)
    asset.positions.insert(asset.positions.end(), strand.begin(), strand.end());
  expectOk(asset.process());
  return asset;
}

/// The strands of a tangle twice, red and blue at one place: all their fragments tie in depth.
inline HairAsset twins(const HairAsset& half, bool reversed) {
  HairAsset asset;
  asset.strandCount = 2 * half.strandCount;
  asset.verticesPerStrand = half.verticesPerStrand;
  for (const bool red : {reversed, !reversed}) {
    for (const Float4& p : half.positions) {
      asset.positions.push_back(p);
      asset.vertexColor.push_back(red ? Float4{1, 0.1f, 0, 1} : Float4{0, 0.1f, 1, 1});
    }
  }
  expectOk(asset.process());
  return asset;
}

inline StrandMaterial tangleMaterial(const TangleDef& def) {
  StrandMaterial material;
  material.rootColor = {0.6f, 0.3f, 0.1f};
  material.tipColor = {0.2f, 0.5f, 0.7f};
  // Strands keep their colour when their order changes.
  material.colorVariation = 0;
  material.opacity = def.opacity;
  material.fiberRadius = def.radius;
  material.tipRadiusRatio = 0.2f;
  return material;
}

/// It hangs nowhere.
inline HairDef tangleHair(const TangleDef& def) {
  HairDef hair = {.name = "tangle", .material = tangleMaterial(def)};
  hair.settings.gravity = {0, 0, 0};
  return hair;
}

inline View tangleView(uint32_t pixels, bool reversedDepth = false) {
  return cameraView(
      {.eye = {0, 0, 0.5f}, .width = pixels, .nearPlane = 0.1f, .reversedDepth = reversedDepth});
}

/// In the middle of the hair: strands behind the eye, through the near plane and across it.
inline View viewFromInside(uint32_t pixels, bool reversedDepth, float nearPlane = 0.001f) {
  return cameraView({.eye = {0, 0, 0},
                     .target = {0, 0, -1},
                     .fov = 1.5f,
                     .width = pixels,
                     .nearPlane = nearPlane,
                     .farPlane = 1,
                     .reversedDepth = reversedDepth});
}

inline constexpr Transparency kEachTransparency[] = {
    Transparency::kAlphaTest, Transparency::kStochastic, Transparency::kWindowed,
    Transparency::kHybrid4,   Transparency::kHybrid8,    Transparency::kHybrid16,
    Transparency::kShortCut,  Transparency::kTiles};

inline std::vector<Light> tangleLights() {
  Light key = {.direction = {0.5f, 0.7f, 0.5f}, .shadow = HairShadow::kDeep, .shadowSize = 128};
  Light side = {.hasPosition = true, .position = {-0.4f, 0.1f, 0.2f}};
  side.color = {0.05f, 0.06f, 0.1f};
  side.ambient = {0, 0, 0};
  return {key, side};
}

/// A scene with a tangle on a device of its own, at rest.
class TangleRun {
 public:
  explicit TangleRun(Api api) : run(api) {}

  void add(const TangleDef& def) { add(def, tangle(def)); }
  void add(const TangleDef& def, const HairAsset& asset) {
    run.add(asset, tangleHair(def));
    hair_ = run.lastHair();
    run.step();
  }
  HairObject& hair() { return run.scene.hair(hair_); }
  /// Draws the hair with every fifth vertex, a whole strand and all tangents not finite.
  /// \param far  every fourth vertex is so far away that its products have no floats, too
  RenderedImage renderSpoiled(const View& view, const TransparencySettings& settings,
                              bool far = false) {
    std::vector<Float4> positions = run.positions(hair());
    const std::vector<Float4> tangents(positions.size(), {kNan, 0, kInf, 0});
    for (size_t i = 0; i < positions.size(); i += 5) positions[i] = {kNan, kInf, -kInf, kNan};
    for (size_t i = 0; i < 6; ++i) positions[i] = {kNan, kNan, kNan, kNan};
    for (size_t i = 6; far && i < positions.size(); i += 4)
      positions[i] = {1e17f, -3e17f, 2e17f, 0};
    lists.assign(1, {});
    addUpload(lists[0], hair().buffers().positions, std::as_bytes(std::span(positions)));
    addUpload(lists[0], hair().buffers().tangents, std::as_bytes(std::span(tangents)));
    expectOk(run.scene.draw(view, tangleLights(), settings, lists));
    return renderLists(view).value_or(RenderedImage{});
  }

  /// Draws with these settings into an empty target.
  RenderedImage render(const View& view, const TransparencySettings& settings,
                       const RenderTargetDef& target = {}) {
    lists.clear();
    const uint32_t width = target.width > 0 ? target.width : view.width;
    const uint32_t height = target.height > 0 ? target.height : view.height;
    const RenderedImage none = {width, height, std::vector<Float4>(size_t{width} * height)};
    expectOk(run.scene.draw(view, tangleLights(), settings, lists));
    return renderLists(view, target).value_or(none);
  }

  /// \param target the size of the view where it has none.
  std::optional<RenderedImage> renderLists(const View& view, RenderTargetDef target = {}) {
    if (target.width == 0) target.width = view.width;
    if (target.height == 0) target.height = view.height;
    target.clearDepth = view.reversedDepth ? 0.0f : 1.0f;
    Result<RenderedImage> image = run.renderLists(lists, target);
    EXPECT_TRUE(image) << image.error().message;
    if (!image) return std::nullopt;
    return std::move(*image);
  }

  /// The exact composite of the last render().
  std::vector<ExactPixel> exact(const View& view, uint32_t capacity = 1 << 17) {
    FragmentCapture capture(resources(), capacity);
    std::vector<PassList> drawn = std::move(lists);
    lists.assign(1, {});
    capture.addDraws(drawn[0], run.scene.shadowWords(), lists[0]);
    renderLists(view);
    lists = std::move(drawn);
    return FragmentCapture::composite(capture.read(*run.device()), view);
  }

  TransparencyCounters counters(uint32_t nodeCount) {
    const auto words = run.read<std::byte>(run.scene.transparencyCounters());
    return readTransparencyCounters(words, nodeCount);
  }

  // The scene's own table: the test adds its capture to it.
  ResourceTable& resources() { return const_cast<ResourceTable&>(run.scene.resources()); }

  SceneRun run;
  std::vector<PassList> lists;

 private:
  HairId hair_ = HairId::kInvalid;
};

/// The strands have the same picture to the bit in either order, and in the next frame, which finds
/// buffers that were used before.
/// \param asset  makes the strands, in the reverse order if so
/// \return the picture
template <class Asset>
RenderedImage expectNoOrder(TangleRun& scene, TangleRun& other, const TangleDef& def,
                            const Asset& asset, const View& view,
                            const std::vector<TransparencySettings>& methods) {
  scene.add(def, asset(false));
  other.add(def, asset(true));
  RenderedImage image;
  for (const TransparencySettings& settings : methods) {
    image = scene.render(view, settings);
    EXPECT_TRUE(sameBits(image, other.render(view, settings)))
        << "method " << static_cast<int>(settings.method);
    EXPECT_TRUE(sameBits(image, scene.render(view, settings)))
        << "method " << static_cast<int>(settings.method);
  }
  return image;
}

/// Makes a TangleRun of the parameter's API, or skips.
class TangleTest : public testing::TestWithParam<Api> {
 protected:
  void SetUp() override {
    tangleRun_ = std::make_unique<TangleRun>(GetParam());
    if (tangleRun_->run.device() == nullptr)
      PELAGE_SKIP_WITHOUT_DEVICE() << "skipped: no " << apiName(GetParam()) << " device";
  }
  TangleRun& tangleRun() { return *tangleRun_; }
  RenderedImage expectNoOrderOfStrands(const TangleDef& def, const View& view,
                                       const std::vector<TransparencySettings>& methods) {
    TangleDef reversed = def;
    reversed.reversed = true;
    TangleRun other(GetParam());
    return expectNoOrder(
        tangleRun(), other, def, [&](bool turned) { return tangle(turned ? reversed : def); }, view,
        methods);
  }
  /// With each strand there twice.
  RenderedImage expectNoOrderOfTwins(const TangleDef& def, const View& view,
                                     const std::vector<TransparencySettings>& methods) {
    TangleRun other(GetParam());
    return expectNoOrder(
        tangleRun(), other, def, [&](bool turned) { return twins(tangle(def), turned); }, view,
        methods);
  }

 private:
  std::unique_ptr<TangleRun> tangleRun_;
};

}  // namespace pelage::test
