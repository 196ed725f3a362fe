// A groom at rest with its mesh, and the views of it that the transparency benchmark has.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "camera.h"
#include "demo_assets.h"
#include "mesh_object.h"
#include "pelage/headless.h"
#include "pelage/scene.h"

namespace bench {

struct HairSceneDef {
  std::string name;
  sample::DemoAssets assets;
  pelage::StrandMaterial material;
  pelage::FollowDef follow;
  pelage::Light light;
  sample::Camera whole, close;
};

/// The mohawk on its body, with 16 follow hairs a guide, as wide as the study of the methods had
/// them: 23 to 31 layers a pixel. Nothing where the folder does not have it.
pelage::Result<std::optional<HairSceneDef>> mohawkScene(const std::filesystem::path& data);
/// The generated groom with 10 follow hairs a guide.
pelage::Result<HairSceneDef> groomScene(uint32_t guides, float aspect);
/// The character with its long hair.
pelage::Result<HairSceneDef> characterScene(float aspect);

/// The scene on a device, which knows its buffers by the ids of this table.
class HairScene {
 public:
  static pelage::Result<std::unique_ptr<HairScene>> create(const HairSceneDef& def,
                                                           pelage::HeadlessDevice& device);

  /// Mesh and hair; as Scene::draw(). All lists are cleared first.
  pelage::Result<void> draw(const pelage::View& view, const pelage::TransparencySettings& settings,
                            std::vector<pelage::PassList>& lists);
  /// Completes the lists and runs them over a grey target, all of them `times` times. More than
  /// once only those that ran in the last frame, too.
  pelage::Result<pelage::RenderedImage> render(std::vector<pelage::PassList>& lists,
                                               const pelage::View& view, pelage::BufferId depthCopy,
                                               std::vector<pelage::PassTiming>* timings,
                                               int times = 1);

  pelage::HeadlessDevice& device() { return device_; }
  pelage::Scene& scene() { return scene_; }
  pelage::ResourceTable& resources() { return scene_.resources(); }
  pelage::BufferId shadowWords() const { return scene_.shadowWords(); }
  pelage::HairObject& hair() { return scene_.hair(hair_); }
  const pelage::HairObject& hair() const { return scene_.hair(hair_); }
  pelage::BufferId transparencyCounters() const { return scene_.transparencyCounters(); }

 private:
  explicit HairScene(pelage::HeadlessDevice& device) : device_(device) {}
  pelage::Result<void> settle();

  pelage::HeadlessDevice& device_;
  pelage::Scene scene_;
  pelage::HairId hair_ = pelage::HairId::kInvalid;
  std::optional<sample::MeshObject> mesh_;
  pelage::Light light_;
};

}  // namespace bench
