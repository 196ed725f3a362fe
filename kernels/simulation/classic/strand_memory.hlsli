// Where the classic solver keeps a strand while it works on it: g_state and g_lengths, strand
// fastest. It fits neither into registers nor into 16 KB of group-shared memory without leaving
// most of a GPU idle; in this order a wave's way to the caches is one line wide.
#ifndef PELAGE_SIMULATION_CLASSIC_STRAND_MEMORY_HLSLI
#define PELAGE_SIMULATION_CLASSIC_STRAND_MEMORY_HLSLI

#include "../../common/quaternion.hlsli"
#include "../../common/root_pose.hlsli"
#include "../../common/strand_indexing.hlsli"

// A strand, and what its sweeps share.
struct Strand {
  uint guide;
  uint lane;  // in the thread group
  uint held;  // the last vertex that the root moves; behind it all are free
  float3 root;
};

// xyz: position relative to g_origin [m]. w: inverse mass, 0 or 1; scratch in the length solve.
float4 loadPoint(Strand s, uint vertex) { return g_state[guideIndex(0, vertex, s.guide)]; }

void storePoint(Strand s, uint vertex, float4 value) {
  g_state[guideIndex(0, vertex, s.guide)] = value;
}

float3 position(Strand s, uint vertex) { return loadPoint(s, vertex).xyz; }

// Where the sub-step begins, moved along with the root's motion.
float3 beginning(Strand s, uint vertex) { return g_state[guideIndex(1, vertex, s.guide)].xyz; }

// x: scratch of the length solve. y: rest length of the segment behind the vertex [m], its sign bit
// set when the vertex is held.
float2 loadLength(Strand s, uint vertex) { return g_lengths[guideIndex(0, vertex, s.guide)]; }

void storeLength(Strand s, uint vertex, float2 value) {
  g_lengths[guideIndex(0, vertex, s.guide)] = value;
}

float2 packLength(float rest, bool held) {
  uint bits = (asuint(rest) & 0x7fffffffu) | (held ? 0x80000000u : 0u);
  return float2(0.0, asfloat(bits));
}

float inverseMass(float2 stored) { return (asuint(stored.y) >> 31) != 0u ? 0.0 : 1.0; }

float restLength(float2 stored) { return asfloat(asuint(stored.y) & 0x7fffffffu); }

float3 restPosition(uint vertex, uint guide) { return g_rest[guideIndex(0, vertex, guide)].xyz; }

float segmentLength(Strand s, uint segment) { return restLength(loadLength(s, segment)); }

// A share of the way to a goal when the spring behind it is `factor` times as stiff.
float scaledShare(float share, float factor) {
  precise float scaled = share * factor;
  precise float r = scaled / (1.0 - share + scaled);
  return r;
}

// What rounding alone may change the length of a segment at p by: coordinates have an error of
// 6e-8 of their size at each of a few roundings, and the arm from the root is at most as long as p
// and the root are far from the origin. Errors below it are left alone: corrections of that size
// would be rounded again, step after step, and a resting strand would wander.
float lengthRounding(float3 p, float3 root) {
  precise float r = 2.4e-7 * (max(abs(p.x), max(abs(p.y), abs(p.z))) +
                              max(abs(root.x), max(abs(root.y), abs(root.z))));
  return r;
}

#endif
