// The classic baseline's SDF of a mesh that moves: its build, and the collision with it.
#pragma once

#include <memory>
#include <string_view>

#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "reference/sdf/mesh_shapes.h"
#include "sdf/colliding_vertices.h"
#include "simulation/workbench.h"

namespace bench {

class SdfBuild;

/// On the padded grid of the original, with the cells of pelage's SDF of the mesh: a 50th of its
/// longest side.
class HeadSdf {
 public:
  HeadSdf(Workbench& workbench, const pelage::reference::TriangleMesh& mesh);
  ~HeadSdf();
  HeadSdf(const HeadSdf&) = delete;
  HeadSdf& operator=(const HeadSdf&) = delete;

  /// Adds the build of the mesh as it is now, and the collision.
  /// \param mesh  with the triangles that it was made with
  pelage::Result<void> addPasses(pelage::PassList& list,
                                 const pelage::reference::TriangleMesh& mesh,
                                 const CollidingVertices& vertices);
  /// Whether a buffer of this name holds the SDF.
  static bool isBuffer(std::string_view name) { return name == "contactSdfKeys"; }

 private:
  std::unique_ptr<SdfBuild> field_;
};

}  // namespace bench
