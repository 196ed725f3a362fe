// Corners of a segment from two records in a row, which are the vertex inputs of an instance. The
// including file has the layouts of group render.
#ifndef PELAGE_SHADING_STRAND_RECORD_CORNER_HLSLI
#define PELAGE_SHADING_STRAND_RECORD_CORNER_HLSLI

#include "layouts/render.hlsli"
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

struct RecordCorner {
  float2 own;    // [pixels], as in the record
  float2 other;  // the other corner of the same vertex
  float z;       // clip z and w
  float w;
  float halfWidth;  // of the fiber [pixels]
  float side;       // -1 or 1: which edge
  bool wide;        // the two corners differ
  uint4 look;       // the record's third word
};

// Returns true if the two records are ends of a segment that is drawn.
bool isSegment(StrandRecordInput record) {
  uint both = record.shape.w & record.nextShape.w;
  return (both & kRecordDrawn) != 0u && (record.shape.w & kRecordStartsSegment) != 0u;
}

// \param corner 0 and 1 of the first record, 2 and 3 of the next one.
RecordCorner recordCorner(StrandRecordInput record, uint corner) {
  bool second = corner >= 2u;
  uint4 corners = second ? record.nextCorners : record.corners;
  uint4 shape = second ? record.nextShape : record.shape;
  bool high = (corner & 1u) != 0u;
  RecordCorner result;
  result.look = second ? record.nextLook : record.look;
  result.side = high ? 1.0 : -1.0;
  result.z = asfloat(shape.x);
  result.w = asfloat(shape.y);
  result.halfWidth = asfloat(shape.z);
  result.own = asfloat(high ? corners.zw : corners.xy);
  result.other = asfloat(high ? corners.xy : corners.zw);
  result.wide = (shape.w & kRecordWide) != 0u;
  return result;
}

// A corner of a ribbon that is as wide as the fiber, but at least one pixel.
struct NarrowCorner {
  float4 clip;
  float coverage;  // width of the fiber over that of the ribbon, 0..1
};

// Records have a ribbon that is a pixel wider than the fiber.
NarrowCorner narrowCorner(RecordCorner corner) {
  float shown = max(corner.halfWidth, 0.5);
  float2 center = (corner.own + corner.other) * 0.5;
  float2 moved = center + (corner.own - center) * (shown / (corner.halfWidth + 0.5));
  NarrowCorner narrow;
  narrow.clip = clipOfPoint(corner.wide ? moved : corner.own, corner.z, corner.w);
  narrow.coverage = corner.wide ? corner.halfWidth / shown : 1.0;
  return narrow;
}

#endif
