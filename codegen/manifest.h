// The manifest: every kernel with its permutations, and every layout. docs: codegen/README.md.
#pragma once

#include <compare>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "codegen/diagnostics.h"
#include "pelage/layout.h"
#include "pelage/tier.h"

namespace pelage::codegen {

/// A property with several values, for each of which a kernel is compiled. The macro is the name in
/// capitals: globalShape is GLOBAL_SHAPE.
struct Axis {
  std::string name;
  bool isBool = true;
  std::vector<int32_t> values{0, 1};  ///< the first one is the default
};

/// Values of all axes, in their order. One compiled variant.
using Permutation = std::vector<int32_t>;

/// An axis, as an index, and one of its values.
using AxisValue = std::pair<uint32_t, int32_t>;

/// The buffer that a vertex kernel's inputs come from.
struct ManifestVertexInput {
  uint32_t stride = 0;  ///< bytes
  bool perInstance = false;
  std::vector<uint32_t> offsets;  ///< bytes; by location, from 0 on
};

/// The permutations for which all conditions hold need a higher tier.
struct TierRule {
  std::vector<AxisValue> conditions;
  Tier tier = Tier::kBase;
};

/// The permutations for which all conditions hold, all of them without conditions, do not run on
/// WebGPU.
struct WebgpuException {
  std::vector<AxisValue> conditions;
  std::string why;
};

struct ManifestKernel {
  std::string name;
  std::string file;  ///< relative to the manifest
  Stage stage = Stage::kCompute;
  uint32_t group = 0;  ///< index into Manifest::groups
  std::vector<Axis> axes;
  /// A permutation for which all conditions of one entry hold does not exist.
  std::vector<std::vector<AxisValue>> excludes;
  std::vector<std::vector<AxisValue>> conflicts;  ///< the excludes that no key may request
  std::optional<ManifestVertexInput> vertexInput;
  Tier tier = Tier::kBase;  ///< of the permutations without a rule
  std::vector<TierRule> tierRules;
  std::vector<WebgpuException> webgpuExceptions;
  bool precise = false;
  bool commutes = false;
  uint32_t line = 0;  ///< in the manifest

  bool isExcluded(const Permutation& permutation) const;
  bool isConflict(const Permutation& permutation) const;
  /// All combinations of the values of all axes; the last axis varies fastest.
  std::vector<Permutation> combinations() const;
  /// The combinations that are not excluded.
  std::vector<Permutation> permutations() const;
  Permutation defaultPermutation() const;
  /// The highest tier of the kernel and of the rules that hold.
  Tier tierOf(const Permutation& permutation) const;
  /// Why the permutation does not run on WebGPU; nullptr if it does.
  const std::string* whyNotWebgpu(const Permutation& permutation) const;
};

struct ManifestGroup {
  std::string name;
  std::vector<std::string> layouts;  ///< index = set
};

/// A file whose `static const` numbers become C++ constants.
struct ManifestConstants {
  std::string file;   ///< relative to the manifest
  std::string space;  ///< their C++ namespace in the manifest's one: the file's name
  uint32_t line = 0;
};

struct Manifest {
  std::string file;                         ///< name of the manifest, without its folder
  std::vector<std::string> namespaceParts;  ///< "a::b" is {"a", "b"}
  std::vector<ManifestGroup> groups;        ///< in the order of the file
  std::vector<ManifestConstants> constants;
  std::vector<ManifestKernel> kernels;
  bool webgpu = false;  ///< the kernels keep to kWebgpuLimits, but for their exceptions

  std::string namespaceName() const;    ///< "a::b"
  std::string namespaceFolder() const;  ///< "a/b"
  /// Whether the kernels of two groups can be the stages of one draw: layoutsFit() of kernel.h.
  bool groupsFit(uint32_t a, uint32_t b) const;
};

/// Reads a manifest. Its errors go into the diagnostics, under the file's name without its folder.
Manifest readManifest(const std::filesystem::path& path, Diagnostics& diagnostics);

/// "globalShape" -> "GLOBAL_SHAPE".
std::string macroName(const std::string& axis);
/// "wind=1 globalShape=0".
std::string permutationKey(const ManifestKernel& kernel, const Permutation& permutation);

}  // namespace pelage::codegen
