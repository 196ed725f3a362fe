// Strands for acceleration structures: which vertices of a strand are written, and their radii.
#ifndef PELAGE_RAY_STRANDS_HLSLI
#define PELAGE_RAY_STRANDS_HLSLI

#include "base/dispatch.hlsli"
#include "base/quaternion.hlsli"

// A segment is two quads at right angles, which share no vertex.
static const uint kRayTriangleVertices = 8;
static const uint kRayTriangleIndices = 12;

cbuffer RayStrandsConstants : register(b0, space0) {
  uint g_rayElements;      // strands x segments for triangles, x vertices for spheres
  uint g_rayVertices;      // of a strand that is read, >= 2
  uint g_raySegments;      // of a strand that is written, 1..g_rayVertices - 1
  float g_rayRadius;       // of a fiber at the root [m]
  float g_rayTipChange;    // radius at the tip over that at the root, less 1
  float g_rayVertexShare;  // 1 / (g_rayVertices - 1)
  uint g_rayPad0;
  uint g_rayPad1;
};

// [strand][vertex]: xyz world position [m].
StructuredBuffer<float4> g_rayStrands : register(t0, space0);
// [strand]: factor of the radius; with THICKNESS.
StructuredBuffer<float> g_rayThickness : register(t1, space0);
// Three floats a vertex [m].
RWStructuredBuffer<float> g_rayPositions : register(u0, space0);
// One float a vertex [m]; spheres alone.
RWStructuredBuffer<float> g_rayRadii : register(u1, space0);

// The vertex of the strand that is read for vertex `i` of those written; both ends are kept.
uint sourceVertex(uint i) {
  return (i * (g_rayVertices - 1u) + g_raySegments / 2u) / g_raySegments;
}

float3 rayPosition(uint strand, uint vertex) {
  return g_rayStrands[strand * g_rayVertices + vertex].xyz;
}

float rayRadius(uint strand, uint vertex) {
  precise float along = (float)vertex * g_rayVertexShare;
  precise float radius = g_rayRadius * (1.0 + g_rayTipChange * along);
#if THICKNESS
  radius = radius * g_rayThickness[strand];
#endif
  return radius;
}

void writeRayPosition(uint vertex, float3 position) {
  g_rayPositions[vertex * 3u] = position.x;
  g_rayPositions[vertex * 3u + 1u] = position.y;
  g_rayPositions[vertex * 3u + 2u] = position.z;
}

#endif
