#include "assets/hair_cache_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <system_error>
#include <utility>

#include "base/file_io.h"
#include "base/hash.h"
#include "pelage/hair_asset.h"

namespace pelage::detail::hair_cache {

uint64_t countVertices(const HairCacheDef& def) {
  if (def.vertexCounts.empty()) return uint64_t{def.strandCount} * def.verticesPerStrand;
  uint64_t count = 0;
  for (const uint32_t vertices : def.vertexCounts) count += vertices;
  return count;
}

const char* faultOf(const HairCacheDef& def) {
  const auto isVertexCount = [](uint32_t n) { return n >= 1 && n <= kMaxVerticesPerStrand; };
  if (def.strandCount == 0) return "it has no strands";
  if (!def.vertexCounts.empty() && def.vertexCounts.size() != def.strandCount)
    return "vertexCounts has not one count a strand";
  if (def.vertexCounts.empty()
          ? !isVertexCount(def.verticesPerStrand)
          : !std::all_of(def.vertexCounts.begin(), def.vertexCounts.end(), isVertexCount))
    return "a strand has 1 to 256 vertices";
  if (countVertices(def) > kMaxHairCacheVertices) return "it has more than 2^28 vertices";
  if (!def.strandIds.empty() && def.strandIds.size() != def.strandCount)
    return "strandIds has not one id a strand";
  if (!(def.framesPerSecond >= 1e-3 && def.framesPerSecond <= 1e6))
    return "framesPerSecond is not within 1e-3..1e6";
  if (def.firstFrame < -kMaxFrameNumber || def.firstFrame > kMaxFrameNumber)
    return "firstFrame is not within +-2^40";
  if (def.errorBound != 0 && !(def.errorBound >= 1e-9f && def.errorBound <= 1))
    return "errorBound is not 0 and not within 1e-9..1 m";
  if (def.keyInterval < 1 || def.keyInterval > kMaxKeyInterval)
    return "keyInterval is not within 1..256";
  return nullptr;
}

std::vector<Chunk> chunksOf(const HairCacheDef& def) {
  std::vector<Chunk> chunks;
  Chunk chunk;
  for (uint32_t s = 0; s < def.strandCount; ++s) {
    ++chunk.strandCount;
    chunk.vertexCount += verticesOf(def, s);
    if (chunk.vertexCount < kChunkVertices && s + 1 < def.strandCount) continue;
    chunks.push_back(chunk);
    chunk = {.firstStrand = s + 1, .firstVertex = chunk.firstVertex + chunk.vertexCount};
  }
  return chunks;
}

std::vector<std::byte> packHeader(const HairCacheDef& def) {
  std::vector<std::byte> tables;
  const auto add = [&](const auto& array) {
    const auto bytes = std::as_bytes(std::span(array));
    tables.insert(tables.end(), bytes.begin(), bytes.end());
  };
  add(def.strandIds);
  add(def.vertexCounts);
  add(def.name);
  Header header;
  header.strandCount = def.strandCount;
  header.verticesPerStrand = def.vertexCounts.empty() ? def.verticesPerStrand : 0;
  header.keyInterval = def.keyInterval;
  header.nameLength = static_cast<uint32_t>(def.name.size());
  header.framesPerSecond = def.framesPerSecond;
  header.firstFrame = def.firstFrame;
  header.errorBound = def.errorBound;
  header.hasIds = def.strandIds.empty() ? 0 : 1;
  header.tablesChecksum = hash64(tables);
  header.checksum = hash64(std::as_bytes(std::span(&header, 1)).first(offsetof(Header, checksum)));
  std::vector<std::byte> bytes;
  append(bytes, header);
  bytes.insert(bytes.end(), tables.begin(), tables.end());
  return bytes;
}

std::vector<std::byte> packIndex(std::span<const IndexEntry> index, uint64_t offset) {
  const auto entries = std::as_bytes(index);
  std::vector<std::byte> bytes(entries.begin(), entries.end());
  append(bytes, offset);
  append(bytes, static_cast<uint64_t>(index.size()));
  append(bytes, hash64(bytes));
  append(bytes, kEndMagic);
  return bytes;
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      partial_(std::exchange(other.partial_, {})),
      file_(std::move(other.file_)),
      size_(other.size_) {}

OutputFile::~OutputFile() {
  if (partial_.empty()) return;
  file_.close();
  std::error_code ignored;
  std::filesystem::remove(partial_, ignored);
}

Error OutputFile::failed(const char* what) const {
  return Error{ErrorCode::kFileNotFound, fmt::format("{}: {}", partial_.string(), what)};
}

Result<OutputFile> OutputFile::create(const std::filesystem::path& path) {
  std::filesystem::path partial = path;
  partial += ".partial";
  std::ofstream file(partial, std::ios::binary | std::ios::trunc);
  if (!file)
    return Error{ErrorCode::kFileNotFound,
                 fmt::format("{}: cannot be created; check the folder and its permissions",
                             partial.string())};
  return OutputFile(path, std::move(partial), std::move(file));
}

Result<void> OutputFile::write(std::span<const std::byte> bytes) {
  file_.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
  if (!file_) return failed("cannot be written; is the disk full?");
  size_ += bytes.size();
  return {};
}

Result<void> OutputFile::close() {
  file_.close();
  if (!file_) return failed("cannot be written; is the disk full?");
  std::error_code error;
  std::filesystem::rename(partial_, path_, error);
  if (error) return failed(error.message().c_str());
  partial_.clear();
  return {};
}

}  // namespace pelage::detail::hair_cache
