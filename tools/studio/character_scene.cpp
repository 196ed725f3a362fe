// The scene of the character: three grooms and three colliders.
#include <algorithm>
#include <cmath>

#include "demo_scene.h"
#include "names.h"
#include "scene_setup.h"

namespace sample {

using pelage::CharacterGroom;

namespace {

constexpr Float3 kCharacterCameraDirection = {0.42f, 0.14f, 1};
constexpr float kFrameBottom = -0.06f;  // m; the picture ends at the chest
constexpr float kFrameSide = 0.22f;     // m; and beside the shoulders
constexpr float kSdfCell = 0.010f;      // m

pelage::SimulationSettings settingsFor(const CharacterGroom& groom, pelage::Solver solver) {
  pelage::SimulationSettings settings = groom.settings;
  settings.solver = solver;
  if (solver == pelage::Solver::kClassic) {
    settings.globalStiffness = std::max(settings.globalStiffness, kClassicGlobalStiffness);
    settings.globalRange = 1;
  }
  return settings;
}

// [vertex] the larger share.
std::vector<float> larger(std::vector<float> a, const std::vector<float>& b) {
  for (size_t i = 0; i < a.size(); ++i) a[i] = std::max(a[i], b[i]);
  return a;
}

}  // namespace

Result<DemoScene> DemoScene::create(const Character& character, const DemoDef& def) {
  DemoScene demo(def);
  demo.boneCount_ = static_cast<uint32_t>(character.skeleton.bones.size());
  demo.isCharacter_ = true;
  demo.place_ = def.place;
  demo.setMotion(def.motion);
  demo.cameraDef_.direction = kCharacterCameraDirection;
  demo.cameraDef_.margin = 0.02f;
  demo.takeLook({studioLight(kCharacterCameraDirection)}, def);

  for (const CharacterGroom& groom : character.grooms) {
    pelage::HairAsset hair = groom.hair;
    if (Result<void> done = hair.process(); !done) return done.error();
    pelage::HairDef hairDef;
    hairDef.name = groom.name;
    hairDef.material = groom.material;
    hairDef.settings = settingsFor(groom, def.solver);
    hairDef.influences = groom.bones.strands;
    if (Result<void> added = demo.addHair(hair, hairDef, groom.follow, def); !added)
      return added.error();
  }
  for (const pelage::CharacterCollider& collider : character.colliders) {
    Result<void> added =
        demo.addCollider(collider.mesh, {.name = collider.name, .cellSize = kSdfCell}, def);
    if (!added) return added.error();
  }
  if (!def.drawSdf)
    if (Result<void> added = demo.addBody(character); !added) return added.error();

  const double seconds = demo.cycle_.end;
  std::vector<Float3> points;
  for (int i = 0; i * kSweptStep <= seconds; ++i) {
    const std::vector<AffineTransform> bones = demo.pose_(i * kSweptStep);
    for (const CharacterGroom& groom : character.grooms)
      sweepHair(groom.hair, groom.bones.strands, bones, points);
    sweepMesh(character.mesh, bones, points);
  }
  for (const Float3& p : points)
    if (p.y > kFrameBottom && std::abs(p.x - def.place.x) < kFrameSide)
      demo.sweptPoints_.push_back(p);
  return demo;
}

Result<void> DemoScene::addBody(const Character& character) {
  const auto covered = [&](const CharacterGroom& groom) {
    return coveredShares(character.mesh, groom.hair, kScalpRange * groom.rootSpacing);
  };
  const std::vector<float> scalp =
      larger(covered(character.grooms[0]), covered(character.grooms[2]));
  const std::vector<float> coat = covered(character.grooms[1]);
  MeshDef def;
  def.name = "character";
  def.influences = character.mesh.influences;
  def.scalp = scalp;
  def.coat = coat;
  if (Result<void> done = addMesh(character.mesh, def); !done) return done;
  if (Result<void> done = addFaceHair(character.skeleton); !done) return done;
  meshes_.back().material = {character.parts[0].color, character.parts[1].color,
                             character.parts[2].color};
  return {};
}

}  // namespace sample
