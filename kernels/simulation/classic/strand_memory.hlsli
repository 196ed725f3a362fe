// Storage of a strand while the classic solver works on it: g_state, strand fastest.
// A strand fits neither into registers nor into 16 KB of group-shared memory without leaving most
// of a GPU idle; in this order the accesses of a wave are one line wide.
#ifndef PELAGE_SIMULATION_CLASSIC_STRAND_MEMORY_HLSLI
#define PELAGE_SIMULATION_CLASSIC_STRAND_MEMORY_HLSLI

#include "../../base/quaternion.hlsli"
#include "../root_pose.hlsli"
#include "../strand_indexing.hlsli"

// A strand, and the values that its sweeps share.
struct Strand {
  uint guide;
  uint lane;  // in the thread group
  uint held;  // the last vertex that the root moves; all later ones are free
  float3 root;
};

// xyz: position relative to g_origin [m]. w: inverse mass, 0 or 1; scratch in the length solve.
float4 loadPoint(Strand s, uint vertex) { return g_state[guideIndex(0, vertex, s.guide)]; }

void storePoint(Strand s, uint vertex, float4 value) {
  g_state[guideIndex(0, vertex, s.guide)] = value;
}

float3 position(Strand s, uint vertex) { return loadPoint(s, vertex).xyz; }

// Start of the sub-step, transported by the root's motion.
float3 beginning(Strand s, uint vertex) { return g_state[guideIndex(1, vertex, s.guide)].xyz; }

// x: scratch of the length solve. y: rest length of the segment behind the vertex [m], its sign bit
// set when the vertex is held.
// Two vertices share an element.
float2 loadLength(Strand s, uint vertex) {
  float4 both = g_state[guideIndex(3, vertex >> 1, s.guide)];
  return (vertex & 1u) != 0u ? both.zw : both.xy;
}

void storeLength(Strand s, uint vertex, float2 value) {
  uint element = guideIndex(3, vertex >> 1, s.guide);
  if ((vertex & 1u) != 0u)
    g_state[element].zw = value;
  else
    g_state[element].xy = value;
}

float2 packLength(float rest, bool held) {
  uint bits = (asuint(rest) & 0x7fffffffu) | (held ? 0x80000000u : 0u);
  return float2(0.0, asfloat(bits));
}

float inverseMass(float2 stored) { return (asuint(stored.y) >> 31) != 0u ? 0.0 : 1.0; }

float restLength(float2 stored) { return asfloat(asuint(stored.y) & 0x7fffffffu); }

float3 restPosition(uint vertex, uint guide) { return g_rest[guideIndex(0, vertex, guide)].xyz; }

float segmentLength(Strand s, uint segment) { return restLength(loadLength(s, segment)); }

// Returns the fraction of the displacement to a target if the spring behind it is `factor` times as
// stiff.
float scaledShare(float share, float factor) {
  precise float scaled = share * factor;
  precise float r = scaled / (1.0 - share + scaled);
  return r;
}

// Returns the change of a segment's length at p that rounding alone may cause: coordinates have an
// error of 6e-8 of their size at each of a few roundings, and the arm from the root is at most as
// long as p and the root are far from the origin. Smaller errors are not corrected: corrections of
// that size would be rounded again, step after step, and a resting strand would wander.
float lengthRounding(float3 p, float3 root) {
  precise float r = 2.4e-7 * (max(abs(p.x), max(abs(p.y), abs(p.z))) +
                              max(abs(root.x), max(abs(root.y), abs(root.z))));
  return r;
}

#endif
