// The reflection of a module: resources, struct layouts, specialization constants, limits.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "codegen/spirv_reader.h"
#include "pelage/layout.h"

namespace pelage::codegen {

/// Class of an HLSL register, in the order in which bindings are numbered.
enum class RegisterClass : uint8_t { kUniform, kTexture, kUav, kSampler };

/// 'b', 't', 'u' or 's'.
char registerLetter(RegisterClass registerClass);

enum class ScalarType : uint8_t { kFloat, kInt, kUint, kBool, kOther };

/// A member of a host-shared struct, as the GPU reads it.
struct StructMember {
  std::string name;  ///< as in HLSL
  ScalarType scalar = ScalarType::kFloat;
  uint32_t components = 1;  ///< of a vector
  uint32_t columns = 1;     ///< > 1: a matrix
  std::string structName;   ///< nested struct; then scalar is kOther
  uint32_t arraySize = 0;   ///< 0: not an array
  uint32_t arrayStride = 0;
  bool nestedArray = false;  ///< an array of arrays
  uint32_t offset = 0;
  bool operator==(const StructMember&) const = default;
};

struct StructLayout {
  std::string name;
  std::vector<StructMember> members;
  uint32_t size = 0;     ///< with tail padding: array stride, or block size rounded to 16
  bool isBlock = false;  ///< a cbuffer, else the element of a structured buffer or nested
  bool operator==(const StructLayout&) const = default;
};

/// A resource of one module.
struct Resource {
  uint32_t id = 0;
  std::string name;
  std::string structName;  ///< element or block type as in HLSL
  ResourceKind kind = ResourceKind::kStorageBuffer;
  RegisterClass registerClass = RegisterClass::kUniform;
  uint32_t registerNumber = 0;
  uint32_t space = 0;
  bool hasRegister = false;
  uint32_t stride = 0;   ///< bytes an element or a block
  bool isArray = false;  ///< an array of resources
  bool isRuntimeElement = false;
};

struct SpecConstantInfo {
  std::string name;
  uint32_t id = 0;
  ScalarType type = ScalarType::kUint;
  uint32_t defaultBits = 0;
  bool operator==(const SpecConstantInfo&) const = default;
};

/// An input of the vertex stage that is no system value.
struct StageInput {
  uint32_t location = 0;
  std::string name;
  ScalarType scalar = ScalarType::kFloat;  ///< kOther: a matrix, an array
  uint32_t components = 1;
  bool operator==(const StageInput&) const = default;
};

struct ModuleReflection {
  std::vector<Resource> resources;  ///< those that the entry point can reach, by (space, register)
  std::map<std::string, StructLayout> structs;
  std::vector<std::string> structConflicts;  ///< names with two layouts in this module
  std::vector<SpecConstantInfo> specConstants;
  std::vector<StageInput> inputs;  ///< of any stage, ascending by location
  uint32_t groupSize[3] = {0, 0, 0};
  uint32_t sharedBytes = 0;  ///< groupshared memory with the default specialization
};

/// Reads names and registers from the module as written by the front end.
ModuleReflection reflectModule(const SpirvReader& module);

/// Returns the accesses of the entry point to each resource variable, by id. Variables without
/// access are absent.
std::map<uint32_t, Access> resourceAccess(const SpirvReader& module);

/// Returns the GL binding numbers of the module's storage buffers, by (set, binding): dense from
/// `first`, in that order.
std::map<std::pair<uint32_t, uint32_t>, uint32_t> storageBufferNumbers(const SpirvReader& module,
                                                                       uint32_t first);

}  // namespace pelage::codegen
