// The motion of a drawn strand's vertices since the last frame. The including file has the layouts
// of group strandDepth.
//
// A vertex at p, that was at q in the last frame, has the clip coordinates
//   c = C (p, 1)   and had   c' = C' (q, 1)
// so that c - c' = C (p - q, 0) + (C - C') (q, 1). The sum of differences has no cancellation, and
// is exactly 0 where neither strand nor camera move. All terms are linear along a segment: what is
// interpolated with perspective is exact. A fragment at x [NDC] of a point with clip w, and w' in
// the last frame, moved by
//   x - x' = (c.xy - c'.xy - x (w - w')) / w'
// in normalized device coordinates.
#ifndef PELAGE_SHADING_STRAND_MOTION_HLSLI
#define PELAGE_SHADING_STRAND_MOTION_HLSLI

#include "../layouts/render.hlsli"
#include "../layouts/strand_depth.hlsli"
#include "../drawn_fiber.hlsli"
#include "motion_interface.hlsli"

float3 previousGuidePosition(uint guide, uint vertex) {
  return g_previousPositions[guide * g_renderVertexCount + vertex].xyz;
}

float3 addPreviousGuide(float3 sum, uint guide, uint vertex, float weight) {
  precise float3 r = sum;
  if (weight > 0.0) r = sum + previousGuidePosition(guide, vertex) * weight;
  return r;
}

float4 previousRotation(uint guide) {
  RootTransform root = g_renderRoots[g_previousRoots + guide];
  // The other half.
  if (!isPose(root.rotation, root.position.xyz))
    root = g_renderRoots[g_renderGuideCount - g_previousRoots + guide];
  float4 rotation = float4(0.0, 0.0, 0.0, 1.0);
  if (isPose(root.rotation, root.position.xyz)) rotation = normalizeQuaternion(root.rotation);
  return rotation;
}

// Returns where a follow hair that is not stored was: the steps are those of followVertex(), so
// that hair that has not moved has the same bits. There is a guide.
float3 previousFollow(uint strand, uint vertex) {
  FollowHairRecord follow = g_renderFollowHairRecords[strand - g_renderGuideCount];
  float3 weights = float3(followWeight(follow.guides.x, g_renderGuideCount, follow.weights.x),
                          followWeight(follow.guides.y, g_renderGuideCount, follow.weights.y),
                          followWeight(follow.guides.z, g_renderGuideCount, follow.weights.z));
  precise float sum = weights.x + weights.y + weights.z;
  uint first = follow.guides.x;
  if (!(weights.x > 0.0)) first = weights.y > 0.0 ? follow.guides.y : follow.guides.z;
  float3 mean = previousGuidePosition(first, vertex);
  if (sum > max(weights.x, max(weights.y, weights.z))) {
    precise float3 shares = weights / sum;
    mean = addPreviousGuide(float3(0.0, 0.0, 0.0), follow.guides.x, vertex, shares.x);
    mean = addPreviousGuide(mean, follow.guides.y, vertex, shares.y);
    mean = addPreviousGuide(mean, follow.guides.z, vertex, shares.z);
  }
  precise float separation = follow.offset.w * g_previousTipSeparation;
  return shiftFollow(mean, followAlong(vertex, g_renderVertexCount),
                     rotate(previousRotation(first), follow.offset.xyz), separation);
}

// Returns where a vertex was in the last frame; where it is now if one of the two is not finite: a
// vertex that is drawn at another one's position has no motion of its own.
// \param position of drawnFiber().
float3 previousPosition(uint strand, uint vertex, float3 position) {
  if (!finiteVertex(strand, vertex).known) return position;
  float3 previous = position;
  if (STRAND_EVALUATES_FOLLOWS && strand >= g_renderGuideCount)
    previous = previousFollow(strand, vertex);
  else
    previous = previousGuidePosition(strand, vertex);
  return dot(abs(previous), float3(1.0, 1.0, 1.0)) < 1e18 ? previous : position;
}

// Returns the change of clip x, y and w of a point that was at `previous`.
float3 clipMotion(float3 position, float3 previous) {
  float3 moved = position - previous;
  float4 from = float4(previous, 1.0);
  return float3(dot(g_worldToClip[0].xyz, moved) + dot(g_clipChange[0], from),
                dot(g_worldToClip[1].xyz, moved) + dot(g_clipChange[1], from),
                dot(g_worldToClip[3].xyz, moved) + dot(g_clipChange[2], from));
}

#endif
