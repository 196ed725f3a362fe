// The numbers of a light: which are wrong, and what kernels take of them.
#pragma once

#include <cstdint>
#include <string>

#include "pelage/constants.h"
#include "pelage/light.h"
#include "pelage/types.h"

namespace pelage::detail {

inline constexpr uint32_t kMinShadowSize = 4;  ///< of a map [texels]
inline constexpr uint32_t kMaxShadowSize = strand_shadow_view::kMaxShadowSize;
inline constexpr uint32_t kMaxShadowLayers = strand_shadow_view::kMaxShadowLayers;

/// Name of the first field of a light's cone and shadows that is out of range; empty: none.
std::string numberFaultOf(const Light& light);
/// StrandLight.cone. \param axis unit vector towards the light.
Float4 coneOf(const Light& light, Float3 axis);

}  // namespace pelage::detail
