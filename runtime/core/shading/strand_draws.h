// Draws of strands: what a view knows of the hair in it, and what every method adds to lists.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/bounds.h"
#include "pelage/bindings.h"
#include "pelage/constants.h"
#include "pelage/engine_lights.h"
#include "pelage/gpu_structs.h"
#include "pelage/hair_buffers.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/strand_texture.h"
#include "pelage/view.h"
#include "shading/strand_motion.h"

namespace pelage::detail {

/// A hair object as draws take it.
struct DrawnHair {
  const StrandMaterial* material = nullptr;
  const HairBuffers* buffers = nullptr;
  DrawnStrands strands;
  uint32_t vertexCount = 0;  ///< a strand, >= 2
  uint32_t guideCount = 0;
  uint32_t followCount = 0;
  bool storesFollows = false;  ///< positions has the follow strands, too
  float tipSeparation = 1;
  Uint2 textureSize = {};                   ///< texels of HairDef::baseTexture
  const StrandTexture* texture = nullptr;   ///< of an engine; nullptr: none
  BufferRange colors = {};                  ///< [guide][2]: what it gives in this view
  BufferId positions = BufferId::kInvalid;  ///< of `buffers`, or between two states
  BufferId tangents = BufferId::kInvalid;   ///< likewise
  BufferRange roots;                        ///< [2][guide] RootTransform
  Ball ball;                                ///< around it
  StrandsBefore before;                     ///< for motion vectors
  uint64_t firstRecord = 0;                 ///< in DrawnView::records

  uint64_t drawnVertices() const { return uint64_t{strands.count} * vertexCount; }
  uint32_t strandCount() const { return guideCount + followCount; }
  /// Strands that a kernel places beside their guides.
  uint64_t evaluatedStrands() const {
    return storesFollows || strands.count <= guideCount ? 0 : strands.count - guideCount;
  }
};

/// A draw of a view: what was found out once.
struct DrawnView {
  const View& view;
  std::span<const Light> lights;
  StrandViewConstants constants = {};
  std::span<DrawnHair> hairs = {};
  BufferId shadowWords = BufferId::kInvalid;
  uint64_t shadowBytes = 0;
  bool transformsFirst = false;  ///< the vertex stage has no storage buffers: draws take records
  BufferRange records = {};      ///< of all hairs, where they are transformed first
  const EngineLights* engineLights = nullptr;  ///< TransparencySettings::engineLights
  bool readsUv = false;                        ///< these read the UV of roots
};

/// Bytes of a vertex that transform_strands has placed on the screen.
inline constexpr uint64_t kRecordBytes = strand_record::kRecordWords * sizeof(Uint4);
inline constexpr uint64_t kMaxRecords = uint64_t{1} << 30;  ///< of an object

/// Threads of a dispatch with one for each record.
struct RecordThreads {
  uint32_t x = 0, y = 0;
};
RecordThreads recordThreads(uint64_t records);

/// Constants of a view. Errors: worldToClip that is not finite or has no inverse, an eye that is
/// not finite, a viewport of no whole numbers, a number of samples that targets do not have; too
/// many lights, a light that is not finite, has no direction, or an unknown shadow.
Result<StrandViewConstants> viewConstants(const View& view, std::span<const Light> lights);
/// The error of a view that cannot be drawn.
Error refuseView(const std::string& what);
/// The ball is in front of all planes of the frustum, or cuts them.
bool isInFrustum(const View& view, const Ball& ball);

/// Members of StrandShading.
struct ShadingParts {
  uint32_t model;
  Float4 body, primary, secondary, fiber;
  bool operator==(const ShadingParts&) const = default;
};

ShadingParts shadingOf(const StrandMaterial& material);
/// Name of the first invalid field; empty if all are valid.
std::string faultOf(const StrandMaterial& material);

/// Fills the tables of StrandShading, [material]; of its model four in one element.
void setMaterials(std::span<const StrandMaterial* const> materials, std::span<Uint4> models,
                  std::span<Float4> bodies, std::span<Float4> primaries,
                  std::span<Float4> secondaries, std::span<Float4> fibers);

/// Bits of RenderConstants::strandAttributes: render::kHasThickness and others.
uint32_t strandAttributes(const DrawnView& view, const DrawnHair& hair);

/// The bindings of draws and dispatches over an object's strands.
struct StrandBindings {
  RenderPosTanBindings posTan;
  RenderBindings render;
  uint64_t bytes = 0;  ///< that they move
};

/// \param material index of the object's shading for lists that keep one.
StrandBindings strandBindings(const DrawnView& view, const DrawnHair& hair, size_t material);
/// Places an object's vertices on the screen. \param records where they go, \param first of them.
Result<void> addTransform(const DrawnView& view, const DrawnHair& hair, size_t material,
                          const BufferRange& records, uint64_t first, PassList& list);
/// Bytes that all hairs of a view take when they are transformed first; says where each begins.
uint64_t placeRecords(DrawnView& view);
/// Transforms all of them into view.records.
Result<void> addTransforms(const DrawnView& view, PassList& list);
/// Smooth ribbons of an object into the buffers of a method. \param method its layout's bindings.
Result<void> addStrandDraw(const DrawnView& view, const DrawnHair& hair, size_t material,
                           const KernelVariant& pixel, const LayoutBindings& method,
                           PassList& list);
/// The same of all objects. \param pixel  pelage's kernel, or the engine's with its lights.
Result<void> addStrandDraws(const DrawnView& view, const KernelVariant& pixel,
                            const LayoutBindings& method, PassList& list);
/// Opaque ribbons of all objects into the target. \param stochastic as many samples as the fiber
/// covers, or those above a threshold.
Result<void> addOpaqueDraws(const DrawnView& view, bool stochastic, PassList& list);

}  // namespace pelage::detail
