// Contact of vertices with spheres and tapered capsules.
#ifndef PELAGE_SIMULATION_EXACT_ROD_CONTACT_HLSLI
#define PELAGE_SIMULATION_EXACT_ROD_CONTACT_HLSLI

#include "../../common/colliders.hlsli"
#include "rod_state.hlsli"

// Contact stiffness over the vertex's weight am. At 1e4 and above strands jitter; at 10 they sink
// in by more than 0.05 mm.
static const float kContactStiffness = 30.0;
// Greatest stiffness of friction over am: a strand that sticks creeps by a 300th of a free slip.
static const float kFrictionStiffness = 300.0;
// Friction acts up to this share of the vertex's region outside the surface, because a vertex that
// rests on it is on either side by rounding.
static const float kFrictionReach = 0.05;

// In the part of the frame that is in this sub-step.
Contact contactWith(uint collider, float3 p) {
  return findContact(g_exactColliders[collider], p, g_rootBegin, g_rootEnd);
}

// The frame of an edge from `start`, turned so that its end is out of the colliders.
float4 keepOut(float3 start, float4 frame, float edgeLength) {
  float3 tangent = axisX(frame);
  precise float least = 1e-12 * edgeLength * edgeLength;
  precise float3 direction = tangent;
  bool touched = false;
  for (uint round = 0; round < 2; ++round) {
    precise float3 end = start + direction * edgeLength;
    for (uint c = 0; c < g_colliderCount; ++c) {
      Contact contact = contactWith(c, end);
      if (contact.penetration > 0.0) {
        end = end + contact.normal * contact.penetration;
        touched = true;
      }
    }
    if (!touched) return frame;
    precise float3 aim = end - start;
    precise float squared = dot3(aim, aim);
    if (squared > least) {
      float inverse = inverseRoot(max(squared, 1e-20));
      direction = aim * inverse;
    }
  }
  precise float scalar = max(1.0 + dot3(tangent, direction), 1e-4);
  float4 turn = normalizeProduct(float4(cross3(tangent, direction), scalar));
  return normalizeProduct(multiplyQuaternions(turn, frame));
}

#endif
