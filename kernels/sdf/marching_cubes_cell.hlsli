// Computes the triangles of a cell from the corners that are inside.
//
// Marching cubes (Lorensen and Cline, "Marching cubes: a high resolution 3D surface construction
// algorithm", SIGGRAPH 1987) with consistent cells: the surface on a face depends only on the four
// corners of the face, so both cells at the face agree. On a face with two inside corners at
// opposite ends of a diagonal, each of them is cut off separately.
//
// On every face, going around it counter-clockwise as seen from outside, each run of inside corners
// is cut off by a segment from where the run begins to where it ends. A crossed edge begins a run
// on one of its two faces and ends one on the other, so the segments close to loops. A loop becomes
// a fan of triangles whose diagonals lie in no face: the cell on the other side might draw the same
// diagonal there, and four triangles would share it. There is such a fan for every loop, and a cell
// has at most 5 triangles (marching_cubes_table.py checks both).
//
// The walk replaces the usual table of 256 cases: with the table, lavapipe (Mesa 22.3) compiles the
// kernel for 5 s; with the 24 words of this one, for a quarter of a second.
//
// Corner c is at (c & 1, c >> 1 & 1, c >> 2). Edge 4 a + k runs along axis a; the bits of k are the
// coordinates of its start on the other two axes, the lower axis first.
#ifndef PELAGE_SDF_MARCHING_CUBES_CELL_HLSLI
#define PELAGE_SDF_MARCHING_CUBES_CELL_HLSLI

#include "marching_cubes_table.hlsli"

// Start of an edge.
uint3 startOfEdge(uint edge) {
  uint axis = edge >> 2;
  uint low = edge & 1u;
  uint high = (edge >> 1) & 1u;
  if (axis == 0u) return uint3(0u, low, high);
  if (axis == 1u) return uint3(low, 0u, high);
  return uint3(low, high, 0u);
}

bool isInside(uint corners, uint corner) { return ((corners >> corner) & 1u) != 0u; }

// Bit e is set when edge e has one end inside. \param corners  bit c is set when corner c is inside
uint crossedEdges(uint corners) {
  uint x = corners ^ (corners >> 1);  // at corners 0, 2, 4, 6
  uint y = corners ^ (corners >> 2);  // at corners 0, 1, 4, 5
  uint z = corners ^ (corners >> 4);  // at corners 0, 1, 2, 3
  uint alongX = (x & 1u) | ((x >> 1) & 2u) | ((x >> 2) & 4u) | ((x >> 3) & 8u);
  uint alongY = (y & 3u) | ((y >> 2) & 12u);
  return alongX | (alongY << 4) | ((z & 15u) << 8);
}

// Returns the crossed edge at the end of the run that begins at this one.
uint edgeAfter(uint edge, uint corners) {
  uint3 start = startOfEdge(edge);
  uint side = isInside(corners, start.x | (start.y << 1) | (start.z << 2)) ? 1u : 0u;
  uint after = kAfterEdge[2u * edge + side];
  if (!isInside(corners, (after >> 12) & 7u)) return after & 15u;
  if (!isInside(corners, (after >> 15) & 7u)) return (after >> 4) & 15u;
  return (after >> 8) & 15u;
}

struct CellLoop {
  uint edges;  // a nibble each
  uint count;  // 3 to 7
};

// Returns the loop of the lowest crossed edge.
CellLoop loopOf(uint crossed, uint corners) {
  CellLoop result;
  result.edges = 0u;
  result.count = 0u;
  uint first = firstbitlow(crossed);
  uint edge = first;
  do {
    result.edges |= edge << (4u * result.count);
    result.count += 1u;
    edge = edgeAfter(edge, corners);
  } while (edge != first && result.count < 8u);
  return result;
}

uint edgeOfLoop(CellLoop cell, uint index) {
  uint wrapped = index < cell.count ? index : index - cell.count;
  return (cell.edges >> (4u * wrapped)) & 15u;
}

uint edgesOfLoop(CellLoop cell) {
  uint edges = 0u;
  for (uint i = 0; i < cell.count; ++i) edges |= 1u << edgeOfLoop(cell, i);
  return edges;
}

// The two faces of an edge: bit 2 a + s is the face at coordinate s of axis a.
uint facesOfEdge(uint edge) {
  uint axis = edge >> 2;
  uint low = axis == 0u ? 1u : 0u;
  uint high = axis == 2u ? 1u : 2u;
  return (1u << (2u * low + (edge & 1u))) | (1u << (2u * high + ((edge >> 1) & 1u)));
}

// Returns the first vertex of the loop whose fan has no diagonal in a face.
uint apexOfLoop(CellLoop cell) {
  uint apex = 0u;
  bool sound = false;
  while (!sound && apex < cell.count) {
    uint faces = facesOfEdge(edgeOfLoop(cell, apex));
    sound = true;
    for (uint i = 2; i + 1 < cell.count; ++i)
      if ((faces & facesOfEdge(edgeOfLoop(cell, apex + i))) != 0u) sound = false;
    if (!sound) apex += 1u;
  }
  return apex;
}

uint trianglesOfCell(uint corners) {
  uint triangles = 0u;
  uint crossed = crossedEdges(corners);
  while (crossed != 0u) {
    CellLoop cell = loopOf(crossed, corners);
    crossed &= ~edgesOfLoop(cell);
    triangles += cell.count - 2u;
  }
  return triangles;
}

#endif
