// A vertex of a strand on the screen, in three words of four:
//   0  both corners of the ribbon: x, y, x, y [pixels], row 0 the top row; of a vertex that is not
//      in front of the eye once x and y times w, and w = clip w
//   1  clip z, clip w, half the fiber's width [pixels], flags
//   2  tangent as packDirection() has it, red and green, blue and opacity as halves, UV of the root
//      as packUv() has it
#ifndef PELAGE_SHADING_STRAND_RECORD_HLSLI
#define PELAGE_SHADING_STRAND_RECORD_HLSLI

#include "../base/octahedral.hlsli"
#include "uv_packing.hlsli"

static const uint kRecordWords = 3u;
// Threads of a dispatch over vertices in a row.
static const uint kRecordDispatchRow = 4194304u;
// Flags; below them the material.
static const uint kRecordDrawn = 0x80000000u;
static const uint kRecordStartsSegment = 0x40000000u;  // not the last vertex of its strand
static const uint kRecordWide = 0x20000000u;           // has a normal, so corners of its own
static const uint kRecordMaterial = 63u;
// Vertices nearer to the eye than this, or behind it, have no position on the screen.
static const float kMinClipW = 1e-6;

uint packHalves(float2 value) {
  // Halves end at 65504; NaN gives 0.
  float x = value.x > 0.0 ? min(value.x, 65000.0) : 0.0;
  float y = value.y > 0.0 ? min(value.y, 65000.0) : 0.0;
  return f32tof16(x) | (f32tof16(y) << 16);
}

float2 unpackHalves(uint packed) {
  return float2(f16tof32(packed & 0xffffu), f16tof32(packed >> 16));
}

// Positions are rounded as rasterizers do: to 1/256 of a pixel.
float2 snapped(float2 coordinate) { return floor(coordinate * 256.0 + 0.5) * (1.0 / 256.0); }

// The end of a segment: two corners with one clip z and w. Corners of homogeneous coordinates may
// be scaled at will: those in front of the eye are divided by w.
struct SegmentEnd {
  float2 low;   // corner of side -1: x and y, times w [pixels]
  float2 high;  // of side 1
  float w;      // 1, or clip w
  float z;      // depth, or clip z
  float share;  // factor on a corner's weight for perspective-correct interpolation
};

// Returns true if the end is between the near and the far plane.
bool isInDepth(uint4 record) {
  float z = asfloat(record.x);
  float w = asfloat(record.y);
  return w > kMinClipW && z >= 0.0 && z <= w;
}

SegmentEnd segmentEnd(uint4 corners, uint4 record) {
  float z = asfloat(record.x);
  float w = asfloat(record.y);
  SegmentEnd end;
  end.low = asfloat(corners.xy);
  end.high = asfloat(corners.zw);
  end.w = w;
  end.z = z;
  end.share = 1.0;
  if (w > kMinClipW) {
    end.low = snapped(end.low);
    end.high = snapped(end.high);
    end.w = 1.0;
    end.z = z / w;
    end.share = 1.0 / w;
  }
  return end;
}

#endif
