// pelage's own strands, for the pixel kernels of the benchmarks: smooth ribbons without colours of
// their own.
#define SMOOTH 1
#define VERTEX_COLORS 0
#define BASE_TEXTURE 0
#include "../../kernels/shading/strand_vertex.hlsl"
