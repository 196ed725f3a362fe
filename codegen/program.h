// The data from which the outputs are written.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "codegen/constants.h"
#include "codegen/host_struct.h"
#include "codegen/layout_plan.h"
#include "codegen/manifest.h"
#include "codegen/msl.h"
#include "codegen/reflect.h"
#include "pelage/kernel_code_table.h"

namespace pelage::codegen {

struct BindingUse {
  uint32_t set = 0;
  uint32_t entry = 0;
  Access access = Access::kNone;
  uint32_t glBinding = 0;
};

/// A register of the HLSL that a permutation declares and can read, before optimization.
struct HlslRegister {
  std::string name;
  RegisterClass registerClass = RegisterClass::kUniform;
  uint32_t number = 0;
  uint32_t space = 0;
};

/// A distinct variant: one SPIR-V, used by one or more permutations.
struct VariantOutput {
  std::vector<Permutation> permutations;  ///< in the manifest's order
  std::vector<uint32_t> spirv;            ///< with names where the build keeps them
  std::string glsl;
  std::string essl;
  std::string wgsl;                     ///< empty unless the build asks for it
  std::string noWebgpu;                 ///< why no permutation runs on WebGPU; else empty
  MslModule msl;                        ///< empty unless the build asks for it
  std::vector<HlslRegister> registers;  ///< of the first permutation, by (space, register)
  std::vector<BindingUse> bindings;     ///< ascending by (set, entry)
  uint32_t groupSize[3] = {0, 0, 0};
  uint32_t sharedBytes = 0;
  Tier tier = Tier::kWide;  ///< the lowest one of the permutations
  uint64_t hash = 0;        ///< of the SPIR-V without names
};

/// The code of a kernel's variants in one format, one behind the other and compressed.
struct PackedCode {
  struct Range {
    uint64_t variant = 0;  ///< VariantOutput::hash
    uint32_t offset = 0, size = 0;
  };
  std::string bytes;
  uint32_t unpackedBytes = 0;
  std::vector<Range> ranges;  ///< empty when no variant has code in this format
};

struct KernelOutput {
  ManifestKernel kernel;
  std::vector<SpecConstantInfo> specConstants;  ///< ascending by id
  std::vector<StageInput> inputs;               ///< of vertex kernels, ascending by location
  std::vector<VariantOutput> variants;
  std::array<PackedCode, 4> code;  ///< by CodeFormat
};

/// The constants of a file, in a namespace of their own.
struct ConstantsOutput {
  std::string file;
  std::string space;
  std::vector<SharedConstant> constants;
};

struct Program {
  Manifest manifest;
  std::vector<PlannedLayout> layouts;
  std::vector<HostStruct> structs;  ///< each behind those that it contains
  std::vector<KernelOutput> kernels;
  std::vector<ConstantsOutput> constants;  ///< in the manifest's order
  bool wgsl = false;                       ///< WGSL was asked for
  bool msl = false;                        ///< MSL was asked for
  bool hlsl = false;                       ///< command lines for shader model 6 were asked for
};

/// How generated C++ names things.
struct CppNames {
  std::string space;   ///< "a::b"
  std::string folder;  ///< "a/b"
  std::string prefix;  ///< of names of pelage: "::pelage::", or nothing in pelage itself
};
CppNames cppNames(const Manifest& manifest);

/// Defines a function that returns pointers to constants.
/// \param type of the constants, without its namespace
/// \param items "      &kName,\n" for each
/// \param result the function's type, without its namespace; empty: a span
std::string listFunction(const CppNames& names, const std::string& type, const std::string& name,
                         const std::string& items, const std::string& result = "");

/// The first lines of a generated file.
std::string generatedHead(const Program& program, const std::string& what);
/// Enumerator of VertexFormat without its k: "Float3".
std::string vertexFormat(const StageInput& input);
/// "group "a"" or "groups "a", "b"": those that have the layout.
std::string groupsOf(const Program& program, const PlannedLayout& layout);
/// Content of constants.h.
std::string constantsHeader(const Program& program);
/// Content of bindings.h.
std::string bindingsHeader(const Program& program);

/// Names and contents of the files to write, relative to the output folder.
std::map<std::string, std::string> emitSources(const Program& program);
/// The same of the libraries of code.
std::map<std::string, std::string> emitCode(const Program& program);
/// The header of slots on Metal, and a file of MSL for each permutation.
std::map<std::string, std::string> emitMetal(const Program& program);
/// Arguments of DXC in the manifest's folder, a line for each permutation.
std::string emitDxcLines(const Program& program,
                         const std::vector<std::filesystem::path>& includeDirs);
/// Name of a permutation's file in the folder msl.
std::string mslFile(const KernelOutput& kernel, const VariantOutput& variant);
/// "WIND=1", for each axis.
std::vector<std::string> hlslDefines(const KernelOutput& kernel, const VariantOutput& variant);
/// "cs_6_0".
std::string hlslProfile(Stage stage);

/// reflection.json: the contents of the outputs, without the code.
std::string emitReflection(const Program& program);

}  // namespace pelage::codegen
