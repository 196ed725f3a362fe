// Hair of a demo from caches: what it simulated is recorded, then played.
#pragma once

#include <filesystem>
#include <vector>

#include "demo_scene.h"
#include "pelage/cache_player.h"
#include "pelage/hair_cache.h"
#include "simulation/workbench.h"

namespace bench {

/// The caches of the hair of a demo, in a folder that is removed with it.
class Playback {
 public:
  Playback() = default;
  ~Playback();
  Playback(const Playback&) = delete;
  Playback& operator=(const Playback&) = delete;

  /// Adds the positions of the guides, as the device has them. Errors: those of the cache.
  pelage::Result<void> record(Workbench& workbench, const sample::DemoScene& demo);
  /// Completes the caches and opens them. Errors: those of the cache.
  pelage::Result<void> begin();
  bool plays() const { return !players_.empty(); }
  /// Sets the next frame of each cache, one of 1/60 s after the other, from the first one again at
  /// the end. Returns how long that took, waits for the decoder included [us].
  pelage::Result<double> show(pelage::Scene& scene, const sample::DemoScene& demo);

 private:
  pelage::Result<void> create(const sample::DemoScene& demo, pelage::Scene& scene);

  std::filesystem::path folder_;
  std::vector<pelage::HairCacheWriter> writers_;
  std::vector<pelage::CachePlayer> players_;
  uint64_t shown_ = 0;
};

}  // namespace bench
