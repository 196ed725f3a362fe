// The definition of follow hairs, for the layouts of simulation and drawing.
#ifndef PELAGE_SIMULATION_LAYOUTS_FOLLOW_HLSLI
#define PELAGE_SIMULATION_LAYOUTS_FOLLOW_HLSLI

// Rigid frame of a guide's root in world space: x = rotate(rotation, p - bindRoot) + position.xyz.
struct RootTransform {
  float4 rotation;  // unit quaternion
  float4 position;  // xyz of vertex 0 relative to g_origin [m]; w unused
};

// A follow hair: the weighted mean of up to three guides, shifted by an offset that rotates with
// the first one's root. Guides that do not exist and weights that are not > 0 add nothing; the
// other weights are scaled to the sum 1.
struct FollowHairRecord {
  float4 offset;   // xyz in bind space, from the mean of the guides' roots [m]; w = factor on the
                   // offset at the tip (1 = parallel)
  uint4 guides;    // x..z indices of guide strands; w unused
  float4 weights;  // x..z of them; w unused
};

#endif
