// Forces of an engine's field on the vertices of an object.
#pragma once

#include <string>

#include "passes/buffer_factory.h"
#include "pelage/force_field.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "skinning/hair_frame.h"

namespace pelage::detail {

/// Returns what is wrong with a field, or nothing.
std::string faultOf(const ForceField& field, const ResourceTable& resources);

/// The forces of one object. A copy of it is what a frame is taken back to.
class FieldForces {
 public:
  /// Makes the buffer, or removes it where there is no field.
  void prepare(HairFrame& frame);
  Result<void> record(const HairFrame& frame) const;
  void remove(const BufferFactory& factory) { factory.remove(forces_); }

 private:
  /// [vertex] Float4: the sum with the engine's forces; kInvalid where there is no field.
  BufferId forces_ = BufferId::kInvalid;
};

}  // namespace pelage::detail
