#include <fmt/format.h>

#include <optional>
#include <utility>

#include "assets/hair_cache_file.h"
#include "assets/hair_cache_parts.h"
#include "base/guard.h"
#include "pelage/hair_cache.h"

namespace pelage {
namespace detail::hair_cache {
namespace {

class Joiner {
 public:
  Result<void> create(const std::filesystem::path& path, const HairCacheDef& def) {
    def_ = def;
    nextFrame_ = def.firstFrame;
    auto file = OutputFile::create(path);
    if (!file) return file.error();
    file_.emplace(std::move(*file));
    return file_->write(packHeader(def));
  }

  Result<void> add(const std::filesystem::path& path, StreamReader& stream, const Contents& part) {
    const auto refuse = [&](std::string_view what) {
      return Error{ErrorCode::kInvalidArgument, fmt::format("{}: {}", path.string(), what)};
    };
    HairCacheDef sameFrame = part.def;
    sameFrame.firstFrame = def_.firstFrame;
    if (sameFrame != def_) return refuse("it is not a part of the same cache as the first one");
    if (part.def.firstFrame != nextFrame_)
      return refuse(fmt::format("it begins with frame {}; frame {} is next", part.def.firstFrame,
                                nextFrame_));
    for (IndexEntry entry : part.index) {
      if (auto r = readRecord(stream, entry, record_); !r) return r;
      entry.offset = file_->size();
      if (auto r = file_->write(record_); !r) return r;
      index_.push_back(entry);
    }
    nextFrame_ += static_cast<int64_t>(part.index.size());
    return {};
  }

  Result<void> close() {
    if (auto r = file_->write(packIndex(index_, file_->size())); !r) return r;
    return file_->close();
  }

 private:
  HairCacheDef def_;
  int64_t nextFrame_ = 0;
  std::optional<OutputFile> file_;
  std::vector<IndexEntry> index_;
  std::vector<std::byte> record_;
};

Result<void> join(std::span<const std::filesystem::path> parts, const std::filesystem::path& path) {
  if (parts.empty())
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("{}: there are no parts to join", path.string())};
  Joiner joiner;
  for (size_t i = 0; i < parts.size(); ++i) {
    auto source = FileSource::open(parts[i]);
    if (!source) return source.error();
    const std::string name = parts[i].string();
    StreamReader stream(*source, name);
    auto contents = readContents(stream);
    if (!contents) return contents.error();
    if (i == 0)
      if (auto r = joiner.create(path, contents->def); !r) return r;
    if (auto r = joiner.add(parts[i], stream, *contents); !r) return r;
  }
  return joiner.close();
}

}  // namespace
}  // namespace detail::hair_cache

Result<void> joinHairCaches(std::span<const std::filesystem::path> parts,
                            const std::filesystem::path& path) {
  return detail::guarded([&] { return detail::hair_cache::join(parts, path); });
}

}  // namespace pelage
