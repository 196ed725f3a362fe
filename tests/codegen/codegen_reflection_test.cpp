// The reflection of the build: all kernels of the manifest, numbers without gaps, and what the
// generated tables say. Another front end would have to match it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/enum_names.h"
#include "codegen/manifest.h"
#include "pelage/gpu_structs.h"
#include "pelage/kernels.h"
#include "pelage/layouts.h"
#include "test_project.h"

namespace pelage::codegen::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

const Json& reflection() {
  static const Json kJson = Json::parse(fileText(PELAGE_KERNELS_REFLECTION));
  return kJson;
}

const Manifest& kernelsManifest() {
  static const Manifest kManifest = [] {
    Diagnostics diagnostics;
    Manifest read =
        readManifest(fs::path(PELAGE_SOURCE_DIR) / "kernels/manifest.json", diagnostics);
    EXPECT_TRUE(diagnostics.items().empty()) << diagnostics.format();
    return read;
  }();
  return kManifest;
}

/// The one with this name; null, and a failed test, if there is none.
const Json& named(const char* list, std::string_view name) {
  for (const Json& item : reflection().at(list))
    if (item.at("name").get<std::string_view>() == name) return item;
  ADD_FAILURE() << "no " << name << " in " << list;
  static const Json kNone;
  return kNone;
}

/// Values in their order, without the names: "g_positions float4 storageBuffer read [vertex] 16".
std::string valuesOf(const Json& json) {
  if (json.is_string()) return json.get<std::string>();
  if (!json.is_structured()) return json.dump();
  const bool isArray = json.is_array();
  std::string text;
  for (const Json& value : json) {
    text += text.empty() ? "" : isArray ? ", " : " ";
    text += value.is_object() && !isArray ? value.dump() : valuesOf(value);
  }
  return isArray ? "[" + text + "]" : text;
}

TEST(CodegenReflection, HasEveryKernelOfTheManifestWithItsPermutations) {
  const Json& kernels = reflection().at("kernels");
  ASSERT_EQ(kernels.size(), kernelsManifest().kernels.size());
  for (size_t i = 0; i < kernels.size(); ++i) {
    const ManifestKernel& kernel = kernelsManifest().kernels[i];
    EXPECT_EQ(kernels[i].at("name"), kernel.name);
    EXPECT_EQ(kernels[i].at("file"), kernel.file);
    EXPECT_EQ(kernels[i].at("stage"), word(kernel.stage)) << kernel.name;
    EXPECT_EQ(kernels[i].at("precise"), kernel.precise) << kernel.name;
    EXPECT_EQ(kernels[i].at("commutes"), kernel.commutes) << kernel.name;
    EXPECT_EQ(kernels[i].at("layouts"), Json(kernelsManifest().groups[kernel.group].layouts))
        << kernel.name;
    std::map<std::string, std::string> tiers, expected;
    for (const Json& variant : kernels[i].at("variants"))
      for (const std::string key : variant.at("keys"))
        EXPECT_TRUE(tiers.emplace(key, variant.at("tier")).second) << kernel.name << " " << key;
    for (const Permutation& permutation : kernel.permutations())
      expected[permutationKey(kernel, permutation)] = tierName(kernel.tierOf(permutation));
    EXPECT_EQ(tiers, expected) << kernel.name;
  }
}

TEST(CodegenReflection, HasEveryLayoutOfTheManifestInItsSet) {
  size_t layouts = 0;
  std::map<std::string, uint32_t> sets;
  for (const ManifestGroup& group : kernelsManifest().groups)
    for (uint32_t set = 0; set < group.layouts.size(); ++set) {
      const auto [known, added] = sets.emplace(group.layouts[set], set);
      EXPECT_EQ(known->second, set) << group.name << " " << group.layouts[set];
      if (!added) continue;
      ++layouts;
      const Json& layout = named("layouts", group.layouts[set]);
      EXPECT_EQ(layout.at("set"), set) << group.layouts[set];
      EXPECT_EQ(layout.at("group"), group.name) << group.layouts[set];
    }
  EXPECT_EQ(reflection().at("layouts").size(), layouts);
}

TEST(CodegenReflection, NumbersTheEntriesOfALayoutDenselyByClassAndRegister) {
  constexpr std::string_view kClasses = "btus";
  for (const Json& layout : reflection().at("layouts")) {
    uint32_t binding = 0;
    std::pair<size_t, int> last = {0, -1};
    for (const Json& entry : layout.at("entries")) {
      const std::string what = valuesOf(layout.at("name")) + ": " + valuesOf(entry);
      EXPECT_EQ(entry.at("binding"), binding++) << what;
      const std::string slot = entry.at("register"), kind = entry.at("kind");
      const std::pair at = {kClasses.find(slot[0]), std::stoi(slot.substr(1))};
      EXPECT_LT(at.first, kClasses.size()) << what;
      EXPECT_LT(last, at) << what;
      last = at;
      EXPECT_EQ(slot[0] == 'b', kind == "uniformBuffer") << what;
      EXPECT_EQ(slot[0] == 's', kind == "sampler") << what;
      EXPECT_TRUE(slot[0] == 'u' || entry.at("access") == "read") << what;
      EXPECT_TRUE(kind != "storageBuffer" || entry.at("glBinding") == 0) << what;
    }
    EXPECT_GT(binding, 0u) << layout.at("name");
  }
}

TEST(CodegenReflection, JoinsAccessAndStagesOfTheKernelsOfALayout) {
  std::map<std::string, int> access;
  std::map<std::string, std::set<std::string>> stages;
  const auto bits = [](const Json& json) {
    const std::string text = json;
    return text == "read" ? 1 : text == "write" ? 2 : 3;
  };
  for (const Json& kernel : reflection().at("kernels"))
    for (const Json& variant : kernel.at("variants"))
      for (const Json& binding : variant.at("bindings")) {
        const Json& layout = named(
            "layouts", kernel.at("layouts").at(binding.at("set").get<size_t>()).get<std::string>());
        const Json& entry = layout.at("entries").at(binding.at("entry").get<size_t>());
        EXPECT_EQ(entry.at("name"), binding.at("name")) << kernel.at("name");
        const std::string key = valuesOf(layout.at("name")) + "." + valuesOf(entry.at("name"));
        access[key] |= bits(binding.at("access"));
        stages[key].insert(kernel.at("stage"));
      }
  for (const Json& layout : reflection().at("layouts"))
    for (const Json& entry : layout.at("entries")) {
      const std::string key = valuesOf(layout.at("name")) + "." + valuesOf(entry.at("name"));
      EXPECT_EQ(bits(entry.at("access")), access[key]) << key;
      EXPECT_EQ(entry.at("stages").get<std::set<std::string>>(), stages[key]) << key;
    }
}

TEST(CodegenReflection, SaysOfLayoutsWhatTheGeneratedTablesSay) {
  std::map<std::string, const LayoutTable*> tables;
  for (const Kernel* kernel : allKernels())
    for (const LayoutTable* layout : kernel->layouts) tables[layout->name] = layout;
  ASSERT_EQ(tables.size(), reflection().at("layouts").size());
  for (const auto& [name, table] : tables) {
    const Json& layout = named("layouts", name);
    EXPECT_EQ(layout.at("group"), table->group);
    EXPECT_EQ(layout.at("set"), table->set);
    ASSERT_EQ(layout.at("entries").size(), table->entries.size()) << name;
    for (size_t i = 0; i < table->entries.size(); ++i) {
      const LayoutEntry& entry = table->entries[i];
      Json expected = layout.at("entries")[i];
      StageMask stages = 0;
      for (const Stage stage : {Stage::kCompute, Stage::kVertex, Stage::kPixel})
        if (std::ranges::count(expected.at("stages"), word(stage)) == 1) stages |= stageBit(stage);
      EXPECT_EQ(stages, entry.stages) << name << "." << entry.name;
      expected.erase("stages");
      expected.erase("register");
      EXPECT_EQ(expected, (Json{{"name", entry.name},
                                {"struct", entry.structName},
                                {"kind", word(entry.kind)},
                                {"access", word(entry.access)},
                                {"stride", entry.stride},
                                {"binding", entry.binding},
                                {"glBinding", entry.glBinding}}));
    }
  }
}

TEST(CodegenReflection, SaysOfKernelsWhatTheGeneratedTablesSayWithinTheirTier) {
  ASSERT_EQ(allKernels().size(), reflection().at("kernels").size());
  for (const Kernel* kernel : allKernels()) {
    const Json& variants = named("kernels", kernel->name).at("variants");
    ASSERT_EQ(variants.size(), kernel->variants.size()) << kernel->name;
    EXPECT_EQ(named("kernels", kernel->name).at("commutes"), kernel->commutes) << kernel->name;
    for (size_t i = 0; i < variants.size(); ++i) {
      const KernelVariant& variant = *kernel->variants[i];
      const Json& json = variants[i];
      EXPECT_EQ(json.at("keys")[0], variant.key) << kernel->name;
      EXPECT_EQ(json.at("tier"), tierName(variant.tier)) << kernel->name;
      Json bindings = Json::array();
      for (const VariantBinding& binding : variant.bindings)
        bindings.push_back({{"set", binding.set},
                            {"entry", binding.entry},
                            {"name", kernel->layouts[binding.set]->entries[binding.entry].name},
                            {"access", word(binding.access)},
                            {"glBinding", binding.glBinding}});
      EXPECT_EQ(json.at("bindings"), bindings) << kernel->name;
      EXPECT_EQ(json.contains("groupSize"), kernel->stage == Stage::kCompute) << kernel->name;
      if (kernel->stage != Stage::kCompute) continue;
      EXPECT_EQ(json.at("sharedBytes"), variant.sharedBytes) << kernel->name;
      const TierLimits limits = limitsOf(variant.tier);
      EXPECT_LE(variant.sharedBytes, limits.groupSharedBytes) << kernel->name;
      uint32_t threads = 1;
      for (size_t axis = 0; axis < 3; ++axis) {
        EXPECT_EQ(json.at("groupSize")[axis], variant.groupSize[axis]) << kernel->name;
        EXPECT_LE(variant.groupSize[axis], limits.groupSize[axis]) << kernel->name;
        threads *= variant.groupSize[axis];
      }
      EXPECT_TRUE(threads >= 1 && threads <= limits.groupThreads) << kernel->name;
    }
  }
}

TEST(CodegenReflection, FillsStructsWithoutGaps) {
  std::map<std::string, uint32_t> sizes;
  for (const Json& type : reflection().at("structs")) {
    uint32_t end = 0;
    for (const Json& member : type.at("members")) {
      EXPECT_EQ(member.at("offset"), end) << type.at("name") << ": " << member.at("name");
      end += member.at("size").get<uint32_t>();
    }
    EXPECT_EQ(type.at("size"), end) << type.at("name");
    sizes[type.at("name")] = end;
  }
  for (const Json& layout : reflection().at("layouts"))
    for (const Json& entry : layout.at("entries")) {
      const auto known = sizes.find(entry.at("struct"));
      if (known != sizes.end()) {
        EXPECT_EQ(entry.at("stride"), known->second) << known->first;
      }
      EXPECT_TRUE(entry.at("kind") != "uniformBuffer" || known != sizes.end()) << valuesOf(entry);
    }
  // Each offset of a generated struct is asserted in its header.
  for (const auto& [name, size] : {std::pair("RootBinding", sizeof(RootBinding)),
                                   {"RootTransform", sizeof(RootTransform)},
                                   {"FollowHairRecord", sizeof(FollowHairRecord)},
                                   {"Collider", sizeof(Collider)},
                                   {"Sdf", sizeof(Sdf)},
                                   {"SurfaceBone", sizeof(SurfaceBone)},
                                   {"VertexBinding", sizeof(VertexBinding)},
                                   {"ContactRecord", sizeof(ContactRecord)},
                                   {"StrandShadowView", sizeof(StrandShadowView)},
                                   {"SimulationConstants", sizeof(SimulationConstants)},
                                   {"ExactConstants", sizeof(ExactConstants)},
                                   {"RenderConstants", sizeof(RenderConstants)}})
    EXPECT_EQ(sizes[name], size) << name;
}

// Layouts and kernels that engines bind by hand: a change here is one of the interface.
TEST(CodegenReflection, KeepsWhatEnginesBuildOn) {
  const std::map<std::string, std::vector<std::string>> layouts = {
      {"SimPosTan",
       {"g_positions float4 storageBuffer readWrite [compute] 16 u0 0 0",
        "g_tangents float4 storageBuffer readWrite [compute] 16 u1 1 0"}},
      {"RenderPosTan",
       {"g_renderPositions float4 storageBuffer read [compute, vertex] 16 t0 0 0",
        "g_renderTangents float4 storageBuffer read [compute, vertex] 16 t1 1 0"}},
      {"HairGrid",
       {"HairGridConstants HairGridConstants uniformBuffer read [compute] 80 b0 0 0",
        "g_gridPositions float4 storageBuffer read [compute] 16 t0 1 0",
        "g_otherForces float4 storageBuffer read [compute] 16 t1 2 0",
        "g_gridBefore float4 storageBuffer readWrite [compute] 16 u0 3 0",
        "g_gridRest float storageBuffer readWrite [compute] 4 u1 4 0",
        "g_gridNodes uint storageBuffer readWrite [compute] 4 u2 5 0",
        "g_gridForces float4 storageBuffer write [compute] 16 u3 6 0"}},
      {"Render",
       {"StrandViewConstants StrandViewConstants uniformBuffer read [compute, vertex, pixel] 1728 "
        "b0 "
        "0 0",
        "RenderConstants RenderConstants uniformBuffer read [compute, vertex, pixel] 160 b1 1 1",
        "g_strandThickness float storageBuffer read [compute, vertex] 4 t0 2 0",
        "g_renderFollowHairRecords FollowHairRecord storageBuffer read [compute, vertex] 48 t1 3 0",
        "g_renderRoots RootTransform storageBuffer read [compute, vertex] 32 t2 4 0",
        "g_vertexColors uint2 storageBuffer read [compute, vertex] 8 t3 5 0",
        "g_baseTexture uint2 storageBuffer read [compute, vertex] 8 t4 6 0",
        "g_shadowWords uint storageBuffer read [pixel] 4 t5 7 0"}},
  };
  for (const auto& [name, lines] : layouts) {
    std::vector<std::string> actual;
    for (const Json& entry : named("layouts", name).at("entries"))
      actual.push_back(valuesOf(entry));
    EXPECT_EQ(actual, lines) << name;
  }
  const std::map<std::string, std::string> kernels = {
      {"skin_roots",
       "[] es [1 0 SimulationConstants read 0, 1 1 g_rest read 0, 1 2 g_boneTransforms read 1, "
       "1 3 g_rootBindings read 2, 1 8 g_rootTransforms readWrite 3] [64, 1, 1] 0"},
      {"simulate_exact",
       "[globalShape=0 velocityShockPropagation=0 forces=0] base [0 0 g_positions "
       "readWrite 0, 0 1 g_tangents readWrite 1, 1 0 ExactConstants read 0, 1 1 g_rest read 2, "
       "1 5 g_state readWrite 3, 1 6 g_sleep readWrite 4] [32, 1, 1] 0"},
      {"apply_hair_grid",
       "[] base [0 0 HairGridConstants read 0, 0 1 g_gridPositions read 0, 0 2 g_otherForces read "
       "1, 0 3 g_gridBefore readWrite 2, 0 4 g_gridRest read 3, 0 5 g_gridNodes read 4, "
       "0 6 g_gridForces write 5] [64, 1, 1] 0"},
      {"strand_record_vertex",
       "[smooth=0] es [1 0 StrandViewConstants read 0, 1 1 RenderConstants read 1]"},
      {"strand_pixel",
       "[stochastic=0] es [1 0 StrandViewConstants read 0, 1 1 RenderConstants read 1, "
       "1 7 g_shadowWords read 0]"}};
  for (const auto& [name, line] : kernels) {
    Json variant = named("kernels", name).at("variants")[0];
    variant.erase("hash");
    EXPECT_EQ(valuesOf(variant), line) << name;
  }
  // Six words of four, of a segment and of the next one.
  const Json& input = named("kernels", "strand_record_vertex").at("vertexInput");
  EXPECT_EQ(input.at("step"), "instance");
  EXPECT_EQ(input.at("stride"), 48);
  EXPECT_EQ(valuesOf(input.at("attributes")),
            "[0 uint 4 0, 1 uint 4 16, 2 uint 4 32, 3 uint 4 48, 4 uint 4 64, 5 uint 4 80]");
}

// All that a reflection can say, of a few kernels. To accept a change that is meant, run this test
// with PELAGE_UPDATE_GOLDEN=1 in the environment and read the difference.
TEST(CodegenReflection, OfTheFixtureMatchesTheGoldenFile) {
  Json json = Json::parse(fileText(PELAGE_FIXTURE_REFLECTION));
  std::string actual;
  for (const auto& [list, inner] :
       {std::pair("layouts", "entries"), {"structs", "members"}, {"kernels", "variants"}})
    for (Json& item : json.at(list)) {
      Json parts = item.at(inner);
      item.erase(inner);
      actual += valuesOf(item) + "\n";
      for (Json& part : parts) {
        part.erase("hash");  // changes with every version of the compilers
        actual += "  " + valuesOf(part) + "\n";
      }
    }
  const fs::path golden = fs::path(PELAGE_CODEGEN_TEST_DIR) / "golden/fixture.txt";
  if (std::getenv("PELAGE_UPDATE_GOLDEN") != nullptr) {
    std::ofstream(golden, std::ios::binary) << actual;
    GTEST_SKIP() << "wrote " << golden;
  }
  EXPECT_EQ(actual, fileText(golden));
}

}  // namespace
}  // namespace pelage::codegen::test
