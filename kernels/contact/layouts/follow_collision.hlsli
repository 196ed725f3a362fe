// Resources of the collision of stored follow hairs. Group "followCollision", all in space0.
//
// Sizes: S strands, of which the last F are follow hairs; V vertices per strand; R = ceil(V / 16)
// rows of vertices; T = ceil(F / 32) tiles of strands.
#ifndef PELAGE_CONTACT_LAYOUTS_FOLLOW_COLLISION_HLSLI
#define PELAGE_CONTACT_LAYOUTS_FOLLOW_COLLISION_HLSLI

#include "contact_records.hlsli"
#include "../../sdf/layouts/sdf.hlsli"

cbuffer FollowCollisionConstants : register(b0, space0) {
  uint g_followTileCount;  // T; first: decision 0008
  uint g_followColliderCount;
  uint g_followHistory;      // 1: g_followBefore has positions of the last frame; 0: it has none
  uint g_followAgain;        // 1: for the strands that are marked
  float4 g_followOrigin;     // xyz origin of SDFs and colliders, in world space [m]
  uint g_firstFollow;        // strand
  uint g_followHairCount;    // F
  uint g_followVertexCount;  // V, 2..256
  uint g_followSdfCount;
};

// A plane that a vertex stays in front of, relative to the origin. Without forces: a follow hair is
// posed anew in every frame.
struct FollowContact {
  float4 plane;  // xyz unit normal out of the collider; w dot(normal, p) of each p in the plane [m]
  float4 hold;   // xyz position of a sticking vertex [m]; w Coulomb's friction coefficient
};

static const uint kFollowTileStrands = 32;
static const uint kFollowRowVertices = 16;
// Contacts are found within this distance of a surface [m]. A strand walks again if a vertex ends
// more than kFollowError from where its contacts were found. Both are equal, so that a vertex
// without a contact may move by as much and stays outside.
static const float kFollowRange = 1e-3;
static const float kFollowError = 1e-3;

// [strand][vertex], S * V: world position [m]; w = inverse mass, > 0 for a free vertex.
RWStructuredBuffer<float4> g_followPositions : register(u0, space0);
// [strand][vertex], S * V: unit tangent; w = 0.
RWStructuredBuffer<float4> g_followTangents : register(u1, space0);
// [2][follow][vertex], 2 * F * V: world position at the end of the last frame [m], w unused; then
// that at which update_follow_hairs has posed it in this one, with its w.
RWStructuredBuffer<float4> g_followBefore : register(u2, space0);
// [2][vertex][follow], 2 * V * F: contacts of the vertices whose bits are set, deepest first.
RWStructuredBuffer<FollowContact> g_followContacts : register(u3, space0);
// kFollowHeadWords, then
//   list   [tile] tiles with marked strands
//   marks  [tile] bit i for strand i of a tile
//   masks  [row][follow] bit i for vertex i of a row: it has a contact; bit 16 + i: a second one
RWStructuredBuffer<uint> g_followWords : register(u4, space0);
// With the sdf permutation: [g_followSdfCount], and what they refer to.
StructuredBuffer<Sdf> g_followSdfs : register(t0, space0);
StructuredBuffer<uint> g_followKeys : register(t1, space0);
StructuredBuffer<uint4> g_followSurface : register(t2, space0);
// [g_followColliderCount]
StructuredBuffer<Collider> g_followColliders : register(t3, space0);

// Words of the head: totals of the frame, then the groups of a dispatch over the list.
static const uint kFollowRecords = 0;    // contacts written
static const uint kFollowMarked = 1;     // strands marked
static const uint kFollowArguments = 4;  // 3 words: tiles in the list, R, 1
static const uint kFollowHeadWords = 8;

uint followList() { return kFollowHeadWords; }
uint followMarks() { return kFollowHeadWords + g_followTileCount; }
uint followMaskWord(uint row, uint follow) {
  return kFollowHeadWords + 2u * g_followTileCount + row * g_followHairCount + follow;
}
uint followContactIndex(uint vertex, uint follow) { return vertex * g_followHairCount + follow; }
// Elements of g_followBefore before the second half.
uint followEvaluatedFrom() { return g_followHairCount * g_followVertexCount; }

#endif
