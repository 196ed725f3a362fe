// Draws contact records as needles, for debugging: triangles from the vertex along the contact's
// normal, a few pixels wide at the vertex.
//
// Vertices: one instance a strand, 3 a record, kMaxContacts records a vertex of the strand; no
//           index buffer.
// Reads:    g_drawnPositions, g_drawnContacts, g_drawnWords, g_drawnStrands, DrawContactsConstants
// Writes:   ContactVaryings
//
// The color shows the depth of the vertex behind the record's plane. The needle of a sliding
// contact is half as long and paler.
//
// Invariant (tests/contact): a vertex without a record, a record that is not finite, and one behind
// the eye have no pixel.
#include "layouts/draw_contacts.hlsli"

// A vertex this close to its plane touches it [m].
static const float kContactDepth = 5e-5;
static const float3 kApartColor = float3(0.03, 0.16, 0.90);
static const float3 kContactColor = float3(0.03, 0.65, 0.07);
static const float3 kShallowColor = float3(0.95, 0.75, 0.02);
static const float3 kDeepColor = float3(0.90, 0.02, 0.02);
// Share of the largest possible friction from which on a vertex slides.
static const float kSlidingShare = 0.999;
static const float kSlidingLength = 0.5;  // share of the needle's length
static const float kSlidingWhite = 0.5;   // share of white in the color

bool isDrawable(float3 v) { return dot(abs(v), float3(1.0, 1.0, 1.0)) < 1e18; }

float4 toClip(float3 p) {
  float4 homogeneous = float4(p, 1.0);
  return float4(dot(g_contactsToClip[0], homogeneous), dot(g_contactsToClip[1], homogeneous),
                dot(g_contactsToClip[2], homogeneous), dot(g_contactsToClip[3], homogeneous));
}

float3 colorOf(float depth, bool slides) {
  float3 color = kContactColor;
  if (depth < -kContactDepth) color = kApartColor;
  float share = (depth - kContactDepth) / max(g_deepestDepth - kContactDepth, 1e-9);
  if (share > 0.0) color = lerp(kShallowColor, kDeepColor, min(share, 1.0));
  return slides ? lerp(color, float3(1.0, 1.0, 1.0), kSlidingWhite) : color;
}

// Returns true if a vertex of a strand has a record of index `which`.
bool hasRecord(uint strand, uint vertex, uint first, uint which) {
  uint mask = g_drawnWords[g_drawnMasks + strand * g_drawnMaskWords + (vertex >> 5)];
  if (((mask >> (vertex & 31u)) & 1u) == 0u) return false;
  return which == 0u || (g_drawnContacts[first].bits & kContactMore) != 0u;
}

// Returns a corner of a needle with both ends in front of the eye.
float4 cornerOf(float4 foot, float4 tip, uint corner) {
  if (corner == 2u) return tip;
  float2 halfSize = g_drawnPixels * 0.5;
  float2 along = (tip.xy / tip.w - foot.xy / foot.w) * halfSize;
  // A needle along the line of sight may lie in any direction on the screen.
  float2 across = float2(1.0, 0.0);
  float squared = dot(along, along);
  if (squared > 1e-8) across = float2(-along.y, along.x) * rsqrt(squared);
  float side = corner == 0u ? -0.5 : 0.5;
  foot.xy += across / halfSize * (side * g_needleWidth * foot.w);
  return foot;
}

ContactVaryings contact_vertex(uint index : SV_VertexID, uint strand : SV_InstanceID) {
  ContactVaryings result;
  result.clip = float4(2.0, 2.0, 2.0, 1.0);
  result.color = float3(0.0, 0.0, 0.0);
  uint record = index / 3u;
  uint vertex = record / kMaxContacts;
  uint which = record - vertex * kMaxContacts;
  if (strand >= g_drawnStrandCount || vertex >= g_drawnStrands[strand].count) return result;
  uint element = g_drawnStrands[strand].target + vertex;
  if (element >= g_drawnVertexCount || (vertex >> 5) >= g_drawnMaskWords) return result;
  uint first = element * kMaxContacts;
  if (!hasRecord(strand, vertex, first, which)) return result;

  ContactRecord contact = g_drawnContacts[first + which];
  float3 position = g_drawnPositions[element].xyz;
  float3 normal = contact.plane.xyz;
  float3 found = float3(contact.foundX, contact.foundY, contact.foundZ);
  float depth = -(contact.plane.w + dot(normal, position - g_drawnOrigin.xyz - found));
  float most = contact.surface.w * contact.force.w;
  bool slides = most > 0.0 && length(contact.force.xyz) > kSlidingShare * most;
  float3 end = position + normal * (g_needleLength * (slides ? kSlidingLength : 1.0));
  if (!isDrawable(end) || !(abs(depth) < 1e18)) return result;
  float4 foot = toClip(position);
  float4 tip = toClip(end);
  if (!(foot.w > 1e-6) || !(tip.w > 1e-6)) return result;
  result.clip = cornerOf(foot, tip, index - record * 3u);
  result.color = colorOf(depth, slides);
  return result;
}
