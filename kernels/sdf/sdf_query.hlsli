// Distance, normal and motion of the surface of an SDF at a point.
//
// The including file defines SDF_KEYS and SDF_SURFACE, the buffers (uint and uint4) of all SDFs,
// and SDF_CLOSEST_FEATURE, 0 to use the trilinear distance and its gradient for near points, too:
// cheaper, and 4 degrees off. With SDF_DENSE there are SDFs without triangles, too, which an engine
// has filled: their distance is the trilinear one. Units are cells from node 0, in the space of the
// SDF at the end of a frame.
#ifndef PELAGE_SDF_SDF_QUERY_HLSLI
#define PELAGE_SDF_SDF_QUERY_HLSLI

#include "sdf_key.hlsli"
#include "sdf_closest.hlsli"

#ifndef SDF_CLOSEST_FEATURE
#define SDF_CLOSEST_FEATURE 1
#endif
#ifndef SDF_DENSE
#define SDF_DENSE 0
#endif

// Steps over adjacent triangles from the best one of the corners. 95 % of the normals within a cell
// of a body with triangles far smaller than a cell are off by 56 degrees without a step, by 2 with
// two and by 0.001 with four.
static const uint kSdfWalk = 4;
// Below this distance a point is on the surface: its offset has no direction [cell].
static const float kSdfContact = 1e-4;
// If a corner's triangle is as far as the distances of the corners say, within this tolerance, no
// other triangle is tested [cell]: 5 to 6 triangles per query instead of 12 or more. With 0.15 it
// is one less, and 1 % of the normals are off by 5 degrees.
static const float kSdfAgrees = 0.05;
// Number of searches for the triangle at the foot of a deep point, and their maximum range [cell].
static const uint kSdfFeet = 4;
static const float kSdfFootRange = 4.0;
// Order value of corners that have been tested: after all others.
static const float kSdfLooked = 1e30;
// Error bound of the distances of keys [cell], with slack.
static const float kSdfKeyError = 5e-3;

struct SdfHit {
  bool found;  // nearer than the query's range; else the distance is a lower bound and the rest 0
  float distance;  // [cell], negative inside
  float3 normal;   // unit, outwards
  float3 motion;   // of the surface in the frame [cell]
};

// The eight nodes around a point, seen from the nearest one: corner k is one node further along x,
// y and z where its bits 0, 1 and 2 are set.
struct SdfLocation {
  bool inside;   // of the grid
  uint node;     // element of the nearest node
  uint3 onward;  // offset to the next node along each axis, modulo 2^32
  float3 share;  // fraction of the distance to it, 0..0.5
  float3 side;   // its direction, -1 or 1
};

// \param shift  0: of all nodes; else of those whose coordinates are multiples of 2^shift. Beyond
//               the last of these the point is taken to be at it.
SdfLocation sdfLocationOf(Sdf sdf, float3 p, uint shift) {
  SdfLocation location;
  location.inside = false;
  location.node = 0;
  location.onward = uint3(0, 0, 0);
  location.share = float3(0.0, 0.0, 0.0);
  location.side = float3(1.0, 1.0, 1.0);
  uint3 nodes = sdf.nodes.xyz;
  float3 last = float3(nodes - 1u);
  bool inside = isUsable(p) && min(nodes.x, min(nodes.y, nodes.z)) >= 2u &&
                min(p.x, min(p.y, p.z)) >= 0.0 && p.x < last.x && p.y < last.y && p.z < last.z;
  if (inside) {
    uint3 most = (nodes - 1u) >> shift;
    precise float3 q = p / float(1u << shift);
    uint3 nearest = min(uint3(q + 0.5), most);
    precise float3 off = q - float3(nearest);
    bool3 back = bool3(off.x < 0.0 || nearest.x == most.x, off.y < 0.0 || nearest.y == most.y,
                       off.z < 0.0 || nearest.z == most.z);
    uint3 strides = uint3(most.x > 0u ? 1u : 0u, most.y > 0u ? nodes.x : 0u,
                          most.z > 0u ? nodes.x * nodes.y : 0u)
                    << shift;
    location.inside = true;
    location.node =
        sdf.nodes.w + ((nearest.x + nodes.x * (nearest.y + nodes.y * nearest.z)) << shift);
    location.onward =
        uint3(back.x ? 0u - strides.x : strides.x, back.y ? 0u - strides.y : strides.y,
              back.z ? 0u - strides.z : strides.z);
    location.share = float3(back.x ? max(-off.x, 0.0) : off.x, back.y ? max(-off.y, 0.0) : off.y,
                            back.z ? max(-off.z, 0.0) : off.z);
    location.side = float3(back.x ? -1.0 : 1.0, back.y ? -1.0 : 1.0, back.z ? -1.0 : 1.0);
  }
  return location;
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

SdfSlope sdfTrilinear(SdfCorners corners, SdfLocation location) {
  float3 t = location.share;
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
  precise float3 gradient = float3(slopeX, slopeY, slopeZ) * location.side;
  SdfSlope slope;
  slope.distance = value;
  slope.gradient = gradient;
  return slope;
}

// Triangles of keys; kSdfNone of one that is not set, or of another SDF.
uint4 sdfTriangles(Sdf sdf, uint4 keys) {
  uint mask = (1u << sdf.triangleBits) - 1u;
  uint4 t = keys & mask;
  return uint4(sdfIsSet(keys.x) && t.x < sdf.triangleCount ? t.x : kSdfNone,
               sdfIsSet(keys.y) && t.y < sdf.triangleCount ? t.y : kSdfNone,
               sdfIsSet(keys.z) && t.z < sdf.triangleCount ? t.z : kSdfNone,
               sdfIsSet(keys.w) && t.w < sdf.triangleCount ? t.w : kSdfNone);
}

// The data of the eight nodes around a point.
struct SdfCell {
  SdfLocation location;
  uint4 low;   // keys of the corners 0 - 3
  uint4 high;  // and 4 - 7
  SdfCorners corners;
  float4 lowOffset;  // squared distances to the corners, in steps from node to node
  float4 highOffset;
};

// \param key  of the nearest node
SdfCell sdfCellOf(Sdf sdf, SdfLocation location, uint key) {
  float most = sdfGreatestCode(sdf.triangleBits);
  precise float3 scale = float3(sdf.band, sdf.band / most, sdf.farRange / most);
  precise float3 away = location.share * location.share;
  precise float3 back = (1.0 - location.share) * (1.0 - location.share);
  uint4 onward =
      uint4(0u, location.onward.x, location.onward.y, location.onward.x + location.onward.y);
  uint4 lowNodes = onward + location.node;
  uint4 highNodes = lowNodes + location.onward.z;
  SdfCell cell;
  cell.location = location;
  cell.low = uint4(key, SDF_KEYS[lowNodes.y], SDF_KEYS[lowNodes.z], SDF_KEYS[lowNodes.w]);
  cell.high = uint4(SDF_KEYS[highNodes.x], SDF_KEYS[highNodes.y], SDF_KEYS[highNodes.z],
                    SDF_KEYS[highNodes.w]);
  cell.corners.low = sdfDistances(cell.low, sdf.triangleBits, scale);
  cell.corners.high = sdfDistances(cell.high, sdf.triangleBits, scale);
  precise float4 flat = float4(away.x + away.y, back.x + away.y, away.x + back.y, back.x + back.y);
  precise float4 lowOffset = flat + away.z;
  precise float4 highOffset = flat + back.z;
  cell.lowOffset = lowOffset;
  cell.highOffset = highOffset;
  return cell;
}

#if SDF_CLOSEST_FEATURE
// Returns `there` for the components that are the index, `else4` for the others.
float4 sdfWhere(uint4 indices, uint index, float4 there, float4 else4) {
  return float4(indices.x == index ? there.x : else4.x, indices.y == index ? there.y : else4.y,
                indices.z == index ? there.z : else4.z, indices.w == index ? there.w : else4.w);
}

// Neighbors of a triangle that may be nearer: across the edge that the closest point is on, across
// the two edges at the vertex, or across the edge that is nearest to it on the face.
uint3 sdfBeside(Sdf sdf, SdfClosest closest) {
  uint3 beside = sdfNeighbors(sdf, closest.index);
  precise float rest = 1.0 - closest.weights.x - closest.weights.y;
  float least = min(rest, min(closest.weights.x, closest.weights.y));
  // For the edges 01, 12, 20, opposite the vertices 2, 0, 1.
  bool3 crosses = bool3(closest.weights.y <= least, rest <= least, closest.weights.x <= least);
  return uint3(crosses.x ? beside.x : kSdfNone, crosses.y ? beside.y : kSdfNone,
               crosses.z ? beside.z : kSdfNone);
}

// Returns the triangle at the point's foot on the plane of another one, at most kSdfFootRange from
// its closest point: where a surface is nearly flat, this is the nearest one.
uint sdfTriangleAtFoot(Sdf sdf, float3 p, SdfClosest closest) {
  float3 none = float3(0.0, 0.0, 0.0);
  float3 normal = directionOr(sdfFaceNormal(loadSdfCorners(sdf, closest.index)), none);
  precise float3 aside = closest.offset - normal * dot3(closest.offset, normal);
  precise float size = squareRoot(dot3(aside, aside));
  precise float share = size > kSdfFootRange ? kSdfFootRange / size : 1.0;
  precise float3 foot = p - closest.offset + aside * share;
  SdfLocation location = sdfLocationOf(sdf, foot, 0u);
  uint index = kSdfNone;
  if (location.inside) index = sdfTriangles(sdf, SDF_KEYS[location.node].xxxx).x;
  return index;
}

// Finds the nearest of the corners' triangles, and from there crosses to nearer ones.
//
// It starts with the corner that agrees best with the point's direction along the gradient, then
// tests the next one. If one is about as far as the distances of the corners say, and the point is
// on the side that they say, the others are skipped. Deep inside, where corners are far apart, it
// looks up the triangle at the point's foot. Last, it crosses edges to nearer triangles. (Where a
// surface is concave, a triangle beside a face may be nearer.)
SdfClosest sdfClosestFeature(Sdf sdf, float3 p, SdfCell cell, uint4 low, uint4 high, SdfSlope slope,
                             bool deep) {
  float3 level = float3(0.0, 0.0, 0.0);
  precise float3 along = directionOr(slope.gradient, level) * cell.location.side;
  precise float3 behind = -(along * cell.location.share);
  precise float3 ahead = behind + along;
  precise float4 flat =
      float4(behind.x + behind.y, ahead.x + behind.y, behind.x + ahead.y, ahead.x + ahead.y);
  precise float4 lowAlong = flat + behind.z;
  precise float4 highAlong = flat + ahead.z;
  precise float4 lowOff = cell.lowOffset - lowAlong * lowAlong;
  precise float4 highOff = cell.highOffset - highAlong * highAlong;
  float4 looked = float4(kSdfLooked, kSdfLooked, kSdfLooked, kSdfLooked);
  lowOff = sdfWhere(low, kSdfNone, looked, lowOff);
  highOff = sdfWhere(high, kSdfNone, looked, highOff);

  SdfClosest best = noTriangle();
  float expected = abs(slope.distance);
  uint feet = deep ? kSdfFeet : 0u;
  uint walked = 0;
  uint came = kSdfNone;
  uint start = kSdfNone;
  uint3 beside = uint3(kSdfNone, kSdfNone, kSdfNone);
  // One loop, so that threads of a wave that test corners and threads that walk share it.
  [loop] for (uint turn = 0; turn < 8u + kSdfFeet + 3u * kSdfWalk; ++turn) {
    uint index = kSdfNone;
    float4 least4 = min(lowOff, highOff);
    float least = min(min(least4.x, least4.y), min(least4.z, least4.w));
    bool corner = least < kSdfLooked;
    if (corner) {
      index = highOff.w == least ? high.w : index;
      index = highOff.z == least ? high.z : index;
      index = highOff.y == least ? high.y : index;
      index = highOff.x == least ? high.x : index;
      index = lowOff.w == least ? low.w : index;
      index = lowOff.z == least ? low.z : index;
      index = lowOff.y == least ? low.y : index;
      index = lowOff.x == least ? low.x : index;
      lowOff = sdfWhere(low, index, looked, lowOff);
      highOff = sdfWhere(high, index, looked, highOff);
    } else if (best.index == kSdfNone) {
      break;
    } else if (feet > 0u) {
      feet = best.feature == kSdfFace ? 0u : feet - 1u;
      if (feet > 0u) index = sdfTriangleAtFoot(sdf, p, best);
      if (index == best.index) {
        index = kSdfNone;
        feet = 0u;
      }
    } else {
      uint nearest = min(beside.x, min(beside.y, beside.z));
      if (nearest == kSdfNone) {
        if (walked >= kSdfWalk || best.index == start) break;
        came = start;
        start = best.index;
        ++walked;
        beside = sdfBeside(sdf, best);
        beside =
            uint3(beside.x == came ? kSdfNone : beside.x, beside.y == came ? kSdfNone : beside.y,
                  beside.z == came ? kSdfNone : beside.z);
        nearest = min(beside.x, min(beside.y, beside.z));
      }
      index = nearest;
      beside = uint3(beside.x == nearest ? kSdfNone : beside.x,
                     beside.y == nearest ? kSdfNone : beside.y,
                     beside.z == nearest ? kSdfNone : beside.z);
    }
    if (index < sdf.triangleCount) {
      SdfCorner3 corners = loadSdfCorners(sdf, index);
      SdfClosest found = closestOnCorners(corners, p, index);
      bool nearer = found.squared < best.squared;
      if (nearer) best = found;
      if (!nearer && !corner) feet = 0u;
      // The far side of a thin plate may be as far as that by chance, but shows its back.
      bool sameSide = (dot3(found.offset, sdfFaceNormal(corners)) < 0.0) == (slope.distance < 0.0);
      if (corner && nearer && sameSide && abs(squareRoot(found.squared) - expected) < kSdfAgrees) {
        lowOff = looked;
        highOff = looked;
      }
    }
  }
  return best;
}
#endif

// Bounds of a point's distance from the keys around it.
struct SdfNear {
  bool may;        // it may be within the range; else only the distance counts
  float distance;  // a lower bound [cell]
  SdfCell cell;
};

// \param range  [cell] points further from the surface, or outside the grid, are ignored
SdfNear sdfNearOf(Sdf sdf, float3 p, float range) {
  SdfNear near = (SdfNear)0;
  near.distance = sdf.band;
  SdfLocation location = sdfLocationOf(sdf, p, 0u);
  if (location.inside) {
    // The distance changes by at most the displacement: no corner may be further from the surface
    // than the point's distance and the range together. For most points the nearest corner decides.
    uint key = SDF_KEYS[location.node];
    precise float first = sdfDistance(key, sdf.band, sdf.farRange, sdf.triangleBits);
    precise float away = squareRoot(dot3(location.share, location.share));
    precise float bound = first - away - kSdfKeyError;
    near.distance = min(bound, sdf.band);
    if (!(bound > range)) {
      near.cell = sdfCellOf(sdf, location, key);
      precise float4 lowClear = max(near.cell.corners.low - (range + kSdfKeyError), 0.0);
      precise float4 highClear = max(near.cell.corners.high - (range + kSdfKeyError), 0.0);
      precise float4 lowBeyond = lowClear * lowClear - near.cell.lowOffset;
      precise float4 highBeyond = highClear * highClear - near.cell.highOffset;
      near.may = !(sdfGreatest(lowBeyond, highBeyond) > 0.0);
      if (!near.may) near.distance = max(near.distance, range);
    }
  }
  return near;
}

// Returns true if a corner is deeper than its distance from the point: then the point is inside.
bool sdfIsWithin(SdfCell cell) {
  precise float4 lowDeep = max(-cell.corners.low - kSdfKeyError, 0.0);
  precise float4 highDeep = max(-cell.corners.high - kSdfKeyError, 0.0);
  precise float4 lowWithin = lowDeep * lowDeep - cell.lowOffset;
  precise float4 highWithin = highDeep * highDeep - cell.highOffset;
  return sdfGreatest(lowWithin, highWithin) > 0.0;
}

// \param range  as above
SdfHit sdfQuery(Sdf sdf, float3 p, float range) {
  SdfNear near = sdfNearOf(sdf, p, range);
  SdfHit hit;
  hit.found = false;
  hit.distance = near.distance;
  hit.normal = float3(0.0, 0.0, 0.0);
  hit.motion = float3(0.0, 0.0, 0.0);
  if (near.may) {
    SdfCell cell = near.cell;
    uint4 low = sdfTriangles(sdf, cell.low);
    uint4 high = sdfTriangles(sdf, cell.high);
    uint4 any4 = min(low, high);
    bool deep =
        sdfIsInside(cell.low.x) && min(min(any4.x, any4.y), min(any4.z, any4.w)) == kSdfNone;
#if SDF_DENSE
    bool dense = sdf.triangleCount == 0u;
    deep = deep && !dense;
#endif
    bool within = sdfIsWithin(cell);
    if (deep) {
      // Only nodes of the coarse grid have triangles there.
      SdfLocation coarse = sdfLocationOf(sdf, p, sdfCoarseShift(sdf.band));
      cell = sdfCellOf(sdf, coarse, SDF_KEYS[coarse.node]);
      low = sdfTriangles(sdf, cell.low);
      high = sdfTriangles(sdf, cell.high);
    }
    SdfSlope slope = sdfTrilinear(cell.corners, cell.location);

#if SDF_DENSE
    if (dense) {
      float3 none = float3(0.0, 0.0, 0.0);
      hit.distance = slope.distance;
      hit.normal = directionOr(slope.gradient, none);
      hit.found = hit.distance < range && dot3(hit.normal, hit.normal) > 0.0;
      return hit;
    }
#endif
#if SDF_CLOSEST_FEATURE
    SdfClosest best = sdfClosestFeature(sdf, p, cell, low, high, slope, deep);
    if (best.index != kSdfNone) {
      SdfSide side = sdfSideOf(sdf, best, slope.distance < 0.0);
      hit.distance = side.distance;
      hit.normal = side.normal;
      // Overlapping meshes have sheets inside: the point is inside, whichever sheet is nearest.
      if (within && hit.distance > kSdfContact) {
        hit.distance = min(slope.distance, 0.0);
        hit.normal = directionOr(slope.gradient, side.normal);
      }
      hit.found = hit.distance < range;
      if (hit.found) hit.motion = sdfMotionAt(sdf, best.index, best.weights);
    }
#else
    hit.distance = slope.distance;
    float3 none = float3(0.0, 0.0, 0.0);
    hit.normal = directionOr(slope.gradient, none);
    hit.found = hit.distance < range && dot3(hit.normal, hit.normal) > 0.0;
    uint known = low.x;
    if (hit.found && known != kSdfNone)
      hit.motion = sdfMotionAt(sdf, known, float2(1.0 / 3.0, 1.0 / 3.0));
#endif
  }
  return hit;
}

#endif
