// Resources of find_contacts. Group "contact".
#ifndef PELAGE_CONTACT_LAYOUTS_CONTACT_HLSLI
#define PELAGE_CONTACT_LAYOUTS_CONTACT_HLSLI

#include "contact_records.hlsli"
#include "../../sdf/layouts/sdf.hlsli"

cbuffer ContactConstants : register(b0, space0) {
  uint g_contactStride;  // elements of a set of the scratch; 0: there is none; first: decision 0008
  uint g_contactBefore;  // element of g_contacts, see there
  uint g_contactStrands;      // word of g_contactWords
  uint g_contactStrandTotal;  // simulated or not
  float4 g_contactOrigin;     // xyz [m]: records, capsules and SDFs are relative to it; w unused
  uint g_contactStrandCount;
  uint g_contactVertexCount;  // elements of g_contactPositions
  uint g_contactMaskWords;    // words of a strand's mask
  uint g_capsuleCount;
  uint g_contactSdfCount;
  uint g_contactHead;   // first word of this sub-step's head
  uint g_contactList;   // of the list of strands
  uint g_contactMasks;  // of the masks
  uint g_tileList;      // of the list of tiles in g_awakeTiles
  uint g_contactFlags;  // bits: the flags below
  uint g_contactTileCount;
  uint g_contactRootCount;
  float g_contactBegin;  // of the sub-step in the frame, 0..1
  float g_contactEnd;
  float g_contactRatio;  // length of this sub-step over that of the last one
  float g_contactRange;  // a vertex within this distance of a surface has a record [m]
  // xyz additional displacement of falling vertices in the sub-step, if it is far enough to skip a
  // thin part [m]; w unused
  float4 g_contactFall;
  // Outside of a second search: vertices that a group takes of a strand, 2..32; its strands; groups
  // of a tile and a word of the masks.
  uint g_contactGroupVertices;
  uint g_contactGroupStrands;
  uint g_contactTileGroups;
  uint g_contactPad0;
};

// Bits of g_contactFlags.
static const uint kListedFlag = 1;     // only the tiles listed in g_awakeTiles
static const uint kAgainFlag = 2;      // again, for the strands of the list
static const uint kNoHistoryFlag = 4;  // nothing is known of the displacement before
static const uint kOddFlag = 8;      // which of the two steps of roots is that of the last sub-step
static const uint kMovingFlag = 16;  // an SDF moves in the frame
static const uint kFastFlag = 32;    // colliders are fast: sub-steps are shorter for them

static const uint kTileStrands = 32;
static const uint kGroupThreads = 128;
// Vertices of a word of the masks, and strands of a group in a second search.
static const uint kMaskVertices = 32;
static const uint kListedStrands = kGroupThreads / kMaskVertices;

// [vertex] world position [m], before the sub-step; again: after it.
StructuredBuffer<float4> g_contactPositions : register(t0, space0);
// As contact_records.hlsli has it. From g_contactBefore on: [vertex] xyz world position before the
// last sub-step; again: before this one. Then [2][strand] xyz displacement of the root in this
// sub-step and the last one. Floats as their bits.
RWStructuredBuffer<uint4> g_contacts : register(u0, space0);
RWStructuredBuffer<uint> g_contactWords : register(u1, space0);
StructuredBuffer<uint> g_awakeTiles : register(t1, space0);
// [2][root][2]: this frame and the last one; rotation, then position of vertex 0 relative to the
// origin [m].
StructuredBuffer<float4> g_contactRoots : register(t2, space0);
// Without the sdf permutation.
StructuredBuffer<Collider> g_capsules : register(t3, space0);
// With it: [g_contactSdfCount] Sdf, then [g_capsuleCount] Collider, kColliderElements each.
StructuredBuffer<uint4> g_contactColliders : register(t4, space0);
StructuredBuffer<uint> g_contactSdfKeys : register(t5, space0);
StructuredBuffer<uint4> g_contactSdfSurface : register(t6, space0);
static const uint kColliderElements = kSdfElements;

#endif
