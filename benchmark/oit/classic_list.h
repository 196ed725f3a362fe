// The classic baseline of transparency; see baselines/classic_list_layout.hlsli.
#pragma once

#include <vector>

#include "oit/hair_scene.h"

namespace bench {

class ClassicList {
 public:
  explicit ClassicList(HairScene& scene) : scene_(scene) {}
  ~ClassicList() { free(); }
  ClassicList(const ClassicList&) = delete;
  ClassicList& operator=(const ClassicList&) = delete;

  /// Writes the lists that draw mesh and hair, as HairScene::draw() does.
  /// \param nodes that there is room for.
  pelage::Result<void> draw(const pelage::View& view, uint32_t nodes,
                            std::vector<pelage::PassList>& lists);

 private:
  void makeRoom(pelage::BufferId& buffer, const char* name, uint64_t bytes, uint32_t stride);
  void free();

  HairScene& scene_;
  pelage::BufferId heads_ = pelage::BufferId::kInvalid, nodes_ = pelage::BufferId::kInvalid,
                   counter_ = pelage::BufferId::kInvalid;
};

}  // namespace bench
