// What hair collides with; the one definition for all solvers.
#ifndef PELAGE_LAYOUTS_COLLIDER_HLSLI
#define PELAGE_LAYOUTS_COLLIDER_HLSLI

// A sphere or a tapered capsule in motion: the union of the spheres between two ends, all [m] and
// relative to the origin of the hair's state. One that is not finite touches nothing.
struct Collider {
  float4 head;        // xyz at the frame's end, w radius
  float4 tail;        // xyz at the frame's end, w radius; equal to the head for a sphere
  float4 headBefore;  // xyz at the frame's begin, w Coulomb friction
  float4 tailBefore;  // xyz at the frame's begin; w unused
  float4 spin;        // xyz rotation vector of the frame about the axis, or a sphere's centre [rad]; w
                      // unused
};

#endif
