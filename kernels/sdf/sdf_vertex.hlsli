// Collides a vertex with an SDF, as described in collide_vertices. The including file defines what
// sdf_collision.hlsli needs.
#ifndef PELAGE_SDF_SDF_VERTEX_HLSLI
#define PELAGE_SDF_SDF_VERTEX_HLSLI

#include "sdf_collision.hlsli"

static const uint kSdfRounds = 4;

struct SdfVertex {
  float3 now;
  float3 before;
  bool moved;
};

// \param frameBegin, frameEnd  shares of the frame at which it is where it was before, and now
void collideWithSdf(inout SdfVertex vertex, Sdf sdf, float frameBegin, float frameEnd) {
  float3 from = vertex.before;
  float3 to = vertex.now;
  float begin = frameBegin;
  float end = frameEnd;
  precise float3 shift = float3(0.0, 0.0, 0.0);  // to where the surface stands still
  precise float3 transported = float3(0.0, 0.0, 0.0);
  precise float3 pointIndex = vertex.now;
  float3 normal = float3(0.0, 0.0, 0.0);
  bool touched = false;
  [loop] for (uint round = 0; round < kSdfRounds; ++round) {
    SdfContact contact = sdfContact(sdf, from, to, begin, end, 0.0);
    if (!contact.found) break;
    precise float cell = sdf.origin.w;
    if (round == 0) {
      shift = contact.motion * (cell * (1.0 - frameEnd));
      transported = contact.motion * (cell * (frameEnd - frameBegin));
      pointIndex = pointIndex + shift;
      begin = 1.0;
      end = 1.0;
    }
    touched = true;
    normal = contact.normal;
    precise float push = max(contact.penetration, 0.0);
    precise float3 outward = normal * push;
    precise float3 start = contact.swept ? contact.stop : contact.from;
    precise float3 displacement = contact.to + outward - start;
    precise float off = dot3(displacement, normal);
    precise float3 slip = displacement - normal * off;
    precise float size = squareRoot(dot3(slip, slip));
    precise float most = sdf.friction * push;
    precise float share = size > most ? most / size : 1.0;
    outward = outward - slip * share;
    precise float3 pushed = pointIndex + outward * cell;
    precise float3 stop = sdf.origin.xyz + contact.stop * cell;
    bool stays = contact.swept && round + 1u == kSdfRounds;
    pointIndex = stays ? stop : pushed;
    if (!contact.swept) break;
    from = stop;
    to = pointIndex;
  }
  if (!touched || !isUsable(pointIndex)) return;
  precise float3 now = pointIndex - shift;
  precise float3 velocity = now - vertex.before - transported;
  precise float rising = dot3(velocity, normal);
  precise float3 before = vertex.before + normal * rising;
  vertex.now = now;
  vertex.before = before;
  vertex.moved = true;
}

#endif
