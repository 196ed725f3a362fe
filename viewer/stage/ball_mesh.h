// The sphere that stands for the ball of a stage.
#pragma once

#include <optional>

#include "mesh_object.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/types.h"
#include "pelage/view.h"

namespace viewer {

class BallMesh {
 public:
  /// Adds its draw to a list; the first call adds its buffers to the table. \param radius > 0 [m].
  pelage::Result<void> draw(const pelage::Float3& center, float radius, const pelage::View& view,
                            const pelage::Light& light, pelage::ResourceTable& resources,
                            pelage::PassList& list);

 private:
  std::optional<sample::MeshObject> mesh_;
};

}  // namespace viewer
