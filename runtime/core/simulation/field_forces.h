// Forces of an engine's field on the vertices of an object.
#pragma once

#include <cstdint>
#include <string>

#include "passes/room_buffers.h"
#include "pelage/force_field.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"

namespace pelage::detail {

/// The object that a field acts on, in a frame.
struct FieldHair {
  const std::string& name;
  const ForceField& field;
  uint64_t vertices;  ///< of the guides
  BufferId positions = BufferId::kInvalid;
  BufferId otherForces = BufferId::kInvalid;  ///< that the field's are added to; kInvalid: none
};

/// What is wrong with a field, or nothing.
std::string faultOf(const ForceField& field, const ResourceTable& resources);

/// The forces of one object. A copy of it is what a frame is taken back to.
class FieldForces {
 public:
  /// Makes the buffer, or removes it where there is no field.
  void prepare(const FieldHair& hair, const RoomBuffers& room);
  /// Adds the pass of a frame. \param known  there are positions of the frame before
  Result<void> record(const FieldHair& hair, bool known, const ResourceTable& resources,
                      PassList& list) const;
  void remove(const RoomBuffers& room) { room.remove(forces_); }

  /// [vertex] Float4: the sum with the other forces; kInvalid where there is no field.
  BufferId forces() const { return forces_; }

 private:
  BufferId forces_ = BufferId::kInvalid;
};

}  // namespace pelage::detail
