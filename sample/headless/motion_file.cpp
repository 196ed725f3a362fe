#include "motion_file.h"

#include <memory>
#include <utility>

#ifdef PELAGE_SAMPLE_AUTHORING
#include "pelage/authoring/animation.h"
#endif

namespace sample {

using pelage::Error;
using pelage::ErrorCode;
using pelage::Result;

#ifdef PELAGE_SAMPLE_AUTHORING

Result<BoneMotion> loadMotion(const std::filesystem::path& path, const std::string& clip) {
  auto loaded = pelage::loadAnimation(path, clip);
  if (!loaded) return loaded.error();
  const auto animation = std::make_shared<const pelage::SkeletonAnimation>(*std::move(loaded));
  BoneMotion motion;
  motion.name = path.string();
  motion.seconds = animation->seconds;
  pelage::Skeleton skeleton = pelage::skeletonOf(*animation);
  for (const pelage::Bone& bone : skeleton.bones) motion.bones.push_back(bone.name);
  motion.pose = [animation, skeleton = std::move(skeleton)](double seconds) {
    return pelage::skinningTransforms(skeleton, pelage::poseAt(*animation, seconds));
  };
  return motion;
}

#else

Result<BoneMotion> loadMotion(const std::filesystem::path& path, const std::string&) {
  return Error{ErrorCode::kUnsupported,
               path.string() +
                   ": this program was built without animations: configure with "
                   "-DPELAGE_AUTHORING=ON"};
}

#endif

}  // namespace sample
