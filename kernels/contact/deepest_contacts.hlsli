// Finds the deepest contacts of a swept vertex with the colliders of an object.
//
// The including file defines CONTACT_CAPSULE(c), CONTACT_CAPSULE_COUNT, CONTACT_SDF(f) and
// CONTACT_SDF_COUNT; CONTACT_SDF_MOTION(f, sdf, p), about how the SDF moves in the frame near p [m],
// where it is too far to be asked for it; CONTACT_LOOKS, 2 if a fast vertex may go further than predicted, else 1;
// CONTACT_RESTS, as in sweepCapsule(); and with SDF also
// SDF_KEYS and SDF_SURFACE.
#ifndef PELAGE_CONTACT_DEEPEST_CONTACTS_HLSLI
#define PELAGE_CONTACT_DEEPEST_CONTACTS_HLSLI

#include "colliders.hlsli"
#include "layouts/contact_records.hlsli"
#if SDF
#define SDF_FACING 1
#define SDF_DENSE DENSE_SDF
#include "../sdf/sdf_collision.hlsli"

// Returns the contact of a vertex with an SDF, in the form of the other colliders.
//
// A swept vertex gets the plane at which its path meets the surface. A solver that lets it continue
// along the plane queries again from its previous position.
//
// \param before      position of the vertex at the start of the sub-step
// \param begin, end  the part of the frame that is in the sub-step, 0..1
// \param range       a vertex within this distance of the surface has a contact [m]
// \param guess       as in sdfContact()
Contact findSdfContact(Sdf sdf, float3 before, float3 p, float begin, float end, float range,
                       float3 guess) {
  SdfContact found = sdfContact(sdf, before, p, begin, end, range, guess);
  precise float cell = sdf.origin.w;
  precise float penetration = found.penetration * cell;
  precise float3 surfaceMotion = found.motion * ((end - begin) * cell);
  Contact contact;
  contact.normal = found.normal;
  contact.penetration = found.found ? penetration : -1e18;
  contact.surfaceMotion = surfaceMotion;
  contact.friction = sdf.friction;
  return contact;
}
#endif

// Displacements longer than this may cross a thin part [m].
static const float kLeap = 0.01;

struct Found {
  Contact contact;
  uint collider;
};

// A vertex over a part of the frame. Positions are relative to the colliders' origin [m].
struct SweptVertex {
  float3 from;
  float3 to;
  float3 relative;  // displacement against the strand's root
  float3 root;      // displacement of the strand's root
  float begin;      // of the part, 0..1
  float end;
  float range;  // a vertex within this distance of a surface has a contact [m]; further for one
                // that moves against the root:
  float share;  // by this share of its displacement
};

Found nothingFound() {
  Found found;
  found.contact.normal = float3(0.0, 0.0, 0.0);
  found.contact.penetration = -1e18;
  found.contact.surfaceMotion = float3(0.0, 0.0, 0.0);
  found.contact.friction = 0.0;
  found.collider = kContactCollider;
  return found;
}

// Returns the distance within which a vertex has a contact with a surface that moves by so much.
float rangeOf(SweptVertex vertex, float3 surfaceMotion) {
  precise float3 against = surfaceMotion - vertex.root;
  precise float range = vertex.range + vertex.share * squareRoot(dot3(against, against));
  return range;
}

// Bounds of a vertex for all capsules.
struct CapsuleReach {
  float path;  // length [m]
  float range;
};

CapsuleReach capsuleReach(SweptVertex vertex) {
  precise float3 displacement = vertex.to - vertex.from;
  precise float range = vertex.range + vertex.share * squareRoot(dot3(vertex.root, vertex.root));
  CapsuleReach reach;
  reach.path = squareRoot(dot3(displacement, displacement));
  reach.range = range;
  return reach;
}

// Returns true if a collider may be in range.
bool mayCollide(SweptVertex vertex) {
  CapsuleReach reach = capsuleReach(vertex);
  bool may = false;
  for (uint c = 0; c < CONTACT_CAPSULE_COUNT && !may; ++c) {
    may = mayTouchCapsule(CONTACT_CAPSULE(c), vertex.to, reach.path, vertex.end, reach.range,
                          vertex.share);
  }
#if SDF
  for (uint f = 0; f < CONTACT_SDF_COUNT && !may; ++f) {
    Sdf sdf = CONTACT_SDF(f);
    float3 motion = CONTACT_SDF_MOTION(f, sdf, vertex.to);
    float range = rangeOf(vertex, motion * (vertex.end - vertex.begin));
    may = sdfMayBeInRange(sdf, vertex.from, vertex.to, vertex.relative,
                          float2(vertex.begin, vertex.end), range, motion);
  }
#endif
  return may;
}

void keepDeepest(Found found, float range, inout Found first, inout Found second) {
  float depth = found.contact.penetration;
  if (depth > -range && depth > first.contact.penetration) {
    second = first;
    first = found;
  } else if (depth > -range && depth > second.contact.penetration) {
    second = found;
  }
}

// \param first, second  deepest first; kContactCollider where there is none
void findDeepest(SweptVertex vertex, out Found first, out Found second) {
  first = nothingFound();
  second = nothingFound();
  CapsuleReach reach = capsuleReach(vertex);
  for (uint c = 0; c < CONTACT_CAPSULE_COUNT; ++c) {
    Collider capsule = CONTACT_CAPSULE(c);
    if (mayTouchCapsule(capsule, vertex.to, reach.path, vertex.end, reach.range, vertex.share)) {
      Found found;
      found.contact =
          sweepCapsule(capsule, vertex.from, vertex.to, vertex.begin, vertex.end, CONTACT_RESTS);
      found.collider = min(c, kContactSdf - 1u);
      keepDeepest(found, rangeOf(vertex, found.contact.surfaceMotion), first, second);
    }
  }
#if SDF
  for (uint f = 0; f < CONTACT_SDF_COUNT; ++f) {
    Found found;
    // A fast vertex may go further than predicted, and end behind a thin part: query a second time,
    // as far again. (One call, because compilers copy the query to every call.)
    Sdf sdf = CONTACT_SDF(f);
    float3 motion = CONTACT_SDF_MOTION(f, sdf, vertex.to);
    float range = rangeOf(vertex, motion * (vertex.end - vertex.begin));
    precise float3 displacement = vertex.to - vertex.from;
    precise float3 further = float3(0.0, 0.0, 0.0);
    [loop] for (uint look = 0; look < CONTACT_LOOKS; ++look) {
      found.contact = findSdfContact(sdf, vertex.from, vertex.to + further, vertex.begin,
                                     vertex.end, range, motion);
      precise float depth = found.contact.penetration + dot3(further, found.contact.normal);
      found.contact.penetration = depth;
      if (found.contact.penetration > -range || dot3(displacement, displacement) <= kLeap * kLeap)
        break;
      further = displacement;
    }
    found.collider = kContactSdf | min(f, kContactSdf - 2u);
    keepDeepest(found, range, first, second);
  }
#endif
}

#endif
