// Contacts of a strand in the solve: each is a plane that a vertex stays in front of, with Coulomb
// friction in the plane. Their forces come from operator splitting (Daviet, "Simple and Scalable
// Frictional Contacts for Thin Nodal Objects", SIGGRAPH 2020; ADMM: Boyd et al., "Distributed
// Optimization and Statistical Learning via the Alternating Direction Method of Multipliers",
// 2011). The elimination has a constant penalty R for every contact, whether it presses or not. A
// fixed number of iterations then alternates between Coulomb's law at each contact alone and the
// linear response of the strand (solve_contacts.hlsl). With w0 = the gap along the normal
// and the slip in the iterate, dx = the displacement by the solve, P = the projection into the
// friction cone, y = the force of the penalty:
//   v = 1.6 R dx - 0.6 y,  f' = P(f - R w0 - v),  y' = v + f' - f
// The force on the vertex is f + y, and y vanishes where the law holds. The elimination has the f of
// the last step, and the next step starts from this one's: hair at rest takes one pass, and does not
// creep.
//
// The penetration that remains is removed from the positions only: the edge to the vertex is
// rotated, the next edges lead back to the solution, and the history of the displacements does not
// change.
//
// Rounding: the iterations add R dx to R w0. A force from the new position would have the rounding of
// positions, 1e-9 m and more, times R.
#ifndef PELAGE_SIMULATION_EXACT_EXACT_CONTACT_HLSLI
#define PELAGE_SIMULATION_EXACT_EXACT_CONTACT_HLSLI

#include "../../contact/layouts/contact_records.hlsli"
#include "exact_gains.hlsli"

#if CONTACTS
// Penalty of a contact over the weight of its vertex, along the normal and across it. Other ratios
// from 1 to 30 converge more slowly; with the weight of the strand friction is wrong.
static const float kContactPenalty = 3.0;
static const float kFrictionPenalty = 1.5;
// Minimum weight of a vertex for its penalty, over the mean of the strand's: a tip has half.
static const float kLeastWeight = 0.5;
// With 3 iterations friction is 20 % off; from 8 on the error is that of the linearization. With 8
// an undamped limp rope gains 4.0 % of mgL in a second, with 10 2.5 %.
static const uint kContactIterations = 10;
static const float kRelaxation = 1.6;
// A vertex at rest on a surface is on either side of it by rounding [m].
static const float kContactDistance = 2e-5;
// Strands with contacts are linearized once more if an edge rotated by more than kContactRotation
// [rad]; or by more than kForceRotation, and the sizes of the forces changed by more than kForceChange
// of their sum. With so much drag that strands without contact may rotate further, it adds nothing but
// in the step of a reset, which knows no forces (docs/decisions/0005-second-pass.md).
static const float kContactRotation = 0.4;
static const float kForceChange = 0.5;
static const float kForceRotation = 0.1;
// Distance from where a contact was found within which its plane is valid [m]; and that of a contact
// that presses on a surface that moves by more than that along its normal.
static const float kContactRange = 0.03;
static const float kQuickContactRange = 0.005;

// Element of g_contacts in a set of the scratch; contact_records.hlsli has the sets.
uint scratchIndex(uint set, uint vertex, ExactStrand strand) {
  // Behind the records, and a position of every vertex and two displacements of every root.
  uint first = (kMaxContacts * kContactElements + 1u) * g_outputCount + 2u * g_strandCount;
  return first + stateIndex(set, vertex, strand);
}

// Stores the response of an edge, without a change of the forces at its end.
void storeResponse(uint edge, ExactStrand strand, Response r) {
  uint element = scratchIndex(0, edge, strand);
  g_contacts[element] = asuint(float4(r.w.xx, r.w.xy, r.w.xz, r.w.yy));
  g_contacts[element + g_stateStride] = asuint(float4(r.w.yz, r.w.zz, 0.0, 0.0));
  g_contacts[element + 2u * g_stateStride] = asuint(float4(r.e, 0.0));
}

// Planes of a vertex with a record, and two vectors of other sets, in tiles as the state.
struct StoredTouch {
  float4 plane0;
  float4 plane1;
  float4 a;
  float4 b;
};

float4 loadScratch(uint set, uint vertex, ExactStrand strand) {
  return asfloat(g_contacts[scratchIndex(set, vertex, strand)]);
}
void storeScratch(uint set, uint vertex, ExactStrand strand, float4 value) {
  g_contacts[scratchIndex(set, vertex, strand)] = asuint(value);
}

StoredTouch loadTouch(uint vertex, ExactStrand strand, uint set) {
  StoredTouch touch;
  touch.plane0 = loadScratch(kScratchPlanes, vertex, strand);
  touch.plane1 = loadScratch(kScratchPlanes + 1u, vertex, strand);
  touch.a = loadScratch(set, vertex, strand);
  touch.b = loadScratch(set + 1u, vertex, strand);
  return touch;
}

float3 tangentialPart(float3 normal, float3 v) {
  precise float3 r = v - normal * dot3(v, normal);
  return r;
}

// R v.
float3 penalized(float3 normal, float weight, float3 v) {
  precise float across = weight * kFrictionPenalty;
  precise float along = dot3(normal, v);
  precise float3 r = v * across + normal * (along * (weight * kContactPenalty - across));
  return r;
}

// Returns the nearest force in the friction cone, the normal part first.
float3 projected(float3 normal, float friction, float3 trial) {
  precise float along = dot3(normal, trial);
  precise float pressing = max(along, 0.0);
  precise float3 flat = trial - normal * along;
  precise float most = friction * pressing;
  precise float squared = dot3(flat, flat);
  // No branch, so that compilers may interleave it with other work.
  precise float factor = most * inverseRoot(max(squared, 1e-30));
  flat = flat * (squared > most * most ? factor : 1.0);
  precise float3 r = normal * pressing + flat;
  return r;
}

float lengthOf(float3 v) {
  precise float r = squareRoot(dot3(v, v));
  return r;
}

// Minimum weight of a vertex for the penalty of its contacts.
float leastWeight(ExactStrand strand) {
  precise float r = g_weight * strand.strandLength * kLeastWeight / float(strand.count - 1u);
  return r;
}

uint recordOf(ExactStrand strand, uint vertex) { return (strand.target + vertex) * kMaxContacts; }

// Returns the word of the mask that has the vertex.
uint contactMask(uint index, uint vertex) {
  return g_contactWords[g_contactMasks + index * g_contactMaskWords + vertex / 32u];
}

bool hasContact(uint mask, uint vertex) { return ((mask >> (vertex & 31u)) & 1u) != 0u; }

// Returns how many of its vertices have a record.
uint contactCount(uint index, uint count) {
  uint contacts = 0u;
  for (uint word = 0; word * 32u < count; ++word)
    contacts = contacts + countbits(contactMask(index, word * 32u));
  return contacts;
}

// Returns the last vertex in contact, or 0.
uint lastContact(uint index, uint count) {
  uint last = 0u;
  for (uint word = 0u; word * 32u < count; ++word) {
    uint mask = contactMask(index, word * 32u);
    if (mask != 0u) last = word * 32u + firstbithigh(mask);
  }
  return min(last, count - 1u);
}

// Strands that a group of solve_contacts takes of a list.
uint strandsOfGroup(uint list) { return 1u << (kContactListCount - 1u - list); }

// First word of an entry of a list for solve_contacts.
uint listedWord(uint list, uint entry) {
  return g_contactMasks + g_strandCount * g_contactMaskWords +
         kContactListWords * (list * g_strandCount + entry);
}

// Returns true if the strand has a record.
bool touchesAnything(uint index, uint count) {
  uint any = 0u;
  for (uint word = 0; word * 32u < count; ++word) any = any | contactMask(index, word * 32u);
  return any != 0u;
}

// Returns the displacement in world space of a vertex at x that the iterate moves by `displacement`
// from its transported position.
float3 worldDisplacement(RigidMotion transport, float3 x, float3 displacement) {
  precise float3 transported = x - displacement;
  precise float3 before = rotate(conjugate(transport.rotation), transported - transport.shift);
  precise float3 moved = x - before;
  return moved;
}

// Returns the frame, rotated so that its tangent is `direction`.
float4 rotateFrame(float4 frame, float3 tangent, float3 direction) {
  precise float scalar = max(1.0 + dot3(tangent, direction), 1e-4);
  float4 relativeRotation = normalizeProduct(float4(cross3(tangent, direction), scalar));
  return normalizeProduct(multiplyQuaternions(relativeRotation, frame));
}

// ---- roll-out

// Returns the direction of an edge from `start` whose end is in front of a plane.
//
// \param foundAt  where the contact was found, `distance` in front of the plane
float3 keepOut(float3 direction, float3 normal, float3 foundAt, float distance, float3 start,
               float edgeLength) {
  precise float3 end = start + direction * edgeLength;
  precise float gap = distance + dot3(normal, end - foundAt);
  precise float along = dot3(direction, normal);
  precise float3 flat = direction - normal * along;
  precise float size = dot3(flat, flat);
  if (!(gap < -kContactDistance && size > 1e-10)) return direction;
  precise float off = min(max(along * edgeLength - gap, -edgeLength), edgeLength);
  precise float rest = squareRoot(max(edgeLength * edgeLength - off * off, 0.0));
  precise float3 arm = normal * off + flat * (rest * inverseRoot(size));
  return directionOr(arm, direction);
}

// Returns the change of an edge by a rotation u: as rotatedBy(), without the rounding of a
// difference of tangents.
float3 rotatedEdge(float3 u, float3 edge) {
  precise float3 halfRotation = u * 0.5;
  float3 rotated = cross3(halfRotation, edge);
  precise float scale = 2.0 / (1.0 + dot3(halfRotation, halfRotation));
  precise float3 r = (rotated + cross3(halfRotation, rotated)) * scale;
  return r;
}

// Returns true if a vertex is too far from where its contact was found, by the square of the distance.
//
// \param plane  as in correctionOf()
bool isFar(float4 plane, float squared) {
  bool quick = plane.w < kNoLimit && abs(plane.w) > kQuickContactRange;
  float most = quick ? kQuickContactRange : kContactRange;
  return squared > most * most;
}

// Returns the part of a displacement that led out of a collider, beyond `correction`.
//
// \param plane  normal, and displacement of the surface along it if the contact presses
// \param gap    of the end of the displacement
float3 correctionOf(float3 correction, float4 plane, float gap, float3 moved) {
  precise float outward = dot3(moved, plane.xyz) - plane.w;
  precise float begun = gap - outward;
  precise float3 corrected = correction;
  if (plane.w < kNoLimit && begun < 0.0 && outward > 0.0)
    corrected = correction + plane.xyz * min(outward, -begun);
  return corrected;
}
#endif

#endif
