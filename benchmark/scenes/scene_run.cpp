#include "scenes/scene_run.h"

#include <algorithm>
#include <utility>

#include "head_motion.h"
#include "pelage/skeleton.h"
#include "scene_setup.h"
#include "scenes/characters.h"
#include "scenes/head_sdf.h"
#include "simulation/strand_solver.h"

namespace bench {

using pelage::AffineTransform;
using pelage::BufferId;
using pelage::Float3;
using pelage::PassList;
using pelage::Result;
using pelage::reference::TriangleMesh;
using sample::DemoScene;

namespace {

constexpr uint32_t kBaselineSweeps = 2;
constexpr uint32_t kBaselineVertices = 32;

TriangleMesh posed(const pelage::CollisionMesh& mesh, const std::vector<AffineTransform>& bones) {
  TriangleMesh result;
  result.indices = mesh.indices;
  result.positions.reserve(mesh.positions.size());
  for (size_t i = 0; i < mesh.positions.size(); ++i)
    result.positions.push_back(sample::blendedPoint(bones, mesh.influences[i], mesh.positions[i]));
  return result;
}

/// Hair without colliders, by pelage's solvers or the baseline's.
class FreeRun : public SceneRun {
 public:
  static Result<std::unique_ptr<SceneRun>> create(Workbench& workbench, const SceneRow& row,
                                                  const BenchScene& scene) {
    // The classic solver's settings are the default ones of SimulationSettings.
    SolverChoice choice = {SolverKind::kExact, 1};
    if (row.solver == RowSolver::kClassic)
      choice = {SolverKind::kClassic, pelage::SimulationSettings{}.lengthIterations};
    if (row.solver == RowSolver::kBaseline) choice = {SolverKind::kSweeps, kBaselineSweeps};
    auto solver = makeSolver(workbench, scene, choice);
    if (!solver) return solver.error();
    return std::unique_ptr<SceneRun>(new FreeRun(scene, std::move(*solver)));
  }

  Result<void> advance(std::vector<PassList>& lists) override {
    lists.resize(1);
    return solver_->advance(scene_.motion(frame_++ * kFrameSeconds), lists[0]);
  }
  std::vector<RunHair> hairs() const override {
    RunHair hair;
    hair.asset = &scene_.asset;
    hair.buffers.positions = solver_->positions();
    return {hair};
  }
  ColliderPose colliders() const override { return {}; }
  bool isSdfBuffer(std::string_view) const override { return false; }

 private:
  FreeRun(const BenchScene& scene, std::unique_ptr<StrandSolver> solver)
      : scene_(scene), solver_(std::move(solver)) {}

  const BenchScene& scene_;
  std::unique_ptr<StrandSolver> solver_;
  int frame_ = 0;
};

/// A scene of the sample; errors are of this one, whatever others are in the workbench's scene.
class DemoRun : public SceneRun {
 public:
  DemoRun(std::vector<DemoScene> demos, std::vector<const pelage::HairAsset*> assets,
          std::vector<const pelage::CollisionMesh*> meshes)
      : demos_(std::move(demos)),
        demo_(demos_[0]),
        assets_(std::move(assets)),
        meshes_(std::move(meshes)) {}

  Result<void> advance(std::vector<PassList>& lists) override {
    lists.resize(1);
    Result<void> done = advanceAll(demos_, lists[0]);
    if (done) demo_.finish(lists[0]);
    return done;
  }
  std::vector<RunHair> hairs() const override {
    std::vector<RunHair> hairs;
    for (size_t i = 0; i < assets_.size(); ++i) {
      const pelage::HairObject& hair = demo_.scene().hair(demo_.hairs()[i]);
      hairs.push_back({assets_[i], hair.buffers(), hair.followCount()});
    }
    return hairs;
  }
  ColliderPose colliders() const override {
    ColliderPose pose;
    pose.capsules = demo_.capsules();
    for (const pelage::CollisionMesh* mesh : meshes_)
      pose.meshes.push_back(posed(*mesh, demo_.bones()));
    return pose;
  }
  bool isSdfBuffer(std::string_view name) const override { return bench::isSdfBuffer(demo_, name); }

 private:
  std::vector<DemoScene> demos_;
  DemoScene& demo_;  ///< the first
  std::vector<const pelage::HairAsset*> assets_;
  std::vector<const pelage::CollisionMesh*> meshes_;
};

sample::DemoDef demoDefOf(Workbench& workbench, const SceneRow& row) {
  sample::DemoDef def;
  def.scene = &workbench.scene;
  def.solver = row.solver == RowSolver::kExact ? pelage::Solver::kExact : pelage::Solver::kClassic;
  if (row.followsCollide) def.collidingHair = pelage::CollidingHair::kGuidesAndFollows;
  if (row.kind != SceneKind::kHeadCapsules) def.headCollider = sample::HeadCollider::kMesh;
  // Nothing is drawn: a mesh that is only drawn is left out.
  def.drawSdf = row.kind != SceneKind::kHeadCapsules;
  return def;
}

Result<std::unique_ptr<SceneRun>> makeHeadRun(Workbench& workbench, const SceneRow& row,
                                              SceneAssets& assets) {
  const auto head = assets.head(row.guides);
  if (!head) return head.error();
  sample::DemoAssets used = **head;
  if (row.kind == SceneKind::kHeadCapsules) used.mesh.reset();
  auto demo = DemoScene::create(used, demoDefOf(workbench, row));
  if (!demo) return demo.error();
  std::vector<const pelage::CollisionMesh*> meshes;
  if (used.mesh) meshes.push_back(&*(*head)->mesh);
  std::vector<DemoScene> demos;
  demos.push_back(*std::move(demo));
  return std::unique_ptr<SceneRun>(
      std::make_unique<DemoRun>(std::move(demos), std::vector{&(*head)->hair}, std::move(meshes)));
}

Result<std::unique_ptr<SceneRun>> makeCharacterRun(Workbench& workbench, const SceneRow& row,
                                                   SceneAssets& assets) {
  const auto character = assets.character(row.guides);
  if (!character) return character.error();
  auto demos = makeCharacters(**character, demoDefOf(workbench, row), row.characters);
  if (!demos) return demos.error();
  std::vector<const pelage::HairAsset*> hair;
  for (const pelage::CharacterGroom& groom : (*character)->grooms) hair.push_back(&groom.hair);
  std::vector<const pelage::CollisionMesh*> meshes;
  for (const pelage::CharacterCollider& collider : (*character)->colliders)
    meshes.push_back(&collider.mesh);
  return std::unique_ptr<SceneRun>(
      std::make_unique<DemoRun>(*std::move(demos), std::move(hair), std::move(meshes)));
}

/// The head by the classic baseline: its strands, then its SDF and the collision with it. Its mesh
/// is posed on the CPU and uploaded, which is in no pass.
class BaselineHeadRun : public SceneRun {
 public:
  static Result<std::unique_ptr<SceneRun>> create(Workbench& workbench,
                                                  const sample::DemoAssets& head) {
    auto scene = headOfBaseline(head);
    if (!scene) return scene.error();
    std::unique_ptr<BaselineHeadRun> run(new BaselineHeadRun(workbench, head, *std::move(scene)));
    auto solver = makeSweepsSolver(workbench, run->scene_, kBaselineSweeps);
    if (!solver) return solver.error();
    run->solver_ = std::move(*solver);
    return std::unique_ptr<SceneRun>(std::move(run));
  }

  Result<void> advance(std::vector<PassList>& lists) override {
    lists.resize(2);
    const double time = frame_++ * kFrameSeconds;
    Result<void> done = solver_->advance(scene_.motion(time), lists[0]);
    if (!done) return done;
    mesh_ = posed(*head_.mesh, sample::poseSkeleton(head_.skeleton, sample::headPose(time)));
    const CollidingVertices vertices = {solver_->positions(), solver_->positionsBefore(),
                                        scene_.asset.strandCount * scene_.asset.verticesPerStrand};
    PassList& list = lists[1];
    list.clear();
    done = sdf_.addPasses(list, mesh_, vertices);
    if (done) workbench_.scene.finish(list);
    return done;
  }
  std::vector<RunHair> hairs() const override {
    RunHair hair;
    hair.asset = &scene_.asset;
    hair.buffers.positions = solver_->positions();
    return {hair};
  }
  ColliderPose colliders() const override { return {{}, {mesh_}}; }
  bool isSdfBuffer(std::string_view name) const override { return HeadSdf::isBuffer(name); }

 private:
  BaselineHeadRun(Workbench& workbench, const sample::DemoAssets& head, BenchScene scene)
      : workbench_(workbench),
        head_(head),
        scene_(std::move(scene)),
        mesh_{head.mesh->positions, head.mesh->indices},
        sdf_(workbench, mesh_) {}

  Workbench& workbench_;
  const sample::DemoAssets& head_;
  BenchScene scene_;
  std::unique_ptr<StrandSolver> solver_;
  TriangleMesh mesh_;
  HeadSdf sdf_;
  int frame_ = 0;
};

}  // namespace

Result<std::unique_ptr<SceneRun>> makeSceneRun(Workbench& workbench, const SceneRow& row,
                                               SceneAssets& assets) {
  switch (row.kind) {
    case SceneKind::kFree: {
      const auto scene = assets.freeHair(row.guides);
      if (!scene) return scene.error();
      return FreeRun::create(workbench, row, **scene);
    }
    case SceneKind::kCharacter:
      return makeCharacterRun(workbench, row, assets);
    case SceneKind::kHeadCapsules:
    case SceneKind::kHeadSdf:
      break;
  }
  if (row.solver != RowSolver::kBaseline) return makeHeadRun(workbench, row, assets);
  const auto head = assets.head(row.guides, kBaselineVertices);
  if (!head) return head.error();
  return BaselineHeadRun::create(workbench, **head);
}

bool writesTo(const pelage::ResourceTable& resources, const PassList& list,
              const pelage::Pass& pass, const std::function<bool(std::string_view)>& isWanted) {
  for (const pelage::PassBinding& binding : list.bindingsOf(pass)) {
    if (!pelage::writes(binding.access)) continue;
    const pelage::BufferDesc* desc = resources.find(binding.buffer);
    if (desc != nullptr && isWanted(desc->name)) return true;
  }
  return false;
}

// Buffers that colliders share are named "sdf/..."; buffers of one collider have its name.
bool isSdfBuffer(const DemoScene& demo, std::string_view name) {
  if (name.starts_with("sdf/")) return true;
  const auto& colliders = demo.colliders();
  return std::any_of(colliders.begin(), colliders.end(), [&](pelage::ColliderId id) {
    return name.starts_with(demo.scene().collider(id).name() + "/");
  });
}

}  // namespace bench
