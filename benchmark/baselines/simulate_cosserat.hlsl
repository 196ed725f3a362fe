// XPBD baseline: an oriented-particle Cosserat rod by Gauss-Seidel, one thread a strand.
//
// Stretch-shear and bend-twist constraints of Kugelstadt and Schoemer, "Position and Orientation
// Based Cosserat Rods" (SCA 2016); compliance instead of stiffness after Macklin, Mueller and
// Chentanez, "XPBD" (MIG 2016), equation 18; one iteration a sub-step, with multipliers that start
// at 0, after Macklin et al., "Small Steps in Physics Simulation" (SCA 2019). Each constraint is
// solved for all three components at once, in rotation vectors instead of quaternion components.
//
// Every constraint of a sub-step is visited once, from root to tip, so one walk along the strand
// does all of it: vertex i + 1 and edge i are predicted when they are first needed, and vertex i
// and edge i - 1 have their velocities when edge i is done.
//
// Threads: one a strand. Reads g_rodRest, g_rods; writes g_rods, g_places, g_directions.
#include "rotations.hlsli"
#include "cosserat_layout.hlsli"

struct Vertex {
  float3 x;       // predicted and corrected [m]
  float3 before;  // at the sub-step's begin [m]
  float region;   // length that it stands for [m]
  float inverseMass;
};

struct Edge {
  float4 frame;
  float4 before;
  float inverseInertia;
};

float4 turnedBy(float3 angle, float4 frame) {
  return normalize(product(float4(0.5 * angle, 1.0), frame));
}

Vertex predictVertex(uint i, uint strand) {
  float4 x = g_rods[rodIndex(0, i, strand)];
  float3 v = g_rods[rodIndex(1, i, strand)].xyz;
  Vertex vertex;
  vertex.before = x.xyz;
  vertex.region = x.w;
  vertex.inverseMass = 1.0 / x.w;
  vertex.x = x.xyz + (v + g_gravity.xyz * g_subStep) * (g_subStep / (1.0 + g_drag * g_subStep));
  return vertex;
}

Edge predictEdge(uint i, uint strand, float size) {
  Edge edge;
  edge.before = g_rods[rodIndex(2, i, strand)];
  edge.frame = turnedBy(g_rods[rodIndex(3, i, strand)].xyz * g_subStep, edge.before);
  edge.inverseInertia = 1.0 / max(g_inertia * size * size * size, 1e-20);
  return edge;
}

void storeVertex(uint i, uint strand, Vertex vertex) {
  g_rods[rodIndex(0, i, strand)] = float4(vertex.x, vertex.region);
  float3 velocity =
      vertex.inverseMass > 0.0 ? (vertex.x - vertex.before) / g_subStep : float3(0.0, 0.0, 0.0);
  g_rods[rodIndex(1, i, strand)] = float4(velocity, 0.0);
}

void storeEdge(uint i, uint strand, Edge edge) {
  g_rods[rodIndex(2, i, strand)] = edge.frame;
  float4 turn = product(edge.frame, conjugate(edge.before));
  float3 velocity = turn.xyz * ((turn.w < 0.0 ? -2.0 : 2.0) / g_subStep);
  g_rods[rodIndex(3, i, strand)] = float4(edge.inverseInertia > 0.0 ? velocity : 0.0, 0.0);
}

void drawVertex(uint i, uint strand, Vertex vertex, Edge edge) {
  uint target = strand * g_vertexCount + i;
  g_places[target] = float4(vertex.x, i > 1 ? 1.0 : 0.0);
  g_directions[target] = float4(axisX(edge.frame), 0.0);
}

// Bend-twist: the rotation from one edge to the next is the one at rest, with compliance
// region / B. Its vector is 4 tan(angle / 4), as the exact solver has it.
void keepBend(inout Edge parent, inout Edge edge, float4 rest, float region) {
  float4 r = product(product(conjugate(parent.frame), edge.frame), conjugate(rest));
  float3 angle = r.xyz * ((r.w < 0.0 ? -4.0 : 4.0) / (1.0 + abs(r.w)));
  float soft = region / (g_subStep * g_subStep);
  float weights = parent.inverseInertia + edge.inverseInertia;
  float3 multiplier = -angle / (weights + soft / float3(g_twist, g_bend, g_bend));
  float3 push = rotate(parent.frame, multiplier);
  parent.frame = turnedBy(-push * parent.inverseInertia, parent.frame);
  edge.frame = turnedBy(push * edge.inverseInertia, edge.frame);
}

// Stretch-shear, rigid: b - a is the edge's axis e times its length. The system of its three
// components is (w + wq l^2) I - wq e e^T, whose inverse is known (Sherman and Morrison 1950).
void keepEdge(inout Vertex a, inout Vertex b, inout Edge edge, float size) {
  float3 e = axisX(edge.frame) * size;
  float3 error = b.x - a.x - e;
  float mass = a.inverseMass + b.inverseMass;
  float wq = edge.inverseInertia;
  float3 multiplier = (error + e * (wq * dot(e, error) / mass)) / (mass + wq * size * size);
  a.x += multiplier * a.inverseMass;
  b.x -= multiplier * b.inverseMass;
  edge.frame = turnedBy(cross(e, multiplier) * wq, edge.frame);
}

Vertex rootVertex(uint i, uint strand, float4 rotation, float3 shift) {
  float4 bind = g_rodRest[rodIndex(1, i, strand)];
  Vertex vertex;
  vertex.x = rotate(rotation, bind.xyz) + shift;
  vertex.before = vertex.x;
  vertex.region = g_rods[rodIndex(0, i, strand)].w;
  vertex.inverseMass = 0.0;
  return vertex;
}

Edge rootEdge(uint strand, float4 rotation) {
  Edge edge;
  edge.frame = normalize(product(rotation, g_rodRest[rodIndex(0, 0, strand)]));
  edge.before = edge.frame;
  edge.inverseInertia = 0.0;
  return edge;
}

void restart(uint strand) {
  Edge edge = rootEdge(strand, g_rotation);
  for (uint i = 0; i < g_vertexCount; ++i) {
    Vertex vertex = rootVertex(i, strand, g_rotation, g_shift.xyz);
    if (i > 0 && i + 1 < g_vertexCount)
      edge.frame = normalize(product(edge.frame, g_rodRest[rodIndex(0, i, strand)]));
    edge.before = edge.frame;
    storeVertex(i, strand, vertex);
    storeEdge(i, strand, edge);
    drawVertex(i, strand, vertex, edge);
  }
}

void subStep(uint strand, float share, bool draw) {
  float4 rotation = blendRotations(g_rotationBefore, g_rotation, share);
  float3 shift = lerp(g_shiftBefore.xyz, g_shift.xyz, share);
  Vertex root = rootVertex(0, strand, rotation, shift);
  Vertex vertex = rootVertex(1, strand, rotation, shift);
  Edge parent = rootEdge(strand, rotation);
  if (draw) drawVertex(0, strand, root, parent);
  for (uint i = 1; i + 1 < g_vertexCount; ++i) {
    float size = g_rodRest[rodIndex(1, i, strand)].w;
    Edge edge = predictEdge(i, strand, size);
    Vertex next = predictVertex(i + 1, strand);
    if (g_bend > 0.0) keepBend(parent, edge, g_rodRest[rodIndex(0, i, strand)], vertex.region);
    keepEdge(vertex, next, edge, size);
    storeVertex(i, strand, vertex);
    storeEdge(i - 1, strand, parent);
    if (draw) drawVertex(i, strand, vertex, edge);
    vertex = next;
    parent = edge;
  }
  storeVertex(g_vertexCount - 1, strand, vertex);
  storeEdge(g_vertexCount - 2, strand, parent);
  if (draw) drawVertex(g_vertexCount - 1, strand, vertex, parent);
}

[numthreads(64, 1, 1)]
void simulate_cosserat(uint3 thread : SV_DispatchThreadID) {
  uint strand = thread.x;
  if (strand >= g_strandCount || g_vertexCount < 3 || g_vertexCount > 256) return;
  if (g_restart != 0) {
    restart(strand);
    return;
  }
  uint count = min(g_subSteps, 1000);
  for (uint k = 0; k < count; ++k) subStep(strand, float(k + 1) / float(count), k + 1 == count);
}
