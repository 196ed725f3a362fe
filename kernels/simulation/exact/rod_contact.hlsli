// Contact of vertices with spheres, tapered capsules and distance fields.
#ifndef PELAGE_SIMULATION_EXACT_ROD_CONTACT_HLSLI
#define PELAGE_SIMULATION_EXACT_ROD_CONTACT_HLSLI

#include "../../common/colliders.hlsli"
#include "rod_state.hlsli"

#if SDF
#define SDF_KEYS g_fieldKeys
#define SDF_SURFACE g_fieldSurface
#include "../../sdf/sdf_strand_contact.hlsli"
#endif

// Contact stiffness over the vertex's weight am. At 1e4 and above strands jitter; at 10 they sink
// in by more than 0.05 mm.
static const float kContactStiffness = 30.0;
// Greatest stiffness of friction over am: a strand that sticks creeps by a 300th of a free slip.
static const float kFrictionStiffness = 300.0;
// Friction acts up to this share of the vertex's region outside the surface, because a vertex that
// rests on it is on either side by rounding.
static const float kFrictionReach = 0.05;

#if COLLIDERS
// In the part of the frame that is in this sub-step.
Contact contactWith(uint collider, float3 p) {
  return findContact(g_exactColliders[collider], p, g_rootBegin, g_rootEnd);
}
#endif

#if SDF
// Where the vertex was that has been carried to p.
float3 uncarried(Carry carry, float3 p) {
#if VELOCITY_SHOCK_PROPAGATION
  precise float3 r = rotate(conjugate(carry.now.rotation), p - carry.now.shift);
  return r;
#else
  return p;
#endif
}

// As contactWith(). Ways are relative to what the vertex was carried by, and so is the surface's.
//
// \param carriedBefore  where the vertex was, carried
Contact contactWithField(uint field, Carry carry, float3 carriedBefore, float3 p, float reach) {
  float3 before = uncarried(carry, carriedBefore);
  Contact contact =
      findFieldContact(g_exactFields[field], before, p, g_rootBegin, g_rootEnd, reach);
  precise float3 surfaceMotion = contact.surfaceMotion - (carriedBefore - before);
  contact.surfaceMotion = surfaceMotion;
  return contact;
}
#endif

// The frame of an edge from `start`, turned so that its end is out of the colliders.
//
// \param carriedBefore  where its end was, carried
float4 keepOut(float3 start, float4 frame, float edgeLength, Carry carry, float3 carriedBefore) {
  float3 tangent = axisX(frame);
  precise float least = 1e-12 * edgeLength * edgeLength;
  precise float3 direction = tangent;
  bool touched = false;
  // Twice; some compilers would unroll a loop over a constant, with all that is in it.
  uint rounds = min(g_colliderCount + 1u, 1u) + 1u;
  for (uint round = 0; round < rounds; ++round) {
    precise float3 end = start + direction * edgeLength;
#if COLLIDERS
    for (uint c = 0; c < g_colliderCount; ++c) {
      Contact contact = contactWith(c, end);
      if (contact.penetration > 0.0) {
        end = end + contact.normal * contact.penetration;
        touched = true;
      }
    }
#endif
#if SDF
    bool onField = false;
    float3 plane = float3(0.0, 0.0, 0.0);
    for (uint f = 0; f < g_fieldCount; ++f) {
      Contact contact = contactWithField(f, carry, carriedBefore, end, 0.0);
      if (contact.penetration > 0.0) {
        end = end + contact.normal * contact.penetration;
        touched = true;
        onField = true;
        plane = contact.normal;
      }
    }
#endif
    if (!touched) return frame;
    precise float3 aim = end - start;
#if SDF
    if (onField) aim = fitAlongPlane(aim, plane, edgeLength);
#endif
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
