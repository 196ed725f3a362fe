// Keeps the length of a segment while its end stays in front of a plane.
#ifndef PELAGE_CONTACT_FIT_ALONG_PLANE_HLSLI
#define PELAGE_CONTACT_FIT_ALONG_PLANE_HLSLI

#include "../base/quaternion.hlsli"

// Returns the vector of a segment of this length whose end has the same distance from a plane as
// that of `arm`: only the part along the plane changes. If the whole were scaled, a short arm would
// cross the plane.
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
