// What drawing knows of a hair object.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "oit/transparency.h"
#include "pelage/gpu_structs.h"
#include "pelage/scene.h"
#include "scene/hair_internals.h"
#include "shadow/strand_shadow.h"

namespace pelage::detail {

/// Strands that are drawn, with HairObject::drawnShare.
struct DrawnStrands {
  uint32_t count = 0;  ///< instances of the draw
  float shown = 0;     ///< strands, as a real number
  float fading = 0;    ///< of them, the last ones, whose width falls to 0
  float widening = 1;  ///< of all, so that the sum of widths stays what it is without
};

DrawnStrands drawnStrands(const HairObject& object);
inline uint32_t drawnCount(const HairObject& object) { return drawnStrands(object).count; }

Ball ballAround(const Ball& a, const Ball& b);
/// At least as large, and the same for radii that differ little.
float steadyRadius(float radius);

ShadowedHair shadowedHairOf(const HairObject& object, const HairInternals& hair);
void setShadow(StrandViewConstants& constants, uint32_t index, const StrandShadowView& map);

/// Resources of a kind of transparency, for the draws of strands.
struct DrawOffers {
  struct Buffer {
    const char* name;
    BufferId id;
    uint64_t size;
  };
  std::vector<Buffer> buffers;
  std::string blockName;
  std::span<const std::byte> block;
};

/// Members of StrandShading.
struct ShadingParts {
  uint32_t model;
  Float4 body, primary, secondary, fiber;
};

ShadingParts shadingOf(const StrandMaterial& material);

/// Hair objects that fragments can name, as in kernels/oit/fragment_packing.hlsli.
inline constexpr size_t kMaxMaterials = 64;

/// Fills the tables of StrandShading, [object]; of its model four in one element.
void setMaterials(std::span<const HairObject* const> objects, std::span<Uint4> models,
                  std::span<Float4> bodies, std::span<Float4> primaries,
                  std::span<Float4> secondaries, std::span<Float4> fibers);

/// Of draws that blend what they have resolved over the target.
DrawState overTarget();

/// Bits of RenderConstants::strandAttributes, as in kernels/layouts/render.hlsli.
inline constexpr uint32_t kHasThickness = 1;
inline constexpr uint32_t kHasVertexColors = 2;
inline constexpr uint32_t kHasBaseTexture = 4;
uint32_t strandAttributes(const HairBuffers& buffers);

/// Strands that a kernel places beside their guides.
uint64_t placedStrands(const HairObject& object, const HairInternals& hair);

/// Makes a buffer of a scene anew where it is too small.
struct BufferNeed {
  BufferId& buffer;
  const char* name;
  uint64_t bytes;
  uint32_t stride;
  BufferUsage usage = BufferUsage::kStorage;
};

}  // namespace pelage::detail

namespace pelage {

/// A draw of a view: what was found out once.
struct Scene::DrawFrame {
  const View& view;
  std::span<const Light> lights;
  StrandViewConstants constants;
  std::vector<const HairObject*> visible;  ///< [material]
};

}  // namespace pelage
