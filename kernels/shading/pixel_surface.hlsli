// The surface of a strand at a pixel. The including file includes strand_interface.hlsli and
// light_strand.hlsli before.
#ifndef PELAGE_SHADING_PIXEL_SURFACE_HLSLI
#define PELAGE_SHADING_PIXEL_SURFACE_HLSLI

StrandSurface pixelSurface(StrandPixel strand, float3 baseColor) {
  StrandSurface surface = strandSurface(
      fragmentPosition(strand.clip.xy - g_viewport.xy, strand.clip.z), strand.tangent, baseColor);
#if STRAND_UV
  surface.uv = strand.uv;
#endif
  return surface;
}

#endif
