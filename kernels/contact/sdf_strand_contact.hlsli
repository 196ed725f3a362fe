// Contact of a strand's vertex with an SDF, in the form of the other colliders. The including file
// defines SDF_KEYS and SDF_SURFACE.
#ifndef PELAGE_CONTACT_SDF_STRAND_CONTACT_HLSLI
#define PELAGE_CONTACT_SDF_STRAND_CONTACT_HLSLI

#include "colliders.hlsli"
#include "../sdf/sdf_collision.hlsli"

// A swept vertex gets the plane at which its path meets the surface. A solver that lets it continue
// along the plane queries again from its previous position.
//
// \param before      position of the vertex at the start of the sub-step
// \param begin, end  the part of the frame that is in the sub-step, 0..1
// \param reach       a vertex within this distance of the surface has a contact [m]
Contact findSdfContact(Sdf sdf, float3 before, float3 p, float begin, float end,
                         float range) {
  SdfContact found = sdfContact(sdf, before, p, begin, end, range);
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
