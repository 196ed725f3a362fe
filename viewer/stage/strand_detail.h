// What level of detail does to each strand.
#pragma once

#include <cstdint>

#include "pelage/hair_object.h"
#include "pelage/pass_list.h"
#include "stage/inspection_look.h"

namespace viewer {

/// Guides that the solver simulates, once a change of the share has taken effect: all without level
/// of detail, none of hair that is moved rigidly.
uint32_t simulatedGuides(const pelage::HairObject& hair);

/// Adds a hair object to the figures.
void addDetail(const pelage::HairObject& hair, InspectionFigures& figures);

/// Adds the passes that write values of strand_detail.hlsli behind positions.
/// \param records  of all strands of the hair, as pose_strands writes them.
pelage::Result<void> markDetail(const pelage::HairObject& hair, const pelage::ResourceTable& table,
                                pelage::BufferId records, pelage::PassList& list);

}  // namespace viewer
