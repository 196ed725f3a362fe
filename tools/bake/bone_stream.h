// Transforms of named bones, frame by frame, as any program can write them. docs/bake.md describes
// the files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pelage/result.h"
#include "pelage/types.h"

namespace pelage::bake {

struct BoneStream {
  double framesPerSecond = 24;
  std::vector<std::string> bones;
  std::vector<AffineTransform> transforms;  ///< [frame][bone] bind space to world
  uint64_t frameCount() const { return transforms.size() / bones.size(); }
};

/// The file of floats that a header names.
Result<std::filesystem::path> dataOfBoneStream(const std::filesystem::path& header);

/// Loads a header and its floats. Errors name the file, and a JSON pointer or the byte: a setting
/// that is missing or out of range, two bones of one name, a bind transform without an inverse, a
/// file that does not have whole frames, a number that is not finite.
Result<BoneStream> loadBoneStream(const std::filesystem::path& header);

/// The transforms [bone] at a time [s] from the first frame; before it and behind the last one they
/// are those. Between two frames a translation and a stretch (the symmetric polar factor, where
/// there is no shear) are on the line between theirs, and a rotation on the shortest arc. \param
/// seconds  any finite time
std::vector<AffineTransform> transformsAt(const BoneStream& stream, double seconds);

}  // namespace pelage::bake
