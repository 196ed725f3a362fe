// What follow strands are made from, for the simulation's and the drawing's layouts.
#ifndef PELAGE_LAYOUTS_FOLLOW_HLSLI
#define PELAGE_LAYOUTS_FOLLOW_HLSLI

// Rigid frame of a guide's root in world space: x = rotate(rotation, p - bindRoot) + position.xyz.
struct RootTransform {
  float4 rotation;  // unit quaternion
  float4 position;  // xyz of vertex 0 relative to g_origin [m]; w unused
};

// A follow strand: the weighted mean of up to three guides, shifted by an offset that turns with
// the first one's root. Guides that do not exist and weights that are not > 0 add nothing; the
// others count as if they summed to 1.
struct FollowStrand {
  float4 offset;   // xyz in bind space, from the mean of the guides' roots [m]; w = factor on the
                   // offset at the tip (1 = parallel)
  uint4 guides;    // x..z indices of guide strands; w unused
  float4 weights;  // x..z of them; w unused
};

#endif
