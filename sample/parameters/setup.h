// One small picture: what hair there is, how it is held, simulated, lit and drawn. A picture of a
// parameter is a setup in which that parameter was changed.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "pelage/collider.h"
#include "pelage/demo/groom.h"
#include "pelage/hair_asset.h"
#include "pelage/hair_object.h"
#include "pelage/headless.h"
#include "pelage/result.h"
#include "pelage/sdf_collider.h"
#include "pelage/skeleton.h"
#include "pelage/transparency.h"
#include "pelage/view.h"

namespace sample {

/// The subject of the picture.
enum class Subject : uint8_t {
  kLock,    ///< a lock of hair on a small ball
  kSwatch,  ///< hair laid over a roll
  kHead,    ///< the generated head and its groom
  kSleeve,  ///< fur around a tube whose right half turns
};

/// A lock of hair on the surface of a ball around the origin.
struct LockDef {
  pelage::Float3 direction = {1, 0, 0};  ///< from the ball's centre to the lock's middle
  uint32_t guides = 40;
  uint32_t vertices = 24;
  float length = 0.18f;      ///< [m]
  float variation = 0.1f;    ///< strands are this share shorter at most
  float fan = 0.12f;         ///< how much hair goes where the ball's surface faces, 0..1
  float curlRadius = 0;      ///< [m]
  float curlFrequency = 35;  ///< turns a metre
  float ballRadius = 0.03f;  ///< [m]
};

struct Setup {
  Subject subject = Subject::kLock;
  LockDef lock;
  uint32_t swatchGuides = 700;
  bool hasRoll = true;     ///< kSwatch: something is under the hair
  pelage::GroomDef groom;  ///< of kHead
  pelage::ProcessDef process;
  pelage::FollowDef follow;
  pelage::HairDef hair;       ///< without its arrays and counts
  float strandStiffness = 1;  ///< StrandFactors::stiffness of every second guide, and the next two
  float strandGlobalStiffness = 1;
  float strandDamping = 1;
  uint32_t textureSize = 0;  ///< texels an edge of HairDef::baseTexture; 0 for none

  float simulatedShare = 1, drawnShare = 1;
  float drawnStrands = 1;  ///< share of the strands
  bool usesMeshColliders = true;

  /// Where bone 0 is after some seconds; of a head, how it is turned.
  std::function<pelage::AffineTransform(double seconds)> motion;
  std::vector<pelage::CapsuleCollider> capsules;  ///< what hair collides with
  bool hasField = false;  ///< a collider with a distance field: the first capsule, or the head
  pelage::SdfColliderDef collider;
  float margin = 0.001f, friction = 0.3f;
  bool drawsField = false;  ///< in place of the mesh
  pelage::ColliderLook colliderLook;

  uint32_t frames = 1;
  float frameSeconds = 1.0f / 60;

  std::vector<pelage::Light> lights;
  pelage::TransparencySettings transparency;
  uint32_t samples = 1;
  pelage::Float3 center;     ///< in the middle of the picture [m]
  pelage::Float3 toEye;      ///< any length > 0
  float extent = 0.27f;      ///< of the picture at `center` [m]
  uint32_t supersample = 2;  ///< renders so many times larger and averages
};

/// A lock that stands out to the right and hangs as it will.
Setup lockSetup();
/// Hair over a roll, lit from above, that does not move.
Setup swatchSetup();
/// A few hairs of the swatch from near by.
Setup closeSetup();
/// A head with a groom that does not move.
Setup headSetup();
/// A lock that lies on a lying capsule.
Setup capsuleSetup();
/// The same with the capsule's distance field.
Setup fieldSetup();
/// Fur around a tube that twists.
Setup sleeveSetup();

/// The picture of a setup, size x size pixels, by a device of its own: nothing of another picture
/// is in it.
pelage::Result<pelage::RenderedImage> render(const pelage::HeadlessDef& def, const Setup& setup,
                                             uint32_t size);

}  // namespace sample
