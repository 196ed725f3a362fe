// The follow hair that is most like a given hair.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pelage/hair_asset.h"
#include "pelage/types.h"

namespace pelage::detail {

/// Most guides that fitFollowHair() chooses among.
inline constexpr size_t kMaxCandidates = 8;

/// A guide that a hair may follow.
struct Candidate {
  uint32_t guide = 0;              ///< as FollowHair has it
  const Float4* strand = nullptr;  ///< its vertices
};

/// A hair that copies one guide, parallel, with its root where that of `strand` is.
FollowHair copyGuide(std::span<const Float4> strand, const Candidate& guide);

/// Least squares over all choices of at most `guidesPerHair` (1..3) of at most kMaxCandidates
/// guides, their weights and the factor at the tip; the root is that of `strand`.
FollowHair fitFollowHair(std::span<const Float4> strand, std::span<const Candidate> guides,
                         uint32_t guidesPerHair);

/// Vertices of a follow hair at rest, as the kernel update_follow_hairs places them. `strandOf`
/// gives the vertices of a guide. The weights are valid.
template <class StrandOf>
void evaluateFollowHair(const FollowHair& hair, uint32_t vertexCount, const StrandOf& strandOf,
                        Float4* out);

struct GuideShares {
  uint32_t guides[3] = {};
  float shares[3] = {};
  uint32_t first = 0;  ///< the guide whose inverse masses hold
};
/// Shares of the guides, as the kernel takes them.
GuideShares sharesOf(const FollowHair& hair);
Float4 evaluateFollowVertex(const FollowHair& hair, const GuideShares& shares,
                            const Float4* const (&strands)[3], uint32_t vertex,
                            uint32_t vertexCount);

template <class StrandOf>
void evaluateFollowHair(const FollowHair& hair, uint32_t vertexCount, const StrandOf& strandOf,
                        Float4* out) {
  const GuideShares shares = sharesOf(hair);
  const Float4* const strands[3] = {strandOf(shares.guides[0]), strandOf(shares.guides[1]),
                                    strandOf(shares.guides[2])};
  for (uint32_t v = 0; v < vertexCount; ++v)
    out[v] = evaluateFollowVertex(hair, shares, strands, v, vertexCount);
}

}  // namespace pelage::detail
