// Outputs of strand_motion_vertex and motion_record_vertex, for strand_depth_pixel with MOTION.
#ifndef PELAGE_SHADING_MOTION_INTERFACE_HLSLI
#define PELAGE_SHADING_MOTION_INTERFACE_HLSLI

struct MotionPixel {
  float4 clip : SV_Position;
  // xy and z: change of clip xy and w since the last frame; w: clip w in the last frame.
  float4 motion : TEXCOORD0;
  float2 alpha : TEXCOORD1;  // x opacity, y coverage of the ribbon by the fiber, 0..1
};

#endif
