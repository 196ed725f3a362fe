// Computes forces on the guides' vertices from the grid.
//
// Threads: one per vertex, in rows of 2^20.
// Reads:   g_gridPositions, g_gridBefore, g_gridNodes; with pressure g_gridRest; with g_addsForces
//          g_otherForces
// Writes:  g_gridForces; g_gridBefore, for the next step
//
// Pressure: hair that is denser than at rest spreads. With rho the trilinear density and rho0 the
// vertex's rest density (measure_hair_grid.hlsl says which),
//   a = -c^2 s grad(rho) / rho,  s = max(1 - 1.1 rho0 / rho, 0),  |a| <= 2 c^2 / cell a component
// after the idea of a force along the density's gradient (Bertails, Menier, Cani: "A practical
// self-shadowing algorithm for interactive hair animation", Graphics Interface 2005; Petrovic,
// Henne, Anderson: "Volumetric methods for simulation and rendering of hair", Pixar Technical Memo
// 06-08, 2005), but only above the density at rest. (McAdams et al. 2009 project the velocities
// instead, as in a fluid: a solve over the grid.) For s near 1 it is the acceleration of a gas with
// the speed of sound c, which is what bounds c: docs/contact_hair.md.
// Friction: hair drags hair along, through the velocities on the grid (Petrovic et al. 2005): with
// u the momentum of a node over its mass and w the vertex's weight for it,
//   a += r sum w (u - v).
// The same weights are used for both directions, so that sum m a = 0: friction keeps momentum. It
// is explicit, with r the fraction of the velocity that is lost in the step over the step, r h <=
// 1: an implicit drag towards the velocity of the last step would also slow down the fall of all
// hair.
//
// Forces: the forces of g_otherForces are added.
//
// Invariant (tests/contact): 0 for a bundle at rest in its bind pose; pressure points from dense to
// thin; friction keeps momentum to rounding and removes energy; a vertex that is not finite or
// outside gets 0.
#include "hair_grid.hlsli"

// Hair pushes above this multiple of its rest density: the grid positions at which the bind pose
// was measured miss the maximum by up to this. With 1, and half as many positions, a bundle of 300
// strands at rest was pushed by up to 3.6 m/s2.
static const float kSlack = 1.1;

[numthreads(64, 1, 1)]
void apply_hair_grid(uint3 thread : SV_DispatchThreadID) {
  uint index = indexOfThread(thread);
  if (index >= g_gridVertexCount) return;
  GridVertex vertex = gridVertex(index);
  precise float3 acceleration = float3(0.0, 0.0, 0.0);
  bool hasPressure = g_pressure > 0.0;
  bool hasFriction = g_gridFriction != 0u;
  if (vertex.inside) {
    precise float density = 0.0;
    precise float3 slope = float3(0.0, 0.0, 0.0);
    precise float3 relative = float3(0.0, 0.0, 0.0);
    precise float momentumToVelocity = g_massScale / g_momentumScale;
    for (uint corner = 0; corner < 8; ++corner) {
      float3 weights = weightsOf(vertex, corner);
      precise float weight = weights.x * weights.y * weights.z;
      uint word = nodeOf(vertex, corner) << channelShift();
      precise float mass = float(g_gridNodes[word]);
      if (hasPressure) {
        density = density + mass * weight;
        precise float3 faces =
            float3(weights.y * weights.z, weights.x * weights.z, weights.x * weights.y) * mass;
        uint3 side = cornerOf(corner);
        slope = slope + float3(side.x > 0u ? faces.x : -faces.x, side.y > 0u ? faces.y : -faces.y,
                               side.z > 0u ? faces.z : -faces.z);
      }
      if (hasFriction && mass > 0.0) {
        precise float3 momentum =
            float3(float(asint(g_gridNodes[word + 1])), float(asint(g_gridNodes[word + 2])),
                   float(asint(g_gridNodes[word + 3])));
        precise float3 velocity = momentum * (momentumToVelocity / mass);
        relative = relative + (velocity - vertex.velocity) * weight;
      }
    }
    if (hasPressure) {
      float rest = g_gridRest[index];
      precise float limit = rest * kSlack;
      if (rest > 0.0 && density > limit) {
        precise float excess = 1.0 - limit / density;
        precise float3 direction = min(max(slope / density, -2.0), 2.0);
        acceleration = direction * (-(g_pressure * excess) / g_gridOrigin.w);
      }
    }
    if (hasFriction) acceleration = acceleration + relative * g_frictionRate;
  }
  float drag = 0.0;
  if (g_addsForces != 0u) {
    float4 others = g_otherForces[index];
    if (isUsable(others)) {
      acceleration = acceleration + others.xyz;
      drag = others.w;
    }
  }
  g_gridForces[index] = float4(acceleration, drag);
  g_gridBefore[index] = float4(g_gridPositions[index].xyz, g_gridBefore[index].w);
}
