#include "stage/strand_detail.h"

#include <algorithm>
#include <cmath>

#include "stage/inspection_passes.h"
#include "viewer_kernels/kernels.h"

namespace viewer {

using namespace viewer_kernels;
using pelage::BufferRange;
using pelage::HairObject;
using pelage::PassBuilder;
using pelage::Result;

uint32_t simulatedGuides(const HairObject& hair) {
  if (!hair.simulated) return 0;
  if (hair.buffers().lodParents == pelage::BufferId::kInvalid) return hair.guideCount();
  const double wanted =
      std::ceil(static_cast<double>(hair.simulatedShare) * static_cast<double>(hair.guideCount()));
  return static_cast<uint32_t>(std::clamp(wanted, 1.0, static_cast<double>(hair.guideCount())));
}

void addDetail(const HairObject& hair, InspectionFigures& figures) {
  const pelage::DrawnStrands drawn = drawnStrandsOf(hair);
  figures.known = true;
  figures.strands += hair.strandCount();
  figures.drawn += drawn.count;
  figures.fading += static_cast<uint64_t>(std::ceil(drawn.fading));
  figures.widening = std::max(figures.widening, drawn.widening);
  figures.guides += hair.guideCount();
  figures.simulated += simulatedGuides(hair);
}

Result<void> markDetail(const HairObject& hair, const pelage::ResourceTable& table,
                        pelage::BufferId records, pelage::PassList& list) {
  const pelage::DrawnStrands drawn = drawnStrandsOf(hair);
  const BufferRange rest = table.whole(hair.buffers().rest);
  StrandDetailConstants constants = {};
  constants.detailVertexCount = hair.verticesPerStrand();
  constants.detailVertices = hair.strandCount() * hair.verticesPerStrand();
  constants.detailShown = drawn.shown;
  constants.detailFading = drawn.fading;
  constants.detailGuideCount = hair.guideCount();
  constants.detailSimulatedCount = simulatedGuides(hair);
  StrandDetailBindings bindings = {.strandDetailConstants = constants,
                                   .detailRest = rest.isBound() ? rest : table.whole(records),
                                   .detailRecords = table.whole(records)};
  PassBuilder mark(list);
  dispatchOver(mark, markDetailVariant({}), constants.detailVertices);
  if (Result<void> done = mark.finish(bindings); !done) return done;
  // The classic solver has no order of strands, and simulates all or none.
  const bool ordered = hair.settings.solver == pelage::Solver::kExact && rest.isBound();
  if (!ordered || constants.detailSimulatedCount == hair.guideCount()) return {};
  // [guide] ExactStrand are the last elements.
  constants.detailFirstStrand = static_cast<uint32_t>(rest.size / sizeof(pelage::Float4)) -
                                strand_detail::kExactStrandElements * hair.guideCount();
  bindings.strandDetailConstants = constants;
  PassBuilder interpolated(list);
  dispatchOver(interpolated, markInterpolatedVariant({}),
               uint64_t{hair.guideCount()} * hair.verticesPerStrand());
  return interpolated.finish(bindings);
}

}  // namespace viewer
