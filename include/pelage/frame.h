// One frame of a scene: what moves the hair, what draws it, and the order in which that runs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "pelage/export.h"
#include "pelage/hair_depth.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"
#include "pelage/transparency.h"
#include "pelage/view.h"

namespace pelage {

namespace detail {
struct FrameState;
struct SceneParts;
}  // namespace detail

/// A list of a frame, as a runtime runs it.
struct FrameStep {
  static constexpr uint32_t kNoView = ~0u;
  const PassList* list = nullptr;
  uint32_t view = kNoView;  ///< number of the view that its draws belong to
  uint32_t listOfView = 0;  ///< 0 for the first one of the view: clear the target before it
};

/// How an executor of your own runs a frame: see Frame::run().
struct FrameExecutor {
  /// Creates the buffers of the table that are new, and frees those that are gone.
  std::function<Result<void>(const ResourceTable&)> update;
  /// Uploads and dispatches of a list, outside of a render pass.
  std::function<Result<void>(const FrameStep&)> record;
  /// Draws of a list of a view, in a render pass. It is called for the first list of each view,
  /// and for others that have draws.
  std::function<Result<void>(const FrameStep&)> draw;
};

/// A frame of a scene. Scene::simulate() makes it, so that nothing is drawn before it has moved;
/// then come any number of views, and lists of your own; and a runtime takes it:
///
///     auto frame = scene.simulate(seconds);
///     if (frame) view = frame->draw(camera, lights, settings);
///     if (view) images = device.render(*frame, targets);  // or run() of a frame without views
///
/// Calls in another order are refused with a message that says the right one: a view behind
/// finish(), and every call once the scene has another frame or is gone. A frame that is destroyed
/// without having run counts as lost: the next one has all that it had (docs/scene.md, Frames that
/// do not run).
///
/// Threads: the one that uses its scene, also while a runtime records it.
class PELAGE_API Frame {
 public:
  Frame(Frame&& other) noexcept;
  Frame& operator=(Frame&& other) noexcept;
  ~Frame();

  /// Draws the frame between two states of the simulation, for engines that simulate in fixed
  /// steps: objects with HairObject::interpolates are drawn where they are a share of the way from
  /// the state before the last simulation with dt > 0 to the state after it. Vertices move on
  /// straight lines, roots of computed follow hairs rotate evenly. Without the call the frame draws
  /// the last state, and its motion vectors are those of the camera for these objects. After a
  /// reset both states are the new one; Scene::teleport() takes both along.
  ///
  ///     while (accumulator >= kStep) { ...; run(*scene.simulate(kStep)); accumulator -= kStep; }
  ///     auto frame = scene.simulate(0);
  ///     if (frame) placed = frame->interpolate(accumulator / kStep);  // then draw()
  ///
  /// \param share 0..1: 0 is the state before, to the bit, and 1 the last one.
  /// Errors: a share out of range; a frame that is drawn or interpolated already, finished or over.
  /// Cost: with the first call three buffers an object, then a pass or two each.
  Result<void> interpolate(float share);
  /// Draws a view, into buffers of its own, in whatever size and method: the pixels do not depend
  /// on the other views. A light that several views see has one shadow map.
  /// \param before  passes and draws of yours that come first in the view: what is opaque, or
  ///   Scene::drawCollider() and drawContacts().
  /// \return number of the view: 0, 1, ...
  /// Errors: those of Scene::draw(); a frame that is finished or over.
  Result<uint32_t> draw(const View& view, std::span<const Light> lights,
                        const TransparencySettings& settings = {}, PassList before = {});
  /// Draws depth of hair, and motion where the settings ask for it, into targets of their own: a
  /// view beside those of draw(), of the same camera and any method. Its target has a depth target;
  /// with the depth of opaque objects in it, these hide hair. It adds nothing to other views.
  /// \param before  passes and draws of yours that come first in the view.
  /// \return number of the view. Errors: those of Scene::drawDepth(); a frame that is finished or
  /// over.
  Result<uint32_t> drawDepth(const View& view, const HairDepthSettings& settings = {},
                             PassList before = {});
  /// Adds a view that your own passes draw, without any of the library's: with shaders of yours.
  /// \return number of the view. Errors: a frame that is finished or over.
  Result<uint32_t> addView(PassList list);
  /// Fills the shadow maps of these lights in a list of its own, for shaders of yours.
  /// \return number of maps. Errors: those of Scene::castShadows(); a frame that is finished or
  /// over.
  Result<uint32_t> castShadows(std::span<const Light> lights);
  /// An empty list for dispatches of your own behind all that the frame has so far. Fill it before
  /// finish(); it stays where it is as long as the frame does. Asserts that the frame is not
  /// finished.
  PassList& addList();
  /// The same before the simulation: for passes that write forces or vertices.
  PassList& addListBefore();

  /// Writes the barriers of all lists; runtimes call it. Nothing can be added any more. Errors: the
  /// frame is over; a list of your own has draws, which belong to a view.
  Result<void> finish();
  /// Checks that each view is drawn where it was written for, which finish() comes before; runtimes
  /// call it before they record anything. \param areas  [view] the viewport that it gets. Errors:
  /// another rectangle than the View's; the message has both.
  Result<void> checkAreas(std::span<const PixelArea> areas) const;
  /// The steps to run, in this order, after an update() to resources(). Empty before finish().
  std::span<const FrameStep> steps() const;
  /// Runs the frame: finish(), update(), then record() and draw() of each list.
  /// Errors: a function of the executor is empty (draw may be, without views); those of finish()
  /// and of the executor, which end the run.
  Result<void> run(const FrameExecutor& executor);
  uint32_t viewCount() const;

 private:
  friend class Scene;
  explicit Frame(const std::shared_ptr<detail::SceneParts>& scene);
  Result<detail::SceneParts*> open(const char* call) const;
  Result<detail::SceneParts*> openForMore(const char* call) const;
  std::unique_ptr<detail::FrameState> state_;
};

}  // namespace pelage
