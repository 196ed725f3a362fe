// A skinned mesh drawn with the sample's own kernels, in the same pass list as the hair.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "pelage/collision_mesh.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/skeleton.h"
#include "pelage/view.h"

namespace sample {

struct MeshDef {
  std::string name = "mesh";
  /// [vertex] bones and weights in terms of setBones(), from mapBones(); empty binds all vertices
  /// to bone 0.
  std::span<const pelage::BoneInfluences> influences = {};
  uint32_t boneCount = 1;
  /// [vertex] share of the scalp's colour, 0..1; empty for none.
  std::span<const float> scalp = {};
  /// [vertex] share of the coat's colour, likewise.
  std::span<const float> coat = {};
};

/// Linear RGB, 0..1.
struct MeshMaterial {
  pelage::Float3 skin = {0.52f, 0.375f, 0.305f};
  pelage::Float3 scalp = {0.060f, 0.034f, 0.024f};
  pelage::Float3 coat = {0.110f, 0.075f, 0.048f};
};

/// Shadow maps of hair: Scene::shadowWords() and shadowViews(), the first map that of the light.
struct HairShadowMaps {
  pelage::BufferRange words, views;
};

class MeshObject {
 public:
  /// Adds the mesh's buffers to a table. Errors: a mesh without triangles, arrays that do not fit
  /// together, more than 256 bones.
  static pelage::Result<MeshObject> create(pelage::ResourceTable& resources,
                                           const pelage::CollisionMesh& mesh, const MeshDef& def);

  /// Removes the buffers from their table.
  void remove(pelage::ResourceTable& resources);

  /// The bones (bind space to world) of the next draw; identities at first. Asserts on another
  /// count.
  void setBones(std::span<const pelage::AffineTransform> bones);
  /// Adds the draw to a list. \param shadows of hair on the mesh; nullptr for none.
  pelage::Result<void> draw(const pelage::View& view, const pelage::Light& light,
                            pelage::PassList& list, const HairShadowMaps* shadows = nullptr) const;

  MeshMaterial material;

 private:
  pelage::BufferId vertices_ = pelage::BufferId::kInvalid;
  std::vector<pelage::AffineTransform> bones_;
  pelage::BufferId indices_ = pelage::BufferId::kInvalid;
  uint32_t vertexCount_ = 0, indexCount_ = 0;
};

}  // namespace sample
