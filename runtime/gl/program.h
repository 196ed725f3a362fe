// Programs of kernel variants: source with specialization constants, compiling, linking, and the
// binaries that are kept between runs.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "context.h"

namespace pelage::gl {

/// The source of a variant for a profile, with a define for each value that it has a constant for.
Result<std::string> assembleSource(const KernelVariant& variant, Profile profile,
                                   std::span<const SpecValue> values);

class ProgramStore {
 public:
  ProgramStore(std::shared_ptr<const Context> context, ProgramCache cache, Statistics& statistics);
  ~ProgramStore();
  ProgramStore(const ProgramStore&) = delete;
  ProgramStore& operator=(const ProgramStore&) = delete;

  /// The program of a compute kernel (pixel == nullptr) or of a draw; made when it is new.
  Result<GLuint> find(const KernelVariant& kernel, const KernelVariant* pixel,
                      std::span<const SpecValue> values);

  /// A program of one stage alone, for reflection. The caller deletes it.
  Result<GLuint> makeStage(const KernelVariant& variant);

 private:
  struct Entry {
    const KernelVariant* kernel;
    const KernelVariant* pixel;
    std::vector<SpecValue> values;
    GLuint program;
  };
  struct StageSource {
    const KernelVariant* variant;
    std::string text;
  };

  Result<void> checkLimits(const KernelVariant& variant) const;
  Result<GLuint> make(const KernelVariant& kernel, const KernelVariant* pixel,
                      std::span<const SpecValue> values);
  Result<GLuint> compileAndLink(std::span<const StageSource> stages, bool separable);
  /// 0 when there is no usable binary.
  GLuint load(uint64_t key, uint64_t check);
  void store(GLuint program, uint64_t key, uint64_t check);

  std::shared_ptr<const Context> context_;
  ProgramCache cache_;
  Statistics& statistics_;
  std::unordered_map<uint64_t, std::vector<Entry>> programs_;
  std::vector<SpecValue> wanted_;  // scratch of find()
};

}  // namespace pelage::gl
