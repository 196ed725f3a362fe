// An engine's own executor of pelage's pass lists, on plain OpenGL.
#pragma once

#include <pelage/kernel_code.h>
#include <pelage/pass_list.h>

#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

class Executor {
 public:
  /// \param code  the GLSL of all kernels of the lists to come
  explicit Executor(pelage::KernelCodes code) : code_(std::move(code)) {}
  void createBuffers(const pelage::ResourceTable& table);
  /// \param table  that of the list, of which createBuffers() has seen all
  void run(const pelage::PassList& list, const pelage::ResourceTable& table);
  std::vector<float> read(pelage::BufferId buffer, size_t floats) const;

 private:
  unsigned program(const pelage::KernelVariant& variant);

  pelage::KernelCodes code_;
  std::unordered_map<uint32_t, unsigned> buffers_;
  std::unordered_map<const pelage::KernelVariant*, unsigned> programs_;
  unsigned constants_ = 0;
};
