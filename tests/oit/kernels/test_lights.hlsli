// An engine's lights: pelage's own, or one color for every fiber, each channel of which is read from another kind of
// resource.
cbuffer ConstantLight : register(b0, ENGINE_LIGHTS_SPACE) {
  float4 g_constantLight;  // rgb; a: 0 for pelage's own lights
};

StructuredBuffer<float> g_constantScale : register(t0, ENGINE_LIGHTS_SPACE);  // of red
Texture2DArray<float> g_constantTexels : register(t1, ENGINE_LIGHTS_SPACE);   // of green
TextureCube<float4> g_constantCube : register(t2, ENGINE_LIGHTS_SPACE);       // of blue
SamplerState g_constantSampler : register(s0, ENGINE_LIGHTS_SPACE);

float3 engineLight(StrandShading material, StrandSurface surface) {
  [branch]
  if (g_constantLight.a == 0) return viewLight(material, surface);
  float3 scale = float3(g_constantScale[1], g_constantTexels.Load(int4(2, 1, 1, 0)),
                        g_constantCube.SampleLevel(g_constantSampler, surface.tangent, 0.0).b);
  return g_constantLight.rgb * scale;
}
