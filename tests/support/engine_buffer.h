// A buffer that stands for one of an engine, beside a scene's.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "support/lists.h"
#include "support/scene_run.h"

namespace pelage::test {

class EngineBuffer {
 public:
  EngineBuffer(SceneRun& run, std::string name, uint64_t floats) : run_(run), floats_(floats) {
    id_ = run.scene.resources().add({.name = std::move(name),
                                     .size = floats * sizeof(float),
                                     .stride = sizeof(float),
                                     .usage = BufferUsage::kStorage | BufferUsage::kUpload});
  }
  ~EngineBuffer() { run_.scene.resources().remove(id_); }
  EngineBuffer(const EngineBuffer&) = delete;
  EngineBuffer& operator=(const EngineBuffer&) = delete;

  BufferId id() const { return id_; }
  /// As a pass of the engine would, before the next simulation.
  void write(const std::vector<float>& values) {
    ASSERT_EQ(values.size(), floats_);
    PassList list;
    addUpload(list, id_, std::as_bytes(std::span(values)));
    run_.execute(list);
  }

 private:
  SceneRun& run_;
  uint64_t floats_;
  BufferId id_;
};

}  // namespace pelage::test
