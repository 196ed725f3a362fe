#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "assets/hair_cache_codec.h"
#include "assets/hair_cache_file.h"
#include "assets/hair_cache_format.h"
#include "assets/hair_cache_parts.h"
#include "base/file_io.h"
#include "base/guard.h"
#include "base/hash.h"

namespace pelage {

namespace detail::hair_cache {
namespace {

template <class T>
std::span<const std::byte> bytesOf(const T& value) {
  return std::as_bytes(std::span(&value, 1));
}

Result<Header> readHeader(StreamReader& stream) {
  const auto refuse = [&](uint64_t offset, std::string_view what) {
    return fileError(stream.name(), offset, what);
  };
  Header header;
  if (auto r = stream.read(0, std::as_writable_bytes(std::span(&header, 1))); !r) return r.error();
  if (header.magic != kMagic) return refuse(0, "this is no hair cache");
  if (header.byteOrder != kByteOrder) return refuse(12, "it was written with another byte order");
  if (header.version != kHairCacheVersion)
    return refuse(8, fmt::format("version {}; this library reads version {}: bake it again",
                                 header.version, kHairCacheVersion));
  if (header.checksum != hash64(bytesOf(header).first(offsetof(Header, checksum))))
    return refuse(offsetof(Header, checksum), "the checksum of the header is wrong");
  if (header.nameLength > kMaxNameLength) return refuse(28, "the name is longer than 4095 bytes");
  if (header.hasIds > 1) return refuse(52, "hasIds is not 0 or 1");
  if (header.reserved != 0) return refuse(56, "a reserved field is not 0");
  return header;
}

// The tables behind the header.
Result<HairCacheDef> readTables(StreamReader& stream, const Header& header) {
  HairCacheDef def;
  def.strandCount = header.strandCount;
  def.verticesPerStrand = header.verticesPerStrand;
  def.framesPerSecond = header.framesPerSecond;
  def.firstFrame = header.firstFrame;
  def.errorBound = header.errorBound;
  def.keyInterval = header.keyInterval;
  uint64_t at = sizeof(Header);
  std::vector<std::byte> tables;
  const auto table = [&](uint64_t count, auto& out) -> Result<void> {
    if (auto r = stream.readArray(at, count, out); !r) return r;
    const auto bytes = std::as_bytes(std::span(out));
    tables.insert(tables.end(), bytes.begin(), bytes.end());
    at += bytes.size();
    return {};
  };
  std::vector<char> name;
  if (auto r = table(header.hasIds ? header.strandCount : 0, def.strandIds); !r) return r.error();
  if (auto r = table(header.verticesPerStrand == 0 ? header.strandCount : 0, def.vertexCounts); !r)
    return r.error();
  if (auto r = table(header.nameLength, name); !r) return r.error();
  if (header.tablesChecksum != hash64(tables))
    return fileError(stream.name(), sizeof(Header), "the checksum of the tables is wrong");
  def.name.assign(name.begin(), name.end());
  if (const char* fault = faultOf(def)) return fileError(stream.name(), 16, fault);
  return def;
}

// An entry of the index against those before it and the size of a frame.
const char* faultIn(const std::vector<IndexEntry>& index, size_t i, uint64_t begin,
                    uint64_t minSize, uint32_t keyInterval) {
  const IndexEntry& entry = index[i];
  const uint64_t expected = i == 0 ? begin : index[i - 1].offset + index[i - 1].byteCount;
  if (entry.offset != expected) return "a frame does not begin where the one before it ends";
  if (entry.byteCount < minSize) return "a frame is too small for its chunks";
  const uint32_t next = i == 0 ? 0 : index[i - 1].fromKey + 1;
  if (entry.fromKey != 0 && (i == 0 || entry.fromKey != next || entry.fromKey >= keyInterval))
    return "a frame is too far from its key frame";
  return nullptr;
}

Result<std::vector<IndexEntry>> readIndex(StreamReader& stream, const Contents& contents,
                                          uint64_t begin) {
  const auto refuse = [&](uint64_t offset, std::string_view what) {
    return fileError(stream.name(), offset, what);
  };
  if (stream.size() < begin + sizeof(Footer))
    return refuse(stream.size(), "the file ends before its index; was it closed?");
  const uint64_t footerAt = stream.size() - sizeof(Footer);
  Footer footer;
  if (auto r = stream.read(footerAt, std::as_writable_bytes(std::span(&footer, 1))); !r)
    return r.error();
  if (footer.magic != kEndMagic)
    return refuse(footerAt, "the file does not end with an index; was it closed?");
  if (footer.indexOffset < begin || footer.indexOffset > footerAt ||
      (footerAt - footer.indexOffset) % sizeof(IndexEntry) != 0 ||
      (footerAt - footer.indexOffset) / sizeof(IndexEntry) != footer.frameCount)
    return refuse(footerAt, "the index is not where the footer says");
  std::vector<IndexEntry> index;
  if (auto r = stream.readArray(footer.indexOffset, footer.frameCount, index); !r) return r.error();
  std::vector<std::byte> hashed = packIndex(index, footer.indexOffset);
  if (std::memcmp(hashed.data() + hashed.size() - sizeof(Footer), &footer, sizeof(Footer)) != 0)
    return refuse(footer.indexOffset, "the checksum of the index is wrong");
  const uint64_t minSize = sizeof(FrameHeader) + contents.chunks.size() * sizeof(ChunkHeader);
  for (size_t i = 0; i < index.size(); ++i)
    if (const char* fault = faultIn(index, i, begin, minSize, contents.def.keyInterval))
      return refuse(footer.indexOffset + i * sizeof(IndexEntry), fault);
  const uint64_t end = index.empty() ? begin : index.back().offset + index.back().byteCount;
  if (end != footer.indexOffset) return refuse(end, "there are bytes between frames and index");
  return index;
}

}  // namespace

Result<Contents> readContents(StreamReader& stream) {
  auto header = readHeader(stream);
  if (!header) return header.error();
  auto def = readTables(stream, *header);
  if (!def) return def.error();
  Contents contents;
  contents.def = std::move(*def);
  contents.chunks = chunksOf(contents.def);
  auto index = readIndex(stream, contents, packHeader(contents.def).size());
  if (!index) return index.error();
  contents.index = std::move(*index);
  return contents;
}

Result<void> readRecord(StreamReader& stream, const IndexEntry& entry,
                        std::vector<std::byte>& record) {
  if (auto r = stream.readArray(entry.offset, entry.byteCount, record); !r) return r;
  if (hash64(record) != entry.checksum)
    return fileError(stream.name(), entry.offset, "the checksum of the frame is wrong");
  return {};
}

struct FrameReader {
  FrameReader(std::unique_ptr<ByteSource> s, std::string_view n)
      : source(std::move(s)), name(n), stream(*source, name) {}

  std::unique_ptr<ByteSource> source;
  std::string name;
  StreamReader stream;
  Contents contents;
  uint32_t vertexCount = 0;

  Decoder decoder;
  std::vector<std::byte> record;
  std::vector<uint32_t> last, values;  ///< the frame before `values`, then the frame itself
  float step = 0;
  int64_t decoded = -1;  ///< the frame of `values`; -1: none

  Result<void> read(uint64_t frame, std::span<Float3> out);
  Result<void> decodeFrame(uint64_t frame, std::span<Float3> out);
  Result<FrameHeader> readFrameHeader(const IndexEntry& entry) const;
  Result<void> decodeChunk(const IndexEntry& entry, size_t chunk, uint64_t at,
                           const ChunkHeader& header, std::span<Float3> out);
  Error refuse(const IndexEntry& entry, uint64_t at, std::string_view what) const {
    return fileError(name, entry.offset + at, what);
  }
};

namespace {

// Returns whether all are finite.
bool toPositions(const uint32_t* values, float step, std::span<Float3> out) {
  static_assert(sizeof(Float3) == 3 * sizeof(float));
  float* const floats = out.empty() ? nullptr : &out[0].x;
  const size_t count = 3 * out.size();
  if (step > 0) {
    // Integers times a step that the reader has limited are finite.
    for (size_t i = 0; i < count; ++i)
      floats[i] = static_cast<float>(static_cast<int32_t>(values[i])) * step;
    return true;
  }
  bool finite = true;
  for (size_t i = 0; i < count; ++i) {
    floats[i] = fromOrderedBits(values[i]);
    finite = finite && std::isfinite(floats[i]);
  }
  return finite;
}

}  // namespace

Result<FrameHeader> FrameReader::readFrameHeader(const IndexEntry& entry) const {
  const auto header = readAt<FrameHeader>(record, 0);
  if (header.isKey != (entry.fromKey == 0 ? 1u : 0u) || header.reserved != 0)
    return refuse(entry, 0, "the frame is not as the index says");
  if (header.chunkCount != contents.chunks.size())
    return refuse(entry, 8, "a number of chunks that is not that of the strands");
  if (!(header.step >= 0 && header.step <= 4)) return refuse(entry, 4, "a step out of range");
  if (entry.fromKey > 0 && header.step != step)
    return refuse(entry, 4, "a step that is not that of the key frame");
  return header;
}

Result<void> FrameReader::decodeChunk(const IndexEntry& entry, size_t index, uint64_t at,
                                      const ChunkHeader& header, std::span<Float3> out) {
  const Chunk& chunk = contents.chunks[index];
  const uint64_t headerAt = sizeof(FrameHeader) + index * sizeof(ChunkHeader);
  if (header.byteCount > record.size() - at) return refuse(entry, headerAt, "a chunk is too long");
  const bool timeFits = entry.fromKey == 0 ? header.timeOrder == 0
                                           : header.timeOrder >= 1 && header.timeOrder <= 2 &&
                                                 header.timeOrder <= entry.fromKey;
  if (!timeFits || header.planeCount > 4 || header.spaceOrder >= kSpaceOrderCount ||
      header.reserved != 0)
    return refuse(entry, headerAt, "a prediction that there is not");
  const size_t first = size_t{3} * chunk.firstVertex;
  const size_t count = size_t{3} * chunk.vertexCount;
  // Memory grows with the chunks that arrive.
  if (values.size() < first + count) values.resize(first + count);
  if (!decoder.decode(contents.def, chunk, header,
                      std::span<const std::byte>(record).subspan(at, header.byteCount),
                      entry.fromKey > 0 ? last.data() + first : nullptr, values.data() + first))
    return refuse(entry, at, "a chunk that cannot be decoded");
  if (!out.empty() &&
      !toPositions(values.data() + first, step, out.subspan(chunk.firstVertex, chunk.vertexCount)))
    return refuse(entry, at, "a position that is not finite");
  return {};
}

// Decodes the frame behind `decoded`, or a key frame. \param out empty: for those behind it only
Result<void> FrameReader::decodeFrame(uint64_t frame, std::span<Float3> out) {
  decoded = -1;
  const IndexEntry& entry = contents.index[frame];
  if (auto r = readRecord(stream, entry, record); !r) return r;
  auto header = readFrameHeader(entry);
  if (!header) return header.error();
  step = header->step;
  last.swap(values);
  uint64_t at = sizeof(FrameHeader) + contents.chunks.size() * sizeof(ChunkHeader);
  for (size_t c = 0; c < contents.chunks.size(); ++c) {
    const auto chunk = readAt<ChunkHeader>(record, sizeof(FrameHeader) + c * sizeof(ChunkHeader));
    if (auto r = decodeChunk(entry, c, at, chunk, out); !r) return r;
    at += chunk.byteCount;
  }
  if (at != record.size()) return refuse(entry, at, "there are bytes behind the last chunk");
  decoded = static_cast<int64_t>(frame);
  return {};
}

Result<void> FrameReader::read(uint64_t frame, std::span<Float3> out) {
  const auto refuseArgument = [&](std::string_view what) {
    return Error{ErrorCode::kInvalidArgument, fmt::format("{}: {}", name, what)};
  };
  if (frame >= contents.index.size())
    return refuseArgument(
        fmt::format("there is no frame {}: it has {}", frame, contents.index.size()));
  if (out.size() != vertexCount)
    return refuseArgument(fmt::format("room for {} positions of {}", out.size(), vertexCount));
  const auto wanted = static_cast<int64_t>(frame);
  if (decoded == wanted && toPositions(values.data(), step, out)) return {};
  int64_t next = wanted - contents.index[frame].fromKey;
  if (decoded >= next && decoded < wanted) next = decoded + 1;
  for (; next < wanted; ++next)
    if (auto r = decodeFrame(static_cast<uint64_t>(next), {}); !r) return r;
  return decodeFrame(frame, out);
}

}  // namespace detail::hair_cache

struct HairCacheReader::Impl : detail::hair_cache::FrameReader {
  using FrameReader::FrameReader;
};

HairCacheReader::HairCacheReader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
HairCacheReader::HairCacheReader(HairCacheReader&&) noexcept = default;
HairCacheReader& HairCacheReader::operator=(HairCacheReader&&) noexcept = default;
HairCacheReader::~HairCacheReader() = default;

Result<HairCacheReader> HairCacheReader::open(std::unique_ptr<ByteSource> source,
                                              std::string_view name) {
  return detail::guarded([&]() -> Result<HairCacheReader> {
    auto impl = std::make_unique<Impl>(std::move(source), name);
    auto contents = detail::hair_cache::readContents(impl->stream);
    if (!contents) return contents.error();
    impl->contents = std::move(*contents);
    impl->vertexCount = vertexCountOf(impl->contents.def);
    return HairCacheReader(std::move(impl));
  });
}

Result<HairCacheReader> HairCacheReader::open(const std::filesystem::path& path) {
  return detail::guarded([&]() -> Result<HairCacheReader> {
    auto file = FileSource::open(path);
    if (!file) return file.error();
    return open(std::make_unique<FileSource>(std::move(*file)), path.string());
  });
}

const HairCacheDef& HairCacheReader::def() const { return impl_->contents.def; }
uint64_t HairCacheReader::frameCount() const { return impl_->contents.index.size(); }
uint32_t HairCacheReader::vertexCount() const { return impl_->vertexCount; }
Result<void> HairCacheReader::read(uint64_t frame, std::span<Float3> out) {
  return detail::guarded([&] { return impl_->read(frame, out); });
}

}  // namespace pelage
