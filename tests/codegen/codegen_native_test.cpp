// Kernels for Metal and for shader model 6. No compiler of either is here: their texts, slots and
// registers are checked.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <tuple>

#include "pelage/metal_kernel.h"
#include "test_project.h"

namespace pelage::codegen::test {
namespace {

using pelage::test::expectHas;
namespace fs = std::filesystem;

using Value = nlohmann::json;

constexpr const char* kTables[] = {"buffer", "texture", "sampler"};

// The sanitizers see as much of codegen in a few kernels.
#if defined(__SANITIZE_ADDRESS__)
constexpr const char* kKernels = PELAGE_CODEGEN_TEST_DIR "/kernels";
constexpr const char* kReflection = PELAGE_FIXTURE_REFLECTION;
constexpr const char* kMetalHeader = "fixture/gpu/metal.h";
constexpr size_t kLeastVariants = 10;
#else
constexpr const char* kKernels = PELAGE_CODEGEN_TEST_DIR "/../../kernels";
constexpr const char* kReflection = PELAGE_KERNELS_REFLECTION;
constexpr const char* kMetalHeader = "pelage/metal.h";
constexpr size_t kLeastVariants = 100;
#endif

/// All kernels of pelage, once for all tests. Their code comes from the cache of the build.
struct Native {
  TestProject project;
  BuildResult result;
  std::map<std::string, std::string> files;
  Value reflection;

  explicit Native(unsigned jobs) {
    BuildOptions options = project.options();
    options.manifest = std::string(kKernels) + "/manifest.json";
    options.cacheDir = PELAGE_KERNELS_CACHE;
    options.tool = PELAGE_KERNELS_TOOL;
    options.jobs = jobs;
    options.msl = options.hlsl = true;
    result = build(options);
    files = project.outputs();
    reflection = Value::parse(files["reflection.json"], nullptr, false);
  }
  template <class Visit>
  void forEachVariant(const Visit& visit) const {
    size_t count = 0;
    for (const Value& kernel : reflection.at("kernels")) {
      for (const Value& variant : kernel.at("variants")) {
        SCOPED_TRACE(kernel.at("name").get<std::string>() + ' ' +
                     variant.at("keys")[0].get<std::string>());
        visit(kernel, variant);
        ++count;
      }
    }
    EXPECT_GT(count, kLeastVariants);
  }
  const Value& entry(const Value& kernel, const Value& use) const {
    const std::string layoutName = kernel.at("layouts")[use.at("set").get<size_t>()];
    for (const Value& layout : reflection.at("layouts"))
      if (layout.at("name") == layoutName)
        return layout.at("entries")[use.at("entry").get<size_t>()];
    throw std::out_of_range(layoutName);
  }
};

const Native& native() {
  static const Native once(1);
  return once;
}

using Slots = std::set<std::pair<std::string, uint32_t>>;

// The head of the only function that is an entry point; short, unlike the text.
std::string headOf(const std::string& msl) {
  std::istringstream lines(msl);
  std::string head;
  for (std::string line; std::getline(lines, line);) {
    // Helpers begin with an attribute of their own.
    if (line.find("[[", 1) == std::string::npos || line.back() != ')') continue;
    EXPECT_EQ(head, "");
    head = std::move(line);
  }
  return head;
}

// The slots that the MSL itself names, each once.
Slots slotsIn(const std::string& msl) {
  static const std::regex pattern(R"(\[\[(buffer|texture|sampler)\((\d+)\)\]\])");
  Slots slots;
  const std::string head = headOf(msl);
  for (std::sregex_iterator it(head.begin(), head.end(), pattern), end; it != end; ++it)
    EXPECT_TRUE(slots.emplace((*it)[1], std::stoul((*it)[2])).second) << it->str() << " twice";
  return slots;
}

TEST(CodegenNative, GivesMetalASlotForEachBindingWithinItsLimits) {
  ASSERT_TRUE(native().result.ok) << native().result.diagnostics.format();
  native().forEachVariant([](const Value& kernel, const Value& variant) {
    const Value& metal = variant.at("metal");
    const std::string& msl = native().files.at("msl/" + metal.at("file").get<std::string>());
    const std::string head = headOf(msl);
    Slots slots, vertexSlots;
    std::set<std::pair<uint32_t, uint32_t>> bound, used;
    for (const Value& use : variant.at("bindings")) used.emplace(use.at("set"), use.at("entry"));
    for (const Value& b : metal.at("bindings")) {
      const std::string table = b.at("table");
      const uint32_t slot = b.at("slot");
      const Value& entry = native().entry(kernel, b);
      EXPECT_TRUE(bound.emplace(b.at("set"), b.at("entry")).second);
      EXPECT_TRUE(slots.emplace(table, slot).second) << table << slot << " twice";
      const bool isBlock = entry.at("kind") == "uniformBuffer";
      EXPECT_EQ(b.at("bytes"), isBlock ? entry.at("stride") : Value(0)) << entry;
      // The argument with this slot is this resource. A block has its name as a type.
      const std::string name = entry.at("name").get<std::string>() + R"((_\d+)?)";
      const std::regex argument((isBlock ? "[( ]" + name + R"(& \w+)" : " " + name) + R"( \[\[)" +
                                table + R"(\()" + std::to_string(slot) + R"(\)\]\])");
      EXPECT_TRUE(std::regex_search(head, argument)) << name << ' ' << slot << '\n' << head;
    }
    EXPECT_EQ(bound, used);
    if (!metal.at("sizes").is_null()) {
      EXPECT_TRUE(slots.emplace("buffer", metal.at("sizes")).second);
    }
    EXPECT_EQ(slotsIn(msl), slots);
    EXPECT_EQ(metal.at("vertexBuffer").is_null(), !kernel.contains("vertexInput"));
    if (kernel.contains("vertexInput")) {
      const Value& input = kernel.at("vertexInput");
      for (const Value& attribute : input.at("attributes")) {
        const uint32_t element =
            attribute.at("offset").get<uint32_t>() / input.at("stride").get<uint32_t>();
        const uint32_t slot = metal.at("vertexBuffer").get<uint32_t>() + element;
        vertexSlots.emplace("buffer", slot);
        EXPECT_FALSE(slots.contains({"buffer", slot}));
      }
      slots.merge(vertexSlots);
    }
    for (const auto& [table, slot] : slots) {
      const size_t index = std::find(kTables, kTables + 3, table) - kTables;
      EXPECT_LT(slot, kMetalLimits.slots[index]);
    }
    if (kernel.at("stage") == "compute") {
      const Value& size = variant.at("groupSize");
      EXPECT_LE(size[0].get<uint32_t>() * size[1].get<uint32_t>() * size[2].get<uint32_t>(),
                kMetalLimits.threads);
      EXPECT_LE(variant.at("sharedBytes").get<uint32_t>(), kMetalLimits.threadgroupBytes);
    }
  });
}

TEST(CodegenNative, WritesMslWithOneEntryPointAndBalancedBrackets) {
  native().forEachVariant([](const Value& kernel, const Value& variant) {
    const Value& metal = variant.at("metal");
    const std::string& msl = native().files.at("msl/" + metal.at("file").get<std::string>());
    const std::string stage = kernel.at("stage");
    const char* word = stage == "compute" ? "kernel" : stage == "vertex" ? "vertex" : "fragment";
    const std::string name = metal.at("function");
    const std::string head = headOf(msl);
    expectHas(" " + head, std::string(" ") + word + " ");
    expectHas(head, " " + name + "(");
    EXPECT_EQ(metal.at("function"), kernel.at("name"));
    std::string open;
    for (const char c : msl) {
      const size_t closes = std::string_view(")]}").find(c);
      if (c == '(' || c == '[' || c == '{') open += c;
      if (closes == std::string_view::npos) continue;
      ASSERT_FALSE(open.empty());
      ASSERT_EQ(open.back(), "([{"[closes]);
      open.pop_back();
    }
    EXPECT_EQ(open, "");
  });
}

TEST(CodegenNative, NamesRegistersWithoutDuplicatesForEveryPermutation) {
  std::set<std::string> outputs;
  const std::string lines = "\n" + native().files.at("dxc.txt");
  native().forEachVariant([&](const Value& kernel, const Value& variant) {
    const Value& hlsl = variant.at("hlsl");
    std::map<std::tuple<std::string, uint32_t>, std::string> registers;
    for (const Value& r : hlsl.at("registers")) {
      const auto [at, added] = registers.emplace(
          std::tuple(r.at("register").get<std::string>(), r.at("space").get<uint32_t>()),
          r.at("name").get<std::string>());
      EXPECT_TRUE(added) << r << " and " << at->second;
    }
    // Registers include all resources that are left after optimization, as the layout has them.
    for (const Value& use : variant.at("bindings")) {
      const Value& entry = native().entry(kernel, use);
      EXPECT_EQ((registers[{entry.at("register").get<std::string>(), use.at("set")}]),
                entry.at("name"));
    }
    EXPECT_TRUE(fs::exists(fs::path(kKernels) / hlsl.at("file").get<std::string>()));
    std::string line = "\n-T " + hlsl.at("profile").get<std::string>() + " -E " +
                       hlsl.at("entry").get<std::string>() + " -HV 2018";
    if (kernel.at("precise").get<bool>()) line += " -Gis";
    for (const Value& define : hlsl.at("defines")) line += " -D " + define.get<std::string>();
    EXPECT_TRUE(outputs.insert(line).second) << line;
    expectHas(lines, line + " -I . -Fo ");
  });
}

TEST(CodegenNative, WritesTheSameBytesInAnyOrderAndNothingUnasked) {
  const Native again(4);
  EXPECT_TRUE(native().files == again.files);
  // Without the options the reflection is what it was.
  Value stripped = native().reflection;
  for (Value& kernel : stripped.at("kernels"))
    for (Value& variant : kernel.at("variants")) {
      variant.erase("metal");
      variant.erase("hlsl");
    }
  EXPECT_EQ(stripped, Value::parse(fileText(kReflection)));
}

TEST(CodegenNative, WritesAHeaderThatCompiles) {
  const Native& all = native();
  const Value& kernel = all.reflection.at("kernels")[0];
  const Value& variant = kernel.at("variants")[0];
  const Value& metal = variant.at("metal");
  const std::string hash = "0x" + variant.at("hash").get<std::string>() + "ull";
  const std::string table = all.reflection.at("namespace").get<std::string>() + "::kMetalKernels";
  all.project.write(
      "use.cpp", "#include \"" + (all.project.output() / "include" / kMetalHeader).string() +
                     "\"\n#include <string_view>\n"
                     "constexpr auto* k = pelage::findMetalKernel(" +
                     table + ", " + hash +
                     ");\nstatic_assert(k && k->function == std::string_view(\"" +
                     metal.at("function").get<std::string>() +
                     "\") && k->bindings.size() == " + std::to_string(metal.at("bindings").size()) +
                     " && k->threads[0] == " + variant.at("groupSize")[0].dump() +
                     " && k->bindings[0].bytes == " + metal.at("bindings")[0].at("bytes").dump() +
                     ");\nstatic_assert(!pelage::findMetalKernel(" + table + ", 1));\n");
  const pelage::test::ProgramOutput ran = pelage::test::runIn(
      all.project.folder() / "src",
      PELAGE_CXX " -std=c++20 -fsyntax-only -I " PELAGE_CODEGEN_TEST_DIR "/../../include use.cpp");
  EXPECT_EQ(ran.code, 0) << ran.errors;
}

std::string metalMessages(const std::string& hlsl) {
  const TestProject project;
  project.write("manifest.json", manifestWith(computeKernel("some", ", \"tier\": \"wide\"")));
  project.write("some.hlsl", hlsl);
  BuildOptions options = project.options();
  options.msl = true;
  return build(options).diagnostics.format();
}

// A kernel that sums up terms, each of a resource N with a register of its own.
std::string kernelReading(uint32_t count, const std::string& type, char letter,
                          const std::string& term, uint32_t threads = 64) {
  std::string text =
      "RWStructuredBuffer<float> g_out : register(u99, space0);\n"
      "Texture2D<float> g_map : register(t98, space0);\n";
  std::string sum = "0.0";
  for (uint32_t i = 0; i < count; ++i) {
    const std::string n = std::to_string(i), name = "g_in" + n;
    text += type + " " + name + " : register(" + letter + n + ", space0);\n";
    sum += " + " + std::regex_replace(term, std::regex("N"), name);
  }
  return text + "[numthreads(" + std::to_string(threads) +
         ", 1, 1)]\nvoid some(uint i : SV_GroupIndex) { g_out[i] = " + sum + "; }\n";
}

TEST(CodegenNative, RefusesWhatMetalHasTooLittleOf) {
  const auto buffers = [](uint32_t count) {
    return metalMessages(kernelReading(count, "StructuredBuffer<float>", 't', "N[i]"));
  };
  expectHas(buffers(31),
            "some.hlsl:35: error: [PK415] kernel 'some' has no buffer slot for 'g_out'"
            ": Metal has 31");
  EXPECT_EQ(buffers(30).find("PK415"), std::string::npos);
  expectHas(metalMessages(kernelReading(17, "SamplerState", 's',
                                        "g_map.SampleLevel(N, float2(0.5, 0.5), 0.0)")),
            "has no sampler slot for 'g_in16': Metal has 16");
  expectHas(metalMessages(kernelReading(1, "StructuredBuffer<float>", 't', "N[i]", 1025)),
            "kernel 'some' has 1025 threads in a group, Metal has 1024");
}

TEST(CodegenNative, GivesTheSizesOfBuffersASlotOnlyWhereTheyAreAskedFor) {
  const TestProject project;
  project.write("manifest.json",
                manifestWith(computeKernel("some", R"(, "axes": [{"name": "ask"}])")));
  project.write("some.hlsl",
                "RWStructuredBuffer<uint> g_out : register(u0, space1);\n[numthreads(64, 1, 1)]\n"
                "void some(uint i : SV_GroupIndex) {\n  uint count = 1u, stride = 0u;\n"
                "#if ASK\n  g_out.GetDimensions(count, stride);\n#endif\n  g_out[i] = count;\n}\n");
  BuildOptions options = project.options();
  options.msl = options.hlsl = true;
  options.includeDirs = {"/elsewhere"};
  const BuildResult result = build(options);
  ASSERT_TRUE(result.ok) << result.diagnostics.format();
  const auto& variants = result.program.kernels[0].variants;
  expectHas(project.outputs()["dxc.txt"], " -D ASK=1 -I . -I /elsewhere -Fo some_");
  EXPECT_EQ(variants[0].msl.sizes, MetalKernel::kNone);
  EXPECT_EQ(variants[1].msl.sizes, 1);
  EXPECT_EQ(slotsIn(variants[1].msl.source), (Slots{{"buffer", 0}, {"buffer", 1}}));
}

// Another front end would replace one file: docs/decisions/0018-front-end.md.
TEST(CodegenNative, OnlyTheFrontEndIncludesGlslang) {
  std::set<std::string> users;
  for (const char* folder : {"codegen", "tools", "runtime", "include"})
    for (const auto& file :
         fs::recursive_directory_iterator(fs::path(PELAGE_CODEGEN_TEST_DIR) / "../.." / folder))
      if (file.is_regular_file() && fileText(file.path()).find("<glslang/") != std::string::npos)
        users.insert(file.path().filename().string());
  EXPECT_EQ(users, std::set<std::string>{"front_end.cpp"});
}

}  // namespace
}  // namespace pelage::codegen::test
