// Drawing of contact records, for debugging.
#include <cmath>
#include <string>
#include <utility>

#include "scene/scene_impl.h"

namespace pelage::detail {

Result<void> SceneImpl::drawContacts(HairId id, const View& view, const ContactLook& look,
                                     PassList& list) {
  settleFrames(false);
  const HairObject& object = hair(id);
  if (const Result<DrawnView> frame = beginDraw(view, {}, &list); !frame) return frame.error();
  for (const auto& [value, name] :
       {std::pair(look.length, "length"), std::pair(look.width, "width"),
        std::pair(look.deepestDepth, "deepestDepth")}) {
    if (!(value > 0) || !std::isfinite(value))
      return Error{ErrorCode::kInvalidArgument, "ContactLook::" + std::string(name) + " is " +
                                                    std::to_string(value) +
                                                    "; it is a finite number > 0"};
  }
  if (Result<void> moved = addPendingShifts(list); !moved) return moved;
  finishShift();
  Result<void> added =
      object.internals_->contacts.addDraw(list, object.buffers_.positions, view, look);
  setArea({&list, 1}, view);
  return added;
}

Result<float> SceneImpl::deepestContact(HairId id, std::span<const std::byte> contacts,
                                        std::span<const std::byte> contactWords,
                                        std::span<const std::byte> positions) const {
  return hair(id).internals_->contacts.deepest(contacts, contactWords, positions);
}

}  // namespace pelage::detail
