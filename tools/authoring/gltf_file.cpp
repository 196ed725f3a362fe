// glTF 2.0: Khronos, "glTF 2.0 Specification", 3.6 (buffers, accessors), 4 (GLB container).
#include "gltf_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "binary_file.h"

namespace pelage::detail {
namespace {

using tools::fileError;
using tools::readAt;

constexpr uint32_t kGlbMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
constexpr uint32_t kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123,
                   kUnsignedInt = 5125, kFloat = 5126;
// Deeper values are left out: nothing that is read here nests like that.
constexpr int kMaxDepth = 16;

uint64_t sizeOf(uint32_t componentType) {
  switch (componentType) {
    case kByte:
    case kUnsignedByte:
      return 1;
    case kShort:
    case kUnsignedShort:
      return 2;
    case kUnsignedInt:
    case kFloat:
      return 4;
    default:
      return 0;
  }
}

uint32_t componentsOf(std::string_view type) {
  constexpr std::array<std::string_view, 4> kTypes = {"SCALAR", "VEC2", "VEC3", "VEC4"};
  for (uint32_t i = 0; i < kTypes.size(); ++i)
    if (type == kTypes[i]) return i + 1;
  return 0;
}

int base64Value(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

// RFC 4648; nothing when a character is none of it.
std::optional<std::vector<std::byte>> decodeBase64(std::string_view text) {
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  std::vector<std::byte> bytes;
  bytes.reserve(text.size() / 4 * 3 + 3);
  uint32_t bits = 0, bitCount = 0;
  for (const char c : text) {
    const int value = base64Value(c);
    if (value < 0) return std::nullopt;
    bits = bits << 6 | static_cast<uint32_t>(value);
    bitCount += 6;
    if (bitCount < 8) continue;
    bitCount -= 8;
    bytes.push_back(static_cast<std::byte>(bits >> bitCount & 0xFF));
  }
  return bytes;
}

// RFC 3986, percent-encoding.
std::string decodeUri(std::string_view uri) {
  std::string text;
  const auto digit = [](char c) {
    if (c >= '0' && c <= '9') return c - '0';
    const char lower = static_cast<char>(c | 0x20);
    return lower >= 'a' && lower <= 'f' ? lower - 'a' + 10 : -1;
  };
  for (size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() && digit(uri[i + 1]) >= 0 && digit(uri[i + 2]) >= 0) {
      text.push_back(static_cast<char>(digit(uri[i + 1]) * 16 + digit(uri[i + 2])));
      i += 2;
    } else {
      text.push_back(uri[i]);
    }
  }
  return text;
}

// A file of the folder or below it: a stranger's file must not read elsewhere.
bool staysInside(const std::filesystem::path& path) {
  return !path.empty() && path.is_relative() && !path.has_root_name() &&
         std::none_of(path.begin(), path.end(), [](const auto& part) { return part == ".."; });
}

float toFloat(std::span<const std::byte> bytes, uint64_t at, uint32_t type, bool normalized) {
  // Normalized integers: 3.6.2.2, with -1 for the lowest of a signed type.
  switch (type) {
    case kByte: {
      const auto value = static_cast<float>(readAt<int8_t>(bytes, at));
      return normalized ? std::max(value / 127.0f, -1.0f) : value;
    }
    case kUnsignedByte: {
      const auto value = static_cast<float>(readAt<uint8_t>(bytes, at));
      return normalized ? value / 255.0f : value;
    }
    case kShort: {
      const auto value = static_cast<float>(readAt<int16_t>(bytes, at));
      return normalized ? std::max(value / 32767.0f, -1.0f) : value;
    }
    case kUnsignedShort: {
      const auto value = static_cast<float>(readAt<uint16_t>(bytes, at));
      return normalized ? value / 65535.0f : value;
    }
    case kUnsignedInt:
      return static_cast<float>(readAt<uint32_t>(bytes, at));
    default:
      return readAt<float>(bytes, at);
  }
}

}  // namespace

Error GltfFile::fail(std::string_view path, std::string_view what) const {
  return Error{ErrorCode::kInvalidFile, fmt::format("{}: {}: {}", name_, path, what)};
}

Result<void> GltfFile::parse() {
  bytesRead_ = bytes_.size();
  if (bytes_.size() >= 4 && readAt<uint32_t>(bytes_, 0) == kGlbMagic) return parseBinary();
  return parseJson({reinterpret_cast<const char*>(bytes_.data()), bytes_.size()}, 0);
}

Result<void> GltfFile::parseBinary() {
  if (bytes_.size() < 20) return fileError(name_, bytes_.size(), "the file ends inside the header");
  if (const auto version = readAt<uint32_t>(bytes_, 4); version != 2)
    return fileError(name_, 4, fmt::format("GLB version {}; only 2 can be read", version));
  const uint64_t length = readAt<uint32_t>(bytes_, 8);
  if (length > bytes_.size())
    return fileError(name_, bytes_.size(),
                     fmt::format("the file ends here, but its header says {} bytes", length));
  const uint64_t jsonSize = readAt<uint32_t>(bytes_, 12);
  if (readAt<uint32_t>(bytes_, 16) != kJsonChunk)
    return fileError(name_, 16, "the first chunk is not the JSON");
  if (20 + jsonSize > length)
    return fileError(name_, 12, fmt::format("the JSON of {} bytes leaves the file", jsonSize));
  const uint64_t at = (20 + jsonSize + 3) / 4 * 4;
  if (at + 8 <= length && readAt<uint32_t>(bytes_, at + 4) == kBinaryChunk) {
    const uint64_t size = readAt<uint32_t>(bytes_, at);
    if (at + 8 + size > length)
      return fileError(name_, at,
                       fmt::format("the binary chunk of {} bytes leaves the file", size));
    chunk_ = bytes_.subspan(at + 8, size);
  }
  return parseJson({reinterpret_cast<const char*>(bytes_.data()) + 20, jsonSize}, 20);
}

Result<void> GltfFile::parseJson(std::string_view text, uint64_t offset) {
  using nlohmann::json;
  try {
    root_ =
        json::parse(text, [](int depth, json::parse_event_t, json&) { return depth <= kMaxDepth; });
  } catch (const json::parse_error& error) {
    return fileError(name_, offset + error.byte, "the JSON is damaged here, or is none");
  } catch (const json::exception&) {
    return fileError(name_, offset, "the JSON has a number that is out of range");
  }
  if (!root_.is_object() || !root_.contains("asset"))
    return fail("asset", "missing; is it a glTF file?");
  const json& asset = root_["asset"];
  const std::string version =
      asset.is_object() && asset.contains("version") && asset["version"].is_string()
          ? asset["version"].get<std::string>()
          : "";
  if (version.substr(0, 2) != "2.")
    return fail("asset.version", fmt::format("'{}'; only 2.x can be read", version.substr(0, 40)));
  if (root_.contains("extensionsRequired") && root_["extensionsRequired"].is_array())
    for (const json& extension : root_["extensionsRequired"])
      if (extension == "KHR_draco_mesh_compression" || extension == "EXT_meshopt_compression")
        return fail("extensionsRequired", fmt::format("{} cannot be read; export without "
                                                      "compression",
                                                      extension.get<std::string>()));
  return {};
}

Result<const nlohmann::json*> GltfFile::element(const char* list, uint64_t index) const {
  const std::string path = fmt::format("{}[{}]", list, index);
  const auto found = root_.find(list);
  const size_t size = found != root_.end() && found->is_array() ? found->size() : 0;
  if (index >= size) return fail(path, fmt::format("missing; there are {}", size));
  const nlohmann::json& object = (*found)[index];
  if (!object.is_object()) return fail(path, "not an object");
  return &object;
}

Result<uint64_t> GltfFile::whole(const nlohmann::json& object, const char* member,
                                 std::string_view path, std::optional<uint64_t> fallback) const {
  const auto found = object.find(member);
  if (found == object.end()) {
    if (fallback) return *fallback;
    return fail(fmt::format("{}.{}", path, member), "missing");
  }
  if (!found->is_number_unsigned())
    return fail(fmt::format("{}.{}", path, member), "not a whole number of at least 0");
  return found->get<uint64_t>();
}

Result<std::span<const std::byte>> GltfFile::buffer(uint64_t index) {
  if (const auto known = buffers_.find(index); known != buffers_.end()) return known->second;
  const std::string path = fmt::format("buffers[{}]", index);
  auto object = element("buffers", index);
  if (!object) return object.error();
  auto length = whole(**object, "byteLength", path);
  if (!length) return length.error();
  auto bytes = readBuffer(index, **object);
  if (!bytes) return bytes.error();
  if (*length > bytes->size())
    return fail(path + ".byteLength",
                fmt::format("{} bytes, but there are {}", *length, bytes->size()));
  return buffers_[index] = bytes->first(*length);
}

Result<std::span<const std::byte>> GltfFile::readBuffer(uint64_t index,
                                                        const nlohmann::json& object) {
  const std::string path = fmt::format("buffers[{}]", index);
  if (!object.contains("uri")) {
    if (index != 0 || chunk_.data() == nullptr)
      return fail(path, "neither a URI nor a binary chunk");
    return chunk_;
  }
  if (!object["uri"].is_string()) return fail(path + ".uri", "not a string");
  const auto& uri = object["uri"].get_ref<const std::string&>();
  if (const auto known = contents_.find(uri); known != contents_.end())
    return std::span<const std::byte>(known->second);
  std::vector<std::byte> content;
  if (uri.rfind("data:", 0) == 0) {
    const size_t comma = uri.find(',');
    const std::string_view head = std::string_view(uri).substr(0, comma);
    auto decoded =
        comma != std::string::npos && head.size() > 7 && head.substr(head.size() - 7) == ";base64"
            ? decodeBase64(std::string_view(uri).substr(comma + 1))
            : std::nullopt;
    if (!decoded) return fail(path + ".uri", "not base64 data");
    content = *std::move(decoded);
  } else {
    const std::filesystem::path file = decodeUri(uri);
    if (!staysInside(file))
      return fail(path + ".uri",
                  fmt::format("'{}' is not a file in the folder of this one", uri.substr(0, 80)));
    if (folder_.empty())
      return fail(path + ".uri", fmt::format("'{}' cannot be found without the file's folder; "
                                             "load by path, or use a .glb",
                                             uri.substr(0, 80)));
    auto read = tools::readFile(folder_ / file);
    if (!read) return read.error();
    content = *std::move(read);
    bytesRead_ += content.size();
  }
  return std::span<const std::byte>(contents_[uri] = std::move(content));
}

Result<uint32_t> GltfFile::componentCount(uint64_t accessor) const {
  auto object = element("accessors", accessor);
  if (!object) return object.error();
  const auto type = (*object)->find("type");
  return type != (*object)->end() && type->is_string()
             ? componentsOf(type->get_ref<const std::string&>())
             : 0;
}

Result<GltfFile::View> GltfFile::view(uint64_t accessor, uint32_t components) {
  const std::string path = fmt::format("accessors[{}]", accessor);
  auto count = componentCount(accessor);
  if (!count) return count.error();
  if (*count != components)
    return fail(path + ".type", fmt::format("it must have {} components", components));
  const nlohmann::json& object = **element("accessors", accessor);
  if (object.contains("sparse"))
    return fail(path, "sparse accessors cannot be read; export plain ones");
  if (!object.contains("bufferView")) return fail(path, "no bufferView, so no data");
  View result;
  uint64_t numbers[4];
  const char* members[4] = {"bufferView", "byteOffset", "count", "componentType"};
  for (size_t i = 0; i < 4; ++i) {
    auto number =
        whole(object, members[i], path, i == 1 ? std::optional<uint64_t>(0) : std::nullopt);
    if (!number) return number.error();
    numbers[i] = *number;
  }
  const auto [viewIndex, offset, elements, type] = numbers;
  const uint64_t componentSize = type <= kFloat ? sizeOf(static_cast<uint32_t>(type)) : 0;
  if (componentSize == 0) return fail(path + ".componentType", fmt::format("{} is none", type));
  const auto normalized = object.find("normalized");
  result.normalized =
      normalized != object.end() && normalized->is_boolean() && normalized->get<bool>();
  result.componentType = static_cast<uint32_t>(type);
  result.count = elements;
  if (elements == 0) return fail(path + ".count", "0; it must be at least 1");

  const uint64_t elementSize = componentSize * components;
  auto from = bufferView(viewIndex, elementSize);
  if (!from) return from.error();
  // In this order nothing overflows: the first element fits, then the others do.
  const uint64_t length = from->bytes.size();
  if (offset > length || elementSize > length - offset ||
      elements - 1 > (length - offset - elementSize) / from->stride)
    return fail(path, fmt::format("{} elements of {} bytes from byte {} leave its view of {} bytes",
                                  elements, elementSize, offset, length));
  result.stride = from->stride;
  result.bytes = from->bytes.subspan(offset);
  return result;
}

Result<GltfFile::BufferView> GltfFile::bufferView(uint64_t index, uint64_t elementSize) {
  const std::string path = fmt::format("bufferViews[{}]", index);
  auto object = element("bufferViews", index);
  if (!object) return object.error();
  const auto extensions = (*object)->find("extensions");
  if (extensions != (*object)->end() && extensions->contains("EXT_meshopt_compression"))
    return fail(path, "EXT_meshopt_compression cannot be read; export without compression");
  auto bufferIndex = whole(**object, "buffer", path);
  if (!bufferIndex) return bufferIndex.error();
  auto offset = whole(**object, "byteOffset", path, 0);
  if (!offset) return offset.error();
  auto length = whole(**object, "byteLength", path);
  if (!length) return length.error();
  auto stride = whole(**object, "byteStride", path, elementSize);
  if (!stride) return stride.error();
  if (*stride < elementSize || *stride > 252 + elementSize)
    return fail(path + ".byteStride",
                fmt::format("{} for elements of {} bytes", *stride, elementSize));
  auto bytes = buffer(*bufferIndex);
  if (!bytes) return bytes.error();
  if (*offset > bytes->size() || *length > bytes->size() - *offset)
    return fail(path, fmt::format("bytes {} + {} leave the buffer of {} bytes", *offset, *length,
                                  bytes->size()));
  return BufferView{bytes->subspan(*offset, *length), *stride};
}

Result<std::vector<float>> GltfFile::floats(uint64_t accessor, uint32_t components) {
  auto source = view(accessor, components);
  if (!source) return source.error();
  const uint64_t componentSize = sizeOf(source->componentType);
  std::vector<float> values;
  values.reserve(source->count * components);
  for (uint64_t i = 0; i < source->count; ++i)
    for (uint64_t c = 0; c < components; ++c)
      values.push_back(toFloat(source->bytes, i * source->stride + c * componentSize,
                               source->componentType, source->normalized));
  return values;
}

Result<std::vector<uint32_t>> GltfFile::indices(uint64_t accessor) {
  auto source = view(accessor, 1);
  if (!source) return source.error();
  const uint32_t type = source->componentType;
  if (type != kUnsignedByte && type != kUnsignedShort && type != kUnsignedInt)
    return fail(fmt::format("accessors[{}].componentType", accessor),
                "indices must be unsigned integers");
  std::vector<uint32_t> values;
  values.reserve(source->count);
  for (uint64_t i = 0; i < source->count; ++i) {
    const uint64_t at = i * source->stride;
    values.push_back(type == kUnsignedByte    ? readAt<uint8_t>(source->bytes, at)
                     : type == kUnsignedShort ? readAt<uint16_t>(source->bytes, at)
                                              : readAt<uint32_t>(source->bytes, at));
  }
  return values;
}

}  // namespace pelage::detail
