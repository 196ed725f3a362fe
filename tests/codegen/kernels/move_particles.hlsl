// Fixture: reads and writes through helper functions, groupshared memory, specialization constants.
#include "particles.hlsli"
#include "shared/forces.hlsli"

[[vk::constant_id(7)]] const float g_restitution = 0.5;
[[vk::constant_id(2)]] const uint g_wellLimit = 16;
[[vk::constant_id(4)]] const bool g_attract = true;
[[vk::constant_id(5)]] const int g_bias = -3;

groupshared float4 s_positions[64];

[numthreads(64, 1, 1)]
void move_particles(uint3 id : SV_DispatchThreadID, uint lane : SV_GroupIndex) {
  const bool inside = id.x < g_particleCount;
  float4 position = float4(0, 0, 0, 0);
  if (inside) position = g_particles[id.x].position;
  for (uint i = 0; i < SUB_STEPS; ++i) {
    float3 force = g_gravity;
    for (int w = 0; w < g_wellCount; ++w) {
      if (uint(w) >= g_wellLimit) break;
      const float3 pull = wellForce(w, position.xyz);
      force += g_attract ? pull : -pull;
    }
#if AIR_DRAG
    force -= g_drag.x * position.xyz * (g_drag.y + float(g_bias));
#endif
    position.xyz += force * g_timeStep * g_timeStep;
#if BOUNCE
    const float below = dot4(g_planes[0], position);
    if (below < 0.0) position.xyz -= (1.0 + g_restitution) * below * g_planes[0].xyz;
#endif
  }
  s_positions[lane] = position;
  GroupMemoryBarrierWithGroupSync();
  const float4 neighbour = s_positions[(lane + 1) & 63];
  if (!inside) return;
  g_particles[id.x].position = position;
  g_trail[id.x] = neighbour + g_noise.SampleLevel(g_noiseSampler, position.xy, 0.0);
}
