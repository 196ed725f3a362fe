#include "modeling_files.h"

#include <algorithm>
#include <initializer_list>
#include <memory>
#include <utility>

#include "asset_files.h"
#include "names.h"

#ifdef PELAGE_STUDIO_AUTHORING
#include "pelage/authoring/animation.h"
#include "pelage/authoring/collision_from_mesh.h"
#include "pelage/authoring/hair_curves.h"
#include "pelage/authoring/hair_files.h"
#include "pelage/authoring/skin_binding.h"
#include "pelage/authoring/skinned_mesh.h"
#endif

namespace sample {

using Path = std::filesystem::path;

#ifdef PELAGE_STUDIO_AUTHORING

namespace {

bool isOneOf(std::initializer_list<std::string_view> known, std::string_view extension) {
  return std::find(known.begin(), known.end(), extension) != known.end();
}

// Whether files of this kind may have meshes beside curves.
bool isCharacterFile(const Path& path) {
  return isOneOf({".gltf", ".glb", ".obj"}, pelage::program::lowerExtension(path));
}

bool hasClips(const Path& path) { return pelage::program::lowerExtension(path) != ".obj"; }

Error errorIn(const Path& path, const Error& error) {
  return {error.code, path.string() + ": " + error.message};
}

Result<void> addColliders(const Path& path, const pelage::SkinnedMesh& mesh, FileAssets& files) {
  auto made = pelage::collisionMeshes(mesh);
  if (!made) return errorIn(path, made.error());
  for (pelage::NamedCollisionMesh& named : *made) {
    if (Result<void> done = prepareCollider(named.mesh); !done) return errorIn(path, done.error());
    files.assets.meshes.push_back({path.stem().string(), std::move(named.mesh)});
  }
  return {};
}

// Binds hair of other files, which has no bones, to the mesh.
Result<void> bindHair(const Path& path, const pelage::SkinnedMesh& mesh, FileAssets& files,
                      std::vector<std::string>& remarks) {
  for (pelage::CachedHair& hair : files.assets.hairs) {
    if (hair.bones) continue;
    auto bound = pelage::bindRoots(pelage::rootsOf(hair.asset), mesh);
    if (!bound) return errorIn(path, bound.error());
    if (!bound->report.farStrands.empty())
      remarks.push_back(path.string() + ": " + std::to_string(bound->report.farStrands.size()) +
                        " roots of '" + hair.name + "' are further than 5 mm from the mesh");
    hair.bones = std::move(bound->weights);
  }
  return {};
}

Result<pelage::CachedHair> loadCurves(const Path& path, const ModelingDef& def,
                                      std::vector<std::string>& remarks) {
  pelage::HairFileReport file;
  auto curves = pelage::loadHairCurves(path, &file);
  if (!curves) return curves.error();
  for (const std::string& note : file.notes) remarks.push_back(path.string() + ": " + note);
  pelage::CurveImportReport imported;
  if (auto done = pelage::prepareCurves(*curves, {.scale = def.scale}, &imported); !done)
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

Result<void> addMotion(const Path& path, const ModelingDef& def, FileAssets& files,
                       std::vector<std::string>& remarks) {
  if (!hasClips(path) || files.motion) return {};
  auto motion = loadMotion(path, def);
  if (!motion && !def.clip.empty()) return motion.error();
  if (motion)
    files.motion = *std::move(motion);
  else
    remarks.push_back(motion.error().message + "; the head's own motion is played");
  return {};
}

Result<void> addCharacter(const Path& path, const ModelingDef& def, FileAssets& files,
                          std::vector<std::string>& remarks) {
  auto hair = loadCurves(path, def, remarks);
  auto mesh = pelage::loadSkinnedMesh(path);
  if (!hair && !mesh) return hair.error();
  if (!hair) remarks.push_back("no hair: " + hair.error().message);
  if (hair) files.assets.hairs.push_back(*std::move(hair));
  if (!mesh) return {};
  if (Result<void> done = prepareMesh(*mesh, {.scale = def.scale}); !done)
    return errorIn(path, done.error());
  if (Result<void> done = addColliders(path, *mesh, files); !done) return done;
  if (Result<void> done = bindHair(path, *mesh, files, remarks); !done) return done;
  return addMotion(path, def, files, remarks);
}

}  // namespace

bool isModelingFile(std::string_view extension) {
  return isOneOf({".hair", ".obj", ".gltf", ".glb", ".hairtxt", ".usda", ".usd", ".usdc", ".usdz"},
                 extension);
}

const char* modelingExtensions() { return ", .hair, .obj, .gltf, .glb, .hairtxt and .usda"; }

Result<void> addModelingFiles(std::span<const Path> paths, const ModelingDef& def,
                              FileAssets& files, std::vector<std::string>& remarks) {
  for (const Path& path : paths) {
    if (isCharacterFile(path)) continue;
    auto hair = loadCurves(path, def, remarks);
    if (!hair) return hair.error();
    files.assets.hairs.push_back(*std::move(hair));
  }
  for (const Path& path : paths)
    if (isCharacterFile(path))
      if (Result<void> done = addCharacter(path, def, files, remarks); !done) return done;
  return {};
}

Result<BoneMotion> loadMotion(const Path& path, const ModelingDef& def) {
  auto loaded = pelage::loadAnimation(path, def.clip);
  if (!loaded) return loaded.error();
  const auto animation = std::make_shared<const pelage::SkeletonAnimation>(*std::move(loaded));
  BoneMotion motion;
  motion.name = path.string();
  motion.seconds = animation->seconds;
  pelage::Skeleton skeleton = pelage::skeletonOf(*animation);
  for (const pelage::Bone& bone : skeleton.bones) motion.bones.push_back(bone.name);
  motion.pose = [animation, skeleton = std::move(skeleton), scale = def.scale](double seconds) {
    auto bones = pelage::skinningTransforms(skeleton, pelage::poseAt(*animation, seconds));
    for (pelage::AffineTransform& bone : bones)
      for (pelage::Float4& row : bone.rows) row.w *= scale;
    return bones;
  };
  return motion;
}

#else

namespace {

Error withoutAuthoring(const Path& path) {
  return {ErrorCode::kUnsupported,
          path.string() +
              ": this program was built without files of modeling programs: configure "
              "with -DPELAGE_AUTHORING=ON"};
}

}  // namespace

bool isModelingFile(std::string_view) { return false; }
const char* modelingExtensions() { return ""; }
Result<void> addModelingFiles(std::span<const Path> paths, const ModelingDef&, FileAssets&,
                              std::vector<std::string>&) {
  if (paths.empty()) return {};
  return withoutAuthoring(paths.front());
}
Result<BoneMotion> loadMotion(const Path& path, const ModelingDef&) {
  return withoutAuthoring(path);
}

#endif

}  // namespace sample
