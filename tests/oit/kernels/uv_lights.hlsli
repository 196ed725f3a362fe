// An engine's lights that show the UV of roots.
float3 engineLight(StrandShading material, StrandSurface surface) {
  return float3(surface.uv, 0.5 * dot(surface.tangent, surface.tangent));
}
