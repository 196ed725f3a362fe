// Playback of simulated hair from a file: a thread decodes the frames that come next, and a hair
// object shows them without simulating.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "pelage/export.h"
#include "pelage/hair_cache.h"
#include "pelage/hair_object.h"
#include "pelage/result.h"

namespace pelage {

struct CachePlayerDef {
  bool loops = false;  ///< the first frame follows the last one; otherwise that one stays
  /// Frames that are decoded ahead, 1..64. Each takes 12 bytes a vertex.
  uint32_t framesAhead = 4;
};

/// Shows the frames of a cache on a hair object of as many guides and vertices.
///
///     auto player = CachePlayer::open("shot.pelagecache");
///     ...
///     player->show(seconds * player->def().framesPerSecond, scene.hair(hair));
///     scene.simulate(dt);  // dt > 0; follow hairs, motion and drawing as usual
///
/// Bones place the roots of follow hairs, and nothing else: set those of the frame. Hair without
/// follow hairs needs none.
///
/// Threads: one at a time, which is that of the scene in show(); the player has one of its own.
class PELAGE_API CachePlayer {
 public:
  /// Errors: those of HairCacheReader::open(), a cache without frames, framesAhead out of range.
  static Result<CachePlayer> open(const std::filesystem::path& path, CachePlayerDef def = {});
  /// The same of a cache that is open.
  static Result<CachePlayer> open(HairCacheReader reader, CachePlayerDef def = {});
  CachePlayer(CachePlayer&&) noexcept;
  CachePlayer& operator=(CachePlayer&&) noexcept;
  ~CachePlayer();

  const HairCacheDef& def() const;
  uint64_t frameCount() const;

  /// Sets the positions of a frame with HairObject::setPositions(). Between two frames, vertices
  /// are on the line between their positions. It waits until the frames are decoded: not at all
  /// where frames come in order and slower than that. Where the frame is not within kMaxStep frames
  /// of the one shown before, and where playback loops, the hair is reset, so that it has no
  /// motion. \param frame from the first one, 0; beyond the last one it stays or loops. Between the
  ///   last frame and the first one of a loop, the last one stays.
  /// Errors: a frame that is not finite; a cache whose strands are not those of the object; those
  /// of HairCacheReader::read() and setPositions().
  Result<void> show(double frame, HairObject& hair);

  static constexpr double kMaxStep = 4;

 private:
  struct Impl;
  explicit CachePlayer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace pelage
