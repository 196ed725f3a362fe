// Resources for transforming strands to the screen. Group "strandRecords" (space2 after RenderPosTan
// and Render).
#ifndef PELAGE_SHADING_LAYOUTS_STRAND_RECORDS_HLSLI
#define PELAGE_SHADING_LAYOUTS_STRAND_RECORDS_HLSLI

cbuffer StrandRecordsConstants : register(b0, space2) {
  uint g_recordCapacity;  // of g_strandRecords, in records
  uint g_firstRecord;     // of this object
  uint g_objectRecords;   // of this object
  uint g_recordPad0;
};

// [vertex][3], see shading/strand_record.hlsli.
RWStructuredBuffer<uint4> g_strandRecords : register(u0, space2);

#endif
