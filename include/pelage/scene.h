// A scene: hair objects and the pass lists that move and draw them.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "pelage/hair_object.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/view.h"

namespace pelage {

struct ExactConstants;

/// A hair object of a scene.
enum class HairId : uint32_t { kInvalid = 0xffffffffu };

/// Holds hair objects and writes their pass lists. No graphics API: a runtime creates the buffers
/// of resources() and runs the lists, in the order in which they were made.
///
///     Scene scene;
///     auto hair = scene.addHair(asset, {.name = "groom"});
///     ...
///     scene.hair(*hair).setBones(bones);
///     scene.simulate(1.0f / 60, list);  // then the runtime runs the list
class Scene {
 public:
  /// Adds a hair object. Errors: an asset without strands, settings out of range, a follow hair of
  /// a guide that does not exist, bone weights of another groom.
  Result<HairId> addHair(const HairAsset& asset, const HairDef& def);
  /// Removes a hair object and its buffers.
  void removeHair(HairId id);
  /// Asserts that the object exists.
  HairObject& hair(HairId id);
  const HairObject& hair(HairId id) const;
  uint32_t hairCount() const;

  /// The buffers that a runtime is to create before it runs the next list. Add buffers of your own
  /// to use them in passes beside the scene's.
  ResourceTable& resources() { return resources_; }
  const ResourceTable& resources() const { return resources_; }

  /// Writes the passes that advance every hair object by dt.
  /// \param dt seconds, >= 0. 0 skips the simulation. Steps are at most 1/60 s: a longer dt is cut
  ///   into equal sub-steps, at most kMaxSubSteps of them; time beyond that is dropped. The exact
  ///   solver cuts each of them further into SimulationSettings::subSteps.
  /// \param list cleared first.
  /// Errors: dt or a setting is out of range; a share without HairDef::levelOfDetail; a buffer of
  /// setForces() that is too small; an object with too many strands for one dispatch. After one of
  /// the first three nothing has changed: bones and resets wait for the next frame.
  Result<void> simulate(float dt, PassList& list);
  /// Adds draws of all visible hair objects to a list (which is not cleared).
  Result<void> draw(const View& view, const Light& light, PassList& list);
  /// Computes the barriers of a list that is complete. Call it once for each list, in the order in
  /// which the lists run; lists of your own that touch the scene's buffers included.
  void finish(PassList& list) { hazards_.resolve(list); }

  /// Seconds simulated so far; the phase of the wind.
  double time() const { return time_; }

  static constexpr uint32_t kMaxSubSteps = 4;

 private:
  struct Frame;
  void addSolverBuffers(HairObject& object);
  void removeSolverBuffers(HairObject& object);
  void removeBuffer(BufferId& buffer);
  Result<void> checkObject(const HairObject& object) const;
  Result<void> simulateObject(HairObject& object, float length, uint32_t steps, PassList& list);
  Result<void> addRootPass(const Frame& frame);
  Result<void> addClassicPasses(const Frame& frame);
  Result<void> addExactPasses(Frame& frame);
  Result<void> addSleepPass(Frame& frame, ExactConstants constants);
  void setLevelOfDetail(const Frame& frame, ExactConstants& constants);
  Result<void> addInterpolationPass(const Frame& frame, const ExactConstants& constants,
                                    uint32_t strands);
  void bindExact(const Frame& frame, PassBuilder& builder) const;
  Result<void> addFollowPass(const Frame& frame);
  void addHairGrid(HairObject& object);
  void removeHairGrid(HairObject& object);
  Result<void> addHairGridPasses(HairObject& object, double h, bool reset, PassList& list);
  void finishHairGrid(HairObject& object, double frame);
  BufferId forcesOf(const HairObject& object) const;

  ResourceTable resources_;
  HazardTracker hazards_;
  std::vector<std::unique_ptr<HairObject>> objects_;
  double time_ = 0;
};

}  // namespace pelage
