// The colliders of hair; the one definition for all solvers.
#ifndef PELAGE_CONTACT_LAYOUTS_COLLIDER_HLSLI
#define PELAGE_CONTACT_LAYOUTS_COLLIDER_HLSLI

// A sphere or a tapered capsule in motion: the union of the spheres between two ends, all [m] and
// relative to the origin of the hair's state. One that is not finite has no contacts.
struct Collider {
  float4 head;        // xyz at the frame's end, w radius
  float4 tail;        // xyz at the frame's end, w radius; equal to the head for a sphere
  float4 headBefore;  // xyz at the frame's start, w Coulomb friction
  float4 tailBefore;  // xyz at the frame's start; w unused
  float4 spin;        // xyz rotation vector of the frame about the axis, or a sphere's center [rad]; w
                      // unused
};

#endif
