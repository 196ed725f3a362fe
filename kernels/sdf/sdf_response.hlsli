// Contact of a moving point with the surface of a signed distance field that moves, too.
//
// The field is that of a frame's end. A point at share t of the frame is looked for where it would
// be if it went along with the surface for the rest of the frame: (1 - t) times the motion of the
// nearest feature further. There the surface stands still, and a way is the way relative to it.
#ifndef PELAGE_SDF_SDF_RESPONSE_HLSLI
#define PELAGE_SDF_SDF_RESPONSE_HLSLI

#include "sdf_query.hlsli"

// Whether a way may go without a sweep where the surface faces alike at its begin and its end: cheaper,
// and one in 60 fast vertices gets through a body with fingers and ears in a step.
#ifndef SDF_FACING
#define SDF_FACING 0
#endif

// A way longer than this is swept [cell]: half of the thinnest plate that counts.
static const float kSdfSweepFrom = 0.5;
// A sweep stops this near to the surface [cell], when the next kSdfLookAhead lead at least as deep
// below it: not where the way runs along the surface.
static const float kSdfStop = 0.1;
static const float kSdfLookAhead = 0.5;
// Least steps of a sweep [cell], towards the surface and along it.
static const float kSdfLeastStep = 0.05;
static const float kSdfLeastGlide = 0.25;
// Queries of a contact. A sweep that has used them up stops where it is.
static const uint kSdfMostQueries = 64;

// In cells from node 0, relative to the surface.
struct SdfContact {
  bool found;           // nearer than the margin and the reach; else the rest is 0
  bool swept;          // the way ends at `stop`, before its end
  float3 normal;       // unit, outwards
  float penetration;   // how far the way's end is from where the margin ends, inwards
  float3 motion;       // of the surface in the whole frame
  float3 from;         // the way's begin
  float3 to;           // its end
  float3 stop;
};

static const uint kSdfAtEnd = 0;
static const uint kSdfAtBegin = 1;
static const uint kSdfOnWay = 2;
static const uint kSdfFacing = 3;
// A way that ends no deeper below the plane at its begin than this share of it, and half a cell, and
// where the surface faces the same way at both, does not lead through something.
static const float kSdfFacingDrop = 0.25;

// The part of a way from a in a unit direction that is within the grid.
float2 sdfPartWithin(SdfField field, float3 a, float3 direction, float most) {
  float3 last = float3(max(field.nodes.xyz, 1u) - 1u);
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

// False when sdfContact() without a reach finds nothing, which costs a look at some keys to say.
bool sdfMayTouch(SdfField field, float3 before, float3 after, float end) {
  precise float inverseCell = 1.0 / field.origin.w;
  precise float3 a = (before - field.origin.xyz) * inverseCell;
  precise float3 b = (after - field.origin.xyz) * inverseCell;
  precise float3 way = b - a;
  precise float margin = field.margin * inverseCell;
  if (!isUsable(a) || !isUsable(b)) return false;
  // Long ways are swept.
  if (!(dot3(way, way) <= kSdfSweepFrom * kSdfSweepFrom)) return true;
  bool shifts = field.motionScale > 0.0 && field.surfaceStride >= 7u && end < 1.0;
  float reach = shifts ? max(margin, field.band) : margin;
  return sdfNearOf(field, b, reach).may;
}

// False when sdfContact() with this reach [m] finds nothing, where what moves with the surface goes
// `relative` against it.
bool sdfMayReach(SdfField field, float3 before, float3 after, float3 relative, float end,
                 float reach) {
  precise float inverseCell = 1.0 / field.origin.w;
  precise float3 a = (before - field.origin.xyz) * inverseCell;
  precise float3 b = (after - field.origin.xyz) * inverseCell;
  bool moving = field.motionScale > 0.0 && field.surfaceStride >= 7u;
  precise float3 way = moving ? relative * inverseCell : b - a;
  precise float wanted = (field.margin + reach) * inverseCell;
  if (!isUsable(a) || !isUsable(b)) return false;
  // Swept, and as far beyond: the surface may be that far from the end.
  precise float squared = dot3(way, way);
  if (squared > kSdfSweepFrom * kSdfSweepFrom) wanted = wanted + 2.0 * squareRoot(squared);
  bool shifts = moving && end < 1.0;
  float range = shifts ? max(wanted, field.band) : wanted;
  SdfNear near = sdfNearOf(field, b, range);
  if (near.may) return true;
  // Outside the grid nothing is known but how far away that is.
  float3 last = float3(max(field.nodes.xyz, 1u) - 1u);
  precise float3 beside = max(max(-b, b - last), 0.0);
  precise float away = dot3(beside, beside);
  return away > 0.0 && range >= field.band && away <= range * range;
}

// \param before, after  the point at the way's begin and end, in the space of field.origin [m]
// \param begin, end     shares of the frame at which it is there, 0..1
// \param reach          what is this far outside the margin is a contact, too [m]
SdfContact sdfContact(SdfField field, float3 before, float3 after, float begin, float end,
                      float reach) {
  precise float inverseCell = 1.0 / field.origin.w;
  precise float3 a = (before - field.origin.xyz) * inverseCell;
  precise float3 b = (after - field.origin.xyz) * inverseCell;
  precise float margin = field.margin * inverseCell;
  precise float wanted = margin + reach * inverseCell;
  SdfContact contact;
  contact.found = false;
  contact.swept = false;
  contact.normal = float3(0.0, 0.0, 0.0);
  contact.penetration = 0.0;
  contact.motion = float3(0.0, 0.0, 0.0);
  contact.from = a;
  contact.to = b;
  contact.stop = b;
  if (!isUsable(a) || !isUsable(b)) return contact;

  bool moving = field.motionScale > 0.0 && field.surfaceStride >= 7u;
  precise float left = 1.0 - end;
  precise float leftBefore = 1.0 - begin;
  bool shifts = moving && left > 0.0;
  uint phase = kSdfAtEnd;
  precise float3 at = b;
  precise float3 direction = float3(0.0, 0.0, 0.0);
  precise float s = 0.0;
  precise float last = 0.0;
  // A way that may be long needs to know how the surface moves, though it may be far.
  precise float3 wholeWay = b - a;
  bool mayBeLong = dot3(wholeWay, wholeWay) > kSdfSweepFrom * kSdfSweepFrom;
  bool asks = moving && (left > 0.0 || mayBeLong);
  float range = asks ? max(wanted, field.band) : wanted;
  [loop] for (uint query = 0; query < kSdfMostQueries; ++query) {
    SdfHit hit = sdfQuery(field, at, range);
    if (phase == kSdfOnWay) {
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
      float least = approach < 0.0 ? kSdfLeastStep : kSdfLeastGlide;
      s = s + max(clear - 0.5 * kSdfStop, least);
    } else {
      precise float3 direct = contact.to - contact.from;
      float length = squareRoot(dot3(direct, direct));
      if (phase == kSdfFacing) {
        precise float below = hit.distance + dot3(hit.normal, direct);
        bool faces = hit.found && dot3(hit.normal, contact.normal) > 0.0;
        if (faces && below > -kSdfFacingDrop * length - kSdfSweepFrom) break;
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
        precise float3 way = to - from;
        precise float squared = dot3(way, way);
        if (!(squared > kSdfSweepFrom * kSdfSweepFrom)) break;
        if (moving && phase == kSdfAtEnd && !hit.found) {
          // How the surface moves is told by what is near to the begin then.
          phase = kSdfAtBegin;
          at = a;
          range = field.band;
          continue;
        }
#if SDF_FACING
        if (phase == kSdfAtEnd && contact.found) {
          phase = kSdfFacing;
          at = from;
          range = field.band;
          continue;
        }
#endif
      }
      precise float3 from = contact.from;
      precise float3 way = contact.to - from;
      precise float size = squareRoot(dot3(way, way));
      direction = way / size;
      float2 part = sdfPartWithin(field, from, direction, size);
      phase = kSdfOnWay;
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
