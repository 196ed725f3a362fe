// Position, radius and color of a drawn strand at a vertex. The including file has the layouts of
// group render, and the permutation ATTRIBUTES: factors on the radius, colors of vertices, a
// texture or its colors, and UV; g_strandAttributes has the ones that exist.
#ifndef PELAGE_SHADING_DRAWN_FIBER_HLSLI
#define PELAGE_SHADING_DRAWN_FIBER_HLSLI

#include "color_packing.hlsli"
#include "../base/quaternion.hlsli"
#include "../base/random_hash.hlsli"
#include "layouts/render.hlsli"
#include "strand_common.hlsli"
#define STRAND_POSITIONS g_renderPositions
#define STRAND_TANGENTS g_renderTangents
#define STRAND_VERTEX_COUNT g_renderVertexCount
#define STRAND_FOLLOW_HAIRS g_renderFollowHairRecords
#define STRAND_ROOTS g_renderRoots
#define STRAND_GUIDE_COUNT g_renderGuideCount
// Kernels without the permutation FOLLOWS evaluate them where the object says so.
#if defined(FOLLOWS) && !FOLLOWS
#define STRAND_EVALUATES_FOLLOWS false
#else
#define STRAND_EVALUATES_FOLLOWS (g_evaluatesFollows != 0u)
#endif
#define STRAND_TIP_SEPARATION g_renderTipSeparation
#include "drawn_strand.hlsli"

#if ATTRIBUTES
bool hasAttribute(uint attribute) { return (g_strandAttributes & attribute) != 0u; }

float4 texelAt(int2 at) {
  int2 size = int2(g_textureSize);
  // Coordinates run from -1 to the size.
  int2 wrapped = int2(at.x < 0 ? size.x - 1 : (at.x >= size.x ? 0 : at.x),
                      at.y < 0 ? size.y - 1 : (at.y >= size.y ? 0 : at.y));
  return unpackColor(g_baseTexture[uint(wrapped.y * size.x + wrapped.x)]);
}

// Interpolates the four nearest texels; the texture repeats.
float4 textureAt(float2 uv) {
  float2 texel = (uv - floor(uv)) * float2(g_textureSize);
  // Handles NaN, and the rounding of a UV just below 0.
  texel.x = texel.x > 0.0 ? min(texel.x, float(g_textureSize.x)) : 0.0;
  texel.y = texel.y > 0.0 ? min(texel.y, float(g_textureSize.y)) : 0.0;
  texel -= 0.5;
  float2 low = floor(texel);
  float2 share = texel - low;
  int2 at = int2(low);
  return lerp(lerp(texelAt(at), texelAt(at + int2(1, 0)), share.x),
              lerp(texelAt(at + int2(0, 1)), texelAt(at + int2(1, 1)), share.x), share.y);
}
#endif

// The UV of a strand's root, within 0..1; 0 without kHasStrandUvs.
float2 rootUv(uint guide) {
  float2 uv = float2(0.0, 0.0);
#if ATTRIBUTES
  uint at = hasAttribute(kHasBaseTexture) ? g_textureSize.x * g_textureSize.y + guide : 2u * guide;
  if (hasAttribute(kHasStrandUvs)) uv = asfloat(g_baseTexture[at]);
  uv -= floor(uv);
#endif
  return uv;
}

float4 strandColor(uint strand, uint guide, uint vertex, float along) {
  float random = unitFloat(hashUint(strand)) * 2.0 - 1.0;
  float share = g_tipColor.a;
  float tip = share > 0.0 ? saturate((along - (1.0 - share)) / share) : 0.0;
  float4 color =
      float4(lerp(g_rootColor.rgb, g_tipColor.rgb, tip) * (1.0 + g_strandVariation * random),
             g_rootColor.a);
#if ATTRIBUTES
  if (hasAttribute(kHasVertexColors))
    color *= unpackColor(g_vertexColors[guide * g_renderVertexCount + vertex]);
  if (hasAttribute(kHasBaseTexture))
    color *= textureAt(asfloat(g_baseTexture[g_textureSize.x * g_textureSize.y + guide]));
  if (hasAttribute(kHasStrandColors)) color *= unpackColor(g_baseTexture[2u * guide + 1u]);
#endif
  return color;
}

// Returns the factor on the strand's width.
float strandWidth(uint strand) {
  float left = g_drawnStrands - float(strand);
  return g_strandWidening *
         (g_fadingStrands > 0.0 ? saturate(left / g_fadingStrands) : (left > 0.0 ? 1.0 : 0.0));
}

// Returns the vertex; known = false also if it is not finite.
DrawnVertex finiteVertex(uint strand, uint vertex) {
  DrawnVertex drawn = drawnVertex(strand, vertex);
  drawn.known = drawn.known && dot(abs(drawn.position), float3(1.0, 1.0, 1.0)) < 1e18;
  return drawn;
}

struct DrawnFiber {
  float3 position;  // world [m]
  float3 tangent;   // unit
  float4 color;     // linear rgb, opacity
  float2 uv;        // of the root, 0..1; 0 without kHasStrandUvs
  float radius;     // [m]
  bool known;       // false: the strand is not drawn
};

// \param strand, \param vertex indices in range.
DrawnFiber drawnFiber(uint strand, uint vertex) {
  DrawnFiber fiber;
  fiber.position = float3(0.0, 0.0, 0.0);
  fiber.tangent = float3(0.0, 1.0, 0.0);
  fiber.color = float4(0.0, 0.0, 0.0, 0.0);
  fiber.uv = float2(0.0, 0.0);
  fiber.radius = 0.0;
  DrawnVertex at = finiteVertex(strand, vertex);
  // A vertex that is not finite takes the position of the nearest finite one.
  for (uint apart = 1u; !at.known && apart < g_renderVertexCount; ++apart) {
    if (vertex >= apart) at = finiteVertex(strand, vertex - apart);
    if (!at.known && vertex + apart < g_renderVertexCount)
      at = finiteVertex(strand, vertex + apart);
  }
  fiber.known = at.known;
  if (!at.known) return fiber;
  fiber.position = at.position;
  fiber.tangent = directionOr(at.tangent, float3(0.0, 1.0, 0.0));

  float along = float(vertex) / float(max(g_renderVertexCount, 2u) - 1u);
  fiber.radius = g_fiberRadius * lerp(1.0, g_tipRadiusRatio, along) * strandWidth(strand);
  uint guide = strand;
#if ATTRIBUTES
  if (hasAttribute(kHasThickness)) fiber.radius *= g_strandThickness[strand];
  if (hasAttribute(kHasVertexColors | kHasBaseTexture | kHasStrandColors | kHasStrandUvs) &&
      strand >= g_renderGuideCount)
    guide = g_renderFollowHairRecords[strand - g_renderGuideCount].guides.x;
#endif
  guide = min(guide, g_renderGuideCount - 1u);
  fiber.color = strandColor(strand, guide, vertex, along);
  fiber.uv = rootUv(guide);
  return fiber;
}

StrandView renderView() {
  StrandView view;
  view.clipX = g_worldToClip[0];
  view.clipY = g_worldToClip[1];
  view.clipZ = g_worldToClip[2];
  view.clipW = g_worldToClip[3];
  view.eye = g_eye.xyz;
  view.viewportSize = g_viewport.zw;
  return view;
}

#endif
