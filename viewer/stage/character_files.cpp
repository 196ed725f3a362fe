#include "stage/character_files.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <utility>

#include "stage/curve_files.h"

#ifdef PELAGE_VIEWER_AUTHORING
#include "pelage/authoring/animation.h"
#include "pelage/authoring/collision_from_mesh.h"
#include "pelage/authoring/skin_binding.h"
#include "pelage/authoring/skinned_mesh.h"
#endif

namespace viewer {

using pelage::Error;
using pelage::ErrorCode;
using pelage::Result;

#ifdef PELAGE_VIEWER_AUTHORING

namespace {

// Only these have clips.
bool hasClips(const std::filesystem::path& path) {
  return path.extension() == ".gltf" || path.extension() == ".glb";
}

Result<void> addColliders(const std::filesystem::path& path, const pelage::SkinnedMesh& mesh,
                          LoadedFiles& files) {
  auto made = pelage::collisionMeshes(mesh);
  if (!made) return Error{made.error().code, path.string() + ": " + made.error().message};
  for (pelage::NamedCollisionMesh& named : *made) {
    if (Result<void> done = prepareCollider(named.mesh); !done)
      return Error{done.error().code, path.string() + ": " + done.error().message};
    files.assets.meshes.push_back({path.stem().string(), std::move(named.mesh)});
  }
  return {};
}

// Hair in files of its own knows no bones.
Result<void> bindHair(const std::filesystem::path& path, const pelage::SkinnedMesh& mesh,
                      LoadedFiles& files) {
  for (pelage::CachedHair& hair : files.assets.hairs) {
    if (hair.bones) continue;
    auto bound = pelage::bindRoots(pelage::rootsOf(hair.asset), mesh);
    if (!bound) return Error{bound.error().code, path.string() + ": " + bound.error().message};
    if (!bound->report.farStrands.empty())
      files.remarks.push_back(path.string() + ": " +
                              std::to_string(bound->report.farStrands.size()) + " roots of '" +
                              hair.name + "' are further than 5 mm from the mesh");
    hair.bones = std::move(bound->weights);
  }
  return {};
}

// The skeleton of the file in meters.
sample::BoneMotion motionOf(const std::filesystem::path& path, pelage::SkeletonAnimation loaded,
                            float scale) {
  const auto animation = std::make_shared<const pelage::SkeletonAnimation>(std::move(loaded));
  sample::BoneMotion motion;
  motion.name = path.string();
  motion.seconds = animation->seconds;
  pelage::Skeleton skeleton = pelage::skeletonOf(*animation);
  for (const pelage::Bone& bone : skeleton.bones) motion.bones.push_back(bone.name);
  motion.pose = [animation, skeleton = std::move(skeleton), scale](double seconds) {
    auto bones = pelage::skinningTransforms(skeleton, pelage::poseAt(*animation, seconds));
    for (pelage::AffineTransform& bone : bones)
      for (pelage::Float4& row : bone.rows) row.w *= scale;
    return bones;
  };
  return motion;
}

Result<void> addMotion(const std::filesystem::path& path, const std::string& clip,
                       LoadedFiles& files) {
  if (!hasClips(path) || files.motion) return {};
  auto animation = pelage::loadAnimation(path, clip);
  if (!animation && !clip.empty()) return animation.error();
  if (animation)
    files.motion = motionOf(path, *std::move(animation), files.scale);
  else
    files.remarks.push_back(animation.error().message + "; the head's own motion is played");
  return {};
}

}  // namespace

bool isCharacterFile(std::string_view extension) {
  constexpr std::string_view kKnown[] = {".gltf", ".glb", ".obj"};
  return std::find(std::begin(kKnown), std::end(kKnown), extension) != std::end(kKnown);
}

Result<void> addCharacterFile(const std::filesystem::path& path, const std::string& clip,
                              LoadedFiles& files) {
  auto hair = loadCurveFile(path, files.scale, files.remarks);
  auto mesh = pelage::loadSkinnedMesh(path);
  if (!hair && !mesh) return hair.error();
  if (!hair) files.remarks.push_back("no hair: " + hair.error().message);
  if (hair) files.assets.hairs.push_back(*std::move(hair));
  if (!mesh) return {};
  if (Result<void> done = prepareMesh(*mesh, {.scale = files.scale}); !done)
    return Error{done.error().code, path.string() + ": " + done.error().message};
  if (Result<void> done = addColliders(path, *mesh, files); !done) return done;
  if (Result<void> done = bindHair(path, *mesh, files); !done) return done;
  return addMotion(path, clip, files);
}

#else

bool isCharacterFile(std::string_view) { return false; }
Result<void> addCharacterFile(const std::filesystem::path& path, const std::string&, LoadedFiles&) {
  return Error{ErrorCode::kUnsupported,
               path.string() + ": this viewer was built without PELAGE_AUTHORING"};
}

#endif

}  // namespace viewer
