#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <deque>

#include "assets/asset_cache_format.h"
#include "assets/prepared_collider.h"
#include "assets/tfx_layout.h"
#include "base/errors.h"
#include "base/file_io.h"
#include "base/guard.h"
#include "base/hash.h"

namespace pelage {
namespace detail::cache {
namespace {

using Bytes = std::vector<std::byte>;

void appendText(Bytes& bytes, std::string_view text) {
  const auto part = std::as_bytes(std::span(text));
  bytes.insert(bytes.end(), part.begin(), part.end());
}

Bytes packNames(const std::vector<BoneName>& bones) {
  Bytes bytes;
  for (const BoneName& bone : bones) {
    append(bytes, bone.index);
    append(bytes, static_cast<uint32_t>(bone.name.size()));
    appendText(bytes, bone.name);
  }
  return bytes;
}

Bytes packSources(const std::vector<SourceKey>& sources) {
  Bytes bytes;
  for (const SourceKey& source : sources) {
    append(bytes, source.size);
    append(bytes, source.hash);
    append(bytes, static_cast<uint32_t>(source.name.size()));
    appendText(bytes, source.name);
  }
  return bytes;
}

// The sections of a file, before their offsets are known.
class Sections {
 public:
  /// The bytes must remain valid.
  void add(Kind kind, size_t item, std::span<const std::byte> bytes) {
    if (bytes.empty()) return;
    Section section;
    section.kind = static_cast<uint32_t>(kind);
    section.item = static_cast<uint32_t>(item);
    section.size = bytes.size();
    section.alignment = alignmentOf(kind);
    section.checksum = hash64(bytes);
    parts_.push_back({section, bytes});
  }
  void addOwn(Kind kind, size_t item, Bytes bytes) {
    owned_.push_back(std::move(bytes));
    add(kind, item, owned_.back());
  }

  Bytes write(uint32_t hairCount, uint32_t meshCount) {
    std::sort(parts_.begin(), parts_.end(),
              [](const Part& a, const Part& b) { return comesBefore(a.section, b.section); });
    Header header;
    header.sectionCount = static_cast<uint32_t>(parts_.size());
    header.hairCount = hairCount;
    header.meshCount = meshCount;
    header.fileSize = sizeof(Header) + parts_.size() * sizeof(Section);
    for (Part& part : parts_) {
      part.section.offset = header.fileSize;
      header.fileSize += part.section.size;
    }
    Bytes bytes;
    bytes.reserve(header.fileSize);
    append(bytes, header);
    for (const Part& part : parts_) append(bytes, part.section);
    header.checksum = headerChecksum(bytes);
    std::memcpy(bytes.data(), &header, sizeof(header));
    for (const Part& part : parts_) bytes.insert(bytes.end(), part.bytes.begin(), part.bytes.end());
    return bytes;
  }

 private:
  struct Part {
    Section section;
    std::span<const std::byte> bytes;
  };
  std::vector<Part> parts_;
  std::deque<Bytes> owned_;
};

// Fills the layout of the asset's file in, and returns its extra parts. If the asset no longer
// matches its file, only the reserved words are of use.
Bytes packLayout(const HairAsset& asset, HairInfo& info) {
  const TfxFileLayout& layout = asset.fileLayout;
  std::copy(std::begin(layout.reserved), std::end(layout.reserved), info.layoutReserved);
  Bytes extras;
  if (tfxLayoutFits(asset)) {
    info.layoutStrandCount = layout.strandCount;
    info.layoutVerticesPerStrand = layout.verticesPerStrand;
    info.layoutFileSize = layout.fileSize;
    std::copy(std::begin(layout.offsets), std::end(layout.offsets), info.layoutOffsets);
    info.layoutExtraCount = static_cast<uint32_t>(layout.extras.size());
    for (const TfxFileLayout::Extra& extra : layout.extras) {
      append(extras, extra.offset);
      append(extras, static_cast<uint64_t>(extra.bytes.size()));
      extras.insert(extras.end(), extra.bytes.begin(), extra.bytes.end());
    }
  }
  return extras;
}

Result<void> addHair(const CachedHair& hair, size_t item, Sections& sections) {
  const auto refuse = [&](std::string_view what) {
    return invalid(fmt::format("hair {} ('{}'): {}", item, hair.name, what));
  };
  const HairAsset& asset = hair.asset;
  if (asset.restLengths.empty()) return refuse("call process() on the asset first");
  if (auto r = validate(asset); !r) return refuse(r.error().message);
  const uint64_t vertices = uint64_t{asset.strandCount} * asset.verticesPerStrand;
  if (asset.degenerateSegmentCount > vertices) return refuse("degenerateSegmentCount is too large");
  Result<void> fits;
  forEachArray(asset, asset.strandCount, vertices,
               [&](Kind kind, const auto& array, uint64_t count, bool optional) {
                 if (fits && array.size() != count && !(optional && array.empty()))
                   fits = refuse(fmt::format("{}: {} elements instead of {}", nameOf(kind),
                                             array.size(), count));
                 sections.add(kind, item, std::as_bytes(std::span(array)));
               });
  if (!fits) return fits;
  if (hair.bones && hair.bones->strands.size() != asset.strandCount)
    return refuse(fmt::format("{} guides, but bone weights for {}", asset.strandCount,
                              hair.bones->strands.size()));
  if (hair.bones && hair.bones->repairedStrandCount > asset.strandCount)
    return refuse("repairedStrandCount is too large");
  if (hair.followHairs.size() > kMaxFollowHairs) return refuse("more than 2^31 follow hairs");
  if (const auto fault = faultOf(hair))
    return refuse(fmt::format("{}: {}", nameOf(fault->kind), fault->what));

  HairInfo info;
  info.strandCount = asset.strandCount;
  info.verticesPerStrand = asset.verticesPerStrand;
  info.followCount = static_cast<uint32_t>(hair.followHairs.size());
  info.degenerateSegmentCount = asset.degenerateSegmentCount;
  sections.addOwn(Kind::kHairExtras, item, packLayout(asset, info));
  if (hair.bones) {
    info.boneCount = static_cast<uint32_t>(hair.bones->bones.size());
    info.repairedStrandCount = hair.bones->repairedStrandCount;
    sections.addOwn(Kind::kHairBones, item, packNames(hair.bones->bones));
    sections.add(Kind::kStrandBones, item, std::as_bytes(std::span(hair.bones->strands)));
  }
  sections.add(Kind::kFollowHairs, item, std::as_bytes(std::span(hair.followHairs)));
  sections.add(Kind::kHairName, item, std::as_bytes(std::span(hair.name)));
  const auto bytes = std::as_bytes(std::span(&info, 1));
  sections.addOwn(Kind::kHairInfo, item, {bytes.begin(), bytes.end()});
  return {};
}

Result<void> addMesh(const CachedMesh& cached, size_t item, Sections& sections) {
  const auto refuse = [&](std::string_view what) {
    return invalid(fmt::format("mesh {} ('{}'): {}", item, cached.name, what));
  };
  const CollisionMesh& mesh = cached.mesh;
  const size_t vertices = mesh.positions.size();
  if (vertices == 0 || vertices > 0x7fffffffu || mesh.indices.empty() ||
      mesh.indices.size() % 3 != 0 || mesh.indices.size() / 3 > 0x7fffffffu)
    return refuse("needs vertices and triangles, fewer than 2^31");
  if (mesh.normals.size() != vertices || mesh.influences.size() != vertices)
    return refuse(fmt::format("has {} positions, {} normals and {} influences", vertices,
                              mesh.normals.size(), mesh.influences.size()));
  if (mesh.repairedVertexCount > vertices) return refuse("repairedVertexCount is too large");
  if (const auto fault = faultOf(mesh))
    return refuse(fmt::format("{}: {}", nameOf(fault->kind), fault->what));
  auto topology = topologyOf(mesh);
  if (!topology) return refuse(topology.error().message);
  const TopologyInfo topologyInfo = infoOf(*topology);
  const auto topologyBytes = std::as_bytes(std::span(&topologyInfo, 1));
  sections.addOwn(Kind::kTopologyInfo, item, {topologyBytes.begin(), topologyBytes.end()});
  forEachTopologyArray(*topology, 0, 0, 0, [&](Kind kind, const auto& array, uint64_t) {
    const auto part = std::as_bytes(std::span(array));
    sections.addOwn(kind, item, {part.begin(), part.end()});
  });
  const MeshInfo info = {.vertexCount = static_cast<uint32_t>(vertices),
                         .triangleCount = static_cast<uint32_t>(mesh.indices.size() / 3),
                         .boneCount = static_cast<uint32_t>(mesh.bones.size()),
                         .repairedVertexCount = mesh.repairedVertexCount};
  const auto bytes = std::as_bytes(std::span(&info, 1));
  sections.addOwn(Kind::kMeshInfo, item, {bytes.begin(), bytes.end()});
  sections.add(Kind::kMeshPositions, item, std::as_bytes(std::span(mesh.positions)));
  sections.add(Kind::kMeshNormals, item, std::as_bytes(std::span(mesh.normals)));
  sections.add(Kind::kMeshInfluences, item, std::as_bytes(std::span(mesh.influences)));
  sections.add(Kind::kMeshIndices, item, std::as_bytes(std::span(mesh.indices)));
  sections.addOwn(Kind::kMeshBones, item, packNames(mesh.bones));
  sections.add(Kind::kMeshName, item, std::as_bytes(std::span(cached.name)));
  return {};
}

Result<Bytes> save(const AssetCache& cache) {
  const auto isTooLong = [](const auto& named) { return named.name.size() > kMaxNameLength; };
  if (std::any_of(cache.sources.begin(), cache.sources.end(), isTooLong) ||
      std::any_of(cache.hairs.begin(), cache.hairs.end(), isTooLong) ||
      std::any_of(cache.meshes.begin(), cache.meshes.end(), isTooLong))
    return invalid(fmt::format("a name has more than {} bytes", kMaxNameLength));
  if (cache.hairs.size() > kMaxItems || cache.meshes.size() > kMaxItems)
    return invalid(fmt::format("a cache holds at most {} hairs and meshes", kMaxItems));
  Sections sections;
  for (size_t i = 0; i < cache.hairs.size(); ++i)
    if (auto r = addHair(cache.hairs[i], i, sections); !r) return r.error();
  for (size_t i = 0; i < cache.meshes.size(); ++i)
    if (auto r = addMesh(cache.meshes[i], i, sections); !r) return r.error();
  sections.addOwn(Kind::kSources, 0, packSources(cache.sources));
  return sections.write(static_cast<uint32_t>(cache.hairs.size()),
                        static_cast<uint32_t>(cache.meshes.size()));
}

}  // namespace
}  // namespace detail::cache

Result<std::vector<std::byte>> saveAssetCache(const AssetCache& cache) {
  return detail::guarded([&] { return detail::cache::save(cache); });
}

Result<void> saveAssetCache(const AssetCache& cache, const std::filesystem::path& path) {
  return detail::guarded([&]() -> Result<void> {
    const auto bytes = detail::cache::save(cache);
    if (!bytes) return bytes.error();
    return detail::writeFile(path, *bytes);
  });
}

}  // namespace pelage
