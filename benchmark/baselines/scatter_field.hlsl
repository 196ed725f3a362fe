// Classic baseline of distance fields, second pass (field_layout.hlsli).
// Threads: one a triangle. Reads g_corners, g_triangles; writes g_fieldKeys.
#include "field_layout.hlsli"

float distanceToSegment(float3 p, float3 a, float3 b) {
  float3 edge = b - a;
  float t = saturate(dot(p - a, edge) / max(dot(edge, edge), 1e-30));
  return length(p - a - t * edge);
}

// By barycentric coordinates of the foot on the plane; outside the triangle, the nearest edge.
float distanceToTriangle(float3 p, float3 a, float3 b, float3 c, float3 normal) {
  float area = dot(normal, normal);
  float u = dot(cross(c - b, p - b), normal);
  float v = dot(cross(a - c, p - c), normal);
  float w = dot(cross(b - a, p - a), normal);
  if (area > 0.0 && u >= 0.0 && v >= 0.0 && w >= 0.0) return abs(dot(p - a, normal)) / sqrt(area);
  return min(distanceToSegment(p, a, b),
             min(distanceToSegment(p, b, c), distanceToSegment(p, c, a)));
}

[numthreads(64, 1, 1)]
void scatter_field(uint3 thread : SV_DispatchThreadID) {
  if (thread.x >= g_triangleCount) return;
  float3 a = g_corners[g_triangles[3 * thread.x]].xyz;
  float3 b = g_corners[g_triangles[3 * thread.x + 1]].xyz;
  float3 c = g_corners[g_triangles[3 * thread.x + 2]].xyz;
  float3 normal = cross(b - a, c - a);
  float3 last = float3(g_fieldNodes.xyz) - 1.0;
  float3 low = (min(a, min(b, c)) - g_fieldOrigin.xyz) / g_fieldOrigin.w;
  float3 high = (max(a, max(b, c)) - g_fieldOrigin.xyz) / g_fieldOrigin.w;
  int3 from = int3(clamp(floor(low) - 2.0, 0.0, last));
  int3 to = int3(clamp(floor(high) + 2.0, 0.0, last));
  for (int z = from.z; z <= to.z; ++z) {
    for (int y = from.y; y <= to.y; ++y) {
      for (int x = from.x; x <= to.x; ++x) {
        float3 p = g_fieldOrigin.xyz + g_fieldOrigin.w * float3(x, y, z);
        float magnitude = distanceToTriangle(p, a, b, c, normal);
        float signedDistance = dot(p - a, normal) < 0.0 ? -magnitude : magnitude;
        uint node = uint(x) + g_fieldNodes.x * (uint(y) + g_fieldNodes.y * uint(z));
        InterlockedMin(g_fieldKeys[node], toKey(signedDistance));
      }
    }
  }
}
