// Computes the bones of roots on a mesh that an engine deforms: blend shapes and whatever else
// moves a skin beside bones.
//
// Threads: one per element of g_surfaceBones in a part of the mesh, in rows of 2^20.
// Reads:   g_surfaceBones, g_surfaceVertices
// Writes:  g_surfaceTransforms: the bone of each element
// Run it once for each skeleton, part of its mesh and form, in frames in which the engine has
// written vertices.
//
// The rigid motion that takes a triangle's bind frame to its current one, as rootTransforms() of
// pelage/skin_table.h computes it on the host. In the plane of the triangle the map is
//   G = [ edge' / edge, (shear' - shear edge' / edge) / height; 0, height' / height ],
// and the rotation of its polar decomposition, for a positive determinant, has cosine and sine
// proportional to G00 + G11 and G10 - G01.
//
// Invariant (tests/skinning): the bones of rootTransforms() within rounding. A triangle that is not
// finite or has no area (twice it is below 1e-6 of its longest edge's square) becomes a bone that
// skinning does not use: the root stays where it was.
#include "polar_rotation.hlsli"
#include "../base/dispatch.hlsli"

// A root on a triangle, as the mesh was when the hair was bound to it. The triangle's frame has x
// along the edge from corner 0 to 1, z along the normal and y = z cross x. Corner 1 is at (edge, 0)
// and corner 2 at (shear, height) in its plane.
struct SurfaceBone {
  uint4 corners;   // x, y, z: vertices of the triangle; w: bone that is written
  float4 frameX;   // xyz of the bind frame's x axis; w = edge [m], > 0
  float4 frameY;   // xyz of its y axis; w = height [m], > 0
  float4 root;     // xyz bind position of the root [m]; w = shear [m]
  float4 offset;   // xyz of the root from its surface point, in the frame [m]; w = 0
  float4 weights;  // x, y: barycentric weights of corners 1 and 2; zw = 0
};

cbuffer SurfaceBonesConstants : register(b0, space0) {
  uint g_surfaceFirst;         // first element of g_surfaceBones; first: decision 0008
  uint g_surfaceCount;         // elements
  uint g_surfaceStride;        // floats from vertex to vertex in g_surfaceVertices, >= 3
  uint g_surfaceOffset;        // floats before the first position
  float4 g_surfaceOrigin;      // xyz of the origin that bones are relative to, in world space [m]
  float4 g_surfaceOriginRest;  // xyz what rounding has left of it; 0 for whole meters
  uint g_surfaceToDual;        // 1: g_surfaceTransforms has dual quaternions; 0: matrices
  uint g_surfacePad0;
  uint g_surfacePad1;
  uint g_surfacePad2;
};

StructuredBuffer<SurfaceBone> g_surfaceBones : register(t0, space0);
// Positions in world space [m], written by the engine.
StructuredBuffer<float> g_surfaceVertices : register(t1, space0);
// Bind space to the origin's: 3 rows of [M | t] a bone, or 2 quaternions (skinning/bones.hlsli).
RWStructuredBuffer<float4> g_surfaceTransforms : register(u0, space0);

// Twice the area over the square of the longest edge, below which a triangle has none: what floats
// leave of the normal of a thinner one is rounding. (The host, in doubles, goes on to 1e-9.)
static const float kNoArea = 1e-6;
static const float kShortestEdge = 1e-18;  // [m]
// The exponent of a float, and what it is subtracted from to be that of the reciprocal.
static const uint kExponentBits = 0x7f800000u;
static const uint kReciprocalExponents = 0x7f000000u;

float3 surfaceVertex(uint vertex) {
  uint first = g_surfaceOffset + g_surfaceStride * vertex;
  return float3(g_surfaceVertices[first], g_surfaceVertices[first + 1],
                g_surfaceVertices[first + 2]);
}

// The corners, the first one relative to the origin and the others relative to the first one.
struct SurfaceTriangle {
  float3 a;
  float3 u;
  float3 v;
};

SurfaceTriangle triangleOf(SurfaceBone bone) {
  float3 a = surfaceVertex(bone.corners.x);
  float3 b = surfaceVertex(bone.corners.y);
  float3 c = surfaceVertex(bone.corners.z);
  SurfaceTriangle t;
  precise float3 relative = (a - g_surfaceOrigin.xyz) - g_surfaceOriginRest.xyz;
  precise float3 u = b - a;
  precise float3 v = c - a;
  t.a = relative;
  t.u = u;
  t.v = v;
  return t;
}

// Rows of a rotation, and where it takes the root.
struct SurfaceMotion {
  float3 rowX;
  float3 rowY;
  float3 rowZ;
  float3 to;
  bool usable;
};

SurfaceMotion motionOf(SurfaceBone bone) {
  SurfaceTriangle t = triangleOf(bone);
  SurfaceMotion motion;
  motion.rowX = float3(1.0, 0.0, 0.0);
  motion.rowY = float3(0.0, 1.0, 0.0);
  motion.rowZ = float3(0.0, 0.0, 1.0);
  motion.to = t.a;
  precise float3 w = t.v - t.u;
  float3 sizes = max(abs(t.u), max(abs(t.v), abs(w)));
  float largest = max(sizes.x, max(sizes.y, sizes.z));
  motion.usable = isUsable(t.a) && isUsable(t.u) && isUsable(t.v) && largest > kShortestEdge;
  if (!motion.usable) return motion;
  // The edges are scaled to about unit size, so that no product overflows or vanishes. Powers of
  // two round nothing.
  uint exponent = asuint(largest) & kExponentBits;
  float size = asfloat(exponent);
  float inverseSize = asfloat(kReciprocalExponents - exponent);
  precise float3 u = t.u * inverseSize;
  precise float3 v = t.v * inverseSize;
  precise float3 uv = w * inverseSize;
  float longest = max(dot3(u, u), max(dot3(v, v), dot3(uv, uv)));
  float3 normal = cross3(u, v);
  float area = squareRoot(dot3(normal, normal));
  float edge = squareRoot(dot3(u, u));
  motion.usable = area > kNoArea * longest;
  if (!motion.usable) return motion;
  precise float3 x = u / edge;
  precise float3 z = normal / area;
  precise float3 y = cross3(z, x);
  precise float shear = dot3(v, x) * size;
  precise float stretch = edge * size / bone.frameX.w;
  precise float trace = stretch + area / edge * size / bone.frameY.w;
  precise float skew = (bone.root.w * stretch - shear) / bone.frameY.w;
  precise float norm = squareRoot(trace * trace + skew * skew);
  motion.usable = norm > 1e-12 && norm < 1e12;
  if (!motion.usable) return motion;
  precise float cosine = trace / norm;
  precise float sine = skew / norm;
  precise float3 turnedX = x * cosine + y * sine;
  precise float3 turnedY = y * cosine - x * sine;
  float3 bindX = bone.frameX.xyz;
  float3 bindY = bone.frameY.xyz;
  float3 bindZ = cross3(bindX, bindY);
  precise float3 rowX = bindX * turnedX.x + bindY * turnedY.x + bindZ * z.x;
  precise float3 rowY = bindX * turnedX.y + bindY * turnedY.y + bindZ * z.y;
  precise float3 rowZ = bindX * turnedX.z + bindY * turnedY.z + bindZ * z.z;
  motion.rowX = rowX;
  motion.rowY = rowY;
  motion.rowZ = rowZ;
  precise float3 offset = turnedX * bone.offset.x + turnedY * bone.offset.y + z * bone.offset.z;
  precise float3 to = t.a + t.u * bone.weights.x + t.v * bone.weights.y + offset;
  motion.to = to;
  return motion;
}

[numthreads(64, 1, 1)]
void follow_surface(uint3 thread : SV_DispatchThreadID) {
  uint index = indexOfThread(thread);
  if (index >= g_surfaceCount) return;

  SurfaceBone bone = g_surfaceBones[g_surfaceFirst + index];
  SurfaceMotion motion = motionOf(bone);
  float3 root = bone.root.xyz;
  precise float3 shift =
      motion.to - float3(dot3(motion.rowX, root), dot3(motion.rowY, root), dot3(motion.rowZ, root));
  bool usable = motion.usable && isUsable(shift);
  uint target = bone.corners.w;
  if (g_surfaceToDual != 0u) {
    float4 real = quaternionOfRotation(motion.rowX, motion.rowY, motion.rowZ);
    precise float3 halved = shift * 0.5;
    float4 dual = multiplyQuaternions(float4(halved, 0.0), real);
    if (!usable) {
      real = unusableRow();
      dual = unusableRow();
    }
    g_surfaceTransforms[target * 2] = real;
    g_surfaceTransforms[target * 2 + 1] = dual;
    return;
  }
  float4 rowX = float4(motion.rowX, shift.x);
  float4 rowY = float4(motion.rowY, shift.y);
  float4 rowZ = float4(motion.rowZ, shift.z);
  if (!usable) {
    rowX = unusableRow();
    rowY = unusableRow();
    rowZ = unusableRow();
  }
  g_surfaceTransforms[target * 3] = rowX;
  g_surfaceTransforms[target * 3 + 1] = rowY;
  g_surfaceTransforms[target * 3 + 2] = rowZ;
}
