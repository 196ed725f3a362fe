// A device with the buffers that a benchmark has on it.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "pelage/headless.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/scene.h"

namespace bench {

/// A device and the buffers on it. A device knows buffers by the ids of one table, so that all
/// solvers of a run share this one.
struct Workbench {
  pelage::HeadlessDevice& device;
  pelage::Scene scene;

  /// Adds a buffer with its contents to the table.
  template <class T>
  pelage::BufferId add(std::string name, const std::vector<T>& values,
                       pelage::BufferUsage usage = pelage::BufferUsage::kStorage |
                                                   pelage::BufferUsage::kReadback);
  /// Runs a complete list, and returns the times of its passes.
  pelage::Result<std::vector<pelage::PassTiming>> run(pelage::PassList& list);
};

template <class T>
pelage::BufferId Workbench::add(std::string name, const std::vector<T>& values,
                                pelage::BufferUsage usage) {
  pelage::BufferDesc desc;
  desc.name = std::move(name);
  desc.size = values.size() * sizeof(T);
  desc.stride = sizeof(T);
  desc.usage = usage;
  const auto bytes = std::as_bytes(std::span(values));
  desc.initial.assign(bytes.begin(), bytes.end());
  return scene.resources().add(std::move(desc));
}

}  // namespace bench
