#include "pelage/frame.h"

#include <algorithm>
#include <string>
#include <utility>

#include "pelage/assert.h"
#include "pelage/list_check.h"
#include "pelage/scene.h"
#include "scene/scene_parts.h"

namespace pelage {

namespace {

// A frame that takes the place of another one in a variable is made before that is gone.
constexpr size_t kSpareFrames = 2;

// A list of no frame, for callers whose handler of assertions returns.
PassList& strayList() {
  thread_local PassList stray;
  stray.clear();
  return stray;
}

using Item = detail::FrameState::Item;

std::span<const Item> itemsOf(const detail::FrameState& state) {
  return std::span(state.items).first(state.used);
}

void dropLast(detail::FrameState& state) { state.items[--state.used].list->clear(); }

// Whether a caller's list has something, its memory included.
bool isGiven(const PassList& list) {
  return list.passes.capacity() > 0 || list.uploads.capacity() > 0 || list.frame != 0 ||
         list.samples != 0 || list.area != PixelArea{};
}

}  // namespace

Frame::Frame(const std::shared_ptr<detail::SceneParts>& scene) {
  auto& spare = scene->drawing.spareFrames;
  spare.reserve(kSpareFrames);  // so that frames may end where there is no memory
  if (spare.empty()) {
    state_ = std::make_unique<detail::FrameState>();
  } else {
    state_ = std::move(spare.back());
    spare.pop_back();
  }
  state_->scene = scene;
}

Frame::Frame(Frame&& other) noexcept = default;

Frame& Frame::operator=(Frame&& other) noexcept {
  const Frame before = std::move(*this);
  state_ = std::move(other.state_);
  return *this;
}

Frame::~Frame() {
  if (state_ == nullptr) return;
  const std::shared_ptr<detail::SceneParts> scene = state_->scene.lock();
  if (scene == nullptr || scene->drawing.spareFrames.size() == kSpareFrames) return;
  state_->clear();
  scene->drawing.spareFrames.push_back(std::move(state_));
}

// The scene, where it has this frame still.
Result<detail::SceneParts*> Frame::open(const char* call) const {
  const auto refuse = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidArgument, "Frame::" + std::string(call) + ": " + what};
  };
  if (state_ == nullptr) return refuse("the frame was moved away");
  const std::shared_ptr<detail::SceneParts> scene = state_->scene.lock();
  if (scene == nullptr) return refuse("the scene of the frame is gone");
  if (scene->store.frame != state_->frame) {
    return refuse(
        "simulate() has begun another frame of the scene: draw a frame and give it to the runtime "
        "before the next simulate()");
  }
  return scene.get();
}

Result<detail::SceneParts*> Frame::openForMore(const char* call) const {
  Result<detail::SceneParts*> scene = open(call);
  if (scene && state_->finished) {
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
  if (state_->drawsStrands || state_->interpolated) {
    return Error{ErrorCode::kInvalidArgument,
                 std::string("Frame::interpolate(): the frame is ") +
                     (state_->drawsStrands ? "drawn" : "interpolated") +
                     " already: call it once, before draw(), drawDepth() and castShadows()"};
  }
  Result<void> placed =
      (*scene)->simulation.interpolate(share, *state_->items[state_->simulation].list);
  state_->interpolated = placed.ok();
  return placed;
}

Result<uint32_t> Frame::draw(const View& view, std::span<const Light> lights,
                             const TransparencySettings& settings, PassList before) {
  const Result<detail::SceneParts*> scene = openForMore("draw()");
  if (!scene) return scene.error();
  detail::FrameState& own = *state_;
  // Into the memory of the view that had its number in an earlier frame.
  std::vector<PassList>& lists = own.drawn;
  lists.clear();
  for (size_t i = own.used; i < own.items.size() && own.items[i].view == own.views; ++i)
    lists.push_back(std::move(*own.items[i].list));
  if (lists.empty()) lists.emplace_back();
  if (isGiven(before)) lists[0] = std::move(before);
  Result<void> drawn = (*scene)->drawing.draw(view, lights, settings, lists);
  if (!drawn)
    for (PassList& list : lists) list.clear();
  const auto isEmpty = [](const PassList& l) { return l.passes.empty() && l.uploads.empty(); };
  const size_t first = own.used;
  size_t count = lists.size();
  while (count > 1 && isEmpty(lists[count - 1])) --count;
  for (uint32_t i = 0; i < lists.size(); ++i) own.add(own.views, i) = std::move(lists[i]);
  own.used = drawn ? first + count : first;
  lists.clear();
  if (!drawn) return drawn.error();
  own.drawsStrands = true;
  return own.views++;
}

Result<uint32_t> Frame::drawDepth(const View& view, const HairDepthSettings& settings,
                                  PassList before) {
  const Result<detail::SceneParts*> scene = openForMore("drawDepth()");
  if (!scene) return scene.error();
  PassList& list = state_->add(state_->views);
  if (isGiven(before)) list = std::move(before);
  if (Result<void> drawn = (*scene)->drawing.drawDepth(view, settings, list); !drawn) {
    dropLast(*state_);
    return drawn.error();
  }
  state_->drawsStrands = true;
  return state_->views++;
}

Result<uint32_t> Frame::addView(PassList list) {
  if (const Result<detail::SceneParts*> scene = openForMore("addView()"); !scene)
    return scene.error();
  state_->add(state_->views) = std::move(list);
  return state_->views++;
}

Result<uint32_t> Frame::castShadows(std::span<const Light> lights) {
  const Result<detail::SceneParts*> scene = openForMore("castShadows()");
  if (!scene) return scene.error();
  Result<uint32_t> cast = (*scene)->drawing.castShadows(lights, state_->add());
  if (cast)
    state_->drawsStrands = true;
  else
    dropLast(*state_);
  return cast;
}

PassList& Frame::addList() {
  PELAGE_ASSERT(state_ != nullptr, "Frame::addList(): the frame was moved away");
  if (state_ == nullptr) return strayList();
  PELAGE_ASSERT(!state_->finished, "Frame::addList(): add lists before finish()");
  return state_->add();
}

PassList& Frame::addListBefore() {
  PELAGE_ASSERT(state_ != nullptr, "Frame::addListBefore(): the frame was moved away");
  if (state_ == nullptr) return strayList();
  PELAGE_ASSERT(!state_->finished, "Frame::addListBefore(): add lists before finish()");
  PassList& list = state_->add();
  const auto first = state_->items.begin();
  const auto last = first + static_cast<ptrdiff_t>(state_->used);
  std::rotate(first + static_cast<ptrdiff_t>(state_->simulation++), last - 1, last);
  return list;
}

Result<void> Frame::finish() {
  const Result<detail::SceneParts*> scene = open("finish()");
  if (!scene) return scene.error();
  if (state_->finished) return {};
  for (const Item& item : itemsOf(*state_)) {
    if (item.view != FrameStep::kNoView) continue;
    for (const Pass& pass : item.list->passes) {
      if (!isDraw(pass.kind)) continue;
      return Error{ErrorCode::kInvalidArgument,
                   "Frame::finish(): a list of addList() has the draw '" + std::string(pass.name) +
                       "'; draws belong to a view: give the list to draw() or addView()"};
    }
  }
  state_->finished = true;
  for (const Item& item : itemsOf(*state_)) {
    (*scene)->journal.finish(*item.list);
    state_->steps.push_back({item.list.get(), item.view, item.listOfView});
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
  return state_ != nullptr ? std::span<const FrameStep>(state_->steps)
                           : std::span<const FrameStep>();
}

uint32_t Frame::viewCount() const { return state_ != nullptr ? state_->views : 0; }

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
  for (const FrameStep& step : state_->steps) {
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
  Frame frame(parts_);
  if (Result<void> done = simulate(dt, frame.state_->add()); !done) return done.error();
  frame.state_->frame = parts_->store.frame;
  return frame;
}

}  // namespace pelage
