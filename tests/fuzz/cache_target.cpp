#include <algorithm>
#include <cstring>

#include "assets/asset_cache_format.h"
#include "assets/prepared_collider.h"
#include "base/hash.h"
#include "pelage/asset_cache.h"
#include "targets.h"

namespace pelage::fuzz {
namespace {

using detail::cache::Header;
using detail::cache::Section;
using Bytes = std::vector<std::byte>;

// Makes the checksums right as far as the file has what they are of.
Bytes sealedCache(std::span<const std::byte> bytes) {
  Bytes out(bytes.begin(), bytes.end());
  if (out.size() < sizeof(Header)) return out;
  Header header;
  std::memcpy(&header, out.data(), sizeof(header));
  header.fileSize = out.size();
  const size_t count =
      std::min<size_t>(header.sectionCount, (out.size() - sizeof(Header)) / sizeof(Section));
  for (size_t i = 0; i < count; ++i) {
    std::byte* entry = out.data() + sizeof(Header) + i * sizeof(Section);
    Section section;
    std::memcpy(&section, entry, sizeof(section));
    if (section.offset > out.size() || section.size > out.size() - section.offset) continue;
    section.checksum =
        detail::hash64(std::span<const std::byte>(out).subspan(section.offset, section.size));
    std::memcpy(entry, &section, sizeof(section));
  }
  std::memcpy(out.data(), &header, sizeof(header));
  header.checksum = detail::cache::headerChecksum(
      std::span<const std::byte>(out).first(sizeof(Header) + count * sizeof(Section)));
  std::memcpy(out.data(), &header, sizeof(header));
  return out;
}

Outcome checkCache(std::span<const std::byte> bytes) {
  const auto cache = loadAssetCache(bytes, kName);
  if (!cache) return refused(cache.error());
  for (const CachedHair& hair : cache->hairs) {
    if (!validate(hair.asset)) return broken("an asset is not valid");
    if (!packRest(hair.asset)) return broken("an asset is not processed");
    if (!saveTfx(hair.asset)) return broken("an asset cannot be saved");
    if (hair.bones && !saveTfxBone(*hair.bones)) return broken("bones cannot be saved");
  }
  for (const CachedMesh& cached : cache->meshes)
    if (!inspectMesh(cached.mesh)) return broken("an index is out of range");
  const auto saved = saveAssetCache(*cache);
  if (!saved) return broken("cannot be saved: " + saved.error().message);
  const auto again = loadAssetCache(*saved, kName);
  if (!again) return broken("cannot be loaded again: " + again.error().message);
  const auto twice = saveAssetCache(*again);
  if (!twice || *twice != *saved) return broken("saving and loading gives something else");
  return {true, {}};
}

}  // namespace

Outcome cache(std::span<const std::byte> bytes) {
  return checkAlsoSealed(bytes, checkCache, sealedCache);
}

}  // namespace pelage::fuzz
