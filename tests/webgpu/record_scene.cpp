// Runs hair on Vulkan, and writes what another executor needs to run the same lists, with the
// buffers and the picture that came out: record_scene FOLDER makes scene.json and scene.bin of each
// scene. The hair swings: its bone moves by one meter a second and turns.
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>
#include <vector>

#include "device.h"
#include "frame_words.h"
#include "pelage/demo/groom.h"
#include "pelage/headless.h"
#include "pelage/scene.h"
#include "web_scene.h"

namespace {

using namespace pelage;
using nlohmann::json;

constexpr int kFrames = 60;
constexpr float kStep = 1.0f / 60;
constexpr uint32_t kWidth = 320, kHeight = 240;  // of the picture

class Recorder {
 public:
  explicit Recorder(const std::filesystem::path& folder)
      : folder_(folder), bytes_(folder / "scene.bin", std::ios::binary) {}

  Result<void> add(const ResourceTable& resources, std::span<const PassList* const> lists) {
    const auto frame = writer_.write(resources, lists);
    if (!frame) return frame.error();
    const uint64_t offset = put(*frame);
    frames_.push_back({{"offset", offset}, {"size", frame->size()}});
    return {};
  }

  // A buffer as it is at the end.
  void expect(const char* what, BufferId buffer, std::span<const std::byte> values) {
    outputs_.push_back({{"what", what},
                        {"buffer", writer_.numberOf(buffer)},
                        {"expected", put(values)},
                        {"size", values.size()}});
  }

  // The picture of the last lists: four floats a pixel.
  void expect(const RenderedImage& image) {
    picture_ = {{"width", image.width},
                {"height", image.height},
                {"expected", put(std::as_bytes(std::span(image.pixels)))}};
  }

  bool finish() {
    const json scene = {{"frames", frames_}, {"outputs", outputs_}, {"picture", picture_}};
    std::ofstream(folder_ / "scene.json") << scene;
    bytes_.close();
    return bytes_.good();
  }

 private:
  uint64_t put(std::span<const std::byte> values) {
    const auto offset = static_cast<uint64_t>(bytes_.tellp());
    bytes_.write(reinterpret_cast<const char*>(values.data()),
                 static_cast<std::streamsize>(values.size()));
    return offset;
  }

  std::filesystem::path folder_;
  std::ofstream bytes_;
  webgpu::FrameWriter writer_;
  json frames_ = json::array();
  json outputs_ = json::array();
  json picture_;
};

BufferId bufferOf(const ResourceTable& resources, std::string_view name) {
  for (uint32_t slot = 0; slot < resources.end(); ++slot) {
    const BufferDesc* desc = resources.find(resources.at(slot));
    if (desc != nullptr && desc->name == name) return resources.at(slot);
  }
  return BufferId::kInvalid;
}

Result<ColliderId> addHead(Scene& scene, const CollisionMesh& head) {
  return scene.addCollider(head, {.name = "head", .cellSize = 0.01f, .boneCount = 2});
}

// Draws the hair by tiles. \param x of the head
Result<void> draw(Scene& scene, HeadlessDevice& device, float x, Recorder& recorder) {
  View view;
  view.eye = {x + 0.1f, 0.05f, 0.7f};
  view.width = kWidth;
  view.height = kHeight;
  view.worldToClip = lookAt(view.eye, {x, 0, 0}, {0, 1, 0}, 0.7f,
                            static_cast<float>(kWidth) / static_cast<float>(kHeight), 0.1f, 10);
  const Light lights[] = {{.shadow = HairShadow::kDeep, .shadowSize = 256}};
  TransparencySettings settings;
  settings.method = Transparency::kTiles;
  std::vector<PassList> lists;
  if (auto drawn = scene.draw(view, lights, settings, lists); !drawn) return drawn;
  std::vector<const PassList*> drawn;
  for (PassList& list : lists) {
    scene.finish(list);
    drawn.push_back(&list);
  }
  if (auto added = recorder.add(scene.resources(), drawn); !added) return added;
  if (auto updated = device.update(scene.resources()); !updated) return updated;
  const auto image = device.render(drawn, {.width = kWidth, .height = kHeight});
  if (!image) return image.error();
  recorder.expect(*image);
  return {};
}

struct Recording {
  const char* name;
  Solver solver = Solver::kExact;
  bool contacts = false;  // with other hair and a capsule
  bool head = false;      // an SDF of the head
  bool picture = false;   // drawn at the end, with fibers that cover pixels
};

Result<void> record(const std::filesystem::path& folder, const Recording& recording) {
  std::filesystem::create_directories(folder);
  auto groom = generateGroom({.seed = 7, .strandCount = 500});
  if (!groom) return groom.error();
  if (auto processed = groom->hair.process(); !processed) return processed.error();
  Scene scene;
  HairDef def{.name = "hair"};
  def.settings.solver = recording.solver;
  if (recording.picture) def.material.fiberRadius = 0.001f;
  if (recording.contacts) def.settings.contact = {.stiffness = 0.2f, .friction = 0.2f};
  const auto hair = scene.addHair(groom->hair, def);
  if (!hair) return hair.error();
  ColliderId head = ColliderId::kInvalid;
  if (recording.head) {
    const auto added = addHead(scene, groom->head);
    if (!added) return added.error();
    head = *added;
  }
  const auto device = createHeadlessVulkan({});
  if (!device) return device.error();
  const CapsuleCollider capsule = {
      .head = {0.5f, 0, 0}, .headRadius = 0.1f, .tail = {0.9f, 0.3f, 0}, .tailRadius = 0.1f};
  if (recording.contacts) scene.hair(*hair).setColliders({&capsule, 1});
  scene.setTier((*device)->info().tier);
  Recorder recorder(folder);
  for (int i = 0; i < kFrames; ++i) {
    const float angle = 0.3f * std::sin(0.1f * static_cast<float>(i));
    const AffineTransform bone = rigidTransform({0, std::sin(angle), 0, std::cos(angle)},
                                                {kStep * static_cast<float>(i), 0, 0});
    scene.hair(*hair).setBones({&bone, 1});
    if (recording.head) scene.collider(head).setBones(std::array{bone, bone});
    PassList list;
    if (auto simulated = scene.simulate(kStep, list); !simulated) return simulated;
    scene.finish(list);
    const PassList* const lists[] = {&list};
    if (auto added = recorder.add(scene.resources(), lists); !added) return added;
    if (auto updated = (*device)->update(scene.resources()); !updated) return updated;
    if (auto ran = (*device)->execute(list); !ran) return ran;
  }
  if (recording.picture) {
    if (auto drawn = draw(scene, **device, kStep * kFrames, recorder); !drawn) return drawn;
  }
  const auto expect = [&](const char* what, BufferId buffer) -> Result<void> {
    const auto bytes = (*device)->read(buffer);
    if (!bytes) return bytes.error();
    recorder.expect(what, buffer, *bytes);
    return {};
  };
  if (auto read = expect("positions", scene.hair(*hair).buffers().positions); !read) return read;
  if (recording.head) {
    if (auto read = expect("keys", bufferOf(scene.resources(), "sdf/keys")); !read) return read;
  }
  if (!recorder.finish()) return Error{ErrorCode::kInvalidFile, "cannot write " + folder.string()};
  return {};
}

// The scene of wasm_test.mjs, by the native core.
Result<void> recordPage(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  const auto scene = webgpu::WebScene::head({.strands = 500, .followPerGuide = 0, .seed = 7});
  if (!scene) return scene.error();
  const auto device = sample::createDevice({});
  if (!device) return device.error();
  const double radius[] = {0.001};
  if (auto set = (*scene)->set("material", "fiberRadius", radius); !set) return set;
  const double wind[] = {2, 0, 0};
  if (auto set = (*scene)->set("simulation", "wind.velocity", wind); !set) return set;
  Recorder recorder(folder);
  for (int i = 0; i < 10; ++i) {
    const webgpu::WebCamera camera = {
        .eye = {0.2f, 0.2f, 0.8f}, .target = {0, 0.15f, 0}, .width = kWidth, .height = kHeight};
    if (auto stepped = (*scene)->step(kStep, camera); !stepped) return stepped;
    const auto lists = (*scene)->lists();
    if (auto added = recorder.add((*scene)->scene().resources(), lists); !added) return added;
    if (auto updated = (*device)->update((*scene)->scene().resources()); !updated) return updated;
    const auto image =
        (*device)->render(lists, {.width = kWidth,
                                  .height = kHeight,
                                  .depthCopy = (*scene)->depth(),
                                  .depthCopyAfter = webgpu::WebScene::kDepthList - 1});
    if (!image) return image.error();
    if (i == 9) recorder.expect(*image);
  }
  const BufferId positions = (*scene)->scene().hair((*scene)->hairs()[0]).buffers().positions;
  const auto bytes = (*device)->read(positions);
  if (!bytes) return bytes.error();
  recorder.expect("positions", positions, *bytes);
  if (!recorder.finish()) return Error{ErrorCode::kInvalidFile, "cannot write " + folder.string()};
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::puts("usage: record_scene FOLDER"), 2;
  const std::filesystem::path folder = argv[1];
  if (const auto done = recordPage(folder / "page"); !done) {
    std::fprintf(stderr, "record_scene: page: %s\n", done.error().message.c_str());
    return 1;
  }
  for (const Recording& scene :
       {Recording{.name = "exact"}, Recording{.name = "contacts", .contacts = true},
        Recording{.name = "classic", .solver = Solver::kClassic},
        Recording{.name = "head", .head = true}, Recording{.name = "drawn", .picture = true}}) {
    if (const auto done = record(folder / scene.name, scene); !done) {
      std::fprintf(stderr, "record_scene: %s\n", done.error().message.c_str());
      return 1;
    }
  }
}
