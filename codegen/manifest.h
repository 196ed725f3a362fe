// The manifest: every kernel with its permutations, and every layout. docs: codegen/README.md.
#pragma once

#include <compare>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "codegen/diagnostics.h"
#include "pelage/layout.h"

namespace pelage::codegen {

/// Something that a kernel is compiled with several values of. The macro is the name in capitals:
/// globalShape is GLOBAL_SHAPE.
struct Axis {
  std::string name;
  bool isBool = true;
  std::vector<int32_t> values{0, 1};  ///< the first one is the default
};

/// Values of all axes, in their order. One compiled variant.
using Permutation = std::vector<int32_t>;

/// An axis, as an index, and one of its values.
using AxisValue = std::pair<uint32_t, int32_t>;

struct ManifestKernel {
  std::string name;
  std::string file;  ///< relative to the manifest
  Stage stage = Stage::kCompute;
  uint32_t group = 0;  ///< index into Manifest::groups
  std::vector<Axis> axes;
  /// A permutation for which all conditions of one of them hold does not exist.
  std::vector<std::vector<AxisValue>> excludes;
  std::vector<std::vector<AxisValue>> conflicts;  ///< the excludes that no key may ask for
  bool desktopTier = false;
  bool precise = false;
  uint32_t line = 0;  ///< in the manifest

  bool isExcluded(const Permutation& permutation) const;
  bool isConflict(const Permutation& permutation) const;
  /// Every value of every axis with every other; the last axis varies fastest.
  std::vector<Permutation> combinations() const;
  /// The combinations that are not excluded.
  std::vector<Permutation> permutations() const;
  Permutation defaultPermutation() const;
};

struct ManifestGroup {
  std::string name;
  std::vector<std::string> layouts;  ///< index = set
  uint32_t line = 0;
};

struct Manifest {
  std::string file;                         ///< name of the manifest, without its folder
  std::vector<std::string> namespaceParts;  ///< "a::b" is {"a", "b"}
  std::vector<ManifestGroup> groups;        ///< in the order of the file
  std::vector<ManifestKernel> kernels;

  std::string namespaceName() const;    ///< "a::b"
  std::string namespaceFolder() const;  ///< "a/b"
};

/// Reads a manifest. Everything that is wrong with it goes into the diagnostics, under the file's
/// name without its folder.
Manifest readManifest(const std::filesystem::path& path, Diagnostics& diagnostics);

/// "globalShape" -> "GLOBAL_SHAPE".
std::string macroName(const std::string& axis);
/// "wind=1 globalShape=0".
std::string permutationKey(const ManifestKernel& kernel, const Permutation& permutation);

}  // namespace pelage::codegen
