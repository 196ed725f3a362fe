#include "pelage/cache_player.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "base/guard.h"

namespace pelage {

namespace {

constexpr uint32_t kMaxFramesAhead = 64;

Float3 between(const Float3& a, const Float3& b, float share) {
  return {a.x + (b.x - a.x) * share, a.y + (b.y - a.y) * share, a.z + (b.z - a.z) * share};
}

}  // namespace

struct CachePlayer::Impl {
  // Where a moment is in the file.
  struct Place {
    double frame = 0;  ///< 0..frameCount - 1
    double round = 0;  ///< of a loop
  };
  struct DecodedFrame {
    std::optional<uint64_t> frame;  ///< nothing: free, or being decoded
    std::vector<Float3> positions;
  };

  Impl(HairCacheReader r, CachePlayerDef d)
      : reader(std::move(r)),
        def(d),
        frameCount(reader.frameCount()),
        frames(def.framesAhead + 1),
        decoder([this] { decode(); }) {}
  ~Impl() {
    {
      const std::lock_guard lock(mutex);
      stops = true;
    }
    changed.notify_all();
    decoder.join();
  }

  HairCacheReader reader;  ///< of the thread, but for what does not change
  CachePlayerDef def;
  uint64_t frameCount;
  // The scene's thread alone uses these:
  std::vector<Float3> blended;
  std::optional<Place> shown;

  // Both threads use these:
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<DecodedFrame> frames;
  uint64_t first = 0;  ///< frame that is wanted, with those behind it
  std::optional<Error> error;
  uint64_t errorFrame = 0;  ///< that could not be decoded
  bool stops = false;
  std::thread decoder;  ///< last: it begins with all of the above

  bool isWanted(uint64_t frame) const;
  std::optional<uint64_t> nextToDecode() const;
  DecodedFrame* find(uint64_t frame);
  void decode();
  Result<Place> placeOf(double frame) const;
  Result<void> check(const HairObject& hair) const;
  Result<const std::vector<Float3>*> fetch(uint64_t frame, std::unique_lock<std::mutex>& lock);
  Result<void> show(double frame, HairObject& hair);
};

bool CachePlayer::Impl::isWanted(uint64_t frame) const {
  const uint64_t ahead = frame >= first ? frame - first : frame + frameCount - first;
  return ahead < frames.size() && (def.loops || frame >= first);
}

// The first frame that is wanted and not there.
std::optional<uint64_t> CachePlayer::Impl::nextToDecode() const {
  for (uint64_t i = 0; i < std::min<uint64_t>(frames.size(), frameCount); ++i) {
    uint64_t wanted = first + i;
    if (wanted >= frameCount) {
      if (!def.loops) return std::nullopt;
      wanted -= frameCount;
    }
    if (std::none_of(frames.begin(), frames.end(),
                     [&](const auto& f) { return f.frame == wanted; }))
      return wanted;
  }
  return std::nullopt;
}

auto CachePlayer::Impl::find(uint64_t frame) -> DecodedFrame* {
  const auto found =
      std::find_if(frames.begin(), frames.end(), [&](const auto& f) { return f.frame == frame; });
  return found != frames.end() ? &*found : nullptr;
}

// The thread.
void CachePlayer::Impl::decode() {
  std::unique_lock lock(mutex);
  while (!stops) {
    const auto wanted = error ? std::nullopt : nextToDecode();
    if (!wanted) {
      changed.wait(lock);
      continue;
    }
    // There are as many as are wanted at a time: one is free.
    const auto room = std::find_if(frames.begin(), frames.end(),
                                   [&](const auto& f) { return !f.frame || !isWanted(*f.frame); });
    room->frame.reset();
    lock.unlock();
    const auto done = detail::guarded([&]() -> Result<void> {
      room->positions.resize(reader.vertexCount());
      return reader.read(*wanted, room->positions);
    });
    lock.lock();
    if (done)
      room->frame = *wanted;
    else
      error = done.error(), errorFrame = *wanted;
    changed.notify_all();
  }
}

auto CachePlayer::Impl::placeOf(double frame) const -> Result<Place> {
  if (!std::isfinite(frame))
    return Error{ErrorCode::kInvalidArgument, "CachePlayer::show(): the frame is not finite"};
  const auto count = static_cast<double>(frameCount);
  const double round = def.loops ? std::floor(frame / count) : 0;
  return Place{std::clamp(frame - count * round, 0.0, count - 1), round};
}

Result<void> CachePlayer::Impl::check(const HairObject& hair) const {
  const HairCacheDef& cache = reader.def();
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("hair '{}': the cache '{}' has {}", hair.name(), cache.name, what)};
  };
  if (cache.strandCount != hair.guideCount())
    return refuse(
        fmt::format("{} strands, and the object {} guides", cache.strandCount, hair.guideCount()));
  const auto isOther = [&](uint32_t n) { return n != hair.verticesPerStrand(); };
  if (cache.vertexCounts.empty()
          ? isOther(cache.verticesPerStrand)
          : std::any_of(cache.vertexCounts.begin(), cache.vertexCounts.end(), isOther))
    return refuse(fmt::format("strands of other than {} vertices", hair.verticesPerStrand()));
  return {};
}

// The positions stay until the lock is given back.
Result<const std::vector<Float3>*> CachePlayer::Impl::fetch(uint64_t frame,
                                                            std::unique_lock<std::mutex>& lock) {
  const DecodedFrame* found = find(frame);
  while (found == nullptr) {
    if (error) {
      const Error failed = *std::exchange(error, std::nullopt);
      if (errorFrame == frame) return failed;
    }
    changed.notify_all();
    changed.wait(lock);
    found = find(frame);
  }
  return &found->positions;
}

Result<void> CachePlayer::Impl::show(double frame, HairObject& hair) {
  if (auto r = check(hair); !r) return r;
  const auto place = placeOf(frame);
  if (!place) return place.error();
  const double whole = std::floor(place->frame);
  const auto share = static_cast<float>(place->frame - whole);
  const auto now = static_cast<uint64_t>(whole);
  std::unique_lock lock(mutex);
  first = now;
  changed.notify_all();
  const auto from = fetch(now, lock);
  if (!from) return from.error();
  std::span<const Float3> positions = **from;
  if (share > 0) {
    const auto to = fetch(now + 1, lock);
    if (!to) return to.error();
    blended.resize(positions.size());
    std::transform(positions.begin(), positions.end(), (*to)->begin(), blended.begin(),
                   [&](const Float3& a, const Float3& b) { return between(a, b, share); });
    positions = blended;
  }
  if (auto r = hair.setPositions(positions); !r) return r;
  if (!shown || shown->round != place->round || std::abs(place->frame - shown->frame) > kMaxStep)
    hair.reset();
  shown = *place;
  return {};
}

CachePlayer::CachePlayer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
CachePlayer::CachePlayer(CachePlayer&&) noexcept = default;
CachePlayer& CachePlayer::operator=(CachePlayer&&) noexcept = default;
CachePlayer::~CachePlayer() = default;

Result<CachePlayer> CachePlayer::open(HairCacheReader reader, CachePlayerDef def) {
  return detail::guarded([&]() -> Result<CachePlayer> {
    const auto refuse = [&](std::string_view what) {
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("cache '{}': {}", reader.def().name, what)};
    };
    if (reader.frameCount() == 0) return refuse("it has no frames to play");
    if (def.framesAhead < 1 || def.framesAhead > kMaxFramesAhead)
      return refuse(
          fmt::format("framesAhead is {}, but must be in 1..{}", def.framesAhead, kMaxFramesAhead));
    return CachePlayer(std::make_unique<Impl>(std::move(reader), def));
  });
}

Result<CachePlayer> CachePlayer::open(const std::filesystem::path& path, CachePlayerDef def) {
  auto reader = HairCacheReader::open(path);
  if (!reader) return reader.error();
  return open(std::move(*reader), def);
}

const HairCacheDef& CachePlayer::def() const { return impl_->reader.def(); }
uint64_t CachePlayer::frameCount() const { return impl_->frameCount; }
Result<void> CachePlayer::show(double frame, HairObject& hair) {
  return detail::guarded([&] { return impl_->show(frame, hair); });
}

}  // namespace pelage
