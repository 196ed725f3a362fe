// Draws a segment of a strand as transform_strands and transform_motion have written it, for depth
// and motion: without storage buffers.
//
// Vertices: as those of strand_record_vertex
// Reads:    two records in a row as vertex inputs, StrandViewConstants
// Writes:   MotionPixel
//
// Invariant (tests/shading): the ribbon is that of strand_record_vertex without SMOOTH; where
// neither strand nor camera have moved, the motion is exactly 0.
#include "motion_interface.hlsli"
#include "../strand_record_corner.hlsli"

MotionPixel motion_record_vertex(StrandRecordInput record, uint corner : SV_VertexID) {
  MotionPixel result;
  result.clip = float4(2.0, 2.0, 2.0, 1.0);
  result.motion = float4(0.0, 0.0, 0.0, 1.0);
  result.alpha = float2(0.0, 0.0);
  if (!isSegment(record)) return result;

  RecordCorner at = recordCorner(record, corner);
  NarrowCorner narrow = narrowCorner(at);
  result.clip = narrow.clip;
  result.alpha = float2(unpackHalves(at.look.z).y, narrow.coverage);
  float change = asfloat(at.look.w);
  result.motion = float4(asfloat(at.look.xy), change, at.w - change);
  return result;
}
