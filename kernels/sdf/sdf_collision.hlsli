// Contact of a moving point with the surface of an SDF that moves, too.
//
// The SDF is that of the end of a frame. A point at fraction t of the frame is transformed to where
// it would be if it moved with the surface for the rest of the frame: (1 - t) times the motion of
// the nearest feature further. In that frame of reference the surface is at rest, and displacements
// are relative to it.
#ifndef PELAGE_SDF_SDF_COLLISION_HLSLI
#define PELAGE_SDF_SDF_COLLISION_HLSLI

#include "sdf_query.hlsli"

// Allows a displacement to skip the sweep if the surface faces alike at its start and its end:
// cheaper, but one in 60 fast vertices passes through a body with fingers and ears in a step.
#ifndef SDF_FACING
#define SDF_FACING 0
#endif

// A displacement longer than this is swept [cell]: half of the thinnest plate that counts.
static const float kSdfSweepFrom = 0.5;
#ifndef SDF_SWEEP_FROM
#define SDF_SWEEP_FROM kSdfSweepFrom
#endif
// A sweep stops this close to the surface [cell], if the next kSdfLookAhead lead at least as deep
// below it: not if the path runs along the surface.
static const float kSdfStop = 0.1;
static const float kSdfLookAhead = 0.5;
// Minimum steps of a sweep [cell], towards the surface and along it.
static const float kSdfMinStep = 0.05;
static const float kSdfMinGlide = 0.25;
// Maximum queries of a contact. A sweep that has used them up stops where it is.
static const uint kSdfMostQueries = 64;

// In cells from node 0, relative to the surface.
struct SdfContact {
  bool found;         // nearer than the margin and the range; else the rest is 0
  bool swept;         // the path ends at `stop`, before its end
  float3 normal;      // unit, outwards
  float penetration;  // depth of the path's end below the margin
  float3 motion;      // of the surface in the whole frame
  float3 from;        // start of the path
  float3 to;          // its end
  float3 stop;
};

static const uint kSdfAtEnd = 0;
static const uint kSdfAtBegin = 1;
static const uint kSdfSweeping = 2;
static const uint kSdfFacing = 3;
// A displacement does not cross a thin part if it ends at most this fraction of it, and half a
// cell, below the plane at its start, and the surface faces the same direction at both ends.
static const float kSdfFacingDrop = 0.25;

// Returns the part of a path from a in a unit direction that is within the grid.
float2 sdfPartWithin(Sdf sdf, float3 a, float3 direction, float most) {
  float3 last = float3(max(sdf.nodes.xyz, 1u) - 1u);
  precise float3 safe = float3(abs(direction.x) > 1e-9 ? direction.x : 1e-9,
                               abs(direction.y) > 1e-9 ? direction.y : 1e-9,
                               abs(direction.z) > 1e-9 ? direction.z : 1e-9);
  precise float3 low = -a / safe;
  precise float3 high = (last - a) / safe;
  float3 enter = min(low, high);
  float3 leave = max(low, high);
  return float2(max(max(enter.x, enter.y), max(enter.z, 0.0)),
                min(min(leave.x, leave.y), min(leave.z, most)));
}

bool sdfMoves(Sdf sdf) { return sdf.motionScale > 0.0 && sdf.surfaceStride >= kSdfMovingRecord; }

// Where a triangle is, and how it moves in the frame.
struct SdfGuess {
  float3 at;      // [cell]
  float3 motion;  // [m]
};

SdfGuess sdfGuessOf(Sdf sdf, uint index) {
  SdfGuess guess;
  guess.at = float3(1e18, 1e18, 1e18);
  guess.motion = float3(0.0, 0.0, 0.0);
  if (sdfMoves(sdf) && index < sdf.triangleCount) {
    guess.at = loadSdfCorners(sdf, index).a;
    precise float3 motion = sdfMotionAt(sdf, index, float2(0.0, 0.0)) * sdf.origin.w;
    guess.motion = motion;
  }
  return guess;
}

// Returns false if sdfContact() without a range finds nothing, for the cost of some keys.
bool sdfMayCollide(Sdf sdf, float3 before, float3 after, float end) {
  precise float inverseCell = 1.0 / sdf.origin.w;
  precise float3 a = (before - sdf.origin.xyz) * inverseCell;
  precise float3 b = (after - sdf.origin.xyz) * inverseCell;
  precise float3 displacement = b - a;
  precise float margin = sdf.margin * inverseCell;
  if (!isUsable(a) || !isUsable(b)) return false;
  // Long displacements are swept.
  if (!(dot3(displacement, displacement) <= SDF_SWEEP_FROM * SDF_SWEEP_FROM)) return true;
  bool shifts = sdf.motionScale > 0.0 && sdf.surfaceStride >= 7u && end < 1.0;
  float furthest = shifts ? max(margin, sdf.band) : margin;
  return sdfNearOf(sdf, b, furthest).may;
}

// Returns false if sdfContact() with this range [m] finds nothing, for a point that moves by
// `relative` relative to the root of its strand in `span`, begin and end; otherwise as sdfContact().
bool sdfMayBeInRange(Sdf sdf, float3 before, float3 after, float3 relative, float2 span,
                     float furthest, float3 motion) {
  float begin = span.x, end = span.y;
  precise float inverseCell = 1.0 / sdf.origin.w;
  precise float3 a = (before - sdf.origin.xyz) * inverseCell;
  precise float3 b = (after - sdf.origin.xyz) * inverseCell;
  bool moving = sdf.motionScale > 0.0 && sdf.surfaceStride >= 7u;
  precise float3 displacement = moving ? relative * inverseCell : b - a;
  precise float wanted = (sdf.margin + furthest) * inverseCell;
  bool usable = isUsable(a) && isUsable(b);
  // Swept, and as far beyond: the surface may be that far from the end.
  precise float squared = dot3(displacement, displacement);
  if (dot3(motion, motion) > 0.0) {
    precise float3 against = b - a - motion * (inverseCell * (end - begin));
    squared = max(squared, dot3(against, against));
    b = b + motion * (inverseCell * (1.0 - end));
  }
  if (squared > SDF_SWEEP_FROM * SDF_SWEEP_FROM) wanted = wanted + 2.0 * squareRoot(squared);
  bool shifts = moving && end < 1.0;
  float range = shifts ? max(wanted, sdf.band) : wanted;
  SdfNear near = sdfNearOf(sdf, b, range);
  // Outside the grid only a bound of the distance is known.
  float3 last = float3(max(sdf.nodes.xyz, 1u) - 1u);
  precise float3 beside = max(max(-b, b - last), 0.0);
  precise float away = dot3(beside, beside);
  return usable && (near.may || (away > 0.0 && range >= sdf.band && away <= range * range));
}

// \param before, after  the point at the start and the end of its path, in the space of
//                       sdf.origin [m]
// \param begin, end     shares of the frame at which it is there, 0..1
// \param furthest       a point within this distance outside the margin has a contact [m]
// \param guess          motion in the frame of a surface that is too far to be asked for it [m]
SdfContact sdfContact(Sdf sdf, float3 before, float3 after, float begin, float end, float furthest,
                      float3 guess) {
  precise float inverseCell = 1.0 / sdf.origin.w;
  precise float3 a = (before - sdf.origin.xyz) * inverseCell;
  precise float3 b = (after - sdf.origin.xyz) * inverseCell;
  precise float margin = sdf.margin * inverseCell;
  precise float wanted = margin + furthest * inverseCell;
  SdfContact contact;
  contact.found = false;
  contact.swept = false;
  contact.normal = float3(0.0, 0.0, 0.0);
  contact.penetration = 0.0;
  precise float3 guessed = guess * inverseCell;
  contact.motion = guessed;
  contact.from = a;
  contact.to = b;
  contact.stop = b;
  uint queries = isUsable(a) && isUsable(b) ? kSdfMostQueries : 0u;

  bool moving = sdf.motionScale > 0.0 && sdf.surfaceStride >= 7u;
  precise float left = 1.0 - end;
  precise float leftBefore = 1.0 - begin;
  bool shifts = moving && left > 0.0;
  uint phase = kSdfAtEnd;
  precise float3 at = b + guessed * left;
  contact.to = at;
  precise float3 direction = float3(0.0, 0.0, 0.0);
  precise float s = 0.0;
  precise float last = 0.0;
  // A displacement that may be long needs the motion of the surface, even if it is far.
  precise float3 wholeDisplacement = b - a;
  bool mayBeLong = dot3(wholeDisplacement, wholeDisplacement) > SDF_SWEEP_FROM * SDF_SWEEP_FROM;
  precise float3 against = wholeDisplacement - guessed * (end - begin);
  mayBeLong = mayBeLong || dot3(against, against) > SDF_SWEEP_FROM * SDF_SWEEP_FROM;
  bool asks = moving && (left > 0.0 || mayBeLong);
  float range = asks ? max(wanted, sdf.band) : wanted;
  [loop] for (uint query = 0; query < queries; ++query) {
    SdfHit hit = sdfQuery(sdf, at, range);
    if (phase == kSdfSweeping) {
      precise float clear = hit.distance - margin;
      precise float approach = min(dot3(hit.normal, direction), 0.0);
      precise float ahead = clear + approach * kSdfLookAhead;
      bool lastQuery = query + 1u == kSdfMostQueries;
      if (hit.found && (lastQuery || (clear < kSdfStop && ahead < -kSdfStop))) {
        precise float3 rest = at - contact.to;
        precise float penetration = dot3(rest, hit.normal) - clear;
        precise float3 stop = at - hit.normal * min(clear, 0.0);
        contact.found = true;
        contact.swept = true;
        contact.normal = hit.normal;
        contact.penetration = penetration;
        contact.stop = stop;
        break;
      }
      float least = approach < 0.0 ? kSdfMinStep : kSdfMinGlide;
      s = s + max(clear - 0.5 * kSdfStop, least);
    } else {
      precise float3 direct = contact.to - contact.from;
      float length = squareRoot(dot3(direct, direct));
      if (phase == kSdfFacing) {
        precise float below = hit.distance + dot3(hit.normal, direct);
        bool faces = hit.found && dot3(hit.normal, contact.normal) > 0.0;
        if (faces && below > -kSdfFacingDrop * length - SDF_SWEEP_FROM) break;
      } else {
        if (hit.found) contact.motion = hit.motion;
        if (phase == kSdfAtEnd) {
          if (shifts && hit.found) {
            shifts = false;
            at = b + contact.motion * left;
            contact.to = at;
            continue;
          }
          if (hit.found && hit.distance < wanted) {
            precise float penetration = margin - hit.distance;
            contact.found = true;
            contact.normal = hit.normal;
            contact.penetration = penetration;
          }
        }
        precise float3 from = a + contact.motion * leftBefore;
        precise float3 to = b + contact.motion * left;
        contact.from = from;
        contact.to = to;
        precise float3 displacement = to - from;
        precise float squared = dot3(displacement, displacement);
        if (!(squared > SDF_SWEEP_FROM * SDF_SWEEP_FROM)) break;
        if (moving && phase == kSdfAtEnd && !hit.found) {
          // The motion of the surface is then that near the start.
          phase = kSdfAtBegin;
          at = a + guessed * leftBefore;
          range = sdf.band;
          continue;
        }
#if SDF_FACING
        if (phase == kSdfAtEnd && contact.found) {
          phase = kSdfFacing;
          at = from;
          range = sdf.band;
          continue;
        }
#endif
      }
      precise float3 from = contact.from;
      precise float3 displacement = contact.to - from;
      precise float size = squareRoot(dot3(displacement, displacement));
      direction = displacement / size;
      float2 part = sdfPartWithin(sdf, from, direction, size);
      phase = kSdfSweeping;
      s = part.x;
      last = part.y;
      range = margin + 1.0;
    }
    if (!(s < last)) break;
    at = contact.from + direction * s;
  }
  return contact;
}

#endif
