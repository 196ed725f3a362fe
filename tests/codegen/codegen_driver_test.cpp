// The driver from the outside: what it writes, what it says, what it compiles again.
#include "codegen/driver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "test_project.h"

namespace pelage::codegen::test {
namespace {

using pelage::test::expectHas;

namespace fs = std::filesystem;

const fs::path kFixture = fs::path(PELAGE_CODEGEN_TEST_DIR) / "kernels";

constexpr const char* kGoodKernel = R"(
RWStructuredBuffer<float4> g_data : register(u0, space0);
[numthreads(64, 1, 1)]
void good(uint3 id : SV_DispatchThreadID) { g_data[id.x] = g_data[id.x] * 2.0; }
)";

// The one diagnostic with this code; fails the test when there is none.
Diagnostic only(const BuildResult& result, const std::string& code) {
  std::vector<Diagnostic> found;
  for (const Diagnostic& d : result.diagnostics.sorted()) {
    if (d.code == code) found.push_back(d);
  }
  EXPECT_EQ(found.size(), 1u) << code << " in:\n" << result.diagnostics.format();
  return found.empty() ? Diagnostic{} : found.front();
}

void expectSays(const BuildResult& result, std::string_view text) {
  expectHas(result.diagnostics.format(), text);
}

void expectRefused(const BuildResult& result, std::initializer_list<std::string_view> words) {
  EXPECT_FALSE(result.ok);
  for (const std::string_view text : words) expectSays(result, text);
}

/// The fixture, built with an empty cache: once for all tests.
struct Built {
  TestProject project;
  BuildResult result;
  Built() {
    project.copy(kFixture);
    result = project.build();
  }
  /// Another project with the fixture and with this one's cache.
  void copyTo(const TestProject& other) const {
    other.copy(kFixture);
    fs::create_directories(other.output());
    fs::copy(project.output() / "cache", other.output() / "cache");
  }
};

const Built& built() {
  static const Built once;
  return once;
}

pelage::test::ProgramOutput runTool(const TestProject& project, const std::string& arguments) {
  return pelage::test::runIn(project.folder(), std::string(PELAGE_CODEGEN_TOOL) + " " + arguments);
}

TEST(CodegenDriver, WritesTheSameBytesFromAnotherFolderAndAnEmptyCache) {
  const TestProject& first = built().project;
  const TestProject second;
  second.copy(kFixture);
  BuildOptions sequential = second.options();
  sequential.jobs = 1;
  const BuildResult& one = built().result;
  const BuildResult two = build(sequential);
  ASSERT_TRUE(one.ok) << one.diagnostics.format();
  ASSERT_TRUE(two.ok) << two.diagnostics.format();
  EXPECT_EQ(one.compiled, one.permutations);
  EXPECT_EQ(two.compiled, two.permutations);
  const auto outputs = first.outputs();
  // Nine headers, two tables, the reflection, four lists, and the code of each kernel in three
  // formats.
  EXPECT_EQ(outputs.size(), 9u + 2 + 1 + 4 + 3 * one.program.kernels.size());
  EXPECT_EQ(outputs, second.outputs());
  for (const auto& [name, text] : outputs) {
    EXPECT_EQ(text.find(first.folder().string()), std::string::npos) << name;
  }
}

TEST(CodegenDriver, CompilesNothingTheSecondTimeAndLeavesTheFilesAlone) {
  const TestProject project;
  built().copyTo(project);
  const BuildResult first = project.build();
  ASSERT_TRUE(first.ok) << first.diagnostics.format();
  EXPECT_EQ(first.compiled, 0u) << "in another folder";
  const auto outputs = project.outputs();
  const auto time = fs::last_write_time(project.output() / "kernels.cpp");
  const BuildResult second = project.build();
  ASSERT_TRUE(second.ok) << second.diagnostics.format();
  EXPECT_EQ(second.compiled, 0u);
  EXPECT_EQ(second.fromCache, second.permutations);
  EXPECT_EQ(second.summary(),
            "pelage-codegen: 13 permutations, 0 compiled, 13 from cache, 12 distinct");
  EXPECT_EQ(project.outputs(), outputs);
  EXPECT_EQ(fs::last_write_time(project.output() / "kernels.cpp"), time);
}

TEST(CodegenDriver, RecompilesJustTheUsersOfAChangedInclude) {
  const TestProject project;
  built().copyTo(project);
  project.write("shared/forces.hlsli", fileText(kFixture / "shared/forces.hlsli") + "// changed\n");
  const BuildResult result = project.build();
  ASSERT_TRUE(result.ok) << result.diagnostics.format();
  EXPECT_EQ(result.compiled, 9u) << "the permutations of move_particles and no others";
}

// A project of one kernel that includes limits.hlsli, with the constants of these files.
void writeLimits(const TestProject& project, const std::string& files, const std::string& limits) {
  project.write("manifest.json",
                "{\"namespace\": \"fixture\", \"groups\": {\"g\": [\"First\", \"Second\"]},\n"
                "\"constants\": [" +
                    files + "],\n\"kernels\": [" + computeKernel("good") + "]}\n");
  project.write("good.hlsl", "#include \"limits.hlsli\"\n" + std::string(kGoodKernel));
  project.write("limits.hlsli", limits);
}

std::string constantsHeaderOf(const TestProject& project) {
  return fileText(project.output() / "include/fixture/constants.h");
}

TEST(CodegenDriver, GivesTheHostTheValuesThatTheCompilerFinds) {
  const TestProject project;
  project.write("base.hlsli", "static const uint kBase = 7;\n");
  writeLimits(project, "\"limits.hlsli\"",
              "#include \"base.hlsli\"\n"
              "cbuffer LimitConstants : register(b0, space1) { uint g_unused; };\n"
              "static const uint kTop = 0x80000000u, kFour = 4;\n"
              "static const uint kMixed = (kTop >> 3) | kBase;  // 2^28 and 7\n"
              "static const int kNegative = -3 * 2;\n"
              "static const float kShare = 1.5 / 65535.0;\n"
              "static const float kOne = 1;\n"
              "#if WIND\nstatic const uint kWind = 1;\n#endif\n"
              "uint local() { static const uint kLocal = 3; return kLocal; }\n");
  const BuildResult result = project.build();
  ASSERT_TRUE(result.ok) << result.diagnostics.format();
  // The constants of the file itself, and of no axis.
  expectHas(constantsHeaderOf(project),
            "namespace fixture::limits {\n\n"
            "inline constexpr uint32_t kTop = 2147483648u;\n"
            "inline constexpr uint32_t kFour = 4u;\n"
            "inline constexpr uint32_t kMixed = 268435463u;\n"
            "inline constexpr int32_t kNegative = -6;\n"
            "inline constexpr float kShare = 2.2888533e-05f;\n"
            "inline constexpr float kOne = 1.0f;\n\n"
            "}  // namespace fixture::limits\n");
}

TEST(CodegenDriver, ChangesTheHeaderWithAConstantThatAFileIncludes) {
  const TestProject project;
  project.write("base.hlsli", "static const uint kBase = 7;\n");
  writeLimits(project, "\"limits.hlsli\"",
              "#include \"base.hlsli\"\nstatic const uint kTwice = 2 * kBase;\n");
  ASSERT_TRUE(project.build().ok);
  expectHas(constantsHeaderOf(project), "kTwice = 14u;");
  project.write("base.hlsli", "static const uint kBase = 8;\n");
  BuildOptions options = project.options();
  options.stampFile = project.folder() / "done";
  options.depFile = project.folder() / "done.d";
  ASSERT_TRUE(build(options).ok);
  expectHas(constantsHeaderOf(project), "kTwice = 16u;");
  expectHas(fileText(options.depFile), "base.hlsli");
}

// "line code" of each error in the constants of these files.
std::string errorsInLimits(const std::string& files, const std::string& limits) {
  const TestProject project;
  project.write("more/limits.hlsli", "static const uint kMore = 1;\n");
  project.write("none.hlsli", "const uint kBlockMember = 1;\n");
  writeLimits(project, files, limits);
  std::string text;
  for (const Diagnostic& d : project.build().diagnostics.sorted()) {
    if (d.isError && d.file.find("good.hlsl") == std::string::npos)
      text += std::to_string(d.line) + " " + d.code + "\n";
  }
  return text;
}

TEST(CodegenDriver, RefusesConstantsThatTheHostCannotHave) {
  const std::string file = "\"limits.hlsli\"";
  const std::string fine = "static const uint kFine = 1;\n";
  EXPECT_EQ(errorsInLimits(file, fine), "");
  EXPECT_EQ(errorsInLimits(file,
                           "static const float3 kVector = float3(1, 2, 3);\n"
                           "static const uint kTable[2] = {1, 2};\n"
                           "static const bool kYes = true;\n"
                           "static const uint constexpr = 2;\n"),
            "1 PK510\n2 PK510\n3 PK510\n4 PK510\n");
  EXPECT_EQ(errorsInLimits(file, "cbuffer C : register(b0, space1) { float g_c; };\n" + fine +
                                     "static const float kAtRunTime = g_c * 2.0;\n"
                                     "static const float kInfinite = 1.0 / 0.0;\n"),
            "3 PK511\n4 PK511\n");
  EXPECT_EQ(errorsInLimits("\"none.hlsli\"", fine), "1 PK512\n");
  EXPECT_EQ(errorsInLimits("\"gone.hlsli\"", fine), "2 PK308\n");
  EXPECT_EQ(errorsInLimits(file + ", " + file, fine), "2 PK318\n");
  EXPECT_EQ(errorsInLimits(file + ", \"more/limits.hlsli\"", fine), "2 PK318\n");
  EXPECT_EQ(errorsInLimits(file, "static const uint kSum = kNothing + 1;\n"), "1 PK400\n");
}

TEST(CodegenDriver, MakesADamagedCacheEntryAgain) {
  const TestProject project;
  built().copyTo(project);
  const auto outputs = built().project.outputs();
  for (const fs::directory_entry& entry : fs::directory_iterator(project.output() / "cache")) {
    std::fstream stream(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
    stream.seekp(200);
    stream.put('\x7f');
    stream.put('\x01');
  }
  const BuildResult result = project.build();
  ASSERT_TRUE(result.ok) << result.diagnostics.format();
  EXPECT_EQ(result.compiled, result.permutations);
  EXPECT_EQ(project.outputs(), outputs);
}

TEST(CodegenDriver, ReportsTheErrorsOfAllKernelsAtOnceAndWritesNothing) {
  const TestProject project;
  project.write("manifest.json",
                manifestWith(computeKernel("good") + ",\n" + computeKernel("syntax") + ",\n" +
                             computeKernel("undeclared") + ",\n" + computeKernel("missing")));
  project.write("good.hlsl", kGoodKernel);
  project.write("syntax.hlsl", "[numthreads(1, 1, 1)]\nvoid syntax() {\n  int x = ;\n}\n");
  project.write("undeclared.hlsl",
                "RWStructuredBuffer<float> g_other : register(u1, space0);\n"
                "[numthreads(1, 1, 1)]\nvoid undeclared() {\n  g_other[0] = first;\n"
                "  g_other[1] = second;\n}\n");
  const BuildResult result = project.build();
  expectRefused(
      result,
      {"src/syntax.hlsl:3: error: [PK400] ", "src/undeclared.hlsl:4: error: [PK400] 'first'",
       "src/undeclared.hlsl:5: error: [PK400] 'second'", "src/manifest.json:8: error: [PK308] "});
  EXPECT_EQ(result.diagnostics.format().find("good.hlsl"), std::string::npos);
  EXPECT_TRUE(project.outputs().empty());
}

TEST(CodegenDriver, FindsEveryErrorOfAKernelAndNoneThatFollowsFromAnother) {
  const TestProject project;
  project.write("manifest.json", manifestWith(computeKernel("many")));
  project.write("many.hlsl", R"(RWStructuredBuffer<float> g_x : register(u0, space0);
float twice(float v) { return v * missing1; }
[numthreads(64, 1, 1)]
void many(uint3 id : SV_DispatchThreadID) {
  float a = missing2;
  a += 1.0;
  if (missing3 > a) {
    g_x[0] = a;
  } else {
    g_x[1] = missing4;
  }
  if (a > 2.0) g_x[2] = missing5; else g_x[2] = a;
  for (uint i = 0; i < missing6; ++i) {
    g_x[i] = twice(a, missing7);
  }
  g_x[3] = a;
}
)");
  const BuildResult result = project.build();
  const std::vector<Diagnostic> errors = result.diagnostics.sorted();
  std::vector<uint32_t> lines;
  for (const Diagnostic& error : errors) {
    lines.push_back(error.line);
    EXPECT_EQ(error.code, "PK400");
  }
  EXPECT_EQ(lines, (std::vector<uint32_t>{2, 5, 7, 10, 12, 13, 14})) << result.diagnostics.format();
}

TEST(CodegenDriver, NamesThePermutationOfAnErrorThatNotAllHave) {
  const TestProject project;
  project.write("manifest.json",
                manifestWith(computeKernel("good", R"(, "axes": [{"name": "a"}, {"name": "b"}])")));
  project.write("good.hlsl", std::string("#if A && B\n#error together\n#endif\n") + kGoodKernel);
  expectRefused(project.build(), {"good.hlsl:2: error: [PK400]", "(kernel 'good' with a=1 b=1)"});
}

TEST(CodegenDriver, SurvivesACrashOfTheFrontEndAndCompilesTheOthers) {
  const TestProject project;
  project.write("manifest.json",
                manifestWith(computeKernel("crash") + ",\n" + computeKernel("spec") + ",\n" +
                             computeKernel("good")));
  project.write("good.hlsl", kGoodKernel);
  // Deeper than any parser's stack.
  project.write("crash.hlsl",
                "RWStructuredBuffer<float> g_x : register(u1, space0);\n"
                "[numthreads(1, 1, 1)]\nvoid crash() { g_x[0] = " +
                    std::string(200000, '(') + "1.0" + std::string(200000, ')') + "; }\n");
  project.write("spec.hlsl",
                "[[vk::constant_id(0)]] const uint g_size = 64;\n"
                "RWStructuredBuffer<float> g_y : register(u2, space0);\n"
                "[numthreads(g_size, 1, 1)]\nvoid spec() { g_y[0] = 1.0; }\n");
  const BuildResult result = project.build();
  EXPECT_FALSE(result.ok);
  const Diagnostic crash = only(result, "PK411");
  EXPECT_TRUE(crash.file.ends_with("crash.hlsl"));
  EXPECT_EQ(crash.line, 1u);
  expectHas(crash.message, "'crash'");
  // The sanitizers turn the signal into words of their own.
  EXPECT_TRUE(crash.message.find("signal 11") != std::string::npos ||
              crash.message.find("DEADLYSIGNAL") != std::string::npos)
      << crash.message;
  expectSays(result, "spec.hlsl:3: error: ");
  EXPECT_EQ(result.diagnostics.format().find("good.hlsl"), std::string::npos);
  ASSERT_EQ(result.program.kernels.size(), 3u);
  EXPECT_EQ(result.program.kernels[2].variants.size(), 1u) << "good was compiled all the same";
}

// All kernels go through one child, one after the other.
TEST(CodegenDriver, BlamesEveryCrashOfASharedChildOnItsKernelAlone) {
  const std::string deep = std::string(200000, '(') + "1.0" + std::string(200000, ')');
  const auto kernel = [](const std::string& name, const std::string& value) {
    return "RWStructuredBuffer<float> g_x : register(u1, space0);\n"
           "[numthreads(1, 1, 1)]\nvoid " +
           name + "() { g_x[0] = " + value + "; }\n";
  };
  const TestProject project;
  project.write("manifest.json",
                manifestWith(computeKernel("before") + ",\n" + computeKernel("crash_a") + ",\n" +
                             computeKernel("between") + ",\n" + computeKernel("crash_b") + ",\n" +
                             computeKernel("wrong") + ",\n" + computeKernel("after")));
  for (const std::string name : {"before", "between", "after"})
    project.write(name + ".hlsl", kernel(name, "1.0"));
  for (const std::string name : {"crash_a", "crash_b"})
    project.write(name + ".hlsl", kernel(name, deep));
  project.write("wrong.hlsl", kernel("wrong", "undeclared"));
  BuildOptions options = project.options();
  options.jobs = 1;
  const BuildResult result = build(options);
  EXPECT_FALSE(result.ok);
  std::vector<std::string> crashed;
  for (const Diagnostic& d : result.diagnostics.sorted()) {
    if (d.code == "PK411") crashed.push_back(fs::path(d.file).filename());
  }
  EXPECT_EQ(crashed, (std::vector<std::string>{"crash_a.hlsl", "crash_b.hlsl"}))
      << result.diagnostics.format();
  expectSays(result, "wrong.hlsl:3: error: [PK400]");
  ASSERT_EQ(result.program.kernels.size(), 6u);
  for (const size_t good : {0, 2, 5})
    EXPECT_EQ(result.program.kernels[good].variants.size(), 1u) << good;
}

TEST(CodegenDriver, EndsAKernelThatTakesTooLong) {
  const TestProject project;
  project.write("manifest.json", manifestWith(computeKernel("good")));
  project.write("good.hlsl", kGoodKernel);
  BuildOptions options = project.options();
  options.timeout = std::chrono::seconds(0);
  const BuildResult result = build(options);
  EXPECT_FALSE(result.ok);
  expectHas(only(result, "PK411").message, "did not finish");
}

// The good kernel beside one that writes a resource of this name and slot.
BuildResult buildBeside(const std::string& name, const std::string& slot) {
  const TestProject project;
  project.write("manifest.json",
                manifestWith(computeKernel("good") + ",\n" + computeKernel("other")));
  project.write("good.hlsl", kGoodKernel);
  project.write("other.hlsl", "RWStructuredBuffer<float4> " + name + " : register(" + slot +
                                  ");\n[numthreads(1, 1, 1)]\nvoid other() { " + name +
                                  "[0] = float4(1, 1, 1, 1); }\n");
  return project.build();
}

TEST(CodegenDriver, RefusesTwoResourcesInOneSlotAndNamesBothLines) {
  const BuildResult result = buildBeside("g_else", "u0, space0");
  expectSays(result,
             "src/good.hlsl:2: error: [PK504] 'g_data' and 'g_else' (other.hlsl:1) both "
             "are register(u0, space0)");
  expectSays(result, "src/other.hlsl:1: error: [PK504] 'g_else' and 'g_data' (good.hlsl:2)");
}

TEST(CodegenDriver, RefusesOneResourceInTwoSlotsAndNamesBothLines) {
  const BuildResult result = buildBeside("g_data", "u1, space1");
  expectSays(result,
             "src/good.hlsl:2: error: [PK505] 'g_data' is register(u0, space0) here and "
             "register(u1, space1) at other.hlsl:1");
  expectSays(result, "src/other.hlsl:1: error: [PK505]");
}

// A kernel that reads `count` storage buffers, registers t0 to t(count - 1).
std::string readingKernel(const std::string& name, Stage stage, int count, int first = 0) {
  std::string text, sum = "0.0";
  for (int i = first; i < first + count; ++i) {
    const std::string number = std::to_string(i);
    text += "StructuredBuffer<float4> g_b" + number + " : register(t" + number + ", space0);\n";
    sum += " + g_b" + number + "[i]";
  }
  if (stage == Stage::kCompute) {
    return text + "RWStructuredBuffer<float4> g_sum : register(u0, space0);\n" +
           "[numthreads(64, 1, 1)]\nvoid " + name + "(uint3 id : SV_DispatchThreadID) {\n" +
           "  const uint i = id.x;\n  g_sum[i] = " + sum + ";\n}\n";
  }
  if (stage == Stage::kVertex) {
    return text + "float4 " + name + "(uint i : SV_VertexID) : SV_Position {\n  return " + sum +
           ";\n}\n";
  }
  return text + "float4 " + name + "(float4 p : SV_Position) : SV_Target {\n" +
         "  const uint i = uint(p.x);\n  return " + sum + ";\n}\n";
}

TEST(CodegenDriver, RefusesAPermutationThatIsOverItsTierByName) {
  const TestProject project;
  project.write("manifest.json", manifestWith(computeKernel("good", R"(, "tier": "es",
      "axes": [{"name": "big"}, {"name": "huge"}], "exclude": [{"huge": true, "big": false}],
      "tiers": [{"when": {"huge": true}, "tier": "base"}])")));
  // 2, 6 and 9 buffers.
  project.write("good.hlsl", "#if HUGE\n" + readingKernel("good", Stage::kCompute, 8) +
                                 "#elif BIG\n" + readingKernel("good", Stage::kCompute, 5) +
                                 "#else\n" + readingKernel("good", Stage::kCompute, 1) +
                                 "#endif\n");
  expectRefused(project.build(),
                {"6 storage buffers in one kernel; tier es has 4",
                 "9 storage buffers in one kernel; tier base has 8",
                 "(kernel 'good' with big=1 huge=0)", "(kernel 'good' with big=1 huge=1)"});
}

// A vertex and a pixel kernel that share the layout "First".
void writeDraw(const TestProject& project, int vertexBuffers, int pixelBuffers) {
  project.write(
      "manifest.json",
      manifestWith(
          R"({"name": "some_vertex", "file": "some_vertex.hlsl", "stage": "vertex", "group": "g",
          "tier": "wide"},
         {"name": "some_pixel", "file": "some_pixel.hlsl", "stage": "pixel", "group": "g",
          "tier": "wide"})"));
  project.write("some_vertex.hlsl", readingKernel("some_vertex", Stage::kVertex, vertexBuffers));
  project.write("some_pixel.hlsl", readingKernel("some_pixel", Stage::kPixel, pixelBuffers));
}

TEST(CodegenDriver, RefusesAPairThatIsOverItsTier) {
  const TestProject project;
  writeDraw(project, 9, 8);
  const BuildResult result = project.build();
  EXPECT_FALSE(result.ok);
  const Diagnostic error = only(result, "PK702");
  expectHas(error.message,
            "'some_vertex' and 'some_pixel' have 17 storage buffers together; "
            "tier wide has 16");
  expectHas(error.file, "some_vertex.hlsl");
}

TEST(CodegenDriver, NumbersStorageBuffersOnGlForEachPermutationAndPair) {
  const TestProject project;
  writeDraw(project, 2, 3);
  const BuildResult result = project.build();
  ASSERT_TRUE(result.ok) << result.diagnostics.format();
  const KernelOutput& vertex = result.program.kernels.at(0);
  const KernelOutput& pixel = result.program.kernels.at(1);
  const auto numbers = [](const KernelOutput& kernel) {
    std::vector<uint32_t> list;
    for (const BindingUse& use : kernel.variants.at(0).bindings) list.push_back(use.glBinding);
    return list;
  };
  // Both read g_b0 and g_b1, under two numbers and two names of blocks.
  EXPECT_EQ(numbers(pixel), (std::vector<uint32_t>{0, 1, 2}));
  EXPECT_EQ(numbers(vertex), (std::vector<uint32_t>{3, 4}));
  for (const std::string* text : {&vertex.variants.at(0).glsl, &vertex.variants.at(0).essl}) {
    EXPECT_NE(text->find("binding = 3, std430) readonly buffer vertex_"), std::string::npos)
        << *text;
    EXPECT_NE(text->find("binding = 4, std430) readonly buffer vertex_"), std::string::npos);
  }
  EXPECT_EQ(pixel.variants.at(0).glsl.find("vertex_"), std::string::npos);
}

// Code is found by the hash, and a program may have the tables of two manifests.
TEST(CodegenDriver, GivesOneKernelWithOtherNumbersAnotherHash) {
  const TestProject some, more;
  writeDraw(some, 2, 3);
  writeDraw(more, 2, 4);
  const BuildResult a = some.build(), b = more.build();
  ASSERT_TRUE(a.ok) << a.diagnostics.format();
  ASSERT_TRUE(b.ok) << b.diagnostics.format();
  const VariantOutput& first = a.program.kernels.at(0).variants.at(0);
  const VariantOutput& second = b.program.kernels.at(0).variants.at(0);
  EXPECT_EQ(first.spirv, second.spirv);
  EXPECT_NE(first.glsl, second.glsl);
  EXPECT_NE(first.hash, second.hash);
}

TEST(CodegenDriver, NumbersStorageBuffersFromZeroWhateverTheGroupHas) {
  const TestProject project;
  project.write("manifest.json", manifestWith(computeKernel("low", R"(, "tier": "wide")") + "," +
                                              computeKernel("high", R"(, "tier": "es")")));
  project.write("low.hlsl", readingKernel("low", Stage::kCompute, 12));
  project.write("high.hlsl", readingKernel("high", Stage::kCompute, 2, 12));
  const BuildResult result = project.build();
  ASSERT_TRUE(result.ok) << result.diagnostics.format();
  const VariantOutput& high = result.program.kernels.at(1).variants.at(0);
  ASSERT_EQ(high.bindings.size(), 3u);
  for (uint32_t i = 0; i < 3; ++i) {
    EXPECT_EQ(high.bindings[i].entry, 12 + i);
    EXPECT_EQ(high.bindings[i].glBinding, i);
  }
  EXPECT_EQ(high.tier, Tier::kEs);
}

// Two groups that begin with the same layout.
constexpr const char* kSharingGroups = R"("namespace": "fixture",
  "groups": {"one": ["Common", "First"], "two": ["Common", "Second"]},
  "kernels": [
    {"name": "a", "file": "a.hlsl", "stage": "compute", "group": "one"},
    {"name": "b", "file": "b.hlsl", "stage": "compute", "group": "two"}
  ]
})";

TEST(CodegenDriver, PlansALayoutThatGroupsShareOnceOverTheKernelsOfBoth) {
  const TestProject project;
  project.write("manifest.json", std::string("{") + kSharingGroups);
  project.write("a.hlsl",
                "RWStructuredBuffer<uint> g_low : register(u1, space0);\n"
                "RWStructuredBuffer<uint> g_mine : register(u0, space1);\n"
                "[numthreads(1, 1, 1)]\nvoid a() { g_mine[0] = g_low[0]; }\n");
  project.write("b.hlsl",
                "RWStructuredBuffer<uint> g_high : register(u3, space0);\n"
                "RWStructuredBuffer<uint> g_theirs : register(u0, space1);\n"
                "[numthreads(1, 1, 1)]\nvoid b() { g_high[0] = g_theirs[0]; }\n");
  const BuildResult result = project.build();
  ASSERT_TRUE(result.ok) << result.diagnostics.format();
  const std::vector<PlannedLayout>& layouts = result.program.layouts;
  ASSERT_EQ(layouts.size(), 3u);
  EXPECT_EQ(layouts[0].name, "Common");
  ASSERT_EQ(layouts[0].entries.size(), 2u);
  EXPECT_EQ(layouts[0].entries[0].name, "g_low");
  EXPECT_EQ(layouts[0].entries[1].name, "g_high");
  EXPECT_EQ(layouts[0].entries[1].binding, 1u);
  EXPECT_EQ(layouts[0].entries[0].access, Access::kRead);
  EXPECT_EQ(layouts[0].entries[1].access, Access::kWrite);
  for (const size_t own : {1u, 2u}) {  // behind the shared ones in both groups
    EXPECT_EQ(layouts[own].set, 1u);
    ASSERT_EQ(layouts[own].entries.size(), 1u);
  }
  const std::string header = fileText(project.output() / "include/fixture/layouts.h");
  const size_t first = header.find("CreateCommonLayout(");
  ASSERT_NE(first, std::string::npos);
  EXPECT_EQ(header.find("CreateCommonLayout(", first + 1), std::string::npos);
  expectHas(header, "Set 0 of groups \"one\", \"two\".");
  const std::string kernels = fileText(project.output() / "kernels.cpp");
  expectHas(kernels, "kALayouts[] = {\n    &kCommonLayout,\n    &kFirstLayout,");
  expectHas(kernels, "kBLayouts[] = {\n    &kCommonLayout,\n    &kSecondLayout,");
}

TEST(CodegenDriver, RefusesANameOfASharedLayoutInAnotherLayoutOfAnyOfItsGroups) {
  const TestProject project;
  project.write("manifest.json", std::string("{") + kSharingGroups);
  project.write("a.hlsl",
                "RWStructuredBuffer<uint> g_data : register(u0, space1);\n"
                "[numthreads(1, 1, 1)]\nvoid a() { g_data[0] = 1; }\n");
  project.write("b.hlsl",
                "RWStructuredBuffer<uint> g_data : register(u0, space0);\n"
                "[numthreads(1, 1, 1)]\nvoid b() { g_data[0] = 1; }\n");
  expectRefused(project.build(),
                {"src/a.hlsl:1: error: [PK505] ", "src/b.hlsl:1: error: [PK505] "});
}

// A manifest with one vertex kernel "v", which reads its inputs as `input` says.
std::string vertexManifest(const std::string& input) {
  return manifestWith(R"({"name": "v", "file": "v.hlsl", "stage": "vertex", "group": "g")" + input +
                      "}");
}

TEST(CodegenDriver, GivesTheHostTheInputsOfVertexKernels) {
  const TestProject project;
  project.write("manifest.json",
                vertexManifest(R"(, "vertexInput": {"step": "instance", "stride": 24,
                                                    "offsets": [0, 8, 32]})"));
  project.write("v.hlsl",
                "float4 v([[vk::location(2)]] uint3 c : C, [[vk::location(0)]] float2 a : A,\n"
                "         [[vk::location(1)]] float b : B, uint id : SV_VertexID) : SV_Position {\n"
                "  return float4(a, b, float(c.z + id));\n}\n");
  const BuildResult result = project.build();
  ASSERT_TRUE(result.ok) << result.diagnostics.format();
  const std::string kernels = fileText(project.output() / "kernels.cpp");
  expectHas(kernels,
            "{0, ::pelage::VertexFormat::kFloat2, 0},\n"
            "    {1, ::pelage::VertexFormat::kFloat1, 8},\n"
            "    {2, ::pelage::VertexFormat::kUint3, 32},\n");
  expectHas(kernels, "kVVertexInput = {kVAttributes, 24, true}");
  const std::string reflection = fileText(project.output() / "reflection.json");
  expectHas(reflection, "\"step\": \"instance\"");
  expectHas(reflection, "\"stride\": 24");
}

TEST(CodegenDriver, RefusesVertexInputsThatTheManifestDoesNotPlace) {
  const TestProject project;
  const std::string two = R"(, "vertexInput": {"step": "vertex", "stride": 8, "offsets": [0, 4]})";
  const auto errorOf = [&](const std::string& input, const std::string& arguments) {
    project.write("manifest.json", vertexManifest(input));
    project.write("v.hlsl", "\nfloat4 v(" + arguments +
                                ") : SV_Position {\n  return float4(a, 0, 0, 1);\n}\n");
    return only(project.build(), "PK513").message;
  };
  expectHas(errorOf("", "float a : A"), "1 vertex inputs, but");
  expectHas(errorOf(two, "float a : A"), "has 2 offsets");
  expectHas(errorOf(two, "[[vk::location(0)]] float a : A, [[vk::location(3)]] float b : B"),
            "locations from 0 on");
  expectHas(errorOf(two, "[[vk::location(0)]] float a : A, [[vk::location(1)]] int b : B"),
            "no float or uint");
}

TEST(CodegenDriver, RefusesASpaceThatTheGroupDoesNotHave) {
  const TestProject project;
  project.write("manifest.json", manifestWith(computeKernel("far")));
  project.write("far.hlsl",
                "\nRWStructuredBuffer<float> g_far : register(u0, space2);\n"
                "[numthreads(1, 1, 1)]\nvoid far() { g_far[0] = 1.0; }\n");
  const Diagnostic error = only(project.build(), "PK503");
  EXPECT_TRUE(error.file.ends_with("far.hlsl"));
  EXPECT_EQ(error.line, 2u);
}

TEST(CodegenDriver, RefusesStructsThatDifferBetweenKernels) {
  const TestProject project;
  project.write("manifest.json", manifestWith(computeKernel("one") + ",\n" + computeKernel("two")));
  project.write("one.hlsl",
                "struct Item { float4 a; };\n"
                "RWStructuredBuffer<Item> g_one : register(u0, space0);\n"
                "[numthreads(1, 1, 1)]\nvoid one() { g_one[0].a = float4(1, 1, 1, 1); }\n");
  project.write("two.hlsl",
                "\nstruct Item { float4 b; };\n"
                "RWStructuredBuffer<Item> g_two : register(u1, space0);\n"
                "[numthreads(1, 1, 1)]\nvoid two() { g_two[0].b = float4(1, 1, 1, 1); }\n");
  const Diagnostic error = only(project.build(), "PK601");
  EXPECT_TRUE(error.file.ends_with("two.hlsl"));
  EXPECT_EQ(error.line, 2u);
  expectHas(error.message, "'two'");
  expectHas(error.message, "'one' at one.hlsl:1");
}

TEST(CodegenDriver, RefusesAConstantBlockThatDevicesNeedNotTake) {
  const TestProject project;
  project.write("manifest.json", manifestWith(computeKernel("big")));
  project.write("big.hlsl",
                "cbuffer Big : register(b0, space0) { float4 g_table[1025]; };\n"
                "RWStructuredBuffer<float4> g_out : register(u0, space0);\n"
                "[numthreads(1, 1, 1)]\n"
                "void big(uint3 id : SV_DispatchThreadID) { g_out[0] = g_table[id.x]; }\n");
  EXPECT_EQ(only(project.build(), "PK701").line, 1u);
}

TEST(CodegenDriver, RefusesAnIncludeWhoseNameIsAMacro) {
  const TestProject project;
  project.write("manifest.json", manifestWith(computeKernel("good")));
  project.write("hidden.hlsli", "\n");
  project.write("good.hlsl",
                std::string("#define NAME \"hidden.hlsli\"\n#include NAME\n") + kGoodKernel);
  const BuildResult result = project.build();
  EXPECT_FALSE(result.ok);
}

TEST(CodegenDriver, FindsIncludesBesideTheFileBesideTheManifestAndInTheFolders) {
  const TestProject project;
  project.write("manifest.json", manifestWith(R"(    {"name": "good", "file": "deep/good.hlsl",
     "stage": "compute", "group": "g"})"));
  project.write("deep/near.hlsli", "#define NEAR 1\n");
  project.write("common/base.hlsli", "#define BASE 2\n");
  project.write("../elsewhere/far.hlsli", "#include \"further.hlsli\"\n");
  project.write("../elsewhere/further.hlsli", "#define FAR 3\n");
  project.write("deep/good.hlsl",
                std::string("#include \"near.hlsli\"\n#include \"common/base.hlsli\"\n#include "
                            "<far.hlsli>\n#if NEAR + BASE + FAR != 6\n#error wrong\n#endif\n") +
                    kGoodKernel);
  BuildOptions options = project.options();
  options.includeDirs.push_back(project.folder() / "elsewhere");
  options.stampFile = project.folder() / "done.stamp";
  options.depFile = project.folder() / "done.d";
  const BuildResult result = build(options);
  ASSERT_TRUE(result.ok) << result.diagnostics.format();
  const std::string dependencies = fileText(options.depFile);
  EXPECT_TRUE(dependencies.starts_with(options.stampFile.string() + ":")) << dependencies;
  for (const char* name :
       {"src/manifest.json", "src/deep/good.hlsl", "src/deep/near.hlsli", "src/common/base.hlsli",
        "elsewhere/far.hlsli", "elsewhere/further.hlsli"}) {
    expectHas(dependencies, (project.folder() / name).string());
  }
  EXPECT_EQ(build(options).compiled, 0u);
  project.write("../elsewhere/further.hlsli", "#define FAR (1 + 2)\n");
  EXPECT_EQ(build(options).compiled, 1u);
}

TEST(CodegenTool, PrintsASummaryAndThenTakesEverythingFromItsCache) {
  const TestProject project;
  project.copy(kFixture);
  const std::string arguments = project.manifest().string() + " -o " + project.output().string();
  const auto first = runTool(project, arguments);
  EXPECT_EQ(first.code, 0) << first.errors;
  EXPECT_EQ(first.out, "pelage-codegen: 13 permutations, 13 compiled, 0 from cache, 12 distinct\n");
  const auto second = runTool(project, arguments);
  EXPECT_EQ(second.code, 0) << second.errors;
  EXPECT_EQ(second.out,
            "pelage-codegen: 13 permutations, 0 compiled, 13 from cache, 12 distinct\n");
}

TEST(CodegenTool, ExitsWithOneAndTheErrorsInGccFormat) {
  const TestProject project;
  project.write("manifest.json", manifestWith(computeKernel("good")));
  project.write("good.hlsl", "void good() {}\n");
  const auto run =
      runTool(project, project.manifest().string() + " -o " + project.output().string());
  EXPECT_EQ(run.code, 1);
  EXPECT_TRUE(run.out.empty()) << run.out;
  EXPECT_TRUE(
      run.errors.starts_with((project.folder() / "src/good.hlsl").string() + ":1: error: [PK"))
      << run.errors;
}

TEST(CodegenTool, ExplainsItselfWhenArgumentsAreMissing) {
  const TestProject project;
  const auto run = runTool(project, "");
  EXPECT_EQ(run.code, 2);
  EXPECT_EQ(std::count(run.errors.begin(), run.errors.end(), '\n'), 1) << run.errors;
  EXPECT_NE(runTool(project, "/does/not/exist.json -o x").code, 0);
}

}  // namespace
}  // namespace pelage::codegen::test
