// The builds of distance fields and the collisions with them, pelage's and the baseline's, behind
// one interface.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "sdf/colliding_vertices.h"
#include "sdf/sdf_errors.h"
#include "sdf/sdf_shapes.h"
#include "simulation/workbench.h"

namespace bench {

/// How a vertex is moved out.
enum class Response : uint8_t {
  kClassic,         ///< the baseline's: gradient by forward differences
  kTrilinear,       ///< analytic gradient
  kClosestFeature,  ///< the nearest feature of the surface
};
const char* responseName(Response response);

/// A field on the GPU. Its buffers go with it.
class SdfBuild {
 public:
  virtual ~SdfBuild() = default;
  SdfBuild(const SdfBuild&) = delete;
  SdfBuild& operator=(const SdfBuild&) = delete;

  /// Uploads where the mesh's vertices are from the list on. Only the classic baseline takes them;
  /// kUnsupported elsewhere.
  virtual pelage::Result<void> moveMesh(pelage::PassList& list,
                                        std::span<const pelage::Float3> positions);
  /// Adds the passes of one build.
  virtual pelage::Result<void> addBuild(pelage::PassList& list) = 0;
  virtual std::vector<Response> responses() const = 0;
  virtual pelage::Result<void> addCollision(pelage::PassList& list, const CollidingVertices& hair,
                                            Response response) = 0;
  /// The values at the nodes of the grid that it was made with.
  virtual pelage::Result<std::vector<NodeValue>> nodes() = 0;
  virtual uint64_t nodeCount() const = 0;  ///< of its own grid
  virtual uint64_t sdfBytes() const = 0;   ///< of what is kept a node
  /// Total size of all buffers but mesh and vertices.
  virtual uint64_t bytes() const = 0;

 protected:
  SdfBuild() = default;
};

enum class SdfMotion : uint8_t {
  kAll,   ///< rebuilt as a whole, every time
  kPart,  ///< 9 % of the triangles move, and what they touch is rebuilt
  kNone,  ///< nothing moves, and the GPU finds that out
};

struct SdfMethod {
  std::string name;
  bool classic = false;
  bool ownGrid = false;  ///< classic: the padded grid of the original; else that of pelage
  bool threeAxes = false;
  float band = 2;        ///< [cell]
  uint32_t keyBits = 0;  ///< of a distance at most; 0: what the triangles leave
  SdfMotion motion = SdfMotion::kAll;
  bool collides = false;  ///< hair is measured, too
};

/// Where the nodes are that pelage plans for a mesh; all methods of one shape, cell and band are
/// compared there.
pelage::Result<NodeGrid> comparedGrid(const SdfShape& shape, float cellSize, float band);

pelage::Result<std::unique_ptr<SdfBuild>> makeSdf(Workbench& workbench, const SdfShape& shape,
                                                  const NodeGrid& compared,
                                                  const SdfMethod& method);
std::unique_ptr<SdfBuild> makeClassicSdf(Workbench& workbench, const SdfShape& shape,
                                         const NodeGrid& compared, bool ownGrid);
pelage::Result<std::unique_ptr<SdfBuild>> makePelageSdf(Workbench& workbench, const SdfShape& shape,
                                                        const NodeGrid& compared,
                                                        const SdfMethod& method);

}  // namespace bench
