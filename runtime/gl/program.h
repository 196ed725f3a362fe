// Programs of kernel variants: source with specialization constants, compiling, linking, and the
// binaries that are kept between runs.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "context.h"
#include "pelage/kernel_code.h"

namespace pelage::gl {

/// The source of a variant with a define for each value that it has a constant for.
Result<std::string> assembleSource(const KernelVariant& variant, std::string_view text,
                                   std::span<const SpecValue> values);

/// A program that the driver is at.
struct ProgramBuild {
  std::string names;
  GLuint program = 0;
  std::vector<std::pair<const KernelVariant*, GLuint>> shaders;
  std::chrono::steady_clock::time_point start;
  uint64_t key = 0, check = 0;
};

class ProgramStore {
 public:
  ProgramStore(std::shared_ptr<const Context> context, ProgramCache cache, Statistics& statistics);
  ~ProgramStore();
  void addCode(KernelCodeList code) { codes_.add(code); }
  const std::vector<PipelineTime>& times() const { return times_; }
  ProgramStore(const ProgramStore&) = delete;
  ProgramStore& operator=(const ProgramStore&) = delete;

  /// Whether the context has what a program of these kernels needs, without making it.
  Result<void> checkSupport(const KernelVariant& kernel, const KernelVariant* pixel) const;

  /// The program when it is done, else 0.
  GLuint ready(const KernelVariant& kernel, const KernelVariant* pixel,
               std::span<const SpecValue> values);

  /// Has the driver begin with the program that find() will be asked for. Drivers make several at a
  /// time when all are begun before the first is asked for.
  void begin(const KernelVariant& kernel, const KernelVariant* pixel,
             std::span<const SpecValue> values);

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
    GLuint program;                       ///< 0 while it is being built
    std::unique_ptr<ProgramBuild> build;  ///< nullptr when it is done
  };

  Result<std::string> sourceOf(const KernelVariant& variant,
                               std::span<const SpecValue> values) const;
  /// Fills wanted_.
  std::vector<Entry>& entriesOf(const KernelVariant& kernel, const KernelVariant* pixel,
                                std::span<const SpecValue> values);
  Entry* known(std::vector<Entry>& entries, const KernelVariant& kernel,
               const KernelVariant* pixel) const;
  Result<Entry> start(const KernelVariant& kernel, const KernelVariant* pixel,
                      std::span<const SpecValue> values);

  std::shared_ptr<const Context> context_;
  ProgramCache cache_;
  KernelCodes codes_;
  Statistics& statistics_;
  std::unordered_map<uint64_t, std::vector<Entry>> programs_;
  std::vector<PipelineTime> times_;
  std::vector<SpecValue> wanted_;  // scratch of find()
};

}  // namespace pelage::gl
