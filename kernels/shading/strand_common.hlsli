// Geometry and light of strands, for the project's kernels and for an engine's own: no resources.
#ifndef PELAGE_SHADING_STRAND_COMMON_HLSLI
#define PELAGE_SHADING_STRAND_COMMON_HLSLI

struct StrandView {
  float4 clipX;         // rows of the map from world to clip space, depth 0..1, y up
  float4 clipY;
  float4 clipZ;
  float4 clipW;
  float3 eye;           // position of the camera [m]
  float2 viewportSize;  // [pixels]
};

// A corner of the ribbon.
struct StrandCorner {
  float4 clip;
  float coverage;  // width of the fibre over that of the ribbon, 0..1
};

// A direction's motion on the screen [pixels a metre] at a point of clip coordinates `clip`, w > 0.
float2 projectDirection(StrandView view, float4 clip, float3 direction) {
  float2 moved = float2(dot(view.clipX.xyz, direction), dot(view.clipY.xyz, direction));
  float movedW = dot(view.clipW.xyz, direction);
  float2 ndc = clip.xy / clip.w;
  return (moved - ndc * movedW) / clip.w * (view.viewportSize * 0.5);
}

// The corner of a camera-facing ribbon at a vertex of a strand. Its width on the screen is that of
// the fibre, but never below one pixel: what it gains there it gives back as coverage, so that the
// covered area stays that of the fibre.
// \param position world position [m], \param tangent unit tangent, \param radius of the fibre [m].
// \param side -1 or 1: which edge.
// A tangent along the line of sight takes any direction on the screen. A vertex that is not in
// front of the eye gets no width; the near plane cuts there.
StrandCorner expandStrandVertex(StrandView view, float3 position, float3 tangent, float radius,
                                float side) {
  StrandCorner corner;
  float4 p = float4(position, 1.0);
  corner.clip = float4(dot(view.clipX, p), dot(view.clipY, p), dot(view.clipZ, p),
                       dot(view.clipW, p));
  corner.coverage = 1.0;
  if (!(corner.clip.w > 1e-6)) return corner;

  // Across: at right angles to the fibre and to the line of sight, where the fibre shows its width.
  float3 toEye = view.eye - position;
  float3 across = cross(tangent, toEye);
  float squared = dot(across, across);
  if (!(squared > 1e-10 * dot(toEye, toEye))) {
    float3 axis = abs(toEye.y) < abs(toEye.x) + abs(toEye.z) ? float3(0.0, 1.0, 0.0)
                                                             : float3(1.0, 0.0, 0.0);
    across = cross(axis, toEye);
    squared = dot(across, across);
  }
  across *= 1.0 / sqrt(max(squared, 1e-30));

  // The ribbon is at right angles to the fibre's image, which `across` is only near the centre.
  float2 width = projectDirection(view, corner.clip, across);
  float2 along = projectDirection(view, corner.clip, tangent);
  float2 normal = float2(-along.y, along.x);
  // An image shorter than a thousandth of the width is rounding, not a direction.
  if (!(dot(along, along) > 1e-6 * dot(width, width))) normal = width;
  float normalSquared = dot(normal, normal);
  if (!(normalSquared > 1e-30)) return corner;
  normal *= 1.0 / sqrt(normalSquared);
  if (dot(normal, width) < 0.0) normal = -normal;

  float halfWidth = radius * dot(normal, width);
  float shown = max(halfWidth, 0.5);
  corner.coverage = halfWidth / shown;
  float2 offset = normal * (side * shown) / (view.viewportSize * 0.5);
  corner.clip.xy += offset * corner.clip.w;
  return corner;
}

// Diffuse light on a fibre: the sine of the angle between tangent and light (Kajiya and Kay,
// "Rendering fur with three dimensional textures", SIGGRAPH 1989, equation 14).
float fiberDiffuse(float3 tangent, float3 toLight) {
  float cosine = dot(tangent, toLight);
  return sqrt(max(1.0 - cosine * cosine, 0.0));
}

// Highlight of a fibre (Kajiya and Kay 1989, equation 16, with the half vector and the shifted
// tangents of Scheuermann, "Practical real-time hair rendering and shading", SIGGRAPH sketch 2004).
// \param normal unit vector at right angles to the tangent; \param shift > 0 tilts towards it.
float fiberSpecular(float3 tangent, float3 normal, float3 toLight, float3 toEye, float shift,
                    float exponent) {
  float3 tilted = normalize(tangent + normal * shift);
  float3 middle = toLight + toEye;
  float length2 = dot(middle, middle);
  if (!(length2 > 1e-12)) return 0.0;
  float cosine = dot(tilted, middle) / sqrt(length2);
  float sine = sqrt(max(1.0 - cosine * cosine, 0.0));
  // Fades where the light comes from behind the tilted fibre.
  float front = smoothstep(-1.0, 0.0, cosine);
  // pow() of 0 is not defined everywhere.
  return front * pow(max(sine, 1e-6), max(exponent, 1.0));
}

#endif
