// An engine's own executor of pelage's pass lists, on plain OpenGL.
#pragma once

#include <pelage/pass_list.h>

#include <cstdint>
#include <unordered_map>
#include <vector>

class Executor {
 public:
  void createBuffers(const pelage::ResourceTable& table);
  void run(const pelage::PassList& list);
  std::vector<float> read(pelage::BufferId buffer, size_t floats) const;

 private:
  unsigned program(const pelage::KernelVariant& variant);

  std::unordered_map<uint32_t, unsigned> buffers_;
  std::unordered_map<const pelage::KernelVariant*, unsigned> programs_;
  unsigned constants_ = 0;
};
