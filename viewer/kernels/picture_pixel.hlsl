// Puts the scene over a backdrop and encodes it for the screen, as tools/studio/image.h does on
// the host: compositeOver(), toneMap(), encodeSrgb().
//
// One thread a pixel. Reads g_sceneColor and the constants.
// Invariant: finite for every value of the scene; a NaN is black (viewer_test).
#include "picture.hlsli"

static const float kShoulder = 0.6;  // where the tone curve leaves the identity

float toneMapped(float color) {
  if (!(color > 0.0)) return 0.0;
  if (color <= kShoulder) return color;
  return kShoulder + (1.0 - kShoulder) * (1.0 - exp(-(color - kShoulder) / (1.0 - kShoulder)));
}

float encoded(float color) {
  float x = toneMapped(color);
  return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(max(x, 1e-6), 1.0 / 2.4) - 0.055;
}

// The scene takes the top left of its target, and is magnified between the nearest four pixels.
float4 sceneAt(int2 pixel) {
  if (g_coarseness <= 1u) return g_sceneColor.Load(int4(pixel, 0, 0));
  float2 at = (float2(pixel) + 0.5) / float(g_coarseness) - 0.5;
  int2 last = int2(g_pictureWidth / g_coarseness, g_pictureHeight / g_coarseness) - 1;
  int2 low = clamp(int2(floor(at)), int2(0, 0), last);
  int2 high = min(low + 1, last);
  float2 share = saturate(at - float2(low));
  float4 top = lerp(g_sceneColor.Load(int4(low, 0, 0)),
                    g_sceneColor.Load(int4(high.x, low.y, 0, 0)), share.x);
  float4 bottom = lerp(g_sceneColor.Load(int4(low.x, high.y, 0, 0)),
                       g_sceneColor.Load(int4(high, 0, 0)), share.x);
  return lerp(top, bottom, share.y);
}

float4 picture_pixel(PictureVaryings picture) : SV_Target {
  int2 pixel = int2(picture.clip.xy);
  if (g_flipsRows != 0u) pixel.y = int(g_pictureHeight) - 1 - pixel.y;
  float4 scene = sceneAt(pixel);

  float2 share = (float2(pixel) + 0.5) / float2(float(g_pictureWidth), float(g_pictureHeight));
  float2 away = (share - float2(0.5, 0.45)) / 0.42;
  float glow = 1.0 + g_backdropTop.w * exp(-dot(away, away));
  float3 backdrop = lerp(g_backdropTop.rgb, g_backdropBottom.rgb, share.y) * glow;
  float3 color = scene.rgb + (1.0 - scene.a) * backdrop;
  return float4(encoded(color.r), encoded(color.g), encoded(color.b), 1.0);
}
