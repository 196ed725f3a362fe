// pelage's own strands, for the pixel kernels of the benchmarks: smooth ribbons.
#define SMOOTH 1
#include "../../kernels/shading/strand_vertex.hlsl"
