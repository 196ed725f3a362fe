// Work on the items of a list by several threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace pelage::codegen {

/// Calls `work(item, thread)` once for each item; `thread` is below `threads`.
template <class Item, class Work>
void inParallel(std::vector<Item>& items, size_t threads, const Work& work) {
  std::atomic<size_t> next{0};
  std::vector<std::jthread> running;
  for (size_t thread = 0; thread < std::min(threads, items.size()); ++thread) {
    running.emplace_back([&, thread] {
      for (size_t i = next++; i < items.size(); i = next++) work(items[i], thread);
    });
  }
}

}  // namespace pelage::codegen
