#include "reload/kernel_reload.h"

#include <chrono>
#include <functional>
#include <string>
#include <system_error>
#include <utility>

namespace viewer {

namespace fs = std::filesystem;

namespace {

constexpr std::chrono::milliseconds kInterval{300};

}  // namespace

uint64_t stateOfFolder(const fs::path& folder) {
  uint64_t state = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    std::error_code gone;
    if (!it->is_regular_file(gone)) continue;
    const auto time = it->last_write_time(gone).time_since_epoch().count();
    const uint64_t size = it->file_size(gone);
    // A sum, because folders have no order.
    state += std::hash<std::string>()(it->path().string() + ' ' + std::to_string(time) + ' ' +
                                      std::to_string(size));
  }
  return state;
}

KernelReload::KernelReload(KernelSource source)
    : source_(std::move(source)), thread_([this] { watch(); }) {}

KernelReload::~KernelReload() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

std::optional<KernelBuild> KernelReload::take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(built_, std::nullopt);
}

void KernelReload::watch() {
  const fs::path folder = source_.manifest.parent_path();
  uint64_t known = stateOfFolder(folder), last = known;
  std::unique_lock lock(mutex_);
  while (!wake_.wait_for(lock, kInterval, [this] { return ends_; })) {
    lock.unlock();
    const uint64_t now = stateOfFolder(folder);
    // An editor may still be writing: what was the same twice is complete.
    std::optional<KernelBuild> built;
    if (now != known && now == last) {
      known = now;
      built = buildKernels(source_);
    }
    last = now;
    lock.lock();
    if (built) built_ = std::move(built);
  }
}

}  // namespace viewer
