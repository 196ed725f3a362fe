// The contract's enumerators as words: "storageBuffer" for ResourceKind::kStorageBuffer.
#pragma once

#include <string>

#include "codegen/reflect.h"
#include "pelage/layout.h"
#include "pelage/tier.h"

namespace pelage::codegen {

const char* word(ResourceKind kind);
const char* word(Access access);
const char* word(Stage stage);
inline const char* word(Tier tier) { return tierName(tier); }
/// The name in HLSL; "" for kOther.
const char* word(ScalarType type);

/// "kStorageBuffer".
template <class Enum>
std::string enumerator(Enum value) {
  std::string name = word(value);
  name[0] = static_cast<char>(name[0] - 'a' + 'A');
  return "k" + name;
}

}  // namespace pelage::codegen
