// Resources of drawing contact records. Group "drawContacts", all in space0.
#ifndef PELAGE_CONTACT_LAYOUTS_DRAW_CONTACTS_HLSLI
#define PELAGE_CONTACT_LAYOUTS_DRAW_CONTACTS_HLSLI

#include "contact_records.hlsli"

cbuffer DrawContactsConstants : register(b0, space0) {
  float4 g_contactsToClip[4];  // rows; clip = rows * (p, 1), p in world space, depth 0..1, y up
  float4 g_drawnOrigin;        // xyz [m]: records are relative to it; w unused
  float2 g_drawnPixels;        // size of the viewport [pixels]
  uint g_drawnStrandCount;     // strands that were simulated
  uint g_drawnVertexCount;     // elements of g_drawnPositions
  uint g_drawnMasks;           // first word of the masks in g_drawnWords
  uint g_drawnMaskWords;       // words of a strand's mask
  float g_needleLength;        // length of a sticking contact [m]
  float g_needleWidth;         // width at the vertex [pixels]
  float g_deepestDepth;        // depth from which a contact is red [m]
  float g_drawnPad0;
  float g_drawnPad1;
  float g_drawnPad2;
};

// [vertex] world position [m]
StructuredBuffer<float4> g_drawnPositions : register(t0, space0);
// [vertex][kMaxContacts]
StructuredBuffer<ContactRecord> g_drawnContacts : register(t1, space0);
// As in contact_records.hlsli.
StructuredBuffer<uint> g_drawnWords : register(t2, space0);
// [strand], in the order of the masks
StructuredBuffer<ContactStrand> g_drawnStrands : register(t3, space0);

struct ContactVaryings {
  float4 clip : SV_Position;
  float3 color : TEXCOORD0;  // linear rgb
};

#endif
