#include "pelage/stream.h"

#include <fmt/format.h>

#include <cstring>
#include <system_error>
#include <utility>

#include "base/file_io.h"
#include "base/guard.h"
#include "base/stream_reader.h"
#include "pelage/assert.h"

namespace pelage {

size_t MemorySource::read(uint64_t offset, std::span<std::byte> out) {
  if (offset >= bytes_.size()) return 0;
  const size_t count = std::min<uint64_t>(out.size(), bytes_.size() - offset);
  if (count > 0) std::memcpy(out.data(), bytes_.data() + offset, count);
  return count;
}

Result<FileSource> FileSource::open(const std::filesystem::path& path) {
  return detail::guarded([&]() -> Result<FileSource> {
    const auto refuse = [&](std::string_view what) {
      return Error{ErrorCode::kFileNotFound, fmt::format("{}: {}", path.string(), what)};
    };
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status)) return refuse("no such file");
    if (!std::filesystem::is_regular_file(status)) return refuse("not a regular file");
    const uint64_t size = std::filesystem::file_size(path, error);
    if (error) return refuse(error.message());
    std::ifstream file;
    // Loaders read large parts at once; a buffer would only copy them.
    file.rdbuf()->pubsetbuf(nullptr, 0);
    file.open(path, std::ios::binary);
    if (!file) return refuse("cannot be opened; check its permissions");
    return FileSource(std::move(file), size);
  });
}

size_t FileSource::read(uint64_t offset, std::span<std::byte> out) {
  if (offset != position_) {
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(offset));
    if (!file_) return 0;
    position_ = offset;
  }
  file_.read(reinterpret_cast<char*>(out.data()), static_cast<std::streamsize>(out.size()));
  const auto count = static_cast<size_t>(file_.gcount());
  position_ += count;
  return count;
}

CallbackSource::CallbackSource(Functions functions) : functions_(std::move(functions)) {
  PELAGE_ASSERT(functions_.size && functions_.seek && functions_.read,
                "CallbackSource needs all three functions");
}

size_t CallbackSource::read(uint64_t offset, std::span<std::byte> out) {
  if (!placed_ || offset != position_) {
    placed_ = functions_.seek(offset);
    if (!placed_) return 0;
    position_ = offset;
  }
  const size_t count = functions_.read(out);
  position_ += count;
  return count;
}

namespace detail {

Result<void> StreamReader::checkRange(uint64_t offset, uint64_t count, uint64_t elementSize) const {
  if (offset <= size_ && count <= (size_ - offset) / elementSize) return {};
  return fileError(name_, size_,
                   fmt::format("the file ends, but {} elements of {} bytes are wanted at byte {}",
                               count, elementSize, offset));
}

Result<void> StreamReader::read(uint64_t offset, std::span<std::byte> out) {
  if (auto r = checkRange(offset, out.size(), 1); !r) return r;
  for (size_t done = 0; done < out.size();) {
    const std::span<std::byte> rest = out.subspan(done);
    const size_t count = source_.read(offset + done, rest);
    if (count == 0)
      return fileError(name_, offset + done,
                       fmt::format("reading failed, with {} bytes left to read", rest.size()));
    if (count > rest.size())
      return fileError(name_, offset + done,
                       fmt::format("the source says that it read {} bytes where {} were asked for",
                                   count, rest.size()));
    done += count;
  }
  return {};
}

}  // namespace detail

Result<std::vector<std::byte>> readAll(ByteSource& source, std::string_view name) {
  return detail::guarded([&]() -> Result<std::vector<std::byte>> {
    detail::StreamReader reader(source, name);
    std::vector<std::byte> bytes;
    if (auto r = reader.readArray(0, reader.size(), bytes); !r) return r.error();
    return bytes;
  });
}

}  // namespace pelage
