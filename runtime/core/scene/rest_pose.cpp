// HairObject::setRestPose(): another groom for hair that goes on as it is.
#include <bit>
#include <memory>
#include <string>
#include <utility>

#include "scene/hair_internals.h"
#include "shadow/strand_shadow.h"

namespace pelage {

namespace {

bool sameBits(const Float4& a, const Float4& b) {
  const auto bits = [](float value) { return std::bit_cast<uint32_t>(value); };
  return bits(a.x) == bits(b.x) && bits(a.y) == bits(b.y) && bits(a.z) == bits(b.z);
}

}  // namespace

namespace detail {

void setRestData(RestPose& rest, std::shared_ptr<const HairAsset> asset) {
  rest.longestStrand = longestStrand(*asset);
  rest.volume = static_cast<float>(hairVolume(asset->positions, asset->verticesPerStrand));
  double lengths = 0;
  for (const float length : asset->restLengths) lengths += static_cast<double>(length);
  rest.meanStrand = static_cast<float>(lengths / static_cast<double>(asset->strandCount));
  rest.asset = std::move(asset);
}

}  // namespace detail

Result<void> HairObject::setRestPose(std::span<const Float4> positions) {
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, "hair '" + name_ + "': setRestPose(): " + what};
  };
  detail::HairInternals& hair = *internals_;
  const HairAsset& old = *hair.rest.asset;
  if (positions.size() != old.positions.size()) {
    return refuse("got " + std::to_string(positions.size()) + " positions, but " +
                  std::to_string(guideCount_) + " guides of " + std::to_string(vertexCount_) +
                  " vertices have " + std::to_string(old.positions.size()));
  }
  bool same = true;
  for (size_t i = 0; i < positions.size() && same; ++i)
    same = sameBits(positions[i], old.positions[i]);
  if (same) return {};
  auto changed = std::make_shared<HairAsset>(old);
  for (size_t i = 0; i < positions.size(); ++i) {
    const Float4& p = positions[i];
    changed->positions[i] = {p.x, p.y, p.z, old.positions[i].w};
  }
  if (Result<void> processed = changed->process(); !processed)
    return refuse(processed.error().message);
  changed->vertexThickness = old.vertexThickness;
  setRestData(hair.rest, std::move(changed));
  hair.bounds = detail::boundsOfRoots(*hair.rest.asset, hair.groom.influences);
  ++hair.rest.version;
  return {};
}

}  // namespace pelage
