// Resources of find_contacts. Group "contact".
#ifndef PELAGE_LAYOUTS_CONTACT_HLSLI
#define PELAGE_LAYOUTS_CONTACT_HLSLI

#include "collider.hlsli"
#include "contact_records.hlsli"
#include "sdf_field.hlsli"

cbuffer ContactConstants : register(b0, space0) {
  uint g_contactPad0;  // first: decision 0008
  uint g_contactPad1;
  uint g_contactPad2;
  uint g_contactStrandTotal;  // simulated or not
  float4 g_contactOrigin;  // xyz [m]: records, capsules and SDFs are relative to it; w unused
  uint g_contactStrandCount;
  uint g_contactVertexCount;  // elements of g_contactPositions
  uint g_contactMaskWords;    // words of a strand's mask
  uint g_capsuleCount;
  uint g_fieldCount;
  uint g_contactHead;   // first word of this sub-step's head
  uint g_contactList;   // of the list of tiles
  uint g_contactMasks;  // of the masks
  uint g_tileList;      // of the list of tiles in g_awakeTiles
  uint g_contactFlags;  // bit 0: only the tiles listed in g_awakeTiles; bit 1: again, for the tiles
                        // of the list; bit 2: nothing is known of the displacement before; bit 3:
                        // which of the two steps of roots is that of the last sub-step
  uint g_contactTileCount;
  uint g_contactRootCount;
  float g_contactBegin;  // of the sub-step in the frame, 0..1
  float g_contactEnd;
  float g_contactRatio;  // length of this sub-step over that of the last one
  float g_contactReach;  // what is this far from a surface has a record [m]
  float4 g_contactFall;  // xyz displacement by which vertices fall further in the sub-step, where that is
                         // far enough to leap over something [m]; w unused
};

// [vertex] world position [m], before the sub-step; again: after it.
StructuredBuffer<float4> g_contactPositions : register(t0, space0);
// [vertex] xyz world position before the last sub-step; again: before this one. Then [2][strand] xyz
// displacement of the root in this sub-step and the last one.
RWStructuredBuffer<float4> g_contactBefore : register(u0, space0);
RWStructuredBuffer<ContactRecord> g_contacts : register(u1, space0);
RWStructuredBuffer<uint> g_contactWords : register(u2, space0);
StructuredBuffer<ContactStrand> g_contactStrands : register(t1, space0);
StructuredBuffer<uint> g_awakeTiles : register(t2, space0);
// [2][root][2]: this frame and the last one; rotation, then position of vertex 0 relative to the
// origin [m].
StructuredBuffer<float4> g_contactRoots : register(t3, space0);
StructuredBuffer<Collider> g_capsules : register(t4, space0);
StructuredBuffer<SdfField> g_fields : register(t5, space0);
StructuredBuffer<uint> g_fieldKeys : register(t6, space0);
StructuredBuffer<uint4> g_fieldSurface : register(t7, space0);

#endif
