#include "codegen/host_struct.h"

#include <algorithm>

#include "codegen/names.h"

namespace pelage::codegen {
namespace {

// A member as C++: the type of one element, how many of them, and its bytes.
struct CppType {
  std::string type;
  uint32_t count = 0;  // 0: not an array
  uint32_t elementSize = 0;
};

CppType cppType(const StructMember& member) {
  CppType result;
  result.count = member.arraySize;
  result.elementSize = 4 * member.components;
  switch (member.scalar) {
    case ScalarType::kFloat: {
      constexpr const char* kNames[] = {"float", "Float2", "Float3", "Float4"};
      result.type = kNames[member.components - 1];
      return result;
    }
    case ScalarType::kUint:
    case ScalarType::kInt: {
      const bool isSigned = member.scalar == ScalarType::kInt;
      if (member.components == 4) {
        result.type = isSigned ? "Int4" : "Uint4";
      } else if (member.components == 2 && !isSigned) {
        result.type = "Uint2";
      } else {
        // types.h has no struct for the others: an array of scalars has the same layout.
        result.type = isSigned ? "int32_t" : "uint32_t";
        if (member.components > 1) {
          result.count = member.components * std::max(member.arraySize, 1u);
          result.elementSize = 4;
        }
      }
      return result;
    }
    default:
      result.type = member.structName;
      return result;
  }
}

struct Fault {
  const char* code;
  std::string message;
};

// Describes the error in a member that comes after byte `end`, if there is one.
std::optional<Fault> faultOf(const StructMember& member, bool isBlock, uint32_t end) {
  const std::string what = "member '" + member.name + "' ";
  const std::string name = hostName(member.name);
  if (member.scalar == ScalarType::kBool) {
    return Fault{"PK602", what + "is a bool, whose size differs between host and GPU: use uint"};
  }
  if (member.columns > 1) {
    return Fault{"PK603", what + "is a matrix: store its rows as float4[n]"};
  }
  if (member.nestedArray) {
    return Fault{"PK605", what + "is an array of arrays: use one array"};
  }
  if (member.scalar == ScalarType::kOther && member.structName.empty()) {
    return Fault{"PK604", what + "is not made of 32-bit int, uint or float"};
  }
  if (isBlock && member.structName.empty() && member.components > 1) {
    // std140: the base alignment of a vector of two is 8 bytes, of three or four 16.
    const uint32_t alignment = member.components == 2 ? 8 : 16;
    if (member.offset % alignment != 0) {
      return Fault{"PK608", what + "starts at byte " + std::to_string(member.offset) +
                                ", std140 asks for a multiple of " + std::to_string(alignment) +
                                ": reorder the members or pad"};
    }
  }
  if (!isBlock && member.components == 3) {
    return Fault{"PK607",
                 what +
                     "has three components, which take 16 bytes in a buffer: use four, or three "
                     "scalars"};
  }
  if (member.offset < end) {
    return Fault{"PK611", what + "starts at byte " + std::to_string(member.offset) +
                              ", inside of the member before it: order members by offset"};
  }
  if (!member.structName.empty() && member.arraySize == 0) {
    return Fault{"PK604",
                 what + "is a struct; write its members out, or use an array of it in a buffer"};
  }
  if (member.arraySize > 0 && member.arrayStride != 4 * member.components &&
      member.structName.empty()) {
    return Fault{"PK606", what + "is an array with " + std::to_string(member.arrayStride) +
                              " bytes an element of " + std::to_string(4 * member.components) +
                              ": use float4, uint4 or int4"};
  }
  if (!isIdentifier(name)) {
    return Fault{"PK610", what + "gives '" + name + "', which is no C++ name"};
  }
  return std::nullopt;
}

}  // namespace

std::optional<HostStruct> makeHostStruct(const StructLayout& layout, const SourceLocation& where,
                                         Diagnostics& diagnostics) {
  bool ok = true;
  const auto error = [&](const char* code, const std::string& message) {
    diagnostics.error(where, code, "struct '" + layout.name + "': " + message);
    ok = false;
  };
  HostStruct result;
  result.name = layout.name;
  result.size = layout.size;
  if (!isIdentifier(layout.name)) error("PK600", "this is no C++ name");

  uint32_t end = 0;
  uint32_t paddings = 0;
  const auto pad = [&](uint32_t target) {
    if (target <= end) return;
    const uint32_t words = (target - end) / 4;
    result.fields.push_back({"uint32_t", "padding" + std::to_string(paddings++),
                             words > 1 ? words : 0, end, target - end, true});
    end = target;
  };

  for (const StructMember& member : layout.members) {
    const std::string what = "member '" + member.name + "' ";
    const std::string name = hostName(member.name);
    if (const std::optional<Fault> fault = faultOf(member, layout.isBlock, end)) {
      error(fault->code, fault->message);
      continue;
    }
    CppType type = cppType(member);
    if (!member.structName.empty()) type.elementSize = member.arrayStride;
    for (const HostField& field : result.fields) {
      if (field.name == name)
        error("PK609", what + "has the same C++ name as another one, '" + name + "'");
    }
    pad(member.offset);
    const uint32_t size = type.elementSize * std::max(type.count, 1u);
    result.fields.push_back({type.type, name, type.count, member.offset, size, false});
    end = member.offset + size;
  }
  if (!ok) return std::nullopt;
  if (end > layout.size) {
    error("PK611", "its members take more bytes than it has");
    return std::nullopt;
  }
  pad(layout.size);
  return result;
}

}  // namespace pelage::codegen
