// Contact: finds the contacts of a hair object's vertices with colliders, and keeps the records
// that solvers read.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/local_origin.h"
#include "passes/buffer_factory.h"
#include "passes/moved_elements.h"
#include "pelage/camera.h"
#include "pelage/collider.h"
#include "pelage/constants.h"
#include "pelage/gpu_structs.h"
#include "pelage/hair_buffers.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "skinning/hair_frame.h"

namespace pelage::detail {

/// The colliders of an object in a frame, relative to an origin.
struct ColliderBuffers {
  BufferId capsules = BufferId::kInvalid;  ///< [capsuleCount] Collider
  uint32_t capsuleCount = 0;
  /// [contactSdfCount] Sdf, then the capsules once more, so that a kernel binds both as one.
  BufferId sdfs = BufferId::kInvalid;
  uint32_t contactSdfCount = 0;
  bool hasDenseSdfs = false;  ///< some of them are an engine's
  bool hasMovingSdfs = false;
  BufferId contactSdfKeys = BufferId::kInvalid, contactSdfSurface = BufferId::kInvalid;
  bool any() const { return capsuleCount > 0 || contactSdfCount > 0; }
};

/// Tiles of 32 strands that are awake, as a list with arguments for an indirect dispatch.
struct AwakeTiles {
  BufferId buffer = BufferId::kInvalid;  ///< bound even if there is no list
  bool listed = false;
  uint32_t firstWord = 0;      ///< of the list
  uint64_t argumentBytes = 0;  ///< offset of the arguments
};

/// The state of the moving hair.
struct ContactHair {
  BufferId positions = BufferId::kInvalid;  ///< [vertex] Float4 in world space
  BufferRange roots;                        ///< [2][root] RootTransform, relative to the origin
  uint32_t rootCount = 0;
  uint32_t strands = 0;  ///< that are simulated
  LocalOrigin origin;
};

/// The part of a frame for which contacts are found.
struct ContactStep {
  uint32_t index = 0;        ///< of the sub-step
  float begin = 0, end = 1;  ///< of the sub-step in the frame
  float length = 0;          ///< [s]
  Float3 gravity;            ///< acceleration of falling hair [m/s2]
  float furtherRange = 0;    ///< additional range beyond that of the step [m]
  bool again = false;        ///< only for the strands that the solver has listed
  bool fast = false;         ///< colliders are fast
};

/// Sizes of the buffers of an object's contacts, and where in them its parts are.
struct ContactLayout {
  uint32_t strandCount = 0, steps = 0, verticesPerStrand = 0, stateStride = 0;
  uint32_t maskWords = 1;
  uint64_t vertices = 0;

  uint32_t tiles() const {
    return (strandCount + contact::kTileStrands - 1) / contact::kTileStrands;
  }
  /// Vertices that a group of find_contacts takes of a strand, its strands, and groups of a tile.
  uint32_t groupVertices() const;
  uint32_t groupStrands() const;
  uint32_t tileGroups() const;
  /// Groups in y of the pass over a list of tiles.
  uint32_t rows() const { return maskWords * tileGroups(); }

  uint64_t recordBytes() const {
    return vertices * contact_records::kMaxContacts * sizeof(ContactRecord);
  }
  /// Bytes of the records and what comes behind them.
  uint64_t recordBufferBytes() const;

  /// Offsets of words.
  uint32_t head(uint32_t step) const;
  uint32_t list() const { return head(steps); }
  uint32_t masks() const { return list() + strandCount; }
  uint32_t strands() const;
  uint64_t strandBytes() const { return strandCount * sizeof(ContactStrand); }
  uint64_t wordBytes() const { return strands() * sizeof(uint32_t) + strandBytes(); }
};

/// The contacts of one hair object.
class HairContacts {
 public:
  /// Creates the buffers. The caller has removed earlier ones.
  void prepare(ResourceTable& resources, const std::string& name, const ContactStrands& strands,
               uint32_t verticesPerStrand, uint64_t vertices, uint32_t steps);
  bool isPrepared(uint32_t steps) const {
    return records_ != BufferId::kInvalid && steps <= layout_.steps;
  }
  /// Call once per frame, before the first find().
  void begin(PassList& list);
  /// Adds the pass that finds contacts.
  Result<void> find(PassList& list, const ResourceTable& resources, const ContactHair& hair,
                    const ColliderBuffers& colliders, const AwakeTiles& awake,
                    const ContactStep& step);
  /// Call after a list has moved the positions by a shift of the world.
  void shiftWorld(const Vector3<double>& shifted) { origin_.shifted = shifted; }
  /// Call when moved() is relative to another origin from now on.
  void moveTo(const LocalOrigin& origin) { origin_ = origin; }
  /// Elements that a rigid motion of the object moves.
  std::vector<MovedElements> moved() const;
  /// Call after a frame without contacts: earlier contacts do not continue.
  void forget() { known_ = false; }
  /// Call in a frame without begin(): its totals are 0.
  void clearTotals(PassList& list);
  /// Adds the draw of the records.
  /// \param positions [vertex] Float4
  Result<void> addDraw(PassList& list, BufferId positions, const View& view,
                       const ContactLook& look) const;
  /// Scene::deepestContact().
  Result<float> deepest(std::span<const std::byte> records, std::span<const std::byte> words,
                        std::span<const std::byte> positions) const;
  /// Removes the buffers; prepare() makes them again.
  void remove(const BufferFactory& factory) {
    for (BufferId* buffer : {&records_, &words_}) factory.remove(*buffer);
  }

  BufferId records() const { return records_; }
  BufferId words() const { return words_; }
  const ContactLayout& layout() const { return layout_; }

 private:
  ContactConstants constantsOf(const ContactHair& hair, const ColliderBuffers& colliders,
                               const AwakeTiles& awake, const ContactStep& step) const;

  ContactLayout layout_;
  BufferId records_ = BufferId::kInvalid, words_ = BufferId::kInvalid;
  float lastLength_ = 0;  ///< of the last sub-step [s]
  bool known_ = false;    ///< the last sub-step was found for
  bool odd_ = false;      ///< in turn, from sub-step to sub-step
  bool counted_ = false;  ///< the last frame has totals
  /// [strand] element of vertex 0; shared, because a scene copies all of this for each frame.
  std::shared_ptr<const std::vector<uint32_t>> targets_;
  uint32_t foundStrands_ = 0;  ///< of the last find()
  LocalOrigin origin_;         ///< of the last find()
};

}  // namespace pelage::detail
