// Parts of the generator by themselves.
#include <gtest/gtest.h>

#include <bit>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <optional>

#include "codegen/back_end.h"
#include "codegen/constants.h"
#include "codegen/front_end.h"
#include "codegen/hash.h"
#include "codegen/host_struct.h"
#include "codegen/include_scan.h"
#include "codegen/key_completion.h"
#include "codegen/manifest.h"
#include "codegen/names.h"
#include "codegen/reflect.h"
#include "codegen/spirv_reader.h"
#include "support/test_folder.h"

namespace pelage::codegen {
namespace {

namespace fs = std::filesystem;
using pelage::test::TestFolder;

TEST(Hash, GivesTheExamplesOfTheStandard) {
  // FIPS 180-2, appendix B.
  EXPECT_EQ(sha256Hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256Hex("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256Hex(std::string(1'000'000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Hash, TellsFieldsApart) {
  EXPECT_NE(Sha256().field("ab").field("c").finish(), Sha256().field("a").field("bc").finish());
}

TEST(Names, AreWrittenAsTheHouseStyleWantsThem) {
  EXPECT_EQ(pascalCase("skin_roots"), "SkinRoots");
  EXPECT_EQ(camelCase("skin_roots"), "skinRoots");
  EXPECT_EQ(hostName("g_positions"), "positions");
  EXPECT_EQ(hostName("SimulationConstants"), "simulationConstants");
  EXPECT_EQ(hostName("PPLLBuildConstants"), "ppllBuildConstants");
  EXPECT_EQ(hostName("SDF"), "sdf");
  EXPECT_EQ(hostName("g_X"), "x");
  EXPECT_EQ(macroName("velocityShockPropagation"), "VELOCITY_SHOCK_PROPAGATION");
  EXPECT_FALSE(isIdentifier("float"));
  EXPECT_FALSE(isIdentifier("2d"));
  EXPECT_FALSE(isIdentifier(""));
  EXPECT_TRUE(isIdentifier("_x2"));
}

TEST(Constants, AreReadBackAsTheSameBits) {
  const auto value = [](ScalarType type, uint32_t bits) {
    return constantValue({"kName", type, bits, 1});
  };
  EXPECT_EQ(value(ScalarType::kUint, 0xffffffffu), "4294967295u");
  EXPECT_EQ(value(ScalarType::kInt, 0xffffffffu), "-1");
  EXPECT_EQ(value(ScalarType::kInt, 0x80000000u), "INT32_MIN");
  EXPECT_EQ(value(ScalarType::kFloat, std::bit_cast<uint32_t>(1.0f)), "1.0f");
  EXPECT_EQ(value(ScalarType::kFloat, std::bit_cast<uint32_t>(-0.0f)), "-0.0f");
  for (const float number : {0.1f, 1e-3f, 1.5f / 65535.0f, 3.14159265f, 16777217.0f, 1e18f,
                             std::numeric_limits<float>::min(), std::numeric_limits<float>::max(),
                             std::numeric_limits<float>::denorm_min(), -2.5e-30f}) {
    const std::string text = value(ScalarType::kFloat, std::bit_cast<uint32_t>(number));
    EXPECT_EQ(std::bit_cast<uint32_t>(std::strtof(text.c_str(), nullptr)),
              std::bit_cast<uint32_t>(number))
        << text;
    EXPECT_TRUE(text.ends_with("f")) << text;
    EXPECT_NE(text.find_first_of(".e"), std::string::npos) << text;
  }
}

class ManifestTest : public testing::Test {
 protected:
  void SetUp() override { (void)folder_.write("k.hlsl", "\n"); }
  Manifest read(const std::string& text) {
    diagnostics_ = {};
    return readManifest(folder_.write("manifest.json", text), diagnostics_);
  }
  // The text of the only error: "line code".
  std::string error(const std::string& text) {
    read(text);
    EXPECT_EQ(diagnostics_.sorted().size(), 1u) << diagnostics_.format();
    if (diagnostics_.items().empty()) return "";
    const Diagnostic& d = diagnostics_.items().front();
    EXPECT_EQ(d.file, "manifest.json");
    return std::to_string(d.line) + " " + d.code;
  }
  // A manifest whose kernel, which starts in line 5, has these further keys.
  static std::string kernel(const std::string& more, const std::string& name = "k") {
    return "{\n\"namespace\": \"a\",\n\"groups\": {\"g\": [\"L\"]},\n\"kernels\": [\n{\"name\": "
           "\"" +
           name + "\", \"file\": \"k.hlsl\", \"stage\": \"compute\", \"group\": \"g\"" + more +
           "}\n]}\n";
  }

  const TestFolder folder_;
  Diagnostics diagnostics_;
};

TEST_F(ManifestTest, ListsThePermutationsThatAreNotExcluded) {
  const Manifest manifest =
      read(kernel(R"(, "axes": [{"name": "x"}, {"name": "n", "values": [4, 8]}],
    "conflicts": [{"x": true, "n": 8}])"));
  ASSERT_FALSE(diagnostics_.hasErrors()) << diagnostics_.format();
  ASSERT_EQ(manifest.kernels.size(), 1u);
  EXPECT_EQ(manifest.kernels[0].permutations(), (std::vector<Permutation>{{0, 4}, {0, 8}, {1, 4}}));
  EXPECT_EQ(permutationKey(manifest.kernels[0], {1, 4}), "x=1 n=4");
}

// The key that completes `wanted`.
std::string completed(const ManifestKernel& kernel, const Permutation& wanted) {
  return permutationKey(kernel, completeKeys(kernel).complete(wanted));
}

TEST_F(ManifestTest, CompletesAKeyWithWhatComesWithItsFeatures) {
  const Manifest manifest = read(kernel(R"(, "axes": [{"name": "a"}, {"name": "b"}, {"name": "c"},
      {"name": "n", "values": [4, 8]}],
    "exclude": [{"a": true, "b": false}, {"b": true, "c": false, "n": 8}])"));
  ASSERT_FALSE(diagnostics_.hasErrors()) << diagnostics_.format();
  const ManifestKernel& k = manifest.kernels[0];
  EXPECT_EQ(completed(k, {0, 0, 0, 8}), "a=0 b=0 c=0 n=8") << "it exists";
  EXPECT_EQ(completed(k, {1, 0, 0, 4}), "a=1 b=1 c=0 n=4");
  EXPECT_EQ(completed(k, {0, 1, 0, 8}), "a=0 b=1 c=1 n=8") << "for this value alone";
  EXPECT_EQ(completed(k, {1, 0, 0, 8}), "a=1 b=1 c=1 n=8") << "a brings b, which brings c";
}

TEST_F(ManifestTest, CompletesEveryKeyThatDoesNotConflictToTheSmallestPermutationAroundIt) {
  for (const char* more :
       {R"("exclude": [{"a": true, "b": false}, {"a": true, "c": false}, {"d": true, "a": false}])",
        R"("exclude": [{"a": true, "b": false, "c": false}, {"a": true, "b": true, "c": false}])",
        R"("exclude": [{"a": false, "n": 2}, {"a": false, "n": 0}, {"a": false, "d": true}],
           "conflicts": [{"n": 2, "d": true}])",
        R"("exclude": [{"a": true, "b": false, "n": 2}, {"c": true, "d": false, "b": true}],
           "conflicts": [{"a": true, "c": true, "n": 0}])"}) {
    const Manifest manifest = read(kernel(R"(, "axes": [{"name": "a"}, {"name": "b"}, {"name": "c"},
      {"name": "d"}, {"name": "n", "values": [4, 2, 0]}], )" +
                                          std::string(more)));
    ASSERT_FALSE(diagnostics_.hasErrors()) << diagnostics_.format();
    const ManifestKernel& k = manifest.kernels[0];
    const KeyCompletion completion = completeKeys(k);
    const auto contains = [](const Permutation& larger, const Permutation& smaller) {
      for (size_t i = 0; i < 4; ++i)
        if (larger[i] < smaller[i]) return false;
      return larger[4] == smaller[4];
    };
    size_t changed = 0;
    for (const Permutation& wanted : k.combinations()) {
      const Permutation given = completion.complete(wanted);
      const std::string text = permutationKey(k, wanted) + " -> " + permutationKey(k, given);
      EXPECT_EQ(k.isExcluded(given), k.isConflict(wanted)) << text;
      EXPECT_TRUE(contains(given, wanted)) << text;
      if (k.isConflict(wanted)) continue;
      for (const Permutation& other : k.permutations()) {
        EXPECT_TRUE(!contains(other, wanted) || contains(other, given))
            << text << ", not " << permutationKey(k, other);
      }
      changed += given != wanted;
    }
    EXPECT_GT(changed, 3u) << more;
  }
}

TEST_F(ManifestTest, LetsGroupsShareTheLayoutsWithWhichTheyBegin) {
  const Manifest manifest = read(R"({"namespace": "a", "kernels": [],
    "groups": {"g": ["L", "M"], "h": ["L", "M", "N"], "i": ["L", "O"], "j": ["L"]}})");
  ASSERT_FALSE(diagnostics_.hasErrors()) << diagnostics_.format();
  ASSERT_EQ(manifest.groups.size(), 4u);
  EXPECT_EQ(manifest.groups[1].layouts, (std::vector<std::string>{"L", "M", "N"}));
}

TEST_F(ManifestTest, GivesAPermutationTheHighestTierThatApplies) {
  const Manifest manifest =
      read(kernel(R"(, "axes": [{"name": "a"}, {"name": "n", "values": [4, 8]}],
    "tier": "es", "tiers": [{"when": {"a": true}, "tier": "base"},
                            {"when": {"a": true, "n": 8}, "tier": "wide"}])"));
  ASSERT_FALSE(diagnostics_.hasErrors()) << diagnostics_.format();
  const ManifestKernel& k = manifest.kernels[0];
  EXPECT_EQ(k.tierOf({0, 4}), Tier::kEs);
  EXPECT_EQ(k.tierOf({0, 8}), Tier::kEs);
  EXPECT_EQ(k.tierOf({1, 4}), Tier::kBase);
  EXPECT_EQ(k.tierOf({1, 8}), Tier::kWide);
  EXPECT_EQ(read(kernel("")).kernels.at(0).tierOf({}), Tier::kBase);
}

TEST(Tiers, AreOrderedInAllOfTheirLimits) {
  for (const Tier lower : kTiers) {
    EXPECT_EQ(tierOf(limitsOf(lower)), lower);
    EXPECT_EQ(tierFromName(tierName(lower)), lower);
    for (const Tier higher : kTiers) {
      if (higher < lower) continue;
      EXPECT_EQ(lowerOf(limitsOf(lower), limitsOf(higher)), limitsOf(lower));
    }
  }
  EXPECT_EQ(tierFromName("phone"), std::nullopt);
  TierLimits less = limitsOf(Tier::kEs);
  less.groupSharedBytes = 1;
  EXPECT_EQ(tierOf(less), std::nullopt);
}

TEST_F(ManifestTest, RefusesWhatIsWrongWithTheLine) {
  ASSERT_EQ((read(kernel("")), diagnostics_.format()), "");
  EXPECT_EQ(error("{\n\"namespace\": \"a\",\n\"groups\" {}\n}"), "3 PK301");
  EXPECT_EQ(error("{\n\"namespace\": \"a\",\n\"groups\": {},\n\"kernels\": []\n,\"kernels\": []}"),
            "5 PK301");
  EXPECT_EQ(error("{\n\"groups\": {},\n\"kernels\": []}"), "1 PK302");
  EXPECT_EQ(error("{\n\"namespace\": 7,\n\"groups\": {},\n\"kernels\": []}"), "2 PK302");
  EXPECT_EQ(error("{\n\"namespace\": \"a\",\n\"groups\": {},\n\"kernels\": [],\n\"kernel\": []}"),
            "5 PK303");
  EXPECT_EQ(error("{\n\"namespace\": \"a-b\",\n\"groups\": {},\n\"kernels\": []}"), "2 PK304");
  for (const char* other :
       {"[\"M\", \"L\"]", "[\"N\", \"M\"]", "[\"L\", \"N\", \"M\"]", "[\"N\", \"N\"]"}) {
    EXPECT_EQ(error("{\n\"namespace\": \"a\",\n\"groups\": {\"g\": [\"L\", \"M\"],\n\"h\": " +
                    std::string(other) + "},\n\"kernels\": []}"),
              "4 PK306")
        << other;
  }
  EXPECT_EQ(error("{\n\"namespace\": \"a\",\n\"groups\": {\n\"g\": []},\n\"kernels\": []}"),
            "4 PK305");
  EXPECT_EQ(error(kernel(",\n\"ax\": []")), "6 PK303");
  EXPECT_EQ(error(kernel("", "Upper")), "5 PK304");
  EXPECT_EQ(error(kernel(",\n\"tier\": \"phone\"")), "6 PK302");
  for (const char* old : {"portable", "desktop"})
    EXPECT_EQ(error(kernel(",\n\"tier\": \"" + std::string(old) + "\"")), "6 PK302");
  const std::string axis = ", \"axes\": [{\"name\": \"x\"}], \"tiers\": [\n";
  EXPECT_EQ(error(kernel(axis + R"({"when": {"x": true}, "tier": "tall"}])")), "6 PK302");
  EXPECT_EQ(error(kernel(axis + R"({"tier": "wide"}])")), "6 PK302");
  EXPECT_EQ(error(kernel(axis + R"({"when": {"y": true}, "tier": "wide"}])")), "6 PK314");
  EXPECT_EQ(error(kernel(axis + R"({"when": {"x": true}, "tier": "base"}])")), "6 PK319")
      << "all permutations have it";
  EXPECT_EQ(error(kernel(axis + R"({"when": {}, "tier": "wide"}])")), "6 PK319");
  EXPECT_EQ(error(kernel(",\n\"precise\": 1")), "6 PK302");
  EXPECT_EQ(error(kernel(",\n\"commutes\": 1")), "6 PK302");
  const auto input = [&](const std::string& stage, const std::string& fields) {
    std::string text = kernel(",\n\"vertexInput\": {" + fields + "}");
    const size_t at = text.find("compute");
    return error(text.replace(at, 7, stage));
  };
  EXPECT_EQ(input("compute", R"("step": "vertex", "stride": 4, "offsets": [0])"), "6 PK302");
  EXPECT_EQ(input("vertex", R"("step": "pixel", "stride": 4, "offsets": [0])"), "6 PK302");
  EXPECT_EQ(input("vertex", R"("step": "vertex", "stride": 6, "offsets": [0])"), "6 PK302");
  EXPECT_EQ(input("vertex", R"("step": "vertex", "stride": 4096, "offsets": [0])"), "6 PK302");
  EXPECT_EQ(input("vertex", R"("step": "vertex", "stride": 4, "offsets": [2])"), "6 PK302");
  EXPECT_EQ(input("vertex", R"("step": "vertex", "stride": 4, "offsets": [2048])"), "6 PK302");
  EXPECT_EQ(input("vertex", R"("step": "vertex", "stride": 4)"), "6 PK302");
  EXPECT_EQ(error(kernel(",\n\"axes\": [{\"name\": \"aB\"},\n{\"name\": \"aB\"}]")), "7 PK312");
  EXPECT_EQ(error(kernel(",\n\"axes\": [{\"name\": \"n\", \"values\": [1,\n1]}]")), "7 PK313");
  EXPECT_EQ(error(kernel(",\n\"exclude\": [\n{\"y\": true}]")), "7 PK314");
  EXPECT_EQ(error(kernel(",\n\"axes\": [{\"name\": \"x\"}], \"exclude\": [{\"x\": false}]")),
            "5 PK311");
  const std::string three =
      ",\n\"axes\": [{\"name\": \"a\"}, {\"name\": \"b\"}, {\"name\": \"c\"}],\n";
  EXPECT_EQ(error(kernel(three + R"("conflicts": [{"a": true, "b": true},
    {"a": true, "c": false}])")),
            "8 PK315");
  EXPECT_EQ(error(kernel(three + R"("exclude": [{"a": true, "b": true}])")), "5 PK316")
      << "there is nothing to switch on";
  EXPECT_EQ(error(kernel(three + R"("exclude": [{"a": true, "c": false}],
    "conflicts": [{"b": true, "c": true}])")),
            "5 PK316")
      << "a brings c, which conflicts with b";
  EXPECT_EQ(error(kernel(three + R"("exclude": [{"a": true, "b": false, "c": false}])")), "5 PK317")
      << "a with b or with c";
  EXPECT_EQ(
      error("{\n\"namespace\": \"a\",\n\"groups\": {\"g\": [\"L\"]},\n\"kernels\": [\n"
            "{\"name\": \"k\", \"file\": \"k.hlsl\", \"stage\": \"compute\", \"group\": \"g\"},\n"
            "{\"name\": \"k\", \"file\": \"k.hlsl\", \"stage\": \"compute\", \"group\": \"g\"}]}"),
      "6 PK307");
  EXPECT_EQ(error("{\n\"namespace\": \"a\",\n\"groups\": {\"g\": [\"L\"]},\n\"kernels\": [\n"
                  "{\"name\": \"k\",\n\"file\": \"none.hlsl\", \"stage\": \"compute\",\n"
                  "\"group\": \"g\"}]}"),
            "6 PK308");
  EXPECT_EQ(error("{\n\"namespace\": \"a\",\n\"groups\": {\"g\": [\"L\"]},\n\"kernels\": [\n"
                  "{\"name\": \"k\",\n\"file\": \"k.hlsl\", \"stage\": \"compute\",\n"
                  "\"group\": \"h\"}]}"),
            "7 PK309");
  std::string axes = ", \"axes\": [";
  for (int i = 0; i < 11; ++i)
    axes += (i > 0 ? ", " : "") + ("{\"name\": \"x" + std::to_string(i)) + "\"}";
  EXPECT_EQ(error(kernel(axes + "]")), "5 PK310");
}

TEST_F(ManifestTest, SaysThatItIsNotThere) {
  readManifest(folder_ / "none.json", diagnostics_);
  EXPECT_TRUE(diagnostics_.hasCode("PK300"));
}

StructMember member(const char* name, uint32_t components, uint32_t offset) {
  StructMember m;
  m.name = name;
  m.components = components;
  m.offset = offset;
  return m;
}

std::string codes(const StructLayout& layout) {
  Diagnostics diagnostics;
  EXPECT_FALSE(makeHostStruct(layout, {"a.hlsl", 3}, diagnostics).has_value());
  std::string text;
  for (const Diagnostic& d : diagnostics.sorted()) text += d.code;
  return text;
}

TEST(HostStruct, PadsToTheOffsetsAndTheSize) {
  StructLayout layout{
      "S", {member("g_a", 1, 0), member("g_b", 4, 16), member("c", 2, 40)}, 64, true};
  Diagnostics diagnostics;
  const auto host = makeHostStruct(layout, {"a.hlsl", 1}, diagnostics);
  ASSERT_TRUE(host) << diagnostics.format();
  ASSERT_EQ(host->fields.size(), 6u);
  EXPECT_EQ(host->fields[0].name, "a");
  EXPECT_TRUE(host->fields[1].isPadding);
  EXPECT_EQ(host->fields[1].size, 12u);
  EXPECT_EQ(host->fields[2].type, "Float4");
  EXPECT_EQ(host->fields[3].size, 8u);
  EXPECT_EQ(host->fields[4].type, "Float2");
  EXPECT_EQ(host->fields[5].size, 16u);
}

TEST(HostStruct, RefusesWhatCppOrTheOtherSideCannotExpress) {
  StructMember boolean = member("b", 1, 0);
  boolean.scalar = ScalarType::kBool;
  EXPECT_EQ(codes({"S", {boolean}, 16, true}), "PK602");
  StructMember matrix = member("m", 4, 0);
  matrix.columns = 4;
  EXPECT_EQ(codes({"S", {matrix}, 64, true}), "PK603");
  StructMember strided = member("a", 1, 0);
  strided.arraySize = 4;
  strided.arrayStride = 16;
  EXPECT_EQ(codes({"S", {strided}, 64, true}), "PK606");
  EXPECT_EQ(codes({"S", {member("v", 3, 0)}, 16, false}), "PK607");
  EXPECT_EQ(codes({"S", {member("a", 1, 0), member("v", 3, 4)}, 16, true}), "PK608");
  EXPECT_EQ(codes({"S", {member("g_v", 1, 0), member("v", 1, 4)}, 16, true}), "PK609");
  EXPECT_EQ(codes({"S", {member("register", 1, 0)}, 16, true}), "PK610");
  EXPECT_EQ(codes({"S", {member("a", 4, 0), member("b", 1, 8)}, 16, true}), "PK611");
}

class FrontEndTest : public testing::Test {
 protected:
  FrontEndOutput compile(const std::string& text) {
    (void)folder_.write("k.hlsl", text);
    FrontEndInput input;
    input.baseDir = folder_.path();
    input.file = "k.hlsl";
    input.entry = "k";
    return compileHlsl(input);
  }
  /// The module of a kernel that compiles; valid until the next one.
  SpirvReader moduleOf(const std::string& text) {
    output_ = compile(text);
    EXPECT_TRUE(output_.ok) << output_.log;
    return SpirvReader::parse(output_.spirv).value();
  }
  const TestFolder folder_;
  FrontEndOutput output_;
};

TEST_F(FrontEndTest, NamesFileAndLineOfAnErrorInAnInclude) {
  std::ofstream(folder_ / "inner.hlsli") << "\n\nfloat broken() { return nothing; }\n";
  const FrontEndOutput output =
      compile("#include \"inner.hlsli\"\n[numthreads(1, 1, 1)] void k() { broken(); }\n");
  EXPECT_FALSE(output.ok);
  ASSERT_FALSE(output.messages.empty());
  EXPECT_EQ(output.messages[0].file, "inner.hlsli");
  EXPECT_EQ(output.messages[0].line, 3u);
  EXPECT_EQ(output.files, (std::vector<std::string>{"k.hlsl", "inner.hlsli"}));
}

TEST_F(FrontEndTest, EndsAnIncludeThatIncludesItself) {
  std::ofstream(folder_ / "loop.hlsli") << "#include \"loop.hlsli\"\n";
  EXPECT_FALSE(compile("#include \"loop.hlsli\"\n[numthreads(1, 1, 1)] void k() {}\n").ok);
  IncludeScanner scanner(folder_.path(), {});
  EXPECT_EQ(scanner.closure("k.hlsl"), (std::vector<std::string>{"k.hlsl", "loop.hlsli"}));
}

TEST_F(FrontEndTest, KeepsStorageBuffersInTheirOwnClass) {
  const SpirvReader module = moduleOf(
      "RWStructuredBuffer<uint> g_x : register(u5, space1);\n"
      "[numthreads(4, 2, 1)] void k(uint3 id : SV_DispatchThreadID) { g_x[id.x] = 1; }\n");
  bool found = false;
  for (const SpirvInstruction& i : module.instructions()) {
    if (i.op == SpvOpVariable && module.name(i.result) == "g_x") {
      found = true;
      EXPECT_EQ(i.operands[0], static_cast<uint32_t>(SpvStorageClassStorageBuffer));
    }
  }
  EXPECT_TRUE(found);
  const ModuleReflection reflection = reflectModule(module);
  ASSERT_EQ(reflection.resources.size(), 1u);
  EXPECT_EQ(reflection.resources[0].registerClass, RegisterClass::kUav);
  EXPECT_EQ(reflection.resources[0].registerNumber, 5u);
  EXPECT_EQ(reflection.resources[0].space, 1u);
  EXPECT_EQ(reflection.groupSize[0], 4u);
  EXPECT_EQ(reflection.groupSize[1], 2u);
}

TEST_F(FrontEndTest, SeesResourcesWithoutARegister) {
  const SpirvReader module = moduleOf(
      "RWStructuredBuffer<uint> g_x;\n"
      "[numthreads(1, 1, 1)] void k(uint3 id : SV_DispatchThreadID) { g_x[id.x] = 1; }\n");
  const ModuleReflection reflection = reflectModule(module);
  ASSERT_EQ(reflection.resources.size(), 1u);
  EXPECT_FALSE(reflection.resources[0].hasRegister);
}

TEST_F(FrontEndTest, AddsUpGroupsharedMemory) {
  const SpirvReader module = moduleOf(
      "struct Tile { float3 a; float b; };\n"
      "groupshared float4 s_a[64];\ngroupshared Tile s_b[8];\n"
      "RWStructuredBuffer<float4> g_x : register(u0, space0);\n"
      "[numthreads(64, 1, 1)] void k(uint lane : SV_GroupIndex) {\n"
      "  s_a[lane] = g_x[lane]; s_b[lane & 7].b = 1.0; GroupMemoryBarrierWithGroupSync();\n"
      "  g_x[lane] = s_a[63 - lane] * s_b[0].b; }\n");
  EXPECT_EQ(reflectModule(module).sharedBytes, 64u * 16u + 8u * 16u);
}

TEST_F(FrontEndTest, DerivesAccessFromWhatIsDoneAndNotFromTheDeclaration) {
  const SpirvReader module = moduleOf(
      "RWStructuredBuffer<uint> g_read : register(u0, space0);\n"
      "RWStructuredBuffer<uint> g_write : register(u1, space0);\n"
      "RWStructuredBuffer<uint> g_atomic : register(u2, space0);\n"
      "RWTexture2D<float4> g_image : register(u3, space0);\n"
      "Texture2D<float4> g_texels : register(t0, space0);\n"
      "uint get(uint i) { return g_read[i]; }\n"
      "void put(uint i, uint v) { g_write[i] = v; }\n"
      "[numthreads(1, 1, 1)] void k(uint3 id : SV_DispatchThreadID) {\n"
      "  put(id.x, get(id.y));\n  InterlockedAdd(g_atomic[0], 1);\n"
      "  g_image[id.xy] = g_texels.Load(int3(id.xy, 0)); }\n");
  std::map<std::string, Access> found;
  for (const auto& [id, access] : resourceAccess(module)) found[module.name(id)] = access;
  EXPECT_EQ(found, (std::map<std::string, Access>{{"g_read", Access::kRead},
                                                  {"g_write", Access::kWrite},
                                                  {"g_atomic", Access::kReadWrite},
                                                  {"g_image", Access::kWrite},
                                                  {"g_texels", Access::kRead}}));
}

TEST_F(FrontEndTest, RefusesATextureThatIsReadThroughTwoSamplers) {
  const FrontEndOutput output = compile(
      "Texture2D<float4> g_t : register(t0, space0);\n"
      "SamplerState g_s : register(s0, space0);\nSamplerState g_r : register(s1, space0);\n"
      "RWStructuredBuffer<float4> g_x : register(u0, space0);\n"
      "[numthreads(1, 1, 1)] void k(uint3 id : SV_DispatchThreadID) {\n"
      "  g_x[id.x] = g_t.SampleLevel(g_s, float2(0, 0), 0) + g_t.SampleLevel(g_r, float2(0, 0), "
      "0); }\n");
  ASSERT_TRUE(output.ok) << output.log;
  BackEndInput input;
  input.rawSpirv = output.spirv;
  input.entry = "k";
  input.patches = {{0, RegisterBase::kTexture, 0, 0, ResourceKind::kSampledTexture},
                   {0, RegisterBase::kUav, 1, 0, ResourceKind::kStorageBuffer},
                   {0, RegisterBase::kSampler, 2, 0, ResourceKind::kSampler},
                   {0, RegisterBase::kSampler + 1, 3, 0, ResourceKind::kSampler}};
  const BackEndOutput result = runBackEnd(input);
  ASSERT_EQ(result.errors.size(), 1u);
  EXPECT_EQ(result.errors[0].code, "PK406");
}

TEST(SpirvReader, RefusesWhatIsNoModule) {
  EXPECT_FALSE(SpirvReader::parse({}));
  const uint32_t header[] = {SpvMagicNumber, 0x10300, 0, 1, 0};
  EXPECT_TRUE(SpirvReader::parse(header));
  const uint32_t cut[] = {SpvMagicNumber, 0x10300, 0, 1, 0, 5u << 16 | SpvOpName};
  EXPECT_FALSE(SpirvReader::parse(cut));
  const uint32_t endless[] = {SpvMagicNumber, 0x10300, 0, 1, 0, SpvOpNop};
  EXPECT_FALSE(SpirvReader::parse(endless));
}

}  // namespace
}  // namespace pelage::codegen
