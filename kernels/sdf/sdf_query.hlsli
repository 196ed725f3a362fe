// Distance, normal and motion of the surface of a signed distance field at a point.
//
// The file that includes it defines SDF_KEYS and SDF_SURFACE, the buffers (uint and uint4) of all
// fields, and SDF_CLOSEST_FEATURE as 0 to take the trilinear distance and its gradient for what is
// near, too: cheaper, and 4 degrees off. All here is in cells from node 0, in the space and at the
// time of the field: the end of a frame.
#ifndef PELAGE_SDF_SDF_QUERY_HLSLI
#define PELAGE_SDF_SDF_QUERY_HLSLI

#include "sdf_key.hlsli"
#include "sdf_closest.hlsli"

#ifndef SDF_CLOSEST_FEATURE
#define SDF_CLOSEST_FEATURE 1
#endif

// Steps over adjacent triangles from the best one of the corners, where the file that includes it
// says nothing else. 95 % of the normals within a cell of a body with triangles far smaller than a
// cell are off by 56 degrees without a step, by 2 with two and by 0.001 with four.
#ifndef SDF_WALK
#define SDF_WALK 4
#endif
static const uint kSdfWalk = SDF_WALK;
// Below this distance a point is on the surface: its offset has no direction [cell].
static const float kSdfTouch = 1e-4;
// What distances of keys may be off by [cell], with room.
static const float kSdfKeyError = 5e-3;

struct SdfHit {
  bool found;       // nearer than was asked for; else the distance is a lower bound and the rest 0
  float distance;   // [cell], negative inside
  float3 normal;    // unit, outwards
  float3 motion;    // of the surface in the frame [cell]
};

// The eight nodes around a point, seen from the nearest one: corner k is one node further along x,
// y and z where its bits 0, 1 and 2 are set.
struct SdfPlace {
  bool inside;   // of the grid
  uint node;     // element of the nearest node
  uint3 onward;  // what leads to the next node along each axis, modulo 2^32
  float3 share;  // of the way to it, 0..0.5
  float3 side;   // its direction, -1 or 1
};

SdfPlace sdfPlaceOf(SdfField field, float3 p) {
  SdfPlace place;
  place.inside = false;
  place.node = 0;
  place.onward = uint3(0, 0, 0);
  place.share = float3(0.0, 0.0, 0.0);
  place.side = float3(1.0, 1.0, 1.0);
  uint3 nodes = field.nodes.xyz;
  if (!isUsable(p) || min(nodes.x, min(nodes.y, nodes.z)) < 2u) return place;
  float3 last = float3(nodes - 1u);
  if (min(p.x, min(p.y, p.z)) < 0.0 || p.x >= last.x || p.y >= last.y || p.z >= last.z)
    return place;
  uint3 nearest = uint3(p + 0.5);
  precise float3 off = p - float3(nearest);
  uint row = nodes.x;
  uint slice = nodes.x * nodes.y;
  place.inside = true;
  place.node = field.nodes.w + nearest.x + row * nearest.y + slice * nearest.z;
  place.onward = uint3(off.x < 0.0 ? 0u - 1u : 1u, off.y < 0.0 ? 0u - row : row,
                       off.z < 0.0 ? 0u - slice : slice);
  place.share = abs(off);
  place.side = float3(off.x < 0.0 ? -1.0 : 1.0, off.y < 0.0 ? -1.0 : 1.0, off.z < 0.0 ? -1.0 : 1.0);
  return place;
}

// As sdfDistance(), of four keys.
// \param scale  x band, y [cell] a near code, z [cell] a far code
float4 sdfDistances(uint4 keys, uint triangleBits, float3 scale) {
  uint4 magnitudes = keys & kSdfUnset;
  float4 codes = float4((magnitudes & (kSdfFar - 1u)) >> triangleBits);
  precise float4 close = codes * scale.y;
  precise float4 distant = codes * scale.z + scale.x;
  float4 r;
  r.x = (magnitudes.x & kSdfFar) != 0u ? distant.x : close.x;
  r.y = (magnitudes.y & kSdfFar) != 0u ? distant.y : close.y;
  r.z = (magnitudes.z & kSdfFar) != 0u ? distant.z : close.z;
  r.w = (magnitudes.w & kSdfFar) != 0u ? distant.w : close.w;
  r.x = magnitudes.x == kSdfUnset ? scale.x : r.x;
  r.y = magnitudes.y == kSdfUnset ? scale.x : r.y;
  r.z = magnitudes.z == kSdfUnset ? scale.x : r.z;
  r.w = magnitudes.w == kSdfUnset ? scale.x : r.w;
  r.x = sdfIsInside(keys.x) ? -r.x : r.x;
  r.y = sdfIsInside(keys.y) ? -r.y : r.y;
  r.z = sdfIsInside(keys.z) ? -r.z : r.z;
  r.w = sdfIsInside(keys.w) ? -r.w : r.w;
  return r;
}

float sdfGreatest(float4 a, float4 b) {
  float4 m = max(a, b);
  return max(max(m.x, m.y), max(m.z, m.w));
}

// Distances at the corners.
struct SdfCorners {
  float4 low;   // corners 0 - 3
  float4 high;  // corners 4 - 7
};

// Trilinear distance; its gradient is the exact one of the interpolation.
struct SdfSlope {
  float distance;
  float3 gradient;
};

SdfSlope sdfTrilinear(SdfCorners corners, SdfPlace place) {
  float3 t = place.share;
  float4 low = corners.low;
  float4 high = corners.high;
  precise float4 alongZ = high - low;
  precise float4 flat = low + alongZ * t.z;
  precise float2 alongY = flat.zw - flat.xy;
  precise float2 row = flat.xy + alongY * t.y;
  precise float slopeX = row.y - row.x;
  precise float value = row.x + slopeX * t.x;
  precise float slopeY = alongY.x + (alongY.y - alongY.x) * t.x;
  precise float2 rowZ = alongZ.xy + (alongZ.zw - alongZ.xy) * t.y;
  precise float slopeZ = rowZ.x + (rowZ.y - rowZ.x) * t.x;
  precise float3 gradient = float3(slopeX, slopeY, slopeZ) * place.side;
  SdfSlope slope;
  slope.distance = value;
  slope.gradient = gradient;
  return slope;
}

// The key of corner k out of eight.
uint sdfCornerKey(uint4 low, uint4 high, uint k) {
  uint4 four = k < 4u ? low : high;
  uint2 two = (k & 2u) == 0u ? four.xy : four.zw;
  return (k & 1u) == 0u ? two.x : two.y;
}

bool isOneOf(uint index, uint4 four) { return any(four == uint4(index, index, index, index)); }

// Corners whose triangle no corner before them has, one bit each.
uint sdfDistinctCorners(uint4 low, uint4 high) {
  uint none = kSdfNone;
  uint4 later = uint4(none, high.x, high.y, high.z);
  uint pending = low.x != none ? 1u : 0u;
  pending |= isOneOf(low.y, uint4(none, low.x, none, none)) ? 0u : 2u;
  pending |= isOneOf(low.z, uint4(none, low.xy, none)) ? 0u : 4u;
  pending |= isOneOf(low.w, uint4(none, low.xyz)) ? 0u : 8u;
  pending |= high.x == none || isOneOf(high.x, low) ? 0u : 16u;
  pending |= isOneOf(high.y, low) || isOneOf(high.y, uint4(later.xy, none, none)) ? 0u : 32u;
  pending |= isOneOf(high.z, low) || isOneOf(high.z, uint4(later.xyz, none)) ? 0u : 64u;
  pending |= isOneOf(high.w, low) || isOneOf(high.w, later) ? 0u : 128u;
  return pending;
}

// Triangles of keys; kSdfNone of one that is not set, or of another field.
uint4 sdfTriangles(SdfField field, uint4 keys) {
  uint mask = (1u << field.triangleBits) - 1u;
  uint4 t = keys & mask;
  return uint4(sdfIsSet(keys.x) && t.x < field.triangleCount ? t.x : kSdfNone,
               sdfIsSet(keys.y) && t.y < field.triangleCount ? t.y : kSdfNone,
               sdfIsSet(keys.z) && t.z < field.triangleCount ? t.z : kSdfNone,
               sdfIsSet(keys.w) && t.w < field.triangleCount ? t.w : kSdfNone);
}

#if SDF_CLOSEST_FEATURE
// The nearest of the corners' triangles, the one of the nearest corner first, and from there to
// nearer triangles beside it. (Where a surface is hollow, one beside a face may be nearer.)
SdfClosest sdfClosestFeature(SdfField field, float3 p, uint4 low, uint4 high) {
  SdfClosest best = noTriangle();
  uint pending = sdfDistinctCorners(low, high);
  uint walked = 0;
  uint came = kSdfNone;
  uint start = kSdfNone;
  uint3 beside = uint3(kSdfNone, kSdfNone, kSdfNone);
  // One loop, so that the threads of a wave that look at corners and those that walk share it.
  [loop] for (uint turn = 0; turn < 8 + 3 * kSdfWalk; ++turn) {
    uint index = kSdfNone;
    if (pending != 0u) {
      uint k = firstbitlow(pending);
      pending = pending & (pending - 1u);
      index = sdfCornerKey(low, high, k);
    } else {
      uint nearest = min(beside.x, min(beside.y, beside.z));
      if (nearest == kSdfNone) {
        if (walked >= kSdfWalk || best.index == start || best.index == kSdfNone) break;
        came = start;
        start = best.index;
        ++walked;
        beside = sdfNeighbours(field, start);
        // Not what has been looked at.
        bool3 known = bool3(isOneOf(beside.x, low) || isOneOf(beside.x, high),
                            isOneOf(beside.y, low) || isOneOf(beside.y, high),
                            isOneOf(beside.z, low) || isOneOf(beside.z, high));
        beside = uint3(known.x || beside.x == came ? kSdfNone : beside.x,
                       known.y || beside.y == came ? kSdfNone : beside.y,
                       known.z || beside.z == came ? kSdfNone : beside.z);
        nearest = min(beside.x, min(beside.y, beside.z));
      }
      index = nearest;
      beside = uint3(beside.x == nearest ? kSdfNone : beside.x,
                     beside.y == nearest ? kSdfNone : beside.y,
                     beside.z == nearest ? kSdfNone : beside.z);
    }
    if (index < field.triangleCount) {
      SdfClosest found = closestOnCorners(loadSdfCorners(field, index), p, index);
      if (found.squared < best.squared) best = found;
    }
  }
  return best;
}
#endif

// What the keys around a point tell of its distance.
struct SdfNear {
  bool may;        // be nearer than the reach; else only the distance counts
  float distance;  // a lower bound [cell]
  SdfPlace place;
  uint4 low;       // keys of the corners 0 - 3
  uint4 high;      // and 4 - 7
  SdfCorners corners;
  float4 lowAway;  // squared ways to the corners
  float4 highAway;
};

// \param reach  [cell] what is further from the surface, or outside the grid, is not looked at
SdfNear sdfNearOf(SdfField field, float3 p, float reach) {
  SdfNear near = (SdfNear)0;
  near.distance = field.band;
  near.place = sdfPlaceOf(field, p);
  if (!near.place.inside) return near;
  SdfPlace place = near.place;

  float most = sdfGreatestCode(field.triangleBits);
  precise float3 scale = float3(field.band, field.band / most, field.farRange / most);
  precise float3 away = place.share * place.share;
  precise float3 back = (1.0 - place.share) * (1.0 - place.share);
  // The distance changes by no more than the way: no corner may be further from the surface than
  // from the point and the reach together. For most points the nearest corner tells.
  uint key = SDF_KEYS[place.node];
  precise float first = sdfDistance(key, field.band, field.farRange, field.triangleBits);
  precise float bound = first - squareRoot(away.x + away.y + away.z) - kSdfKeyError;
  near.distance = min(bound, field.band);
  if (bound > reach) return near;

  uint4 onward = uint4(0u, place.onward.x, place.onward.y, place.onward.x + place.onward.y);
  uint4 lowNodes = onward + place.node;
  uint4 highNodes = lowNodes + place.onward.z;
  near.low = uint4(key, SDF_KEYS[lowNodes.y], SDF_KEYS[lowNodes.z], SDF_KEYS[lowNodes.w]);
  near.high = uint4(SDF_KEYS[highNodes.x], SDF_KEYS[highNodes.y], SDF_KEYS[highNodes.z],
                    SDF_KEYS[highNodes.w]);
  near.corners.low = sdfDistances(near.low, field.triangleBits, scale);
  near.corners.high = sdfDistances(near.high, field.triangleBits, scale);
  precise float4 flat =
      float4(away.x + away.y, back.x + away.y, away.x + back.y, back.x + back.y);
  precise float4 lowAway = flat + away.z;
  precise float4 highAway = flat + back.z;
  near.lowAway = lowAway;
  near.highAway = highAway;
  precise float4 lowClear = max(near.corners.low - (reach + kSdfKeyError), 0.0);
  precise float4 highClear = max(near.corners.high - (reach + kSdfKeyError), 0.0);
  precise float4 lowBeyond = lowClear * lowClear - lowAway;
  precise float4 highBeyond = highClear * highClear - highAway;
  near.may = !(sdfGreatest(lowBeyond, highBeyond) > 0.0);
  if (!near.may) near.distance = max(near.distance, reach);
  return near;
}

// \param reach  as above
SdfHit sdfQuery(SdfField field, float3 p, float reach) {
  SdfNear near = sdfNearOf(field, p, reach);
  SdfHit hit;
  hit.found = false;
  hit.distance = near.distance;
  hit.normal = float3(0.0, 0.0, 0.0);
  hit.motion = float3(0.0, 0.0, 0.0);
  if (!near.may) return hit;
  SdfCorners corners = near.corners;
  float4 lowAway = near.lowAway;
  float4 highAway = near.highAway;
  uint4 lowTriangles = sdfTriangles(field, near.low);
  uint4 highTriangles = sdfTriangles(field, near.high);
  SdfSlope slope = sdfTrilinear(corners, near.place);

#if SDF_CLOSEST_FEATURE
  SdfClosest best = sdfClosestFeature(field, p, lowTriangles, highTriangles);
  if (best.index == kSdfNone) return hit;
  SdfSide side = sdfSideOf(field, best, slope.distance < 0.0);
  hit.distance = side.distance;
  hit.normal = side.normal;
  // Meshes that overlap have sheets inside. Where a corner is deeper than it is away from the point
  // the point is inside, whatever sheet is nearest.
  precise float4 lowDeep = max(-corners.low - kSdfKeyError, 0.0);
  precise float4 highDeep = max(-corners.high - kSdfKeyError, 0.0);
  precise float4 lowWithin = lowDeep * lowDeep - lowAway;
  precise float4 highWithin = highDeep * highDeep - highAway;
  bool within = sdfGreatest(lowWithin, highWithin) > 0.0;
  if (within && hit.distance > kSdfTouch) {
    hit.distance = min(slope.distance, 0.0);
    hit.normal = directionOr(slope.gradient, side.normal);
  }
  hit.found = hit.distance < reach;
  if (hit.found) hit.motion = sdfMotionAt(field, best.index, best.weights);
#else
  hit.distance = slope.distance;
  float3 none = float3(0.0, 0.0, 0.0);
  hit.normal = directionOr(slope.gradient, none);
  hit.found = hit.distance < reach && dot3(hit.normal, hit.normal) > 0.0;
  if (hit.found && lowTriangles.x != kSdfNone)
    hit.motion = sdfMotionAt(field, lowTriangles.x, float2(1.0 / 3.0, 1.0 / 3.0));
#endif
  return hit;
}

#endif
