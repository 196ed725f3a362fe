// The lists of a frame, in the memory of an earlier frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "pelage/frame.h"
#include "pelage/pass_list.h"

namespace pelage::detail {

struct FrameState {
  struct Item {
    std::unique_ptr<PassList> list;
    uint32_t view = FrameStep::kNoView;
    uint32_t listOfView = 0;
  };
  std::weak_ptr<SceneParts> scene;
  uint64_t frame = 0;       ///< HairStore::frame
  std::vector<Item> items;  ///< those from `used` on are an earlier frame's, without contents
  size_t used = 0;
  std::vector<FrameStep> steps;
  std::vector<PassList> drawn;  ///< of the view at hand
  size_t simulation = 0;        ///< index of its list
  uint32_t views = 0;
  bool drawsStrands = false;  ///< something reads where strands are drawn
  bool interpolated = false;
  bool finished = false;

  /// The next list of the frame.
  PassList& add(uint32_t view = FrameStep::kNoView, uint32_t listOfView = 0) {
    if (used == items.size()) items.push_back({.list = std::make_unique<PassList>()});
    Item& item = items[used++];
    item.view = view;
    item.listOfView = listOfView;
    return *item.list;
  }
  /// Leaves nothing but memory. Lists that have not run are abandoned.
  void clear() {
    for (Item& item : items) item.list->clear();
    scene.reset();
    used = simulation = views = 0;
    steps.clear();
    drawsStrands = interpolated = finished = false;
  }
};

}  // namespace pelage::detail
