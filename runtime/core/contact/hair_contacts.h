// The contact room: finds where the vertices of a hair object touch colliders, and keeps the
// records that solvers read.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/local_origin.h"
#include "pelage/gpu_structs.h"
#include "pelage/hair_object.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/view.h"

namespace pelage::detail {

/// What an object may collide with in a frame, relative to an origin.
struct ColliderBuffers {
  BufferId capsules = BufferId::kInvalid;  ///< [capsuleCount] Collider
  uint32_t capsuleCount = 0;
  BufferId fields = BufferId::kInvalid;  ///< [fieldCount] SdfField
  uint32_t fieldCount = 0;
  BufferId fieldKeys = BufferId::kInvalid, fieldSurface = BufferId::kInvalid;
  bool any() const { return capsuleCount > 0 || fieldCount > 0; }
};

/// Tiles of 32 strands that are awake, as a list with arguments for an indirect dispatch.
struct AwakeTiles {
  BufferId buffer = BufferId::kInvalid;  ///< bound even where there is no list
  bool listed = false;
  uint32_t firstWord = 0;      ///< of the list
  uint64_t argumentBytes = 0;  ///< offset of the arguments
};

/// What moves the hair.
struct ContactHair {
  BufferId positions = BufferId::kInvalid;  ///< [vertex] Float4 in world space
  BufferId roots = BufferId::kInvalid;      ///< [2][root] RootTransform, relative to the origin
  uint32_t rootCount = 0;
  uint32_t strands = 0;  ///< that are simulated
  LocalOrigin origin;
};

/// The part of a frame for which contacts are found.
struct ContactStep {
  uint32_t index = 0;        ///< of the sub-step
  float begin = 0, end = 1;  ///< of the sub-step in the frame
  float length = 0;          ///< [s]
  Float3 gravity;            ///< acceleration that hair falls with [m/s2]
  float furtherReach = 0;    ///< beyond what the step needs [m]
  bool again = false;        ///< for the tiles that the solver has listed
};

/// Of one hair object.
class HairContacts {
 public:
  /// Makes the buffers for strands in the order in which the solver takes them. Those that were
  /// there have been removed.
  void prepare(ResourceTable& resources, const std::string& name,
               std::span<const ContactStrand> strands, uint32_t verticesPerStrand,
               uint64_t vertices, uint32_t steps);
  bool isPrepared(uint32_t steps) const {
    return records_ != BufferId::kInvalid && steps <= steps_;
  }
  /// Once a frame, before the first find().
  void begin(PassList& list);
  /// Adds the pass that finds contacts.
  Result<void> find(PassList& list, const ResourceTable& resources, const ContactHair& hair,
                    const ColliderBuffers& colliders, const AwakeTiles& awake,
                    const ContactStep& step);
  /// Once a list has moved the positions by a shift of the world.
  void shiftWorld(const Vector3<double>& shifted) { origin_.shifted = shifted; }
  /// Positions of the last sub-step that find() goes on from; kInvalid where it does not.
  BufferId before() const { return known_ ? before_ : BufferId::kInvalid; }
  uint64_t vertexCount() const { return vertices_; }
  /// After a frame without contacts: what was found is not gone on from.
  void forget() { known_ = false; }
  /// In a frame without begin(): its totals are 0.
  void clearTotals(PassList& list);
  /// The draw of the records that there are.
  /// \param positions of [vertex] Float4
  Result<void> addDraw(PassList& list, BufferId positions, const View& view,
                       const ContactLook& look) const;
  /// Scene::deepestContact().
  Result<float> deepest(std::span<const std::byte> records, std::span<const std::byte> words,
                        std::span<const std::byte> positions) const;
  /// All buffers, for their owner to remove.
  std::array<BufferId*, 4> buffers() { return {&strands_, &before_, &records_, &words_}; }

  BufferId records() const { return records_; }
  BufferId words() const { return words_; }
  uint64_t recordBytes() const { return vertices_ * kMaxContacts * sizeof(ContactRecord); }
  uint64_t wordBytes() const;
  uint32_t head(uint32_t step) const;
  uint32_t list() const { return head(steps_); }
  uint32_t masks() const { return list() + 2 * tiles_; }
  uint32_t maskWords() const { return maskWords_; }
  /// Groups in y of the pass over a list of tiles.
  uint32_t rows() const { return maskWords_ * 8; }
  /// Offset of the arguments of the solver's dispatch over the tiles that are solved again.
  uint64_t solveArguments(uint32_t step) const;

  static constexpr uint64_t kMaxContacts = 2;

 private:
  uint64_t beforeBytes() const { return (vertices_ + 2 * uint64_t{strandCount_}) * sizeof(Float4); }

  BufferId strands_ = BufferId::kInvalid, before_ = BufferId::kInvalid,
           records_ = BufferId::kInvalid, words_ = BufferId::kInvalid;
  uint32_t tiles_ = 0, maskWords_ = 1, strandCount_ = 0, steps_ = 0, verticesPerStrand_ = 0;
  uint64_t vertices_ = 0;
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
