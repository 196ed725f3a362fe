// The scenes of the simulation benchmark: what moves, and what the motion should have been.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pelage/hair_asset.h"
#include "pelage/result.h"
#include "reference/rod/rest_strand.h"

namespace bench {

using Points = std::vector<pelage::rod::Vector3d>;
/// Pose of all roots at a time [s]; the hair is bound to one rigid head.
using Motion = std::function<pelage::rod::RootPose(double)>;

inline pelage::rod::Vector3d toVector(const pelage::Float4& v) { return {v.x, v.y, v.z}; }

inline constexpr double kFrameSeconds = 1 / 60.0;

/// The reference that a scene is compared with.
struct Reference {
  /// Positions of the strand in each of the last frames.size() frames.
  std::vector<Points> frames;
  /// Vertices that are compared; empty compares all of them.
  std::vector<int> vertices;
};

/// A groom, its motion and its material. Strands have unit linear density.
struct BenchScene {
  std::string name;
  pelage::HairAsset asset;  ///< processed
  Motion motion;
  int settleFrames = 0;  ///< with the root at motion(0), before the frames that are measured
  int frames = 0;
  double gravity = 9.81;  ///< downwards [m/s2]
  double bend = 0;        ///< B = E I / (rho A) [m4/s2]
  double twist = 0;       ///< G J / (rho A) [m4/s2]
  double airDrag = 0;     ///< [1/s]
  double carry = 0;       ///< share of velocity shock propagation
  /// Lets hair at rest sleep. Off where the price of a step is measured.
  bool sleeps = false;
  /// Computed once; empty where the motion is chaotic and only stretch can be compared. For strands
  /// that are copies of each other, of the first one.
  std::function<std::optional<Reference>()> reference;
  /// Local stiffness of the classic solvers, which know no bending stiffness in SI units.
  float localStiffness = 0;
};

/// A limp strand of 0.3 m, 60 degrees below the horizontal, that swings for 1 s without drag.
/// Reference: a chain in absolute angles, Runge-Kutta at 6,000 Hz.
BenchScene limpSwing(uint32_t copies);
/// The same from the horizontal: its tip cracks like a whip.
BenchScene limpWhip(uint32_t copies);
/// Strands of 0.3 m and bend length 0.05 and 0.15 m that fall from the horizontal, their rest
/// shape, for 1 s without drag. Reference as above, and the bending of the same chain.
BenchScene softSwing(uint32_t copies);
BenchScene stiffSwing(uint32_t copies);
/// A curl on a head that shakes and turns for 2 s. Reference: the exact solver in double precision
/// at 128 steps a frame.
BenchScene shakenCurl(uint32_t copies);
/// The tip of a straight strand of 0.2 m that comes to rest under its weight. Reference: the
/// elastica by shooting.
BenchScene elastica(uint32_t copies);
/// A helix of 64 vertices that sags. Reference: a continuous Kirchhoff rod by shooting.
BenchScene saggingHelix(uint32_t copies);

/// Hair on a head that moves 0.2 m to both sides at 1.9 Hz and turns, for 4 s. Chaotic.
/// \param copies  of all strands, at the same place
/// \param carry  share of velocity shock propagation
BenchScene movedGroom(std::string name, const pelage::HairAsset& asset, uint32_t copies,
                      double carry);

/// The same hair on a head that keeps still, 15 s later, when it has come to rest.
BenchScene restingGroom(std::string name, const pelage::HairAsset& asset, uint32_t copies);

/// A generated groom of this many strands x 32 vertices.
pelage::Result<pelage::HairAsset> generatedHair(uint32_t strands);

}  // namespace bench
