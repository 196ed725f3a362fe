// Kernels that are compiled again while the program runs.
#include <fmt/format.h>

#include <utility>

#include "viewer.h"

namespace viewer {

using pelage::Error;
using pelage::ErrorCode;
using pelage::Result;

// Those of a folder that the user names are compiled before the first frame. Else those of the
// build are watched, where a person can edit them meanwhile.
Result<void> Viewer::openReload() {
  KernelSource source = builtKernels();
  if (source.manifest.empty() && !options_.kernels.empty())
    return Error{ErrorCode::kUnsupported,
                 "--kernels needs the build folder of this program, which is not there any more"};
  if (source.manifest.empty() || (player_ && options_.kernels.empty())) return {};
  if (!options_.kernels.empty()) source.manifest = options_.kernels / "manifest.json";
  reload_ = std::make_unique<KernelReload>(std::move(source));
  return options_.kernels.empty() ? Result<void>() : takeKernels(reload_->build());
}

Result<void> Viewer::reloadKernels() {
  const std::optional<KernelBuild> built = reload_ ? reload_->take() : std::nullopt;
  return built ? takeKernels(*built) : Result<void>();
}

Result<void> Viewer::takeKernels(const KernelBuild& build) {
  if (!build.tables) {
    interface_->say("The old kernels stay", build.error);
    return {};
  }
  // The source that the program was built of has no tables.
  const bool isOwn = build.tables->kernels().empty();
  if (isOwn && !code_) return {};
  std::string names;
  for (const std::string& name : build.tables->kernels())
    names += (names.empty() ? "" : ", ") + name;
  fmt::print("kernels: {}\n", isOwn ? "those of the program" : names);
  return useCode(isOwn ? nullptr : build.tables);
}

// The hair goes on from where it is.
Result<void> Viewer::useCode(std::shared_ptr<const KernelTables> code) {
  const bool hasFrames = firstPicture_ > 0;
  if (hasFrames) {
    Result<void> taken =
        stage_.takeSnapshot([&](pelage::BufferId buffer) { return canvas_->read(buffer); });
    if (!taken) return taken;
  }
  const auto old = std::exchange(code_, std::move(code));
  if (Result<void> set = canvas_->setCode(code_ ? code_->list() : pelage::KernelCodeList()); !set)
    return set;
  if (hasFrames)
    if (const auto kept = stage_.recover(); !kept) return kept.error();
  history_.clear();
  adopt();
  return {};
}

// A driver may refuse what codegen takes. \return whether that was so, and the last frame's are
// back.
bool Viewer::keepsOldKernels(const Error& refused) {
  if (refused.code == ErrorCode::kDeviceLost || code_ == provenCode_) return false;
  if (!useCode(provenCode_)) return false;
  interface_->say("The old kernels stay", refused.message);
  return true;
}

}  // namespace viewer
