#ifndef FIXTURE_FORCES_HLSLI
#define FIXTURE_FORCES_HLSLI

float dot4(float4 plane, float4 p) {
  return plane.x * p.x + plane.y * p.y + plane.z * p.z + plane.w;
}

float3 wellForce(int index, float3 p) {
  const Well well = g_wells[index];
  const float3 d = well.center.xyz - p;
  const float squared = d.x * d.x + d.y * d.y + d.z * d.z + well.radius;
  return d * (well.strength / squared);
}

#endif
