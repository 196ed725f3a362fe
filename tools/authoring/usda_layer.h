// Prims and attributes of a .usda file. OpenUSD, "USD File Formats: usda" and its grammar in
// pxr/usd/sdf (textFileFormat); references, payloads, sublayers and variants are not composed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/result.h"

namespace pelage::detail {

/// An attribute with its value. One of the four arrays has it, as the type says.
struct UsdaAttribute {
  enum class Numbers { kFloat, kDouble, kInteger, kText };

  std::string type;  ///< as in the file, without []
  Numbers numbers = Numbers::kFloat;
  uint32_t components = 1;  ///< numbers of an element: 3 for point3f, 16 for matrix4d
  bool isArray = false;
  uint64_t line = 0;  ///< of the declaration
  std::vector<float> floats;
  std::vector<double> doubles;
  std::vector<int64_t> integers;
  std::vector<std::string> texts;
  std::string interpolation;  ///< empty if the file does not say
  bool hasDefault = false;
  std::optional<double> time;  ///< of the time sample that is the value: the first one

  bool hasValue() const { return hasDefault || time.has_value(); }
  size_t elementCount() const {
    return (floats.size() + doubles.size() + integers.size() + texts.size()) / components;
  }
  /// A number of the value, whatever its type; texts have none.
  double number(size_t index) const {
    if (numbers == Numbers::kFloat) return double{floats[index]};
    return numbers == Numbers::kDouble ? doubles[index] : static_cast<double>(integers[index]);
  }
};

struct UsdaPrim {
  static constexpr uint32_t kNoParent = 0xffffffff;

  std::string name, type;
  uint32_t parent = kNoParent;
  uint64_t line = 0;
  bool defined = true;    ///< "def", and all of its parents
  bool active = true;     ///< and all of its parents
  bool composes = false;  ///< it has references, payloads, inherits, specializes or variants
  std::map<std::string, UsdaAttribute, std::less<>> attributes;
};

struct UsdaLayer {
  std::optional<double> metersPerUnit;
  std::string upAxis;  ///< empty if the file does not say
  bool hasSublayers = false;
  std::vector<UsdaPrim> prims;  ///< parents before their children

  /// "/root/hair"
  std::string pathOf(uint32_t prim) const;
};

/// Reads a layer. \param wanted  decides, by the type of a prim and the name of an attribute, which
/// values are kept; the others are skipped. Errors name the file, the line and the prim: text that
/// is no .usda, values that do not fit their type, prims nested deeper than 128, brackets nested
/// deeper than 64.
Result<UsdaLayer> readUsda(
    std::span<const std::byte> bytes, std::string_view name,
    const std::function<bool(std::string_view primType, std::string_view attribute)>& wanted);

}  // namespace pelage::detail
