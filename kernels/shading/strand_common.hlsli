// Geometry of strands, for the project's kernels and for an engine's own: no resources.
#ifndef PELAGE_SHADING_STRAND_COMMON_HLSLI
#define PELAGE_SHADING_STRAND_COMMON_HLSLI

struct StrandView {
  float4 clipX;  // rows of the map from world to clip space, depth 0..1, y up
  float4 clipY;
  float4 clipZ;
  float4 clipW;
  float3 eye;           // position of the camera [m]
  float2 viewportSize;  // [pixels]
};

// A corner of the ribbon.
struct StrandCorner {
  float4 clip;
  float coverage;  // width of the fiber over that of the ribbon, 0..1
};

// Returns a direction's motion on the screen [pixels per meter] at a point of clip coordinates
// `clip`, w > 0.
float2 projectDirection(StrandView view, float4 clip, float3 direction) {
  float2 moved = float2(dot(view.clipX.xyz, direction), dot(view.clipY.xyz, direction));
  float movedW = dot(view.clipW.xyz, direction);
  float2 ndc = clip.xy / clip.w;
  return (moved - ndc * movedW) / clip.w * (view.viewportSize * 0.5);
}

// A vertex of a fiber on the screen.
struct StrandImage {
  float4 clip;
  float2 normal;    // unit, at right angles to the fiber's image
  float halfWidth;  // of the image [pixels]
  bool visible;     // else there is no normal
};

// A tangent along the line of sight gets an arbitrary direction on the screen. A vertex that is not
// in front of the eye gets no width; the near plane cuts there.
StrandImage projectStrand(StrandView view, float3 position, float3 tangent, float radius) {
  StrandImage image;
  float4 p = float4(position, 1.0);
  image.clip =
      float4(dot(view.clipX, p), dot(view.clipY, p), dot(view.clipZ, p), dot(view.clipW, p));
  image.normal = float2(0.0, 0.0);
  image.halfWidth = 0.0;
  image.visible = false;
  if (!(image.clip.w > 1e-6)) return image;

  // Across: at right angles to the fiber and to the line of sight, where the fiber shows its width.
  float3 toEye = view.eye - position;
  float3 across = cross(tangent, toEye);
  float squared = dot(across, across);
  if (!(squared > 1e-10 * dot(toEye, toEye))) {
    float3 axis =
        abs(toEye.y) < abs(toEye.x) + abs(toEye.z) ? float3(0.0, 1.0, 0.0) : float3(1.0, 0.0, 0.0);
    across = cross(axis, toEye);
    squared = dot(across, across);
  }
  across *= 1.0 / sqrt(max(squared, 1e-30));

  // The ribbon is at right angles to the fiber's image; `across` is that only near the center.
  float2 width = projectDirection(view, image.clip, across);
  float2 along = projectDirection(view, image.clip, tangent);
  float2 normal = float2(-along.y, along.x);
  // An image shorter than a thousandth of the width is rounding, not a direction.
  if (!(dot(along, along) > 1e-6 * dot(width, width))) normal = width;
  float normalSquared = dot(normal, normal);
  if (!(normalSquared > 1e-30)) return image;
  normal *= 1.0 / sqrt(normalSquared);
  if (dot(normal, width) < 0.0) normal = -normal;
  image.normal = normal;
  image.halfWidth = radius * dot(normal, width);
  image.visible = true;
  return image;
}

float4 moveOnScreen(StrandView view, float4 clip, float2 pixels) {
  float2 offset = pixels / (view.viewportSize * 0.5);
  clip.xy += offset * clip.w;
  return clip;
}

// Returns the corner of a camera-facing ribbon at a vertex of a strand. Its width on the screen is
// that of the fiber, but at least one pixel. Coverage compensates for the extra width, so the
// covered area stays that of the fiber.
// \param position world position [m], \param tangent unit tangent, \param radius of the fiber [m].
// \param side -1 or 1: which edge.
StrandCorner expandStrandVertex(StrandView view, float3 position, float3 tangent, float radius,
                                float side) {
  StrandImage image = projectStrand(view, position, tangent, radius);
  StrandCorner corner;
  corner.clip = image.clip;
  corner.coverage = 1.0;
  if (!image.visible) return corner;
  float shown = max(image.halfWidth, 0.5);
  corner.coverage = image.halfWidth / shown;
  corner.clip = moveOnScreen(view, image.clip, image.normal * (side * shown));
  return corner;
}

// A corner of a ribbon that extends half a pixel past the fiber on both sides: it contains all
// pixels whose unit box, laid across the fiber, overlaps the fiber. Distance and half width are
// linear on the screen. Not every API interpolates without perspective, so pass both times clip.w
// to the pixel stage, and clip.w to divide by.
struct StrandRibbon {
  float4 clip;
  float distance;   // signed, from the center line [pixels]
  float halfWidth;  // of the fiber [pixels], >= 0
};

// Maximum width of an image; wider ones are fibers that touch the eye.
static const float kWidestFiber = 32768.0;

// Arguments as for expandStrandVertex.
StrandRibbon expandStrandRibbon(StrandView view, float3 position, float3 tangent, float radius,
                                float side) {
  StrandImage image = projectStrand(view, position, tangent, radius);
  StrandRibbon ribbon;
  ribbon.clip = image.clip;
  ribbon.distance = 0.0;
  ribbon.halfWidth = 0.0;
  if (!image.visible) return ribbon;
  // Also false for a radius that is not a number.
  if (image.halfWidth > 0.0) ribbon.halfWidth = min(image.halfWidth, kWidestFiber);
  ribbon.distance = side * (ribbon.halfWidth + 0.5);
  ribbon.clip = moveOnScreen(view, image.clip, image.normal * ribbon.distance);
  return ribbon;
}

// Returns the share of a pixel that a fiber covers; the pixel is a unit box across the fiber. Over
// all distances it sums to the fiber's width, however thin the fiber is.
// \param distance of the pixel's center from the center line, \param halfWidth of the fiber
// [pixels].
float ribbonCoverage(float distance, float halfWidth) {
  float covered = min(distance + 0.5, halfWidth) - max(distance - 0.5, -halfWidth);
  // Also 0 where it is not a number.
  return covered > 0.0 ? min(covered, 1.0) : 0.0;
}

#endif
