// The linear response of a strand to forces, by the control laws of its edges: from root to tip what
// a state leads to; from tip to root how forces change the control laws.
#ifndef PELAGE_SIMULATION_EXACT_EXACT_COMPLIANCE_HLSLI
#define PELAGE_SIMULATION_EXACT_EXACT_COMPLIANCE_HLSLI

#include "exact_contact.hlsli"

struct StoredResponse {
  float4 a;
  float4 b;
  float4 c;
};

StoredResponse loadResponse(uint edge, ExactStrand strand) {
  uint element = scratchIndex(0, edge, strand);
  StoredResponse stored;
  stored.a = asfloat(g_contacts[element]);
  stored.b = asfloat(g_contacts[element + g_stateStride]);
  stored.c = asfloat(g_contacts[element + 2u * g_stateStride]);
  return stored;
}

Symmetric3 inversePivot(StoredResponse stored) {
  return makeSymmetric(stored.a.x, stored.a.y, stored.a.z, stored.a.w, stored.b.x, stored.b.y);
}

// State (dx, u) of a vertex and the edge before it.
struct RodState {
  float3 dx;
  float3 u;
};

RodState noState() {
  RodState state;
  state.dx = float3(0.0, 0.0, 0.0);
  state.u = float3(0.0, 0.0, 0.0);
  return state;
}

RodState advance(Gain g, float3 k, float3 e, RodState state) {
  RodState next;
  next.u = controlLaw(g, k, state.u, state.dx);
  precise float3 dx = state.dx + cross3(next.u, e);
  next.dx = dx;
  return next;
}

// A sweep from tip to root: what changes of forces do to the control laws.
struct ForceSweep {
  float3 px;
  float3 pf;
  float3 k;
};

ForceSweep noSweep() {
  ForceSweep sweep;
  sweep.px = float3(0.0, 0.0, 0.0);
  sweep.pf = float3(0.0, 0.0, 0.0);
  sweep.k = float3(0.0, 0.0, 0.0);
  return sweep;
}

// \param change of the forces at the end of the edge
ForceSweep addForce(ForceSweep sweep, Gain g, StoredResponse stored, float3 change) {
  precise float3 px = sweep.px - change;
  precise float3 q = cross3(stored.c.xyz, px) + sweep.pf;
  precise float3 k = g.k + multiplySymmetric(inversePivot(stored), q);
  px = px - float3(dot3(g.kx0, q), dot3(g.kx1, q), dot3(g.kx2, q));
  ForceSweep next;
  next.k = k;
  next.px = px;
  next.pf = float3(dot3(g.kw0, q), dot3(g.kw1, q), dot3(g.kw2, q));
  return next;
}

void storeK(uint edge, ExactStrand strand, ForceSweep sweep, Gain g) {
  g_state[gainIndex(edge, strand)] = float4(sweep.k, g.kx0.x);
}

// The last vertex in contact to the root: the changes of the forces go into the gains.
void addForces(ExactStrand strand, uint last) {
  ForceSweep sweep = noSweep();
  PackedGain packed = loadGain(last - 1u, strand);
  StoredResponse stored = loadResponse(last - 1u, strand);
  [loop] for (uint i = last - 1u; i >= 1u; --i) {
    // Loads of the next iteration, before the arithmetic of this one.
    uint before = max(i, 2u) - 1u;
    PackedGain packedBefore = loadGain(before, strand);
    StoredResponse storedBefore = loadResponse(before, strand);
    Gain g = unpackGain(packed);
    sweep = addForce(sweep, g, stored, float3(stored.b.zw, stored.c.w));
    storeK(i, strand, sweep, g);
    packed = packedBefore;
    stored = storedBefore;
  }
}

// Stores the change of the forces of a vertex in contact.
void storeChange(uint vertex, ExactStrand strand, float3 change) {
  uint element = scratchIndex(0, vertex - 1u, strand);
  g_contacts[element + g_stateStride].zw = asuint(change.xy);
  g_contacts[element + 2u * g_stateStride].w = asuint(change.z);
}

#endif
