// The scene of one row on a device, whatever it is made of, behind one interface.
#pragma once

#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "demo_scene.h"
#include "pelage/collider.h"
#include "pelage/hair_asset.h"
#include "pelage/hair_object.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "reference/sdf/mesh_shapes.h"
#include "scenes/scene_assets.h"
#include "scenes/scene_rows.h"
#include "simulation/workbench.h"

namespace bench {

/// A hair object of a row.
struct RunHair {
  const pelage::HairAsset* asset = nullptr;  ///< processed
  pelage::HairBuffers buffers;               ///< `positions` at least, guides first
  uint32_t followHairs = 0;
};

/// The colliders of hair in one frame, in world space.
struct ColliderPose {
  std::vector<pelage::CapsuleCollider> capsules;
  std::vector<pelage::reference::TriangleMesh> meshes;
};

/// Its objects and buffers are removed from the workbench's scene with it.
class SceneRun {
 public:
  virtual ~SceneRun() = default;
  SceneRun(const SceneRun&) = delete;
  SceneRun& operator=(const SceneRun&) = delete;

  /// Writes the complete lists of the next frame of 1/60 s, which run one after another.
  virtual pelage::Result<void> advance(std::vector<pelage::PassList>& lists) = 0;
  virtual std::vector<RunHair> hairs() const = 0;
  /// The colliders of the last frame.
  virtual ColliderPose colliders() const = 0;
  /// Whether a buffer is one of an SDF's own, by its name.
  virtual bool isSdfBuffer(std::string_view name) const = 0;

 protected:
  SceneRun() = default;
};

/// Errors: those of the scene; a solver that has no code for it.
pelage::Result<std::unique_ptr<SceneRun>> makeSceneRun(Workbench& workbench, const SceneRow& row,
                                                       SceneAssets& assets);

/// Whether a pass writes to a buffer whose name is wanted. So no pass has to be known by name.
bool writesTo(const pelage::ResourceTable& resources, const pelage::PassList& list,
              const pelage::Pass& pass, const std::function<bool(std::string_view)>& isWanted);
/// SceneRun::isSdfBuffer() of a scene of the sample.
bool isSdfBuffer(const sample::DemoScene& demo, std::string_view name);

}  // namespace bench
