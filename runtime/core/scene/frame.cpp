#include "pelage/frame.h"

#include <deque>
#include <string>
#include <utility>

#include "pelage/assert.h"
#include "pelage/list_check.h"
#include "pelage/scene.h"
#include "scene/scene_parts.h"

namespace pelage {

namespace {

constexpr size_t kSpareLists = 8;

// A list of no frame, for callers whose handler of assertions returns.
PassList& strayList() {
  thread_local PassList stray;
  stray.clear();
  return stray;
}

}  // namespace

struct Frame::Impl {
  struct Item {
    std::unique_ptr<PassList> list;
    uint32_t view = FrameStep::kNoView;
    uint32_t listOfView = 0;
  };
  std::weak_ptr<detail::SceneParts> scene;
  uint64_t frame = 0;  // HairStore::frame
  std::deque<Item> items;
  std::vector<FrameStep> steps;
  size_t simulation = 0;  // index of its list
  uint32_t views = 0;
  bool drawn = false;  // something reads where strands are drawn
  bool interpolated = false;
  bool finished = false;

  // One whose memory an earlier frame has had.
  std::unique_ptr<PassList> makeList() const {
    const std::shared_ptr<detail::SceneParts> open = scene.lock();
    if (open == nullptr) return std::make_unique<PassList>();
    std::vector<std::unique_ptr<PassList>>& spare = open->drawing.spareLists;
    spare.reserve(kSpareLists);  // so that frames may end where there is no memory
    if (spare.empty()) return std::make_unique<PassList>();
    std::unique_ptr<PassList> list = std::move(spare.back());
    spare.pop_back();
    return list;
  }
  ~Impl() {
    const std::shared_ptr<detail::SceneParts> open = scene.lock();
    if (open == nullptr) return;
    std::vector<std::unique_ptr<PassList>>& spare = open->drawing.spareLists;
    for (Item& item : items) {
      if (spare.size() == kSpareLists) break;
      if (item.list == nullptr) continue;
      item.list->clear();
      spare.push_back(std::move(item.list));
    }
  }
};

Frame::Frame() : impl_(std::make_unique<Impl>()) {}
Frame::Frame(Frame&& other) noexcept = default;
Frame& Frame::operator=(Frame&& other) noexcept = default;
Frame::~Frame() = default;

// The scene, where it has this frame still.
Result<detail::SceneParts*> Frame::open(const char* call) const {
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, "Frame::" + std::string(call) + ": " + what};
  };
  if (impl_ == nullptr) return refuse("the frame was moved away");
  const std::shared_ptr<detail::SceneParts> scene = impl_->scene.lock();
  if (scene == nullptr) return refuse("the scene of the frame is gone");
  if (scene->store.frame != impl_->frame) {
    return refuse(
        "simulate() has begun another frame of the scene: draw a frame and give it to the runtime "
        "before the next simulate()");
  }
  return scene.get();
}

Result<detail::SceneParts*> Frame::openForMore(const char* call) const {
  Result<detail::SceneParts*> scene = open(call);
  if (scene && impl_->finished) {
    return Error{ErrorCode::kInvalidArgument,
                 "Frame::" + std::string(call) +
                     ": the frame is finished: draw all views before finish(), and before a "
                     "runtime takes it"};
  }
  return scene;
}

Result<void> Frame::interpolate(float share) {
  const Result<detail::SceneParts*> scene = openForMore("interpolate()");
  if (!scene) return scene.error();
  if (impl_->drawn || impl_->interpolated) {
    return Error{ErrorCode::kInvalidArgument,
                 std::string("Frame::interpolate(): the frame is ") +
                     (impl_->drawn ? "drawn" : "interpolated") +
                     " already: call it once, before draw(), drawDepth() and castShadows()"};
  }
  Result<void> placed =
      (*scene)->simulation.interpolate(share, *impl_->items[impl_->simulation].list);
  impl_->interpolated = placed.ok();
  return placed;
}

Result<uint32_t> Frame::draw(const View& view, std::span<const Light> lights,
                             const TransparencySettings& settings, PassList before) {
  const Result<detail::SceneParts*> scene = openForMore("draw()");
  if (!scene) return scene.error();
  std::vector<PassList> lists;
  lists.push_back(std::move(before));
  if (Result<void> drawn = (*scene)->drawing.draw(view, lights, settings, lists); !drawn)
    return drawn.error();
  impl_->drawn = true;
  for (uint32_t i = 0; i < lists.size(); ++i) {
    Impl::Item& item = impl_->items.emplace_back();
    item.list = std::make_unique<PassList>(std::move(lists[i]));
    item.view = impl_->views;
    item.listOfView = i;
  }
  return impl_->views++;
}

Result<uint32_t> Frame::drawDepth(const View& view, const HairDepthSettings& settings,
                                  PassList before) {
  const Result<detail::SceneParts*> scene = openForMore("drawDepth()");
  if (!scene) return scene.error();
  if (Result<void> drawn = (*scene)->drawing.drawDepth(view, settings, before); !drawn)
    return drawn.error();
  impl_->drawn = true;
  return addView(std::move(before));
}

Result<uint32_t> Frame::addView(PassList list) {
  if (const Result<detail::SceneParts*> scene = openForMore("addView()"); !scene)
    return scene.error();
  Impl::Item& item = impl_->items.emplace_back();
  item.list = std::make_unique<PassList>(std::move(list));
  item.view = impl_->views;
  return impl_->views++;
}

Result<uint32_t> Frame::castShadows(std::span<const Light> lights) {
  const Result<detail::SceneParts*> scene = openForMore("castShadows()");
  if (!scene) return scene.error();
  std::unique_ptr<PassList> list = impl_->makeList();
  Result<uint32_t> cast = (*scene)->drawing.castShadows(lights, *list);
  if (!cast) return cast;
  impl_->drawn = true;
  impl_->items.emplace_back().list = std::move(list);
  return cast;
}

PassList& Frame::addList() {
  PELAGE_ASSERT(impl_ != nullptr, "Frame::addList(): the frame was moved away");
  if (impl_ == nullptr) return strayList();
  PELAGE_ASSERT(!impl_->finished, "Frame::addList(): add lists before finish()");
  std::unique_ptr<PassList>& list = impl_->items.emplace_back().list;
  list = impl_->makeList();
  return *list;
}

PassList& Frame::addListBefore() {
  PELAGE_ASSERT(impl_ != nullptr, "Frame::addListBefore(): the frame was moved away");
  if (impl_ == nullptr) return strayList();
  PELAGE_ASSERT(!impl_->finished, "Frame::addListBefore(): add lists before finish()");
  const auto at = impl_->items.begin() + static_cast<ptrdiff_t>(impl_->simulation++);
  std::unique_ptr<PassList>& list = impl_->items.emplace(at)->list;
  list = impl_->makeList();
  return *list;
}

Result<void> Frame::finish() {
  const Result<detail::SceneParts*> scene = open("finish()");
  if (!scene) return scene.error();
  if (impl_->finished) return {};
  for (const Impl::Item& item : impl_->items) {
    if (item.view != FrameStep::kNoView) continue;
    for (const Pass& pass : item.list->passes) {
      if (!isDraw(pass.kind)) continue;
      return Error{ErrorCode::kInvalidArgument,
                   "Frame::finish(): a list of addList() has the draw '" + std::string(pass.name) +
                       "'; draws belong to a view: give the list to draw() or addView()"};
    }
  }
  impl_->finished = true;
  for (const Impl::Item& item : impl_->items) {
    (*scene)->journal.finish(*item.list);
    impl_->steps.push_back({item.list.get(), item.view, item.listOfView});
  }
  return {};
}

Result<void> Frame::checkAreas(std::span<const PixelArea> areas) const {
  for (const FrameStep& step : steps()) {
    if (step.view == FrameStep::kNoView || step.view >= areas.size()) continue;
    if (Result<void> fits = checkArea(*step.list, areas[step.view]); !fits) {
      return Error{fits.error().code,
                   "view " + std::to_string(step.view) + ": " + fits.error().message};
    }
  }
  return {};
}

std::span<const FrameStep> Frame::steps() const {
  return impl_ != nullptr ? std::span<const FrameStep>(impl_->steps) : std::span<const FrameStep>();
}

uint32_t Frame::viewCount() const { return impl_ != nullptr ? impl_->views : 0; }

Result<void> Frame::run(const FrameExecutor& executor) {
  const std::pair<const char*, bool> functions[] = {{"update", executor.update != nullptr},
                                                    {"record", executor.record != nullptr},
                                                    {"draw", executor.draw || viewCount() == 0}};
  for (const auto& [name, isThere] : functions)
    if (!isThere)
      return Error{ErrorCode::kInvalidArgument, std::string("Frame::run(): FrameExecutor::") +
                                                    name + " is empty: give a function"};
  if (Result<void> done = finish(); !done) return done;
  const Result<detail::SceneParts*> scene = open("run()");
  if (!scene) return scene.error();
  if (Result<void> done = executor.update((*scene)->store.resources); !done) return done;
  for (const FrameStep& step : impl_->steps) {
    if (Result<void> done = executor.record(step); !done) return done;
    if (step.view == FrameStep::kNoView) continue;
    const bool draws = !step.list->passes.empty() && isDraw(step.list->passes.back().kind);
    if (!draws && step.listOfView > 0) continue;
    if (Result<void> done = executor.draw(step); !done) return done;
  }
  return {};
}

// The simulation is the first list of a frame.
Result<Frame> Scene::simulate(float dt) {
  Frame frame;
  frame.impl_->scene = parts_;
  std::unique_ptr<PassList> list = frame.impl_->makeList();
  if (Result<void> done = simulate(dt, *list); !done) return done.error();
  frame.impl_->frame = parts_->store.frame;
  frame.impl_->items.emplace_back().list = std::move(list);
  return frame;
}

}  // namespace pelage
