// Vertices of strands for drawing. Follow hairs that are not stored are computed from their guides
// here, as update_follow_hairs computes those that are stored; no resources. The including file
// defines:
//   STRAND_POSITIONS, STRAND_VERTEX_COUNT
//   STRAND_FOLLOW_HAIRS, STRAND_ROOTS, STRAND_GUIDE_COUNT, STRAND_TIP_SEPARATION
//   STRAND_EVALUATES_FOLLOWS  true if the buffer of positions has only the guides, and follow hairs
//                             are computed here
// and, where tangents are needed, STRAND_TANGENTS.
#ifndef PELAGE_SHADING_DRAWN_STRAND_HLSLI
#define PELAGE_SHADING_DRAWN_STRAND_HLSLI

#include "../base/quaternion.hlsli"

struct DrawnVertex {
  float3 position;  // [m]
  float3 tangent;   // (0, 1, 0) without STRAND_TANGENTS
  bool known;       // false for a follow hair without a guide
};

float4 guidePosition(uint guide, uint vertex) {
  return STRAND_POSITIONS[guide * STRAND_VERTEX_COUNT + vertex];
}

float3 storedTangent(uint strand, uint vertex) {
#ifdef STRAND_TANGENTS
  return STRAND_TANGENTS[strand * STRAND_VERTEX_COUNT + vertex].xyz;
#else
  return float3(0.0, 1.0, 0.0);
#endif
}

float3 guideTangent(uint guide, uint vertex) { return storedTangent(guide, vertex); }

float4 guideRotation(uint guide) {
  RootTransform root = STRAND_ROOTS[guide];
  if (!isPose(root.rotation, root.position.xyz)) root = STRAND_ROOTS[STRAND_GUIDE_COUNT + guide];
  float4 rotation = float4(0.0, 0.0, 0.0, 1.0);
  if (isPose(root.rotation, root.position.xyz)) rotation = normalizeQuaternion(root.rotation);
  return rotation;
}

#include "../simulation/follow_vertex.hlsli"

// \param vertex < STRAND_VERTEX_COUNT.
DrawnVertex drawnVertex(uint strand, uint vertex) {
  DrawnVertex drawn;
  drawn.position = float3(0.0, 0.0, 0.0);
  drawn.tangent = float3(0.0, 1.0, 0.0);
  drawn.known = true;
  if (STRAND_EVALUATES_FOLLOWS && strand >= STRAND_GUIDE_COUNT) {
    FollowHairRecord follow = STRAND_FOLLOW_HAIRS[strand - STRAND_GUIDE_COUNT];
    GuideVertex guides =
        loadGuides(follow.guides, follow.weights, vertex, STRAND_VERTEX_COUNT, STRAND_GUIDE_COUNT);
    drawn.known = guides.known;
    if (!guides.known) return drawn;
    FollowVertex evaluated =
        followVertex(guides, follow.offset, STRAND_TIP_SEPARATION, vertex, STRAND_VERTEX_COUNT);
    drawn.position = evaluated.position;
    drawn.tangent = evaluated.tangent;
    return drawn;
  }
  drawn.position = STRAND_POSITIONS[strand * STRAND_VERTEX_COUNT + vertex].xyz;
  drawn.tangent = storedTangent(strand, vertex);
  return drawn;
}

#endif
