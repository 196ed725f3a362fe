// Runs hair on Vulkan, and writes what another executor needs to run the same lists, with the
// positions that came out: record_scene FOLDER makes scene.json and scene.bin. The hair swings: its
// bone moves by one meter a second and turns.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <string>

#include "pelage/demo/groom.h"
#include "pelage/headless.h"
#include "pelage/scene.h"

namespace {

using namespace pelage;
using nlohmann::json;

constexpr int kFrames = 60;
constexpr float kStep = 1.0f / 60;

class Recorder {
 public:
  explicit Recorder(const std::filesystem::path& folder)
      : folder_(folder), bytes_(folder / "scene.bin", std::ios::binary) {}

  // Buffers that are new, and the lists' uploads and dispatches.
  void add(const ResourceTable& resources, std::span<const PassList> lists) {
    json frame = {{"buffers", json::array()}, {"lists", json::array()}};
    for (uint32_t slot = 0; slot < resources.end(); ++slot) {
      const BufferId id = resources.at(slot);
      const BufferDesc* desc = resources.find(id);
      if (desc == nullptr || !known_.insert(id).second) continue;
      json buffer = {{"id", name(id)}, {"name", desc->name}, {"size", desc->size}};
      if (!desc->initial.empty()) buffer["initial"] = put(std::span(desc->initial));
      frame["buffers"].push_back(buffer);
    }
    for (const PassList& list : lists) frame["lists"].push_back(add(list));
    frames_.push_back(frame);
  }

  // The positions at the end.
  bool finish(BufferId positions, std::span<const std::byte> values) {
    const json scene = {{"frames", frames_},
                        {"positions", name(positions)},
                        {"expected", put(values)},
                        {"expectedSize", values.size()}};
    std::ofstream(folder_ / "scene.json") << scene;
    bytes_.close();
    return bytes_.good();
  }

 private:
  static std::string name(BufferId id) { return std::to_string(static_cast<uint64_t>(id)); }

  uint64_t put(std::span<const std::byte> values) {
    const auto offset = static_cast<uint64_t>(bytes_.tellp());
    bytes_.write(reinterpret_cast<const char*>(values.data()),
                 static_cast<std::streamsize>(values.size()));
    return offset;
  }

  json add(const PassList& list) {
    const uint64_t constants = put(std::span(list.constants));
    const uint64_t uploads = put(std::span(list.uploadData));
    json result = {{"uploads", json::array()}, {"passes", json::array()}};
    for (const Upload& upload : list.uploads) {
      result["uploads"].push_back({{"buffer", name(upload.buffer)},
                                   {"offset", upload.offset},
                                   {"data", uploads + upload.dataOffset},
                                   {"size", upload.size}});
    }
    for (const Pass& pass : list.passes) {
      char hash[17];
      std::snprintf(hash, sizeof(hash), "%016llx",
                    static_cast<unsigned long long>(pass.kernel->hash));
      json entry = {{"kernel", pass.name}, {"hash", hash}, {"bindings", json::array()}};
      if (pass.kind == PassKind::kDispatchIndirect) {
        entry["indirect"] = name(pass.indirect);
        entry["indirectOffset"] = pass.indirectOffset;
      } else {
        entry["groups"] = pass.groups;
      }
      for (const PassBinding& binding : list.bindingsOf(pass)) {
        json bound = {{"set", binding.set}, {"entry", binding.entry}, {"size", binding.size}};
        const bool isBlock = binding.buffer == BufferId::kInvalid;
        if (!isBlock) bound["buffer"] = name(binding.buffer);
        bound["offset"] = binding.offset + (isBlock ? constants : 0);
        entry["bindings"].push_back(bound);
      }
      result["passes"].push_back(entry);
    }
    return result;
  }

  std::filesystem::path folder_;
  std::ofstream bytes_;
  std::set<BufferId> known_;
  json frames_ = json::array();
};

// \param contacts  with other hair and a capsule
Result<void> record(const std::filesystem::path& folder, Solver solver, bool contacts) {
  std::filesystem::create_directories(folder);
  auto groom = generateGroom({.seed = 7, .strandCount = 500});
  if (!groom) return groom.error();
  if (auto processed = groom->hair.process(); !processed) return processed.error();
  Scene scene;
  HairDef def{.name = "hair"};
  def.settings.solver = solver;
  if (contacts) def.settings.contact = {.stiffness = 0.2f, .friction = 0.2f};
  const auto hair = scene.addHair(groom->hair, def);
  if (!hair) return hair.error();
  const auto device = createHeadlessVulkan({});
  if (!device) return device.error();
  const CapsuleCollider capsule = {
      .head = {0.5f, 0, 0}, .headRadius = 0.1f, .tail = {0.9f, 0.3f, 0}, .tailRadius = 0.1f};
  if (contacts) scene.hair(*hair).setColliders({&capsule, 1});
  scene.setTier((*device)->info().tier);
  Recorder recorder(folder);
  for (int i = 0; i < kFrames; ++i) {
    const float angle = 0.3f * std::sin(0.1f * static_cast<float>(i));
    const AffineTransform bone = rigidTransform({0, std::sin(angle), 0, std::cos(angle)},
                                                {kStep * static_cast<float>(i), 0, 0});
    scene.hair(*hair).setBones({&bone, 1});
    PassList list;
    if (auto simulated = scene.simulate(kStep, list); !simulated) return simulated;
    scene.finish(list);
    recorder.add(scene.resources(), {&list, 1});
    if (auto updated = (*device)->update(scene.resources()); !updated) return updated;
    if (auto ran = (*device)->execute(list); !ran) return ran;
  }
  const BufferId positions = scene.hair(*hair).buffers().positions;
  const auto bytes = (*device)->read(positions);
  if (!bytes) return bytes.error();
  if (!recorder.finish(positions, *bytes))
    return Error{ErrorCode::kInvalidFile, "cannot write " + folder.string()};
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::puts("usage: record_scene FOLDER"), 2;
  const std::filesystem::path folder = argv[1];
  struct Recording {
    const char* name;
    Solver solver;
    bool contacts;
  };
  for (const Recording& scene :
       {Recording{"exact", Solver::kExact, false}, Recording{"contacts", Solver::kExact, true},
        Recording{"classic", Solver::kClassic, false}}) {
    if (const auto done = record(folder / scene.name, scene.solver, scene.contacts); !done) {
      std::fprintf(stderr, "record_scene: %s\n", done.error().message.c_str());
      return 1;
    }
  }
}
