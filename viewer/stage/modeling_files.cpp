// The files of modeling programs that stage/files.h declares.
#include <algorithm>
#include <initializer_list>
#include <memory>
#include <utility>

#include "stage/files.h"

#ifdef PELAGE_VIEWER_AUTHORING
#include "pelage/authoring/animation.h"
#include "pelage/authoring/collision_from_mesh.h"
#include "pelage/authoring/curve_import.h"
#include "pelage/authoring/hair_files.h"
#include "pelage/authoring/resample.h"
#include "pelage/authoring/skin_binding.h"
#include "pelage/authoring/skinned_mesh.h"
#endif

namespace viewer {

using pelage::Error;
using pelage::ErrorCode;
using pelage::Result;

#ifdef PELAGE_VIEWER_AUTHORING

namespace {

bool isOneOf(std::initializer_list<std::string_view> known, std::string_view extension) {
  return std::find(known.begin(), known.end(), extension) != known.end();
}

Error errorIn(const std::filesystem::path& path, const Error& error) {
  return {error.code, path.string() + ": " + error.message};
}

// Whether files of this kind have clips.
bool hasClips(const std::filesystem::path& path) {
  return path.extension() == ".gltf" || path.extension() == ".glb";
}

Result<void> addColliders(const std::filesystem::path& path, const pelage::SkinnedMesh& mesh,
                          LoadedFiles& files) {
  auto made = pelage::collisionMeshes(mesh);
  if (!made) return errorIn(path, made.error());
  for (pelage::NamedCollisionMesh& named : *made) {
    if (Result<void> done = prepareCollider(named.mesh); !done) return errorIn(path, done.error());
    files.assets.meshes.push_back({path.stem().string(), std::move(named.mesh)});
  }
  return {};
}

// Binds hair of other files, which has no bones, to the mesh.
Result<void> bindHair(const std::filesystem::path& path, const pelage::SkinnedMesh& mesh,
                      LoadedFiles& files) {
  for (pelage::CachedHair& hair : files.assets.hairs) {
    if (hair.bones) continue;
    auto bound = pelage::bindRoots(pelage::rootsOf(hair.asset), mesh);
    if (!bound) return errorIn(path, bound.error());
    if (!bound->report.farStrands.empty())
      files.remarks.push_back(path.string() + ": " +
                              std::to_string(bound->report.farStrands.size()) + " roots of '" +
                              hair.name + "' are further than 5 mm from the mesh");
    hair.bones = std::move(bound->weights);
  }
  return {};
}

// Returns the motion of a file's bones, scaled to meters.
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

bool isCurveFile(std::string_view extension) {
  return isOneOf({".hair", ".obj", ".gltf", ".glb", ".hairtxt"}, extension);
}

const char* curveExtensions() { return ", .hair, .obj, .gltf, .glb and .hairtxt"; }

Result<pelage::CachedHair> loadCurveFile(const std::filesystem::path& path, float scale,
                                         std::vector<std::string>& remarks) {
  pelage::HairFileReport file;
  auto curves = pelage::loadHairCurves(path, &file);
  if (!curves) return curves.error();
  for (const std::string& note : file.notes) remarks.push_back(path.string() + ": " + note);
  pelage::CurveImportReport imported;
  if (auto done = pelage::prepareCurves(*curves, {.scale = scale}, &imported); !done)
    return errorIn(path, done.error());
  if (imported.curvesDropped() > 0)
    remarks.push_back(path.string() + ": " + std::to_string(imported.curvesDropped()) +
                      " curves were dropped: too few vertices, or no length");
  auto resampled = pelage::resampleCurves(*curves);
  if (!resampled) return errorIn(path, resampled.error());
  pelage::CachedHair hair;
  hair.name = path.stem().string();
  hair.asset = std::move(resampled->asset);
  if (auto done = hair.asset.process(); !done) return errorIn(path, done.error());
  return hair;
}

bool isCharacterFile(std::string_view extension) {
  return isOneOf({".gltf", ".glb", ".obj"}, extension);
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
    return errorIn(path, done.error());
  if (Result<void> done = addColliders(path, *mesh, files); !done) return done;
  if (Result<void> done = bindHair(path, *mesh, files); !done) return done;
  return addMotion(path, clip, files);
}

#else

namespace {

Error withoutAuthoring(const std::filesystem::path& path) {
  return {ErrorCode::kUnsupported,
          path.string() + ": this viewer was built without PELAGE_AUTHORING"};
}

}  // namespace

bool isCurveFile(std::string_view) { return false; }
const char* curveExtensions() { return ""; }
Result<pelage::CachedHair> loadCurveFile(const std::filesystem::path& path, float,
                                         std::vector<std::string>&) {
  return withoutAuthoring(path);
}
bool isCharacterFile(std::string_view) { return false; }
Result<void> addCharacterFile(const std::filesystem::path& path, const std::string&, LoadedFiles&) {
  return withoutAuthoring(path);
}

#endif

}  // namespace viewer
