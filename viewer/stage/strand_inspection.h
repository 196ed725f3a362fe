// Views of errors that give each vertex of a strand a value: stretch, penetration, kind of strand,
// level of detail.
#pragma once

#include <cstdint>
#include <map>
#include <span>

#include "demo_scene.h"
#include "pelage/hair_object.h"
#include "pelage/pass_list.h"
#include "pelage/scene.h"
#include "stage/inspection_look.h"

namespace viewer_kernels {
struct OverdrawBindings;
}

namespace viewer {

/// The side of a stage that is inspected.
struct Inspected {
  pelage::Scene* scene = nullptr;
  const sample::DemoScene* demo = nullptr;  ///< in the scene
  double seconds = 0;                       ///< of DemoScene::pose()
  /// Colliders of all hair, in addition to its own.
  std::span<const pelage::CapsuleCollider> others = {};
};

/// Buffers of a hair object that is inspected.
struct StrandValues {
  pelage::BufferId records = pelage::BufferId::kInvalid;
  pelage::BufferId summary = pelage::BufferId::kInvalid;
  pelage::BufferId restLengths = pelage::BufferId::kInvalid;
  pelage::BufferId colliders = pelage::BufferId::kInvalid;
  uint32_t posed = 0;  ///< number of strands in the last frame
};

class StrandInspection {
 public:
  /// Adds passes that draw all strands in the colors of their values. \param counters count
  /// fragments of strands as wide as the transparency methods draw them instead; nullptr: none.
  pelage::Result<void> draw(const InspectionLook& look, const Inspected& what,
                            const pelage::View& view,
                            const viewer_kernels::OverdrawBindings* counters,
                            pelage::PassList& list);
  /// Reads the figures of stretch or penetration. Errors: those of `read`.
  pelage::Result<InspectionFigures> measure(const pelage::BufferReader& read) const;
  /// Removes the buffers.
  void clear(pelage::Scene& scene);

 private:
  StrandValues& valuesOf(const Inspected& what, size_t index);
  pelage::Result<void> evaluate(const InspectionLook& look, const Inspected& what,
                                pelage::PassList& list);
  std::map<pelage::HairId, StrandValues> hairs_;
};

/// Number of guides that the solver simulates, once a change of the share has taken effect: all
/// without level of detail, none of hair that is moved rigidly.
uint32_t simulatedGuides(const pelage::HairObject& hair);

/// Adds the level of detail of a hair object to the figures.
void addDetail(const pelage::HairObject& hair, InspectionFigures& figures);

}  // namespace viewer
