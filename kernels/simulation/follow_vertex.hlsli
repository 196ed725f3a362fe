// Computes a vertex of a follow hair from those of its guides; no resources. The including file
// first defines:
//   float4 guidePosition(uint guide, uint vertex)  [m]; w = inverse mass
//   float3 guideTangent(uint guide, uint vertex)
//   float4 guideRotation(uint guide)               of the root relative to the bind pose
//
// A vertex is the weighted mean of its guides' vertices plus the offset, rotated by the first
// guide's root relative to the bind pose. The offset starts at the mean of the guides' roots, so
// that follow hairs keep their position on a scalp that moves and rotates. Its length is linear
// from 1 at the root to the separation at the tip:
//   s(v) = 1 + (offset.w * tipSeparation - 1) v / (V - 1)
// The tangent is the direction from the previous to the next vertex, as for guides.
#ifndef PELAGE_SIMULATION_FOLLOW_VERTEX_HLSLI
#define PELAGE_SIMULATION_FOLLOW_VERTEX_HLSLI

#include "layouts/follow.hlsli"
#include "../base/quaternion.hlsli"

// The contributions of a strand's guides to one vertex.
struct GuideVertex {
  float4 rotation;  // of the first guide's root
  float4 position;  // w: inverse mass of the first guide
  float3 before;    // at the vertex before, or this one
  float3 after;     // at the vertex after, or this one
  float3 tangent;   // of the first guide
  bool known;       // there is a guide
};

struct FollowVertex {
  float3 position;
  float3 tangent;
};

float followWeight(uint guide, uint guideCount, float weight) {
  return guide < guideCount && weight > 0.0 && weight < 1e18 ? weight : 0.0;
}

float3 addGuide(float3 sum, uint guide, uint vertex, float weight) {
  precise float3 r = sum;
  if (weight > 0.0) r = sum + guidePosition(guide, vertex).xyz * weight;
  return r;
}

// Returns the mean of three guides, of which at least one has a weight.
float3 meanPosition(uint4 guides, float3 weights, uint vertex) {
  float3 sum = addGuide(float3(0.0, 0.0, 0.0), guides.x, vertex, weights.x);
  sum = addGuide(sum, guides.y, vertex, weights.y);
  return addGuide(sum, guides.z, vertex, weights.z);
}

GuideVertex loadGuides(uint4 guides, float4 given, uint vertex, uint vertexCount, uint guideCount) {
  GuideVertex g;
  g.rotation = float4(0.0, 0.0, 0.0, 1.0);
  g.position = float4(0.0, 0.0, 0.0, 0.0);
  g.before = float3(0.0, 0.0, 0.0);
  g.after = float3(0.0, 0.0, 0.0);
  g.tangent = float3(0.0, 0.0, 0.0);
  uint before = max(vertex, 1u) - 1u;
  uint after = min(vertex + 1u, vertexCount - 1u);
  float3 weights = float3(followWeight(guides.x, guideCount, given.x),
                          followWeight(guides.y, guideCount, given.y),
                          followWeight(guides.z, guideCount, given.z));
  precise float sum = weights.x + weights.y + weights.z;
  g.known = sum > 0.0;
  if (!g.known) return g;
  uint first = guides.x;
  if (!(weights.x > 0.0)) first = weights.y > 0.0 ? guides.y : guides.z;
  g.position = guidePosition(first, vertex);
  g.before = guidePosition(first, before).xyz;
  g.after = guidePosition(first, after).xyz;
  // A single guide is copied; the bits of a mean of one could differ.
  if (sum > max(weights.x, max(weights.y, weights.z))) {
    precise float3 shares = weights / sum;
    g.position = float4(meanPosition(guides, shares, vertex), g.position.w);
    g.before = meanPosition(guides, shares, before);
    g.after = meanPosition(guides, shares, after);
  }
  g.tangent = guideTangent(first, vertex);
  g.rotation = guideRotation(first);
  return g;
}

// Returns the fraction of the offset's change from root to tip at a vertex.
float followAlong(uint vertex, uint vertexCount) {
  precise float r = float(vertex) / float(vertexCount - 1u);
  return r;
}

float3 shiftFollow(float3 p, float along, float3 offset, float separation) {
  precise float factor = 1.0 + (separation - 1.0) * along;
  precise float3 r = p + offset * factor;
  return r;
}

// \param given FollowHairRecord.offset, \param tipSeparation factor on its w.
FollowVertex followVertex(GuideVertex guides, float4 given, float tipSeparation, uint vertex,
                          uint vertexCount) {
  float along = followAlong(vertex, vertexCount);
  float alongBefore = followAlong(max(vertex, 1u) - 1u, vertexCount);
  float alongAfter = followAlong(min(vertex + 1u, vertexCount - 1u), vertexCount);
  float3 offset = rotate(guides.rotation, given.xyz);
  precise float separation = given.w * tipSeparation;
  FollowVertex r;
  r.position = shiftFollow(guides.position.xyz, along, offset, separation);
  precise float3 across = shiftFollow(guides.after, alongAfter, offset, separation) -
                          shiftFollow(guides.before, alongBefore, offset, separation);
  r.tangent = directionOr(across, guides.tangent);
  return r;
}

#endif
