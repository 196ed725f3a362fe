#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <memory>
#include <utility>

#include "assets/asset_cache_format.h"
#include "assets/prepared_collider.h"
#include "assets/tfx_layout.h"
#include "base/file_io.h"
#include "base/guard.h"
#include "base/hash.h"
#include "base/stream_reader.h"

namespace pelage {
namespace detail::cache {
namespace {

using Bytes = std::vector<std::byte>;

// Header and table, checked against each other and the size of the file.
class TableReader {
 public:
  explicit TableReader(StreamReader& stream) : stream_(stream) {}

  Result<std::vector<Section>> read(Header& header) {
    if (stream_.size() < sizeof(Header))
      return fault(stream_.size(), "the file ends inside the 48-byte header");
    Bytes bytes(sizeof(Header));
    if (auto r = stream_.read(0, bytes); !r) return r.error();
    header = readAt<Header>(bytes, 0);
    if (auto r = checkHeader(header); !r) return r.error();
    bytes.resize(sizeof(Header) + header.sectionCount * sizeof(Section));
    if (auto r = stream_.read(sizeof(Header), std::span(bytes).subspan(sizeof(Header))); !r)
      return r.error();
    if (headerChecksum(bytes) != header.checksum)
      return fault(offsetof(Header, checksum),
                   "the checksum of the header and the table does not match; the file is damaged");
    std::vector<Section> sections(header.sectionCount);
    if (!sections.empty())
      std::memcpy(sections.data(), bytes.data() + sizeof(Header),
                  sections.size() * sizeof(Section));
    uint64_t end = bytes.size();
    for (size_t i = 0; i < sections.size(); ++i) {
      const uint64_t at = sizeof(Header) + i * sizeof(Section);
      if (auto r = checkSection(sections[i], end, at); !r) return r.error();
      if (i > 0 && !comesBefore(sections[i - 1], sections[i]))
        return fault(at, fmt::format("entry {} of the table is there twice, or out of order", i));
      end += sections[i].size;
    }
    if (end != stream_.size())
      return fault(end,
                   fmt::format("the sections end here, but the file at byte {}", stream_.size()));
    return sections;
  }

 private:
  Error fault(uint64_t offset, std::string_view what) const {
    return fileError(stream_.name(), offset, what);
  }

  Result<void> checkHeader(const Header& header) const {
    if (header.magic != kMagic) return fault(0, "this is no .pelage file");
    if (header.byteOrder != kByteOrder)
      return fault(offsetof(Header, byteOrder),
                   "the byte order is not little endian; make the cache again");
    if (header.version != kAssetCacheVersion)
      return fault(offsetof(Header, version),
                   fmt::format("the cache has version {}, but this library reads {}; make it again "
                               "from its sources",
                               header.version, kAssetCacheVersion));
    if (header.fileSize != stream_.size())
      return fault(std::min(header.fileSize, stream_.size()),
                   fmt::format("the file has {} bytes, but its header says {}", stream_.size(),
                               header.fileSize));
    if (header.hairCount > kMaxItems || header.meshCount > kMaxItems || header.reserved != 0)
      return fault(offsetof(Header, hairCount), "the counts are out of range");
    // This is also the maximum, because a stream may have fewer bytes than it states.
    if (header.sectionCount > kMaxSections ||
        header.sectionCount > (stream_.size() - sizeof(Header)) / sizeof(Section))
      return fault(offsetof(Header, sectionCount),
                   fmt::format("{} sections do not fit the file", header.sectionCount));
    return {};
  }

  Result<void> checkSection(const Section& section, uint64_t expected, uint64_t at) const {
    const auto kind = static_cast<Kind>(section.kind);
    if (nameOf(kind) == nullptr || section.reserved != 0 || section.reserved2 != 0 ||
        section.alignment != alignmentOf(kind))
      return fault(at, "this entry of the table has an unknown kind or alignment");
    if (section.offset != expected || section.size > stream_.size() - expected)
      return fault(at + offsetof(Section, offset),
                   "this entry of the table leaves the file, a gap or overlaps the one before");
    if (section.size == 0 || section.size % section.alignment != 0)
      return fault(at + offsetof(Section, size),
                   "the size of this section is 0 or no multiple of its alignment");
    return {};
  }

  StreamReader& stream_;
};

const Section& sectionOf(Kind kind, size_t item, const std::vector<Section>& sections) {
  Section wanted;
  wanted.kind = static_cast<uint32_t>(kind);
  wanted.item = static_cast<uint32_t>(item);
  const auto of = std::lower_bound(sections.begin(), sections.end(), wanted, comesBefore);
  PELAGE_ASSERT(of != sections.end() && of->kind == wanted.kind && of->item == wanted.item,
                "an array is from a section that was read");
  return *of;
}

// Reads contents of sections; errors name the section and the byte.
class SectionReader {
 public:
  explicit SectionReader(StreamReader& stream) : stream_(stream) {}
  StreamReader& stream() const { return stream_; }

  Error fault(const Section& section, uint64_t offset, std::string_view what) const {
    const auto kind = static_cast<Kind>(section.kind);
    if (kind == Kind::kSources)
      return fileError(stream_.name(), section.offset + offset,
                       fmt::format("section '{}': {}", nameOf(kind), what));
    return fileError(stream_.name(), section.offset + offset,
                     fmt::format("section '{}' of {} {}: {}", nameOf(kind),
                                 belongsToMesh(kind) ? "mesh" : "hair", section.item, what));
  }

  // Reads an array of `count` elements directly into its destination.
  template <class T>
  Result<void> readArray(const Section& section, uint64_t count, std::vector<T>& out) {
    if (count == 0 || section.size / sizeof(T) != count || section.size % sizeof(T) != 0)
      return fault(section, 0,
                   fmt::format("it has {} bytes instead of {} elements of {}", section.size, count,
                               sizeof(T)));
    if (auto r = stream_.readArray(section.offset, count, out); !r) return r;
    if (hash64(std::as_bytes(std::span(out))) != section.checksum)
      return fault(section, 0, "its checksum does not match; the file is damaged");
    return {};
  }

  // The only element of a section.
  template <class T>
  Result<T> readOne(const Section& section) {
    std::vector<T> one;
    if (auto r = readArray(section, 1, one); !r) return r.error();
    return one[0];
  }

  Result<Bytes> readBytes(const Section& section) {
    Bytes bytes;
    if (auto r = readArray(section, section.size, bytes); !r) return r.error();
    return bytes;
  }

  Result<void> readText(const Section& section, std::string& out) {
    if (section.size > kMaxNameLength) return fault(section, 0, "the name is too long");
    auto bytes = readBytes(section);
    if (!bytes) return bytes.error();
    out.assign(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    return {};
  }

  // Reads a length of 32 bits and a name of that many bytes.
  Result<std::string> textAt(const Section& section, const Bytes& bytes, uint64_t& at) const {
    if (bytes.size() - at < sizeof(uint32_t)) return fault(section, at, "it ends inside an entry");
    const auto length = readAt<uint32_t>(bytes, at);
    at += sizeof(uint32_t);
    if (length > kMaxNameLength || length > bytes.size() - at)
      return fault(section, at - sizeof(uint32_t), "a name is too long");
    at += length;
    return std::string(reinterpret_cast<const char*>(bytes.data() + at - length), length);
  }

  Result<void> readBones(const Section& section, uint32_t count, std::vector<BoneName>& bones) {
    auto bytes = readBytes(section);
    if (!bytes) return bytes.error();
    uint64_t at = 0;
    while (at < bytes->size()) {
      if (bytes->size() - at < sizeof(uint32_t))
        return fault(section, at, "it ends inside an entry");
      BoneName bone;
      bone.index = readAt<uint32_t>(*bytes, at);
      at += sizeof(uint32_t);
      auto text = textAt(section, *bytes, at);
      if (!text) return text.error();
      bone.name = std::move(*text);
      bones.push_back(std::move(bone));
    }
    if (bones.size() != count)
      return fault(section, 0, fmt::format("it has {} bones instead of {}", bones.size(), count));
    return {};
  }

  Result<void> faultIn(const Fault& found, size_t item, const std::vector<Section>& sections) {
    return fault(sectionOf(found.kind, item, sections), found.offset, found.what);
  }

  // \param owner  "hair" or "mesh"
  Error missing(const char* owner, size_t item, Kind kind) const {
    return fileError(stream_.name(), sizeof(Header),
                     fmt::format("{} {} has no section '{}'", owner, item, nameOf(kind)));
  }

 private:
  StreamReader& stream_;
};

// The hairs of a cache.
class HairLoader {
 public:
  HairLoader(SectionReader& reader, std::vector<CachedHair>& hairs)
      : reader_(reader), hairs_(hairs) {}

  size_t count() const { return infos_.size(); }

  Result<void> takeInfo(const Section& section) {
    const Result<HairInfo> read = reader_.readOne<HairInfo>(section);
    if (!read) return read.error();
    const HairInfo& info = *read;
    if (section.item != infos_.size() || infos_.size() == kMaxItems)
      return reader_.fault(section, 0, "its number is out of order");
    if (info.strandCount == 0 || info.verticesPerStrand < kMinVerticesPerStrand ||
        info.verticesPerStrand > kMaxVerticesPerStrand)
      return reader_.fault(
          section, 0,
          fmt::format("{} strands of {} vertices; it must be 1 or more of 2 to 256",
                      info.strandCount, info.verticesPerStrand));
    const uint64_t vertices = uint64_t{info.strandCount} * info.verticesPerStrand;
    if (info.degenerateSegmentCount > vertices || info.repairedStrandCount > info.strandCount ||
        info.followCount > kMaxFollowHairs)
      return reader_.fault(section, 0, "a count is out of range");
    if (info.reserved[0] != 0 || info.reserved[1] != 0 || info.reserved[2] != 0)
      return reader_.fault(section, 0, "words that must be 0 are not");
    CachedHair hair;
    HairAsset& asset = hair.asset;
    asset.strandCount = info.strandCount;
    asset.verticesPerStrand = info.verticesPerStrand;
    asset.degenerateSegmentCount = info.degenerateSegmentCount;
    TfxFileLayout& layout = asset.fileLayout;
    layout.strandCount = info.layoutStrandCount;
    layout.verticesPerStrand = info.layoutVerticesPerStrand;
    layout.fileSize = info.layoutFileSize;
    std::copy(std::begin(info.layoutOffsets), std::end(info.layoutOffsets), layout.offsets);
    std::copy(std::begin(info.layoutReserved), std::end(info.layoutReserved), layout.reserved);
    if (info.boneCount > 0) {
      hair.bones.emplace();
      hair.bones->repairedStrandCount = info.repairedStrandCount;
    }
    hairs_.push_back(std::move(hair));
    infos_.push_back(info);
    return {};
  }

  Result<void> take(const Section& section) {
    const HairInfo& info = infos_[section.item];
    CachedHair& hair = hairs_[section.item];
    const auto kind = static_cast<Kind>(section.kind);
    switch (kind) {
      case Kind::kHairName:
        return reader_.readText(section, hair.name);
      case Kind::kHairExtras:
        return readExtras(section, info, hair.asset.fileLayout);
      case Kind::kHairBones:
      case Kind::kStrandBones:
        if (!hair.bones)
          return reader_.fault(section, 0, "the hair has bone weights, but no bones");
        if (kind == Kind::kHairBones)
          return reader_.readBones(section, info.boneCount, hair.bones->bones);
        return reader_.readArray(section, info.strandCount, hair.bones->strands);
      case Kind::kFollowHairs:
        return reader_.readArray(section, info.followCount, hair.followHairs);
      default:
        break;
    }
    Result<void> result;
    forEachArray(hair.asset, info.strandCount, uint64_t{info.strandCount} * info.verticesPerStrand,
                 [&](Kind of, auto& array, uint64_t count, bool) {
                   if (of == kind) result = reader_.readArray(section, count, array);
                 });
    return result;
  }

  // Checks for missing sections, and checks the values.
  Result<void> finish(size_t item, const std::vector<Section>& sections) {
    const CachedHair& hair = hairs_[item];
    const HairInfo& info = infos_[item];
    const auto missing = [&](Kind kind) { return reader_.missing("hair", item, kind); };
    Result<void> complete;
    forEachArray(hair.asset, 0, 0, [&](Kind kind, const auto& array, uint64_t, bool optional) {
      if (complete && array.empty() && !optional) complete = missing(kind);
    });
    if (!complete) return complete;
    if (hair.bones && hair.bones->strands.empty()) return missing(Kind::kStrandBones);
    if (hair.bones && hair.bones->bones.empty()) return missing(Kind::kHairBones);
    if (hair.followHairs.size() != info.followCount) return missing(Kind::kFollowHairs);
    const TfxFileLayout& layout = hair.asset.fileLayout;
    if (layout.extras.size() != info.layoutExtraCount) return missing(Kind::kHairExtras);
    // saveTfx() allocates the size in the layout.
    if (layout.fileSize != 0 && !tfxLayoutFits(hair.asset))
      return fileError(reader_.stream().name(), sizeof(Header),
                       fmt::format("hair {} has the layout of another .tfx file", item));
    const auto found = faultOf(hair);
    return found ? reader_.faultIn(*found, item, sections) : Result<void>();
  }

 private:
  Result<void> readExtras(const Section& section, const HairInfo& info, TfxFileLayout& layout) {
    auto bytes = reader_.readBytes(section);
    if (!bytes) return bytes.error();
    uint64_t at = 0;
    while (at < bytes->size()) {
      constexpr uint64_t kHead = 2 * sizeof(uint64_t);
      if (bytes->size() - at < kHead) return reader_.fault(section, at, "it ends inside an entry");
      const auto size = readAt<uint64_t>(*bytes, at + sizeof(uint64_t));
      if (size > bytes->size() - at - kHead)
        return reader_.fault(section, at, "an entry leaves it");
      const auto begin = bytes->begin() + static_cast<std::ptrdiff_t>(at + kHead);
      layout.extras.push_back(
          {readAt<uint64_t>(*bytes, at), {begin, begin + static_cast<std::ptrdiff_t>(size)}});
      at += kHead + size;
    }
    if (layout.extras.size() != info.layoutExtraCount)
      return reader_.fault(section, 0, "it has another number of entries than the hair says");
    return {};
  }

  SectionReader& reader_;
  std::vector<CachedHair>& hairs_;
  std::vector<HairInfo> infos_;
};

// The collision meshes of a cache.
class MeshLoader {
 public:
  MeshLoader(SectionReader& reader, std::vector<CachedMesh>& meshes)
      : reader_(reader), meshes_(meshes) {}

  size_t count() const { return infos_.size(); }

  Result<void> takeInfo(const Section& section) {
    const Result<MeshInfo> read = reader_.readOne<MeshInfo>(section);
    if (!read) return read.error();
    const MeshInfo& info = *read;
    if (section.item != infos_.size() || infos_.size() == kMaxItems)
      return reader_.fault(section, 0, "its number is out of order");
    if (info.vertexCount == 0 || info.vertexCount > 0x7fffffffu || info.triangleCount == 0 ||
        info.triangleCount > 0x7fffffffu || info.boneCount == 0 ||
        info.repairedVertexCount > info.vertexCount)
      return reader_.fault(section, 0, "a count is out of range");
    meshes_.emplace_back();
    meshes_.back().mesh.repairedVertexCount = info.repairedVertexCount;
    infos_.push_back(info);
    return {};
  }

  Result<void> takeTopologyInfo(const Section& section) {
    const Result<TopologyInfo> read = reader_.readOne<TopologyInfo>(section);
    if (!read) return read.error();
    const TopologyInfo& info = *read;
    if (section.item >= infos_.size()) return reader_.fault(section, 0, "it belongs to no mesh");
    const MeshInfo& mesh = infos_[section.item];
    if (info.triangleCount > mesh.triangleCount || info.pointCount == 0 ||
        info.pointCount > mesh.vertexCount || info.flags > 7)
      return reader_.fault(section, 0, "a count is out of range");
    topologies_.resize(infos_.size());
    topologies_[section.item].emplace().topology.report = reportOf(info);
    topologyInfos_.resize(infos_.size());
    topologyInfos_[section.item] = info;
    return {};
  }

  Result<void> take(const Section& section) {
    const MeshInfo& info = infos_[section.item];
    CachedMesh& cached = meshes_[section.item];
    CollisionMesh& mesh = cached.mesh;
    switch (static_cast<Kind>(section.kind)) {
      case Kind::kMeshName:
        return reader_.readText(section, cached.name);
      case Kind::kMeshBones:
        return reader_.readBones(section, info.boneCount, mesh.bones);
      case Kind::kMeshPositions:
        return reader_.readArray(section, info.vertexCount, mesh.positions);
      case Kind::kMeshNormals:
        return reader_.readArray(section, info.vertexCount, mesh.normals);
      case Kind::kMeshInfluences:
        return reader_.readArray(section, info.vertexCount, mesh.influences);
      case Kind::kMeshIndices:
        return reader_.readArray(section, uint64_t{3} * info.triangleCount, mesh.indices);
      default:
        return takeOfTopology(section);
    }
  }

  Result<void> finish(size_t item, const std::vector<Section>& sections) {
    const CollisionMesh& mesh = meshes_[item].mesh;
    const auto missing = [&](Kind kind) { return reader_.missing("mesh", item, kind); };
    if (mesh.positions.empty()) return missing(Kind::kMeshPositions);
    if (mesh.normals.empty()) return missing(Kind::kMeshNormals);
    if (mesh.influences.empty()) return missing(Kind::kMeshInfluences);
    if (mesh.indices.empty()) return missing(Kind::kMeshIndices);
    if (mesh.bones.empty()) return missing(Kind::kMeshBones);
    if (const auto found = faultOf(mesh)) return reader_.faultIn(*found, item, sections);
    if (item >= topologies_.size() || !topologies_[item]) return {};
    PreparedCollider& prepared = *topologies_[item];
    const MeshInfo& info = infos_[item];
    const TopologyInfo& topologyInfo = topologyInfos_[item];
    Result<void> complete;
    forEachTopologyArray(prepared.topology, info.vertexCount, topologyInfo.triangleCount,
                         topologyInfo.pointCount,
                         [&](Kind kind, const auto& array, uint64_t count) {
                           if (complete && array.size() != count) complete = missing(kind);
                         });
    if (!complete) return complete;
    if (const auto found = faultOf(prepared.topology, info.vertexCount, info.triangleCount))
      return reader_.faultIn(*found, item, sections);
    // The checksums of the hashed sections, which matched.
    prepared.positionsHash = sectionOf(Kind::kMeshPositions, item, sections).checksum;
    prepared.indicesHash = sectionOf(Kind::kMeshIndices, item, sections).checksum;
    meshes_[item].mesh.prepared = std::make_shared<const PreparedCollider>(std::move(prepared));
    return {};
  }

 private:
  Result<void> takeOfTopology(const Section& section) {
    if (section.item >= topologies_.size() || !topologies_[section.item])
      return reader_.fault(section, 0, "it belongs to no topology");
    const TopologyInfo& info = topologyInfos_[section.item];
    Result<void> result;
    forEachTopologyArray(topologies_[section.item]->topology, infos_[section.item].vertexCount,
                         info.triangleCount, info.pointCount,
                         [&](Kind of, auto& array, uint64_t count) {
                           if (of == static_cast<Kind>(section.kind))
                             result = reader_.readArray(section, count, array);
                         });
    return result;
  }

  SectionReader& reader_;
  std::vector<CachedMesh>& meshes_;
  std::vector<MeshInfo> infos_;
  // [mesh] as far as they are there.
  std::vector<std::optional<PreparedCollider>> topologies_;
  std::vector<TopologyInfo> topologyInfos_;
};

// Reads the sections in the order of the file.
class Loader {
 public:
  explicit Loader(StreamReader& stream) : reader_(stream) {}

  Result<AssetCache> load() {
    Header header;
    auto sections = TableReader(reader_.stream()).read(header);
    if (!sections) return sections.error();
    for (const Section& section : *sections)
      if (auto r = take(section); !r) return r.error();
    if (hairs_.count() != header.hairCount || meshes_.count() != header.meshCount)
      return fileError(reader_.stream().name(), offsetof(Header, hairCount),
                       "the numbers of hairs and meshes differ from those in the header");
    for (size_t i = 0; i < hairs_.count(); ++i)
      if (auto r = hairs_.finish(i, *sections); !r) return r.error();
    for (size_t i = 0; i < meshes_.count(); ++i)
      if (auto r = meshes_.finish(i, *sections); !r) return r.error();
    return std::move(cache_);
  }

  Result<std::vector<SourceKey>> loadSources() {
    Header header;
    const auto sections = TableReader(reader_.stream()).read(header);
    if (!sections) return sections.error();
    for (const Section& section : *sections)
      if (static_cast<Kind>(section.kind) == Kind::kSources)
        if (auto r = take(section); !r) return r.error();
    return std::move(cache_.sources);
  }

 private:
  Result<void> readSources(const Section& section) {
    if (section.item != 0) return reader_.fault(section, 0, "there is more than one of them");
    auto bytes = reader_.readBytes(section);
    if (!bytes) return bytes.error();
    uint64_t at = 0;
    while (at < bytes->size()) {
      if (bytes->size() - at < 2 * sizeof(uint64_t))
        return reader_.fault(section, at, "it ends inside an entry");
      SourceKey source;
      source.size = readAt<uint64_t>(*bytes, at);
      source.hash = readAt<uint64_t>(*bytes, at + sizeof(uint64_t));
      at += 2 * sizeof(uint64_t);
      auto text = reader_.textAt(section, *bytes, at);
      if (!text) return text.error();
      source.name = std::move(*text);
      cache_.sources.push_back(std::move(source));
    }
    return {};
  }

  Result<void> take(const Section& section) {
    const auto kind = static_cast<Kind>(section.kind);
    if (kind == Kind::kHairInfo) return hairs_.takeInfo(section);
    if (kind == Kind::kMeshInfo) return meshes_.takeInfo(section);
    if (kind == Kind::kTopologyInfo) return meshes_.takeTopologyInfo(section);
    if (kind == Kind::kSources) return readSources(section);
    const bool mesh = belongsToMesh(kind);
    if (section.item >= (mesh ? meshes_.count() : hairs_.count()))
      return reader_.fault(section, 0, "it belongs to nothing in the file");
    return mesh ? meshes_.take(section) : hairs_.take(section);
  }

  SectionReader reader_;
  AssetCache cache_;
  HairLoader hairs_{reader_, cache_.hairs};
  MeshLoader meshes_{reader_, cache_.meshes};
};

}  // namespace
}  // namespace detail::cache

Result<AssetCache> loadAssetCache(ByteSource& source, std::string_view name) {
  return detail::guarded([&] {
    detail::StreamReader stream(source, name);
    return detail::cache::Loader(stream).load();
  });
}

Result<AssetCache> loadAssetCache(std::span<const std::byte> bytes, std::string_view name) {
  MemorySource source(bytes);
  return loadAssetCache(source, name);
}

Result<AssetCache> loadAssetCache(const std::filesystem::path& path) {
  return detail::guarded([&]() -> Result<AssetCache> {
    auto file = FileSource::open(path);
    if (!file) return file.error();
    return loadAssetCache(*file, path.string());
  });
}

Result<std::vector<SourceKey>> loadAssetCacheSources(ByteSource& source, std::string_view name) {
  return detail::guarded([&] {
    detail::StreamReader stream(source, name);
    return detail::cache::Loader(stream).loadSources();
  });
}

}  // namespace pelage
