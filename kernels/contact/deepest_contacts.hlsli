// The deepest contacts of a swept vertex with the colliders of an object.
//
// The file that includes it defines CONTACT_CAPSULES, CONTACT_CAPSULE_COUNT, CONTACT_FIELDS and
// CONTACT_FIELD_COUNT; CONTACT_LOOKS, 2 where a fast vertex may go further than expected, else 1;
// CONTACT_RESTS, as in sweepCapsule(); and with SDF what sdf_strand_contact.hlsli wants.
#ifndef PELAGE_CONTACT_DEEPEST_CONTACTS_HLSLI
#define PELAGE_CONTACT_DEEPEST_CONTACTS_HLSLI

#include "../common/colliders.hlsli"
#include "../layouts/contact_records.hlsli"
#if SDF
#define SDF_FACING 1
#include "../sdf/sdf_strand_contact.hlsli"
#endif

// Displacements from this on may lead through something thin [m].
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
  float begin;      // of the part, 0..1
  float end;
  float reach;      // what is this far from a surface has a contact, too [m]
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

// True when a collider may be within reach.
bool mayTouch(SweptVertex vertex) {
  for (uint c = 0; c < CONTACT_CAPSULE_COUNT; ++c) {
    Contact contact =
        sweepCapsule(CONTACT_CAPSULES[c], vertex.from, vertex.to, vertex.begin, vertex.end,
                     CONTACT_RESTS);
    if (contact.penetration > -vertex.reach) return true;
  }
#if SDF
  for (uint f = 0; f < CONTACT_FIELD_COUNT; ++f) {
    if (sdfMayReach(CONTACT_FIELDS[f], vertex.from, vertex.to, vertex.relative, vertex.end,
                    vertex.reach))
      return true;
  }
#endif
  return false;
}

void keepDeepest(Found found, float reach, inout Found first, inout Found second) {
  float depth = found.contact.penetration;
  if (!(depth > -reach)) return;
  if (depth > first.contact.penetration) {
    second = first;
    first = found;
  } else if (depth > second.contact.penetration) {
    second = found;
  }
}

// \param first, second  deepest first; a penetration that is not > -reach: there is none
void findDeepest(SweptVertex vertex, out Found first, out Found second) {
  first = nothingFound();
  second = nothingFound();
  for (uint c = 0; c < CONTACT_CAPSULE_COUNT; ++c) {
    Found found;
    found.contact =
        sweepCapsule(CONTACT_CAPSULES[c], vertex.from, vertex.to, vertex.begin, vertex.end,
                     CONTACT_RESTS);
    found.collider = min(c, kContactField - 1u);
    keepDeepest(found, vertex.reach, first, second);
  }
#if SDF
  for (uint f = 0; f < CONTACT_FIELD_COUNT; ++f) {
    Found found;
    // What is fast may go further than expected, and there be behind what is thin: a second time as far
    // again. (One call, as compilers copy the query to every place that it stands in.)
    precise float3 displacement = vertex.to - vertex.from;
    precise float3 further = float3(0.0, 0.0, 0.0);
    [loop] for (uint look = 0; look < CONTACT_LOOKS; ++look) {
      found.contact = findFieldContact(CONTACT_FIELDS[f], vertex.from, vertex.to + further,
                                       vertex.begin, vertex.end, vertex.reach);
      precise float depth = found.contact.penetration + dot3(further, found.contact.normal);
      found.contact.penetration = depth;
      if (found.contact.penetration > -vertex.reach ||
          dot3(displacement, displacement) <= kLeap * kLeap)
        break;
      further = displacement;
    }
    found.collider = kContactField | min(f, kContactField - 2u);
    keepDeepest(found, vertex.reach, first, second);
  }
#endif
}

#endif
