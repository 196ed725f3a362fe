// Guide hairs from a .tfx file, or generated ones.
#pragma once

#include <pelage/demo/groom.h>
#include <pelage/hair_asset.h>

inline pelage::Result<pelage::HairAsset> loadOrGenerate(int argc, char** argv) {
  if (argc > 1) return pelage::loadTfx(argv[1]);
  auto groom = pelage::generateGroom({.strandCount = 500});
  if (!groom) return groom.error();
  return groom->hair;
}

inline pelage::Result<pelage::HairAsset> makeHair(int argc, char** argv) {
  auto asset = loadOrGenerate(argc, argv);
  if (!asset) return asset.error();
  if (auto done = asset->process(); !done) return done.error();  // rest lengths, frames, tangents
  return asset;
}
