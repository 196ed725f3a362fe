// Contact of vertices with spheres and tapered capsules.
#ifndef PELAGE_SIMULATION_EXACT_ROD_CONTACT_HLSLI
#define PELAGE_SIMULATION_EXACT_ROD_CONTACT_HLSLI

#include "rod_state.hlsli"

// Contact stiffness over the vertex's weight am. At 1e4 and above strands jitter; at 10 they sink
// in by more than 0.05 mm.
static const float kContactStiffness = 30.0;
// Greatest stiffness of friction over am: a strand that sticks creeps by a 300th of a free slip.
static const float kFrictionStiffness = 300.0;
// Friction acts up to this share of the vertex's region outside the surface, because a vertex that
// rests on it is on either side by rounding.
static const float kFrictionReach = 0.05;

struct Contact {
  float3 normal;         // unit, out of the collider
  float penetration;     // [m]; negative outside
  float3 surfaceMotion;  // of the collider at the contact, in this sub-step [m]
  float friction;
};

// Distance to the union of the spheres between two ends: the minimum over t of |p - c(t)| - r(t).
// With z along the axis of length L and d from it, the derivative vanishes where
// z - t L = d k / sqrt(1 - k^2), k = (r0 - r1) / L. For k outside -1..1 one end holds the other.
Contact findContact(ExactCollider shape, float3 p) {
  float3 headBefore = shape.headBefore.xyz;
  float3 tailBefore = shape.tailBefore.xyz;
  precise float3 headWay = shape.head.xyz - headBefore;
  precise float3 tailWay = shape.tail.xyz - tailBefore;
  precise float3 headTo = headBefore + headWay * g_rootEnd;
  precise float3 tailTo = tailBefore + tailWay * g_rootEnd;
  precise float3 headFrom = headBefore + headWay * g_rootBegin;
  precise float3 tailFrom = tailBefore + tailWay * g_rootBegin;
  precise float3 axis = tailTo - headTo;
  precise float3 arm = p - headTo;
  precise float squared = dot3(axis, axis);
  precise float taper = shape.head.w - shape.tail.w;
  precise float taper2 = taper * taper;
  precise float t = taper >= 0.0 ? 0.0 : 1.0;
  if (squared > taper2 && squared > 1e-16) {
    precise float along = dot3(arm, axis) / squared;
    precise float3 off = arm - axis * along;
    precise float wide = squareRoot(dot3(off, off)) * taper;
    precise float shift = wide / squareRoot(squared * max(squared - taper2, 1e-16));
    precise float place = along - shift;
    t = min(max(place, 0.0), 1.0);
  }
  precise float3 center = headTo + axis * t;
  precise float3 outward = p - center;
  float distance = squareRoot(max(dot3(outward, outward), 1e-20));
  precise float3 normal = outward * (1.0 / distance);
  precise float penetration = shape.head.w - taper * t - distance;
  precise float3 before = headFrom + (tailFrom - headFrom) * t;
  precise float3 surfaceMotion = center - before;
  Contact contact;
  contact.normal = normal;
  contact.penetration = penetration;
  contact.surfaceMotion = surfaceMotion;
  contact.friction = shape.headBefore.w;
  return contact;
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
      Contact contact = findContact(g_exactColliders[c], end);
      if (contact.penetration > 0.0) {
        end = end + contact.normal * contact.penetration;
        touched = true;
      }
    }
    precise float3 aim = end - start;
    precise float squared = dot3(aim, aim);
    if (squared > least) {
      float inverse = inverseRoot(max(squared, 1e-20));
      direction = aim * inverse;
    }
  }
  if (!touched) return frame;
  precise float scalar = max(1.0 + dot3(tangent, direction), 1e-4);
  float4 turn = normalizeProduct(float4(cross3(tangent, direction), scalar));
  return normalizeProduct(multiplyQuaternions(turn, frame));
}

#endif
