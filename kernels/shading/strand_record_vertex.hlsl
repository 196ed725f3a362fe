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
#include "strand_record_corner.hlsli"
#include "strand_interface.hlsli"

StrandPixel strand_record_vertex(StrandRecordInput record, uint corner : SV_VertexID,
                                 uint index : SV_InstanceID) {
  StrandPixel result = hiddenStrandPixel(index / max(g_renderVertexCount, 1u));
#if STRAND_UV
  result.uv = unpackUv(record.look.w);
#endif
  if (!isSegment(record)) return result;

  RecordCorner at = recordCorner(record, corner);
  result.tangent = unpackDirection(at.look.x);
  result.color = float4(unpackHalves(at.look.y), unpackHalves(at.look.z));
#if SMOOTH
  result.clip = clipOfPoint(at.own, at.z, at.w);
  result.ribbon = float3(at.wide ? at.side * (at.halfWidth + 0.5) : 0.0, at.halfWidth, 1.0) * at.w;
#else
  NarrowCorner narrow = narrowCorner(at);
  result.clip = narrow.clip;
  result.ribbon = float3(narrow.coverage, 0.0, 1.0);
#endif
  return result;
}
