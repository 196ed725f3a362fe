// How a segment stays at its length while its end is in front of a plane.
#ifndef PELAGE_CONTACT_FIT_ALONG_PLANE_HLSLI
#define PELAGE_CONTACT_FIT_ALONG_PLANE_HLSLI

#include "../common/quaternion.hlsli"

// The vector of a segment of this length whose end stays as far from a plane as that of `arm` is:
// its part along the plane gives way. Scaled as a whole, a short arm would lead through the plane.
float3 fitAlongPlane(float3 arm, float3 normal, float segment) {
  precise float off = dot3(arm, normal);
  precise float3 along = arm - normal * off;
  float3 direction = directionOr(along, perpendicular(normal));
  precise float kept = min(max(off, -segment), segment);
  precise float rest = squareRoot(max(segment * segment - kept * kept, 0.0));
  precise float3 r = normal * kept + direction * rest;
  return r;
}

#endif
