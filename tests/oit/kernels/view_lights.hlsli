// An engine's lights that are pelage's.
float3 engineLight(StrandShading material, StrandSurface surface) {
  return viewLight(material, surface);
}
