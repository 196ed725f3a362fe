// Draws a segment of a strand as transform_strands has placed it: without storage buffers, which
// the vertex stage of many devices does not have.
//
// Vertices: one instance per record but the last one, and of each a strip of 4 vertices: the two
//           corners of the record and the two of the next one. The last vertex of a strand starts
//           no segment; its instance is outside the picture.
// Reads:    two records in a row as vertex inputs, RenderConstants, StrandViewConstants
// Writes:   the outputs of StrandPixel, with SMOOTH and without it as strand_vertex does
//
// Invariant (tests/shading): the same picture as with strand_vertex, but for the rounding of
// records: positions to some 1e-4 pixels, colors to halves.
#include "layouts/render.hlsli"
#include "strand_interface.hlsli"
#include "strand_record.hlsli"

struct StrandRecordInput {
  [[vk::location(0)]] uint4 corners : ATTRIBUTE0;
  [[vk::location(1)]] uint4 shape : ATTRIBUTE1;
  [[vk::location(2)]] uint4 look : ATTRIBUTE2;
  [[vk::location(3)]] uint4 nextCorners : ATTRIBUTE3;
  [[vk::location(4)]] uint4 nextShape : ATTRIBUTE4;
  [[vk::location(5)]] uint4 nextLook : ATTRIBUTE5;
};

// The inverse of pointOfClip() in transform_strands.
float4 clipOfPoint(float2 coordinate, float z, float w) {
  float2 extent = g_viewport.zw * 0.5;
  float2 turned = (coordinate - w * extent) / extent;
  if (w > kMinClipW) turned = (coordinate - extent) / extent * w;
  return float4(turned.x, -turned.y, z, w);
}

StrandPixel strand_record_vertex(StrandRecordInput record, uint corner : SV_VertexID,
                                 uint index : SV_InstanceID) {
  StrandPixel result;
  result.clip = float4(2.0, 2.0, 2.0, 1.0);
  result.tangent = float3(0.0, 1.0, 0.0);
  result.color = float4(0.0, 0.0, 0.0, 0.0);
  result.ribbon = float3(0.0, 0.0, 1.0);
#if !SMOOTH
  result.strand = index / max(g_renderVertexCount, 1u);
#endif
  uint both = record.shape.w & record.nextShape.w;
  if ((both & kRecordDrawn) == 0u || (record.shape.w & kRecordStartsSegment) == 0u) return result;

  bool second = corner >= 2u;
  uint4 corners = second ? record.nextCorners : record.corners;
  uint4 shape = second ? record.nextShape : record.shape;
  uint4 look = second ? record.nextLook : record.look;
  bool high = (corner & 1u) != 0u;
  float side = high ? 1.0 : -1.0;
  float w = asfloat(shape.y);
  float halfWidth = asfloat(shape.z);
  float2 own = asfloat(high ? corners.zw : corners.xy);
  float2 other = asfloat(high ? corners.xy : corners.zw);
  result.tangent = unpackDirection(look.x);
  result.color = float4(unpackHalves(look.y), unpackHalves(look.z));
  bool wide = (shape.w & kRecordWide) != 0u;
#if SMOOTH
  result.clip = clipOfPoint(own, asfloat(shape.x), w);
  result.ribbon = float3(wide ? side * (halfWidth + 0.5) : 0.0, halfWidth, 1.0) * w;
#else
  // Records have a ribbon that is a pixel wider than the fiber.
  float shown = max(halfWidth, 0.5);
  float2 center = (own + other) * 0.5;
  float2 moved = center + (own - center) * (shown / (halfWidth + 0.5));
  result.clip = clipOfPoint(wide ? moved : own, asfloat(shape.x), w);
  result.ribbon = float3(wide ? halfWidth / shown : 1.0, 0.0, 1.0);
#endif
  return result;
}
