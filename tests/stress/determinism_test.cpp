// The same bits from every API of one driver, from run to run, and for any order of the strands;
// and the bits that determinism_hashes.txt has for the driver.
#include <cstring>
#include <fstream>
#include <map>
#include <numeric>
#include <sstream>

#include "stress/stress_run.h"

namespace pelage::test {
namespace {

constexpr uint32_t kMixedStrands = 65, kMixedVertices = 17, kMixedFollows = 2, kMixedBones = 4;

/// Strands of 2 to 17 vertices in an order, with their bones and their follow hairs.
struct MixedGroom {
  HairAsset asset;
  std::vector<BoneInfluences> influences;
  std::vector<FollowHair> follows;
};

MixedGroom makeMixedGroom(const std::vector<uint32_t>& order) {
  const HairAsset source = wavyAsset(kMixedStrands, kMixedVertices, 13);
  Random random(4);
  std::vector<BoneInfluences> influences(kMixedStrands);
  std::vector<FollowHair> follows(kMixedStrands * kMixedFollows);
  for (uint32_t s = 0; s < kMixedStrands; ++s) {
    for (uint32_t k = 0; k < 3; ++k) {
      influences[s].bones[k] = (s + k) % kMixedBones;
      influences[s].weights[k] = static_cast<float>(random.between(0.1, 1));
    }
    for (uint32_t k = 0; k < kMixedFollows; ++k)
      follows[s * kMixedFollows + k].offset = toFloat4(random.vector(0.004), random.between(0, 2));
  }
  MixedGroom groom;
  groom.asset.strandCount = kMixedStrands;
  groom.asset.verticesPerStrand = kMixedVertices;
  for (uint32_t slot = 0; slot < kMixedStrands; ++slot) {
    const uint32_t s = order[slot];
    const auto first = source.positions.begin() + static_cast<ptrdiff_t>(s * kMixedVertices);
    groom.asset.positions.insert(groom.asset.positions.end(), first, first + kMixedVertices);
    groom.asset.vertexCounts.push_back(2 + (s * 7) % (kMixedVertices - 1));
    groom.influences.push_back(influences[s]);
    for (uint32_t k = 0; k < kMixedFollows; ++k) {
      groom.follows.push_back(follows[s * kMixedFollows + k]);
      groom.follows.back().guide = slot;
    }
  }
  expectOk(groom.asset.process());
  return groom;
}

/// FNV-1a.
class Hash {
 public:
  void add(const std::vector<Float4>& values) {
    std::vector<unsigned char> bytes(values.size() * sizeof(Float4));
    std::memcpy(bytes.data(), values.data(), bytes.size());
    for (const unsigned char byte : bytes) value_ = (value_ ^ byte) * 0x100000001b3u;
  }
  uint64_t value() const { return value_; }

 private:
  uint64_t value_ = 0xcbf29ce484222325u;
};

/// Solver and features of a hash.
struct HashedCase {
  const char* name;
  Solver solver;
  bool hairContact;
  int frames;
};

constexpr HashedCase kCases[] = {{"Exact", Solver::kExact, false, 1000},
                                 {"ExactContact", Solver::kExact, true, 100},
                                 {"Classic", Solver::kClassic, false, 1000}};

void PrintTo(const HashedCase& variant, std::ostream* out) { *out << variant.name; }

struct HashedRun {
  uint64_t hash = 0;                        ///< of positions and tangents, every 10 frames
  std::vector<Float4> positions, tangents;  ///< at the end
};

/// A head with four bones that shakes, turns and walks, among colliders that move, in steps of
/// several lengths.
HashedRun hashedRun(Api api, const HashedCase& variant, const std::vector<uint32_t>& order) {
  SceneRun run(api);
  const MixedGroom groom = makeMixedGroom(order);
  SimulationSettings settings;
  settings.solver = variant.solver;
  if (variant.hairContact) settings.contact = {.stiffness = 0.5f, .friction = 0.1f};
  settings.globalStiffness = 0.01f;
  settings.relaxationTime = 1e-3f;
  settings.localStiffness = 0.4f;
  settings.vspCoefficient = 0.4f;
  settings.vspThreshold = 30;
  settings.wind.velocity = {0, 0.5f, 3};
  settings.tipSeparation = 1.5f;
  HairObject& hair = run.add(groom.asset, {.settings = settings,
                                           .influences = groom.influences,
                                           .boneCount = kMixedBones,
                                           .followHairs = groom.follows,
                                           .storeFollowHairs = true});
  constexpr std::array<float, 5> kSteps = {1.0f / 60, 1.0f / 60, 1.0f / 144, 1.0f / 30, 1.0f / 90};
  HashedRun outcome;
  Hash hash;
  for (int frame = 0; frame < variant.frames; ++frame) {
    std::vector<AffineTransform> bones;
    for (uint32_t b = 0; b < kMixedBones; ++b) {
      const Eigen::Quaterniond turn(
          Eigen::AngleAxisd(0.7 * std::sin(0.1 * frame + b), Vector3d(b, 1, 0.5).normalized()));
      const Vector3d shift(0.1 * std::sin(0.13 * frame) + 0.004 * frame, 0.02 * b, 0);
      bones.push_back(toTransform(turn.toRotationMatrix() * (1 + 0.05 * b), shift));
    }
    hair.setBones(bones);
    const auto x = static_cast<float>(0.004 * frame);
    const auto sway = static_cast<float>(0.1 * std::sin(0.21 * frame));
    const CapsuleCollider shapes[] = {sphereCollider({x, -0.1f, sway}, 0.08f),
                                      {.head = {x + 0.1f, 0.1f, 0.1f},
                                       .headRadius = 0.04f,
                                       .tail = {x + 0.2f, sway, 0},
                                       .tailRadius = 0.06f,
                                       .friction = 0.6f}};
    hair.setColliders(shapes);
    run.step(kSteps[static_cast<size_t>(frame) % kSteps.size()]);
    if (frame % 10 != 9 && frame + 1 != variant.frames) continue;
    outcome.positions = run.positions(hair);
    outcome.tangents = run.read(hair.buffers().tangents);
    hash.add(outcome.positions);
    hash.add(outcome.tangents);
  }
  EXPECT_TRUE(allFinite(outcome.positions));
  outcome.hash = hash.value();
  return outcome;
}

std::vector<uint32_t> asMade() {
  std::vector<uint32_t> order(kMixedStrands);
  std::iota(order.begin(), order.end(), 0u);
  return order;
}

std::string hex(uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

/// The driver behind a device as one word.
std::string familyWord(const DeviceInfo& info) {
  std::string name = driverFamily(info);
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

/// Lines of "driver way hash"; PELAGE_UPDATE_GOLDEN=1 writes those of the device at hand.
class KnownHashes {
 public:
  KnownHashes() {
    std::ifstream file(path());
    for (std::string line; std::getline(file, line);) {
      if (line.empty() || line[0] == '#') {
        comment_ += line + "\n";
        continue;
      }
      std::istringstream words(line);
      std::string who, solver;
      words >> who >> solver >> hashes_[who + " " + solver];
    }
  }
  /// Empty for a driver that is not known.
  std::string find(const std::string& key) const {
    const auto found = hashes_.find(key);
    return found == hashes_.end() ? std::string() : found->second;
  }
  void set(const std::string& key, const std::string& hash) {
    hashes_[key] = hash;
    std::ofstream file(path());
    file << comment_;
    for (const auto& [name, value] : hashes_) file << name << " " << value << "\n";
  }

 private:
  static std::string path() { return PELAGE_SOURCE_DIR "/tests/stress/determinism_hashes.txt"; }
  std::string comment_;
  std::map<std::string, std::string> hashes_;
};

class Determinism : public testing::TestWithParam<HashedCase> {};

TEST_P(Determinism, TheBitsAreThoseOfEveryApiAndRunAndOfTheTable) {
  std::string first;
  HashedRun expected;
  for (const Api api : {Api::kGl, Api::kGl, Api::kGles, Api::kVulkan}) {
    const Gpu& gpu = Gpu::of(api);
    if (gpu.device() == nullptr) {
      ASSERT_EQ(gpu.error().code, ErrorCode::kUnsupported) << gpu.error().message;
      continue;
    }
    const DeviceInfo& info = gpu.device()->info();
    if (first.empty()) first = familyWord(info);
    if (familyWord(info) != first) continue;
    const HashedRun outcome = hashedRun(api, GetParam(), asMade());
    std::printf("[ FIGURE ] %s %s %s  (%d frames on %s, %s, %s)\n", first.c_str(), GetParam().name,
                hex(outcome.hash).c_str(), GetParam().frames, apiName(api), info.name.c_str(),
                info.driver.c_str());
    if (expected.positions.empty()) expected = outcome;
    EXPECT_EQ(hex(outcome.hash), hex(expected.hash)) << "on " << apiName(api);
  }
  if (first.empty()) PELAGE_SKIP_WITHOUT_DEVICE() << "no device";
  KnownHashes known;
  const std::string key = first + " " + GetParam().name;
  if (std::getenv("PELAGE_UPDATE_GOLDEN") != nullptr) {
    known.set(key, hex(expected.hash));
  } else if (known.find(key).empty()) {
    std::printf("[ FIGURE ] no hash of '%s' is known\n", key.c_str());
  } else {
    EXPECT_EQ(known.find(key), hex(expected.hash))
        << "where the kernels were meant to change, run with PELAGE_UPDATE_GOLDEN=1";
  }
}

TEST_P(Determinism, AStrandDoesNotDependOnItsPlaceAmongTheOthers) {
  Api api = Api::kGl;
  if (Gpu::of(api).device() == nullptr) api = Api::kVulkan;
  if (Gpu::of(api).device() == nullptr) PELAGE_SKIP_WITHOUT_DEVICE() << "no device";
  std::vector<uint32_t> order = asMade();
  Random random(99);
  for (size_t i = order.size() - 1; i > 0; --i)
    std::swap(order[i], order[static_cast<size_t>(random.between(0, static_cast<double>(i + 1)))]);
  const HashedRun plain = hashedRun(api, GetParam(), asMade());
  const HashedRun mixed = hashedRun(api, GetParam(), order);
  uint32_t different = 0;
  const auto compare = [&](size_t a, size_t b) {
    for (size_t v = 0; v < kMixedVertices; ++v) {
      const size_t i = a * kMixedVertices + v, j = b * kMixedVertices + v;
      const bool same = sameBits(plain.positions[i], mixed.positions[j]) &&
                        sameBits(plain.tangents[i], mixed.tangents[j]);
      different += same ? 0 : 1;
    }
  };
  for (size_t slot = 0; slot < kMixedStrands; ++slot) {
    compare(order[slot], slot);
    for (size_t k = 0; k < kMixedFollows; ++k)
      compare(kMixedStrands + order[slot] * kMixedFollows + k,
              kMixedStrands + slot * kMixedFollows + k);
  }
  EXPECT_EQ(different, 0u) << "vertices of " << plain.positions.size();
}

std::string caseTestName(const testing::TestParamInfo<HashedCase>& variant) {
  return variant.param.name;
}

INSTANTIATE_TEST_SUITE_P(All, Determinism, testing::ValuesIn(kCases), caseTestName);

}  // namespace
}  // namespace pelage::test
