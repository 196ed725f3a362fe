// Distance of a point from a sphere or a tapered capsule in motion.
#ifndef PELAGE_CONTACT_COLLIDERS_HLSLI
#define PELAGE_CONTACT_COLLIDERS_HLSLI

#include "layouts/contact_records.hlsli"
#include "../base/quaternion.hlsli"

struct Contact {
  float3 normal;         // unit, out of the collider
  float penetration;     // [m]; negative outside
  float3 surfaceMotion;  // of the collider at the contact, in this sub-step [m]
  float friction;        // Coulomb's coefficient
};

// Returns the distance to the union of the spheres between two ends: the minimum over t of |p -
// c(t)| - r(t). With z along the axis of length L and d from it, the derivative vanishes where z -
// t L = d k / sqrt(1 - k^2), k = (r0 - r1) / L. For k outside -1..1 one end contains the other.
//
// \param begin, end  the part of the collider's motion in this frame that is in the sub-step, 0..1
Contact findContact(Collider shape, float3 p, float begin, float end) {
  Contact contact;
  contact.normal = float3(0.0, 0.0, 0.0);
  contact.penetration = -1e18;
  contact.surfaceMotion = float3(0.0, 0.0, 0.0);
  contact.friction = 0.0;
  if (isUsable(shape.head) && isUsable(shape.tail) && isUsable(shape.headBefore) &&
      isUsable(shape.tailBefore.xyz) && isUsable(shape.spin.xyz)) {
    float3 headBefore = shape.headBefore.xyz;
    float3 tailBefore = shape.tailBefore.xyz;
    precise float3 headDisplacement = shape.head.xyz - headBefore;
    precise float3 tailDisplacement = shape.tail.xyz - tailBefore;
    precise float3 headTo = headBefore + headDisplacement * end;
    precise float3 tailTo = tailBefore + tailDisplacement * end;
    precise float3 headFrom = headBefore + headDisplacement * begin;
    precise float3 tailFrom = tailBefore + tailDisplacement * begin;
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
      precise float parameter = along - shift;
      t = min(max(parameter, 0.0), 1.0);
    }
    precise float3 center = headTo + axis * t;
    precise float3 outward = p - center;
    float distance = squareRoot(max(dot3(outward, outward), 1e-20));
    precise float3 normal = outward * (1.0 / distance);
    precise float penetration = shape.head.w - taper * t - distance;
    precise float3 before = headFrom + (tailFrom - headFrom) * t;
    precise float3 spinMotion =
        cross3(shape.spin.xyz, normal * (shape.head.w - taper * t)) * (end - begin);
    precise float3 surfaceMotion = center - before + spinMotion;
    contact.normal = normal;
    contact.penetration = penetration;
    contact.surfaceMotion = surfaceMotion;
    contact.friction = shape.headBefore.w;
  }
  return contact;
}

// Returns false if sweepCapsule() finds nothing within `range`, and `share` of the surface's
// displacement further, for a part of its cost.
//
// \param path  length of the path to p [m]
bool mayTouchCapsule(Collider shape, float3 p, float path, float end, float range, float share) {
  precise float3 headDisplacement = shape.head.xyz - shape.headBefore.xyz;
  precise float3 tailDisplacement = shape.tail.xyz - shape.tailBefore.xyz;
  precise float3 head = shape.headBefore.xyz + headDisplacement * end;
  precise float3 tail = shape.tailBefore.xyz + tailDisplacement * end;
  precise float3 axis = tail - head;
  precise float3 arm = p - head;
  precise float along = dot3(arm, axis) / max(dot3(axis, axis), 1e-16);
  precise float3 off = arm - axis * min(max(along, 0.0), 1.0);
  float radius = max(shape.head.w, shape.tail.w);
  precise float moved2 =
      max(dot3(headDisplacement, headDisplacement), dot3(tailDisplacement, tailDisplacement));
  precise float spun2 = dot3(shape.spin.xyz, shape.spin.xyz) * radius * radius;
  // At least the displacement of the surface, against which the path may be longer by as much.
  precise float surface = squareRoot(2.0 * (moved2 + spun2));
  // With room for rounding.
  precise float most = (radius + max(range + share * surface, path + surface)) * 1.001 + 1e-4;
  return !(dot3(off, off) > most * most);
}

// A sweep longer than this fraction of the smaller radius finds the first contact on its path.
static const float kSweepFrom = 0.25;
static const float kSweepContact = 1e-5;  // [m]
static const uint kSweepSteps = 16;

// Does the same as findContact() for a point that moves from `from` to `p`. If its path crosses the
// surface, the contact has the plane at the crossing.
//
// A point that is not outside at `from` is held on the side where it is then, if the surface faces
// away from the one nearest to p.
//
// \param rests  true: otherwise a point that lies on the surface at `from` is not swept
Contact sweepCapsule(Collider shape, float3 from, float3 p, float begin, float end, bool rests) {
  Contact last = (Contact)0;
  precise float3 start = p;
  precise float3 direction = float3(0.0, 0.0, 0.0);
  float size = 0.0;
  precise float s = 0.0;
  // One call of findContact(), because compilers copy it to every call: at the end of the path, and
  // from its start on.
  [loop] for (uint i = 0; i <= kSweepSteps; ++i) {
    Contact contact = findContact(shape, i == 0u ? p : start + direction * s, begin, end);
    if (i == 0u) {
      last = contact;
      // Relative to the surface, which is where it is in the end.
      start = from + last.surfaceMotion;
      precise float3 displacement = p - start;
      size = squareRoot(dot3(displacement, displacement));
      if (!(size > kSweepFrom * min(shape.head.w, shape.tail.w)) || last.penetration < -1e17) break;
      direction = displacement * (1.0 / max(size, 1e-20));
    } else {
      if (i == 1u) {
        float deepest = 0.0;
        if (rests && contact.penetration > -kSweepContact) deepest = -1e18;
        if (!(dot3(contact.normal, last.normal) > 0.0)) deepest = rests ? kSweepContact : 1e18;
        if (!(contact.penetration < deepest)) break;
      }
      if (contact.penetration > -kSweepContact) {
        precise float3 left = p - (start + direction * s);
        precise float penetration = contact.penetration - dot3(contact.normal, left);
        contact.penetration = penetration;
        contact.surfaceMotion = last.surfaceMotion;
        last = contact;
        break;
      }
      s = s - contact.penetration;
      if (!(s < size)) break;
    }
  }
  return last;
}

#endif
