#include <cmath>
#include <cstring>
#include <memory>

#include "assets/hair_cache_format.h"
#include "base/hash.h"
#include "pelage/hair_cache.h"
#include "targets.h"

namespace pelage::fuzz {
namespace {

namespace format = detail::hair_cache;
using Bytes = std::vector<std::byte>;

template <class T>
T get(const Bytes& bytes, size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

// Makes the checksums right as far as the file has what they are of.
Bytes sealedHairCache(std::span<const std::byte> in) {
  Bytes bytes(in.begin(), in.end());
  if (bytes.size() < sizeof(format::Header) + sizeof(format::Footer)) return bytes;
  const std::span<const std::byte> all(bytes);
  auto header = get<format::Header>(bytes, 0);
  const uint64_t tables = uint64_t{header.strandCount} * (header.hasIds ? 8 : 0) +
                          uint64_t{header.strandCount} * (header.verticesPerStrand ? 0 : 4) +
                          header.nameLength;
  if (tables <= bytes.size() - sizeof(format::Header))
    header.tablesChecksum = detail::hash64(all.subspan(sizeof(format::Header), tables));
  std::memcpy(bytes.data(), &header, sizeof(header));
  header.checksum = detail::hash64(all.first(offsetof(format::Header, checksum)));
  std::memcpy(bytes.data(), &header, sizeof(header));

  const size_t footerAt = bytes.size() - sizeof(format::Footer);
  auto footer = get<format::Footer>(bytes, footerAt);
  if (footer.indexOffset > footerAt) return bytes;
  for (size_t at = footer.indexOffset; at + sizeof(format::IndexEntry) <= footerAt;
       at += sizeof(format::IndexEntry)) {
    auto entry = get<format::IndexEntry>(bytes, at);
    if (entry.offset > footerAt || entry.byteCount > footerAt - entry.offset) continue;
    entry.checksum = detail::hash64(all.subspan(entry.offset, entry.byteCount));
    std::memcpy(bytes.data() + at, &entry, sizeof(entry));
  }
  footer.checksum = detail::hash64(all.subspan(
      footer.indexOffset, footerAt + offsetof(format::Footer, checksum) - footer.indexOffset));
  std::memcpy(bytes.data() + footerAt, &footer, sizeof(footer));
  return bytes;
}

Outcome checkHairCache(std::span<const std::byte> bytes) {
  auto reader = HairCacheReader::open(std::make_unique<MemorySource>(bytes), kName);
  if (!reader) return refused(reader.error());
  if (!validate(reader->def())) return broken("a def is not valid");
  if (reader->vertexCount() > (1u << 20)) return {true, {}};
  std::vector<Float3> out(reader->vertexCount());
  // The last frame first: its key frame and those between are decoded without a result.
  for (uint64_t f = reader->frameCount(); f-- > 0;) {
    if (auto r = reader->read(f, out); !r) return refused(r.error());
    for (const Float3& p : out)
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
        return broken("a position is not finite");
  }
  return {true, {}};
}

}  // namespace

Outcome haircache(std::span<const std::byte> bytes) {
  return checkAlsoSealed(bytes, checkHairCache, sealedHairCache);
}

}  // namespace pelage::fuzz
