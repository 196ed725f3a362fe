// Every trap that codegen/checks knows, as a file that must fail with number, file and line, and
// files that must pass. A fixture's first lines say what is expected of it:
//   // expect: PK101 line 3 [file NAME] [note]     or: expect: nothing
//   // options: stage=pixel precise tier=wide macro=NAME=VALUE
#include "codegen/checks/checks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <regex>
#include <set>
#include <spirv/unified1/spirv.hpp>
#include <sstream>

#include "codegen/back_end.h"
#include "codegen/checks/line_module.h"
#include "codegen/checks/source_model.h"
#include "codegen/checks/token_stream.h"
#include "codegen/front_end.h"
#include "support/test_folder.h"

namespace pelage::codegen {
namespace {

namespace fs = std::filesystem;
using pelage::test::textOf;

const fs::path kRoot = fs::path(PELAGE_SOURCE_DIR) / "tests" / "codegen";

struct Fixture {
  fs::path path;
  std::set<std::string> expected;  ///< "file:line: error: PK101"
  FrontEndInput compile;
  bool precise = false;
  Tier tier = Tier::kBase;
};

std::string summary(const Diagnostic& diagnostic) {
  return diagnostic.file + ":" + std::to_string(diagnostic.line) +
         (diagnostic.isError ? ": error: " : ": note: ") + diagnostic.code;
}

Fixture readFixture(const fs::path& path) {
  Fixture fixture;
  fixture.path = path;
  fixture.compile.baseDir = kRoot;
  fixture.compile.file = "fixtures/" + path.filename().string();
  fixture.compile.entry = "main";
  std::ifstream stream(path);
  for (std::string line; std::getline(stream, line) && line.starts_with("// ");) {
    std::istringstream words(line.substr(3));
    std::string word;
    words >> word;
    if (word == "expect:") {
      Diagnostic expected{fixture.compile.file, 0, {}, {}, true};
      words >> expected.code;
      while (words >> word) {
        if (word == "line") words >> expected.line;
        if (word == "file") words >> expected.file;
        if (word == "note") expected.isError = false;
      }
      if (expected.code != "nothing") fixture.expected.insert(summary(expected));
    } else if (word == "options:") {
      while (words >> word) {
        if (word == "stage=pixel") fixture.compile.stage = Stage::kPixel;
        if (word == "stage=vertex") fixture.compile.stage = Stage::kVertex;
        if (word == "precise") fixture.precise = true;
        if (word.starts_with("tier=")) fixture.tier = tierFromName(word.substr(5)).value();
        if (word.starts_with("macro=")) {
          const size_t equal = word.find('=', 6);
          fixture.compile.macros.emplace_back(word.substr(6, equal - 6), word.substr(equal + 1));
        }
      }
    }
  }
  return fixture;
}

// Keeps what CheckInput only views.
struct Compiled {
  CheckInput input;
  std::vector<uint32_t> raw;
  BackEndOutput back;
  Diagnostics diagnostics;
  bool reachedFrontEnd = false;
};

void runFixture(const Fixture& fixture, Compiled& result) {
  const PreprocessOutput text = preprocessHlsl(fixture.compile);
  ASSERT_TRUE(text.ok) << (text.messages.empty() ? "" : text.messages.front().text);
  result.input.stage = fixture.compile.stage;
  result.input.entry = fixture.compile.entry;
  result.input.file = fixture.compile.file;
  result.input.preprocessed = text.text;
  result.input.precise = fixture.precise;
  result.input.tier = fixture.tier;
  runSourceChecks(result.input, result.diagnostics);
  if (result.diagnostics.hasErrors()) return;

  result.reachedFrontEnd = true;
  FrontEndOutput front = compileHlsl(fixture.compile);
  ASSERT_TRUE(front.ok) << front.log;
  result.raw = std::move(front.spirv);
  BackEndInput back;
  back.rawSpirv = result.raw;
  back.entry = fixture.compile.entry;
  back.stage = fixture.compile.stage;
  back.precise = fixture.precise;
  back.tier = fixture.tier;
  result.back = runBackEnd(back);
  result.input.rawSpirv = result.raw;
  result.input.optimisedSpirv = result.back.optimised;
  result.input.frontEndLog = front.log;
  runModuleChecks(result.input, result.diagnostics);
}

std::vector<std::string> fixtureNames() {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(kRoot / "fixtures", error)) {
    if (entry.path().extension() == ".hlsl") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

class CheckFixture : public testing::TestWithParam<std::string> {};

TEST_P(CheckFixture, GetsExactlyTheMessagesThatItExpects) {
  const Fixture fixture = readFixture(kRoot / "fixtures" / (GetParam() + ".hlsl"));
  Compiled compiled;
  ASSERT_NO_FATAL_FAILURE(runFixture(fixture, compiled));
  std::set<std::string> found;
  for (const Diagnostic& diagnostic : compiled.diagnostics.items()) {
    found.insert(summary(diagnostic));
    EXPECT_FALSE(diagnostic.message.empty());
    EXPECT_EQ(diagnostic.message.find('\n'), std::string::npos);
  }
  EXPECT_EQ(found, fixture.expected) << compiled.diagnostics.format();
  const bool mustFail = GetParam().starts_with("pk") && !fixture.expected.empty() &&
                        fixture.expected.begin()->find(": note: ") == std::string::npos;
  EXPECT_EQ(compiled.diagnostics.hasErrors(), mustFail);
}

INSTANTIATE_TEST_SUITE_P(All, CheckFixture, testing::ValuesIn(fixtureNames()),
                         [](const auto& test) { return test.param; });

TEST(SourceChecks, HaveAFixtureForEveryNumberTheyCanSay) {
  std::set<std::string> covered;
  for (const std::string& name : fixtureNames()) {
    for (const std::string& line : readFixture(kRoot / "fixtures" / (name + ".hlsl")).expected) {
      covered.insert(line.substr(line.size() - 5));
    }
  }
  // These are made by a wrong tool and not by HLSL: the tests below construct them.
  covered.insert({"PK200", "PK205", "PK209", "PK212", "PK213", "PK219", "PK221", "PK222"});
  for (const char* file : {"source_checks.cpp", "module_checks.cpp"}) {
    const std::string text = textOf(fs::path(PELAGE_SOURCE_DIR) / "codegen" / "checks" / file);
    ASSERT_FALSE(text.empty());
    for (size_t at = text.find("\"PK"); at != std::string::npos; at = text.find("\"PK", at + 1)) {
      EXPECT_EQ(covered.count(text.substr(at + 1, 5)), 1u) << text.substr(at + 1, 5);
    }
  }
}

TEST(SourceChecks, StopASpecializationConstantInNumthreadsBeforeItCrashesTheFrontEnd) {
  const Fixture fixture = readFixture(kRoot / "fixtures" / "pk121_numthreads_spec_constant.hlsl");
  Compiled compiled;
  ASSERT_NO_FATAL_FAILURE(runFixture(fixture, compiled));
  EXPECT_TRUE(compiled.diagnostics.hasCode("PK121"));
  EXPECT_FALSE(compiled.reachedFrontEnd);
  // The trap is real: the front end does not survive this text.
  EXPECT_DEATH({ (void)compileHlsl(fixture.compile); }, "");
}

TEST(SourceChecks, SurviveAnyPrefixOfAKernel) {
  const std::string text = textOf(kRoot / "fixtures" / "good_compute.hlsl");
  const size_t body = text.find('{', text.find("void main"));
  ASSERT_NE(body, std::string::npos);
  for (size_t length = 0; length < text.size(); length += 29) {
    CheckInput input;
    input.entry = "main";
    input.file = "prefix.hlsl";
    input.preprocessed = text.substr(0, length);
    Diagnostics diagnostics;
    runSourceChecks(input, diagnostics);
    EXPECT_EQ(diagnostics.hasCode("PK122"), length <= body) << length;
  }
}

TEST(TokenStream, FollowsLinesThroughCommentsAndLineDirectives) {
  const checks::TokenStream stream = checks::tokenize(
      "a /* x\n y */ b\n#line 40 \"inc/one.hlsli\"\nc // d\n#line 7 \"main.hlsl\"\n\ne 1.5e-3f "
      "a.b <<= 0x1Fu \"s\" # f\n #pragma x y",
      "main.hlsl");
  std::vector<std::string> words;
  for (const checks::Token& token : stream.tokens) {
    words.push_back(stream.fileOf(token) + ":" + std::to_string(token.line) + ":" +
                    std::string(token.text));
  }
  EXPECT_EQ(words,
            (std::vector<std::string>{
                "main.hlsl:1:a", "main.hlsl:2:b", "inc/one.hlsli:40:c", "main.hlsl:8:e",
                "main.hlsl:8:1.5e-3f", "main.hlsl:8:a", "main.hlsl:8:.", "main.hlsl:8:b",
                "main.hlsl:8:<<", "main.hlsl:8:=", "main.hlsl:8:0x1Fu", "main.hlsl:8:\"s\"",
                "main.hlsl:8:#", "main.hlsl:8:f", "main.hlsl:9:#pragma x y", "main.hlsl:9:"}));
}

TEST(SourceModel, ReadsDeclarationsOfEveryKind) {
  const checks::TokenStream stream = checks::tokenize(
      "typedef float2 Pair;\n"
      "struct S { row_major float4x4 m; uint a[2], b; float f() { return 1; } };\n"
      "cbuffer C : register(b1, space2) { Pair p; };\n"
      "[[vk::constant_id(3)]] const uint kN = 4;\n"
      "Texture2D<vector<float, 4> > t : register(t0);\n"
      "[numthreads(1, 2, 3)] void main(in uint3 id : SV_DispatchThreadID, out float x) { x = 1; "
      "}\n",
      "a.hlsl");
  const checks::SourceModel model = checks::parseSource(stream);
  ASSERT_EQ(model.structs.size(), 1u);
  ASSERT_EQ(model.structs[0].members.size(), 3u);
  EXPECT_EQ(model.structs[0].members[0].type, "float4x4");
  EXPECT_EQ(model.structs[0].members[1].arraySizes.size(), 1u);
  EXPECT_TRUE(model.structs[0].members[2].arraySizes.empty());
  ASSERT_EQ(model.blocks.size(), 1u);
  EXPECT_TRUE(model.blocks[0].hasRegister);
  EXPECT_EQ(model.typedefs.count("Pair"), 1u);
  ASSERT_EQ(model.globals.size(), 2u);
  EXPECT_NE(model.globals[0].findAttribute("vk", "constant_id"), nullptr);
  EXPECT_EQ(stream.at(model.globals[1].name).text, "t");
  ASSERT_EQ(model.functions.size(), 2u);
  EXPECT_EQ(stream.at(model.functions[1].name).text, "main");
  ASSERT_EQ(model.functions[1].parameters.size(), 2u);
  EXPECT_EQ(model.functions[1].parameters[0].semantic, "SV_DispatchThreadID");
  EXPECT_TRUE(model.functions[1].parameters[1].isQualified("out"));
  EXPECT_EQ(model.functions[1].attributes[0].name, "numthreads");
}

// ---- what only a wrong tool makes --------------------------------------------------------------

std::vector<uint32_t> compileGood(const char* name) {
  const Fixture fixture = readFixture(kRoot / "fixtures" / (std::string(name) + ".hlsl"));
  FrontEndOutput output = compileHlsl(fixture.compile);
  EXPECT_TRUE(output.ok) << output.log;
  return std::move(output.spirv);
}

Diagnostics checkWords(const std::vector<uint32_t>& raw,
                       const std::vector<uint32_t>& optimised = {}, bool precise = false) {
  CheckInput input;
  input.entry = "main";
  input.file = "words.hlsl";
  input.rawSpirv = raw;
  input.optimisedSpirv = optimised;
  input.precise = precise;
  input.tier = Tier::kWide;
  Diagnostics diagnostics;
  runModuleChecks(input, diagnostics);
  return diagnostics;
}

// Calls `edit(opcode, words)` for every instruction of a module.
template <class Edit>
void forEachInstruction(std::vector<uint32_t>& words, Edit edit) {
  for (size_t at = 5; at < words.size(); at += words[at] >> 16) {
    edit(words[at] & 0xffffu, std::span(words).subspan(at, words[at] >> 16));
  }
}

TEST(ModuleChecks, RefuseABufferBlock) {
  std::vector<uint32_t> words = compileGood("good_wide");
  EXPECT_FALSE(checkWords(words).hasErrors());
  forEachInstruction(words, [](uint32_t opcode, std::span<uint32_t> instruction) {
    if (opcode == spv::OpDecorate && instruction[2] == spv::DecorationBlock) {
      instruction[2] = spv::DecorationBufferBlock;
    }
  });
  const Diagnostics diagnostics = checkWords(words);
  ASSERT_TRUE(diagnostics.hasCode("PK212")) << diagnostics.format();
  EXPECT_EQ(diagnostics.items().front().file, "fixtures/good_wide.hlsl");
  EXPECT_EQ(diagnostics.items().front().line, 8u);
}

TEST(ModuleChecks, RefuseAFloatAtomicEvenWhereTheLanguageHasOne) {
  std::vector<uint32_t> words = compileGood("good_compute");
  EXPECT_FALSE(checkWords(words).hasCode("PK205"));
  uint32_t uintType = 0;
  forEachInstruction(words, [&](uint32_t opcode, std::span<uint32_t> instruction) {
    // Every 32-bit unsigned integer becomes a 64-bit one.
    if (opcode == spv::OpTypeInt && instruction[3] == 0) {
      uintType = instruction[1];
      instruction[2] = 64;
    }
  });
  ASSERT_NE(uintType, 0u);
  EXPECT_TRUE(checkWords(words).hasCode("PK205"));
}

TEST(ModuleChecks, RefuseAnUndefinedValueWhereItIsUsed) {
  std::vector<uint32_t> words = compileGood("good_wide");
  const std::optional<checks::LineModule> module = checks::LineModule::parse(words);
  ASSERT_TRUE(module);
  const auto& instructions = module->instructions();
  const auto sum = std::find_if(instructions.begin(), instructions.end(),
                                [](const auto& i) { return i.opcode == spv::OpIAdd; });
  ASSERT_NE(sum, instructions.end());
  const uint32_t constant = sum->operand(1), line = sum->line;
  forEachInstruction(words, [&](uint32_t opcode, std::span<uint32_t> instruction) {
    if (opcode != spv::OpConstant || instruction[2] != constant) return;
    instruction[0] = 3u << 16 | spv::OpUndef;
    instruction[3] = 1u << 16 | spv::OpNop;
  });
  const Diagnostics diagnostics = checkWords(words);
  std::set<std::string> found;
  for (const Diagnostic& diagnostic : diagnostics.items()) found.insert(summary(diagnostic));
  EXPECT_EQ(found.count("fixtures/good_wide.hlsl:" + std::to_string(line) + ": error: PK209"), 1u)
      << diagnostics.format();
}

TEST(ModuleChecks, RefuseGlobalUniformsThatTheSourceChecksDidNotSee) {
  Fixture fixture = readFixture(kRoot / "fixtures" / "pk134_global_uniform.hlsl");
  const FrontEndOutput output = compileHlsl(fixture.compile);
  ASSERT_TRUE(output.ok) << output.log;
  EXPECT_TRUE(checkWords(output.spirv).hasCode("PK213"));
}

TEST(ModuleChecks, RefuseContractionInAPreciseKernelUntilItIsForbidden) {
  const std::vector<uint32_t> raw = compileGood("good_precise");
  const Diagnostics contracted = checkWords(raw, raw, true);
  EXPECT_TRUE(contracted.hasCode("PK219")) << contracted.format();
  const std::vector<uint32_t> precise = forbidContraction(raw);
  EXPECT_FALSE(checkWords(precise, precise, true).hasErrors());
  // Once is enough.
  EXPECT_EQ(forbidContraction(precise), precise);
}

TEST(ModuleChecks, KeepContractionForbiddenThroughOptimiserAndCrossCompiler) {
  const Fixture fixture = readFixture(kRoot / "fixtures" / "good_precise.hlsl");
  Compiled compiled;
  ASSERT_NO_FATAL_FAILURE(runFixture(fixture, compiled));
  // Every product and every sum is a precise variable of its own; dot() and mul() are gone.
  for (const std::string& text : {compiled.back.glsl, compiled.back.essl}) {
    EXPECT_EQ(text.find("dot("), std::string::npos) << text;
    EXPECT_EQ(text.find("mat3("), std::string::npos) << text;
    std::istringstream stream(text);
    const std::regex sign(" [-+*] "), index("\\[[^\\]]*\\]");
    for (std::string line; std::getline(stream, line);) {
      const std::string code = std::regex_replace(line, index, "");
      const auto signs = std::distance(std::sregex_iterator(code.begin(), code.end(), sign), {});
      if (signs == 0 || line.find("uint _") != std::string::npos) continue;
      EXPECT_EQ(signs, 1) << line;
      EXPECT_TRUE(line.starts_with("    precise ")) << line;
    }
  }
  EXPECT_EQ(compiled.back.essl.find("fma("), std::string::npos);
  // At 310 the cross-compiler would drop the qualifier.
  EXPECT_TRUE(compiled.back.essl.starts_with("#version 320 es"));
}

TEST(ForbidContraction, KeepsTheValuesOfDotProductsAndMatrixProducts) {
  std::vector<uint32_t> precise = forbidContraction(compileGood("good_products"));
  // Without the decoration the optimiser computes the constants.
  std::vector<uint32_t> words(precise.begin(), precise.begin() + 5);
  size_t removed = 0;
  forEachInstruction(precise, [&](uint32_t opcode, std::span<uint32_t> instruction) {
    EXPECT_FALSE(checks::isSumOfProducts(static_cast<uint16_t>(opcode)));
    if (opcode == spv::OpDecorate && instruction[2] == spv::DecorationNoContraction) {
      ++removed;
    } else {
      words.insert(words.end(), instruction.begin(), instruction.end());
    }
  });
  EXPECT_GT(removed, 20u);
  BackEndInput input;
  input.rawSpirv = words;
  input.entry = "main";
  input.tier = Tier::kWide;
  const BackEndOutput output = runBackEnd(input);
  for (const char* value : {"vec4(50.0, 122.0, 194.0, 0.0)", "vec4(54.0, 75.0, 96.0, 0.0)",
                            "vec4(38.0, 44.0, 50.0, 56.0)", "vec4(83.0, 98.0, 113.0, 128.0)"}) {
    EXPECT_NE(output.glsl.find(value), std::string::npos)
        << value << " in " << output.glsl
        << (output.errors.empty() ? "" : output.errors.front().message);
  }
}

TEST(ModuleChecks, RefuseABrokenModule) {
  std::vector<uint32_t> words = compileGood("good_wide");
  words.resize(words.size() - 1);
  words.back() = 0xffff0000u;
  const Diagnostics diagnostics = checkWords(words);
  EXPECT_TRUE(diagnostics.hasCode("PK200")) << diagnostics.format();
  EXPECT_EQ(forbidContraction(words), words);
}

TEST(ModuleChecks, SurviveAnyPrefixAndAnyWrongWord) {
  const std::vector<uint32_t> words = compileGood("good_compute");
  for (size_t length = 0; length < words.size(); length += 41) {
    const std::vector<uint32_t> prefix(words.begin(), words.begin() + static_cast<long>(length));
    (void)checkWords(prefix, prefix, true);
  }
  for (size_t at = 5; at < words.size(); at += 17) {
    std::vector<uint32_t> damaged = words;
    damaged[at] ^= 0x00010003u;
    (void)checkWords(damaged, damaged, true);
    (void)forbidContraction(damaged);
  }
}

TEST(ModuleChecks, RefuseResourcesWithoutABindingInTheTextForOpenGl) {
  CheckInput input;
  input.file = "text.hlsl";
  input.glsl =
      "#version 450\nuniform sampler2D g_map;\nlayout(binding = 1) uniform sampler2D b;\n"
      "layout(std140) uniform Push\n{\n    vec4 a;\n} push;\n"
      "layout(binding = 0, std430) readonly buffer c\n{\n    uint uniform_data[];\n} d;\n";
  input.essl = "#version 320 es\nuniform int SPIRV_Cross_BaseInstance;\n";
  Diagnostics diagnostics;
  runModuleChecks(input, diagnostics);
  std::vector<std::string> codes;
  for (const Diagnostic& diagnostic : diagnostics.items()) codes.push_back(diagnostic.code);
  EXPECT_EQ(codes, (std::vector<std::string>{"PK222", "PK222", "PK221"})) << diagnostics.format();
}

TEST(ModuleChecks, RefuseEveryMessageOfTheSpirvBuilder) {
  CheckInput input;
  input.file = "log.hlsl";
  input.frontEndLog =
      "\nLinked compute stage:\n\nWARNING: inc/a.hlsli:12: 'x' : odd\nMissing functionality: "
      "shadow\n"
      "ERROR: log.hlsl:3: 'y' : reported by the caller\n";
  Diagnostics diagnostics;
  runModuleChecks(input, diagnostics);
  ASSERT_EQ(diagnostics.items().size(), 2u) << diagnostics.format();
  EXPECT_EQ(summary(diagnostics.items()[0]), "inc/a.hlsli:12: error: PK201");
  EXPECT_EQ(summary(diagnostics.items()[1]), "log.hlsl:1: error: PK201");
}

}  // namespace
}  // namespace pelage::codegen
