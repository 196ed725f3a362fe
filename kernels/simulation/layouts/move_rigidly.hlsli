// Resources of move_rigidly. Group "moveRigidly", all in space0.
#ifndef PELAGE_SIMULATION_LAYOUTS_MOVE_RIGIDLY_HLSLI
#define PELAGE_SIMULATION_LAYOUTS_MOVE_RIGIDLY_HLSLI

// Kinds of elements. A block has elements of one kind; kinds repeat after g_movedPeriod blocks.
static const uint kMovesPoint = 0;  // rotated and shifted
// Rotated: displacements, velocities, forces, normals, and the vector parts of quaternions that
// rotate such vectors.
static const uint kMovesDirection = 1;
static const uint kMovesFrame = 2;  // a quaternion, multiplied from the left
static const uint kMovedKindBits = 2;

cbuffer MoveRigidlyConstants : register(b0, space0) {
  uint g_movedFirst;  // element; first: decision 0008
  uint g_movedCount;
  uint g_movedBlock;      // elements, > 0
  uint g_movedPeriod;     // blocks, 1..16
  float4 g_moveRotation;  // unit quaternion
  float4 g_moveShift;     // xyz [m]; w unused
  uint g_movedKinds;      // kMovedKindBits a block of the period, lowest first
  uint g_movedPad0;
  uint g_movedPad1;
  uint g_movedPad2;
};

// Float4 as their bits; w is kept, but for quaternions.
RWStructuredBuffer<uint4> g_movedElements : register(u0, space0);

#endif
