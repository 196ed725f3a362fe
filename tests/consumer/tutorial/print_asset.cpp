#include <cstdio>

#include "make_hair.h"

int main(int argc, char** argv) {
  const auto asset = makeHair(argc, argv);
  if (!asset) return std::fprintf(stderr, "%s\n", asset.error().message.c_str()), 1;
  std::printf("%u strands of %u vertices\n", asset->strandCount, asset->verticesPerStrand);
}
