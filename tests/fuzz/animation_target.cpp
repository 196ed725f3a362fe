#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "pelage/authoring/animation.h"
#include "targets.h"

namespace pelage::fuzz {
namespace {

std::string faultOf(const AnimationKeys& keys, size_t components) {
  const size_t perKey = components * (keys.interpolation == KeyInterpolation::kCubic ? 3u : 1u);
  if (keys.values.size() != keys.times.size() * perKey) return "keys and times do not fit together";
  float before = -1;
  for (const float time : keys.times) {
    if (!(time > before) || !(time >= 0) || !std::isfinite(time)) return "times do not ascend";
    before = time;
  }
  for (const float value : keys.values)
    if (!std::isfinite(value)) return "a key is not finite";
  return {};
}

// The first promise of loadAnimation() that a clip breaks; empty if there is none.
std::string faultOf(const SkeletonAnimation& animation) {
  bool moves = false;
  float last = 0;
  for (size_t i = 0; i < animation.nodes.size(); ++i) {
    const AnimatedNode& node = animation.nodes[i];
    if (node.parent < -1 || node.parent >= static_cast<int32_t>(i)) return "a parent is not below";
    for (const auto& [keys, components] :
         {std::pair(&node.translations, size_t{3}), std::pair(&node.rotations, size_t{4}),
          std::pair(&node.scales, size_t{3})}) {
      if (std::string fault = faultOf(*keys, components); !fault.empty()) return fault;
      if (keys->times.empty()) continue;
      moves = true;
      last = std::max(last, keys->times.back());
    }
  }
  if (!moves) return "the clip moves nothing";
  return animation.seconds == static_cast<double>(last) ? "" : "seconds is not the last key's time";
}

}  // namespace

Outcome animation(std::span<const std::byte> bytes) {
  const auto loaded = loadAnimation(bytes, kName);
  if (!loaded) return refused(loaded.error());
  if (std::string fault = faultOf(*loaded); !fault.empty()) return broken(std::move(fault));
  const Skeleton skeleton = skeletonOf(*loaded);
  if (skeleton.bones.size() != loaded->nodes.size()) return broken("a node has no bone");
  for (const double seconds : {-1.0, 0.0, 0.3, loaded->seconds, loaded->seconds / 2, 1e300})
    if (poseAt(*loaded, seconds).size() != skeleton.bones.size())
      return broken("a node has no transform");
  return {true, {}};
}

}  // namespace pelage::fuzz
