// Contact of a strand's vertex with a field, in the form of the other colliders. The file that
// includes it defines SDF_KEYS and SDF_SURFACE.
#ifndef PELAGE_SDF_SDF_STRAND_CONTACT_HLSLI
#define PELAGE_SDF_SDF_STRAND_CONTACT_HLSLI

#include "../common/colliders.hlsli"
#include "sdf_response.hlsli"

// A vertex that was swept touches the plane at which its way meets the surface: a solver that lets
// it go on along the plane looks again from where it was before.
//
// \param before      where the vertex was at the sub-step's begin
// \param begin, end  the part of the frame that is in the sub-step, 0..1
// \param reach       what is this far from the surface has a contact, too [m]
Contact findFieldContact(SdfField field, float3 before, float3 p, float begin, float end,
                         float reach) {
  SdfContact found = sdfContact(field, before, p, begin, end, reach);
  precise float cell = field.origin.w;
  precise float penetration = found.penetration * cell;
  precise float3 surfaceMotion = found.motion * ((end - begin) * cell);
  Contact contact;
  contact.normal = found.normal;
  contact.penetration = found.found ? penetration : -1e18;
  contact.surfaceMotion = surfaceMotion;
  contact.friction = field.friction;
  return contact;
}

#endif
