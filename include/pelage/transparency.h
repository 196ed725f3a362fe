// How hair is drawn over what is behind it, what that costs in memory, and how full its memory was.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "pelage/export.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"

namespace pelage {

struct EngineLights;

enum class Transparency : uint8_t {
  /// Fragments are opaque, or left out where they cover less of the pixel than a threshold of the
  /// strand's own. The cheapest.
  kAlphaTest,
  /// As many samples of a pixel are written as the fiber covers, picked at random; wants a target
  /// of several samples.
  kStochastic,
  /// The exact composite: per-pixel linked lists, resolved in windows of the nearest fragments.
  kWindowed,
  /// The nearest 4, 8 or 16 fragments of a pixel exactly, the others averaged behind them, in a
  /// fixed amount of memory: 8 bytes a pixel for each fragment kept, and 16. Draws the strands
  /// twice.
  kHybrid4,
  kHybrid8,
  kHybrid16,
  /// The nearest 3 fragments, the others with their mean colour: 28 bytes a pixel. Draws the
  /// strands twice, and writes the depth of the third fragment into the target.
  kShortCut,
  /// The exact composite by compute kernels alone: fragments are sorted by pixel, and only those
  /// that are visible are lit. 48 bytes a vertex of the hair in view, 12 a pixel, and 28 a
  /// fragment;
  /// where that is too much, in rounds over parts of the picture. See opaqueDepth.
  kTiles,
};

struct TransparencySettings {
  Transparency method = Transparency::kWindowed;
  /// Bytes that a method's buffers may take for one view; lists get fewer nodes where it is short.
  /// The buffers are made by the first draw that needs them.
  uint64_t maxBytes = uint64_t{512} << 20;
  /// Bytes that a kernel can have bound of one buffer. Every Vulkan and GL device takes 128 MiB;
  /// most take more (VkPhysicalDeviceLimits::maxStorageBufferRange,
  /// GL_MAX_SHADER_STORAGE_BLOCK_SIZE, DeviceInfo::maxBufferBytes).
  uint64_t maxBufferBytes = uint64_t{128} << 20;
  /// Fragments that there is room for; 0 takes 8 a pixel of the view for lists; for tiles 8 a
  /// vertex, or 2 a pixel if that is more. See growNodes().
  uint32_t nodeCount = 0;
  /// Lists: fragments without room are averaged, behind those that have it; costs 16 bytes a pixel.
  /// Otherwise they are left out.
  bool spillTail = true;
  /// Lists and tiles: where less than this comes through, nothing is looked for behind, 0..1.
  float epsilon = 0.5f / 255;
  /// Tiles: depth of opaque objects, a float for each pixel of the view, row 0 the top row. The
  /// engine fills it after lists[0] and before lists[1]. Without it nothing occludes hair.
  BufferId opaqueDepth = BufferId::kInvalid;
  /// The engine's own lights in place of those that draw() is given, whose ambient light and shadow
  /// maps they may still read. It is looked at during the call only. nullptr: pelage's lights.
  const EngineLights* engineLights = nullptr;
};

/// Sizes of a method's buffers for a view.
struct TransparencyPlan {
  uint32_t nodeCount = 0;  ///< of lists; of tiles the fragments of all rounds
  uint64_t bytes = 0;      ///< of all buffers
  /// Tiles: where memory is short, they are drawn in rounds, each of which walks through all
  /// strands again; 1 to 16.
  uint32_t rounds = 1;
  uint32_t roundCapacity = 0;  ///< tiles: fragments that a round has room for
};

/// Largest number of nodes that lists may have.
inline constexpr uint32_t kMaxListNodes = 0x3ffffff;

/// Errors: a method that is no Transparency; a view without pixels or of more than 2^28; an epsilon
/// that is not 0..1; a cap that is too small for one node, or for the layers of a method that keeps
/// a fixed number, with the size that is needed.
/// \param strandVertices  vertices of the strands in view; only tiles need it.
PELAGE_API Result<TransparencyPlan> planTransparency(uint32_t width, uint32_t height,
                                                     const TransparencySettings& settings,
                                                     uint64_t strandVertices = 0);

/// Counters of the last frame's lists or tiles. A tile whose fragments do not all fit is left
/// empty.
struct TransparencyCounters {
  uint32_t fragments = 0;  ///< that wanted a node
  uint32_t spilled = 0;    ///< of them without room
  uint32_t tiles = 0;      ///< of 8 x 8 pixels that had hair
};

/// Where the GPU keeps which tiles of 8 x 8 pixels the hair of a view is in, and what is in each:
/// for pictures of the load. Valid in lists behind those of the view. With more than 64 materials
/// that shade differently it is what the last batch has: docs/oit.md.
struct TransparencyTiles {
  Transparency method = Transparency::kWindowed;  ///< kWindowed or kTiles
  uint32_t columns = 0, rows = 0;                 ///< of tiles
  uint32_t nodeCount = 0;                         ///< TransparencyPlan::nodeCount of the view
  /// kTiles: [tile] number of fragments, 0 where they had no room; [tile] their offset; then the
  /// tiles that have hair. kWindowed: [tile] whether it has hair; then the tiles that have
  /// hair. Layouts: kernels/oit/layouts/strand_tiles.hlsli and ppll_build.hlsli.
  BufferId tiles = BufferId::kInvalid;
  BufferId counters = BufferId::kInvalid;  ///< Scene::transparencyCounters()
  BufferId heads = BufferId::kInvalid;     ///< kWindowed: [y][x] first node of a pixel's list, + 1
  BufferId nodes = BufferId::kInvalid;     ///< kWindowed: the nodes
};

/// Reads the counters from what Scene::transparencyCounters() holds, read back: those of the last
/// frame that the GPU has finished. Copy them when your engine reads back, and use them a frame
/// late. Asserts on fewer than 32 bytes.
/// \param nodeCount that the lists of that frame had.
PELAGE_API TransparencyCounters readTransparencyCounters(std::span<const std::byte> words,
                                                         uint32_t nodeCount);

/// A number of nodes for the next frames: a quarter more than there were fragments, where some
/// spilled or less than a third of the nodes was used; otherwise the same one, so that buffers are
/// not made anew every frame.
PELAGE_API uint32_t growNodes(const TransparencyCounters& counters, uint32_t nodeCount);

/// The quantities on which the time of the exact methods, kWindowed and kTiles, depends.
struct TransparencyWork {
  double vertices = 0;   ///< of the strands that are drawn
  double fragments = 0;  ///< that their ribbons have in the view
  double tiles = 0;      ///< of 8 x 8 pixels, with hair
  double alpha = 0;      ///< of a fragment on average, 0..1
};

/// Replaces predicted work by the work that a frame counted: fragments and tiles. Other methods
/// than the two change nothing, nor does a frame without hair. \param predicted  from
/// Scene::predictWork() for that frame.
PELAGE_API TransparencyWork refineWork(const TransparencyWork& predicted, Transparency method,
                                       const TransparencyCounters& counters);

/// Milliseconds on the GPU that the model was fitted on; docs/oit_tiles.md has it. Other
/// devices are faster or slower, but often in both methods.
struct TransparencyCost {
  double windowed = 0, tiles = 0;
};
PELAGE_API TransparencyCost predictCost(const TransparencyWork& work);

/// kWindowed or kTiles, whichever is predicted to be faster: both draw the same picture.
/// \param software the device is a software driver (DeviceInfo::software), where windows of lists
/// are always faster.
/// \param current the method of the last frame; it is kept unless the other one takes four fifths
/// of its time or less, so that a view at the border does not change it every frame.
PELAGE_API Transparency chooseTransparency(const TransparencyWork& work, bool software,
                                           Transparency current);

}  // namespace pelage
