// codegen's kernels on the OpenGL and OpenGL ES runtime: the driver lays their blocks out as the
// generated structs say.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "gl/engine_context.h"
#include "pelage/kernels.h"
#include "runtime_test/kernels.h"
#include "runtime_test/layouts.h"
#include "support/full_stress.h"
#include "support/gpu_fixture.h"

namespace pelage::test {
namespace {

using nlohmann::json;

json readJson(const char* path) {
  std::ifstream file(path);
  return json::parse(file, nullptr, false);
}

// "RenderConstants.g_worldToClip[0]" and "g_rootTransforms._data[0].rotation" -> the last name.
std::string lastName(std::string name) {
  if (name.ends_with("[0]")) name.resize(name.size() - 3);
  name.erase(0, name.find_last_of('.') + 1);
  return name.starts_with("g_") ? name.substr(2) : name;
}

class GlLayouts : public GlContextTest {
 protected:
  void SetUp() override {
    GlContextTest::SetUp();
    if (context_->current()) runtime_.emplace(makeRuntime());
  }
  void TearDown() override {
    runtime_.reset();
    GlContextTest::TearDown();
  }

  // Variants of kernels against the structs of the reflection, which are those that the
  // generated header asserts offset by offset. Returns how many members were compared.
  int compare(std::span<const Kernel* const> kernels, const char* reflectionPath) {
    const json reflection = readJson(reflectionPath);
    EXPECT_TRUE(reflection.is_object()) << reflectionPath;
    std::map<std::string, json> structs;
    for (const json& object : reflection.value("structs", json::array()))
      structs[object.at("name")] = object;
    int compared = 0;
    std::set<std::pair<ResourceKind, std::string>> seen;  // blocks
    const auto isNew = [&](const KernelVariant& variant) {
      bool any = false;
      for (const VariantBinding& binding : variant.bindings) {
        const LayoutEntry& entry = variant.kernel->layouts[binding.set]->entries[binding.entry];
        if (seen.emplace(entry.kind, entry.structName).second) any = true;
      }
      return any;
    };
    for (const Kernel* kernel : kernels) {
      // Blocks are laid out alike in all of them, and drivers compile slowly: kernels with a block
      // that none before has, and of these the last permutation, which has most.
      const size_t count = kernel->variants.size();
      const size_t picked = fullStress()                          ? std::min<size_t>(count, 4)
                            : isNew(*kernel->variants[count - 1]) ? 1
                                                                  : 0;
      for (size_t i = 0; i < picked; ++i) {
        const KernelVariant& variant =
            *kernel->variants[picked > 1 ? i * (count - 1) / (picked - 1) : count - 1];
        SCOPED_TRACE(std::string(kernel->name) + " " + variant.key);
        compared += compareVariant(variant, structs);
      }
    }
    return compared;
  }

  int compareVariant(const KernelVariant& variant, const std::map<std::string, json>& structs) {
    const Result<std::vector<gl::DriverBlock>> blocks = runtime_->reflectProgram(variant);
    if (!blocks) {
      ADD_FAILURE() << blocks.error().message;
      return 0;
    }
    // The driver sees exactly the buffers and textures that the tables name, at the tables' binding
    // points. Samplers are merged into the textures.
    std::map<std::pair<ResourceKind, uint32_t>, const LayoutEntry*> wanted;
    size_t samplers = 0;
    for (const VariantBinding& binding : variant.bindings) {
      const LayoutEntry& entry = variant.kernel->layouts[binding.set]->entries[binding.entry];
      if (entry.kind == ResourceKind::kSampler)
        ++samplers;
      else
        wanted[{entry.kind, binding.glBinding}] = &entry;
    }
    EXPECT_EQ(wanted.size() + samplers, variant.bindings.size())
        << "two resources share a GL binding";
    EXPECT_EQ(blocks->size(), wanted.size());
    int compared = 0;
    for (const gl::DriverBlock& block : *blocks) {
      SCOPED_TRACE(block.name);
      const auto found = wanted.find({block.kind, block.binding});
      if (found == wanted.end()) {
        ADD_FAILURE() << "nobody knows of binding " << block.binding;
        continue;
      }
      compared += compareBlock(block, *found->second, structs);
    }
    return compared;
  }

  static int compareBlock(const gl::DriverBlock& block, const LayoutEntry& entry,
                          const std::map<std::string, json>& structs) {
    if (block.kind == ResourceKind::kSampledTexture) return 0;
    const bool uniform = block.kind == ResourceKind::kUniformBuffer;
    const auto known = structs.find(entry.structName);
    if (known == structs.end()) {  // an array of numbers or vectors
      EXPECT_FALSE(uniform);
      EXPECT_EQ(block.members.size(), 1u);
      for (const gl::DriverMember& member : block.members) {
        EXPECT_EQ(member.offset, 0u);
        EXPECT_EQ(member.arrayStride, entry.stride);
      }
      return static_cast<int>(block.members.size());
    }
    EXPECT_EQ(known->second.at("size").get<uint32_t>(), entry.stride);
    if (uniform) {
      EXPECT_EQ((block.dataSize + 15) / 16, (entry.stride + 15) / 16);
    }
    std::map<std::string, json> members;
    for (const json& member : known->second.at("members")) members[member.at("name")] = member;
    std::set<std::string> seen;
    for (const gl::DriverMember& member : block.members) {
      SCOPED_TRACE(member.name);
      const std::string name = lastName(member.name);
      seen.insert(name);
      if (!members.contains(name)) {
        ADD_FAILURE() << "the struct has no member " << name;
        continue;
      }
      const json& expected = members.at(name);
      EXPECT_EQ(member.offset, expected.at("offset").get<uint32_t>());
      if (expected.contains("count")) {
        const uint32_t count = expected.at("count");
        EXPECT_EQ(member.arraySize, count);
        EXPECT_EQ(member.arrayStride * count, expected.at("size").get<uint32_t>());
      }
      if (!uniform) {
        EXPECT_EQ(member.topLevelArrayStride, entry.stride);
      }
    }
    EXPECT_EQ(seen.size(), members.size()) << "the driver does not show every member";
    return static_cast<int>(seen.size());
  }

  std::optional<gl::Runtime> runtime_;
};
INSTANTIATE_TEST_SUITE_P(All, GlLayouts, testing::Values(Api::kGl, Api::kGles), apiTestName);

TEST_P(GlLayouts, AreTheDriversInTheKernelsOfTheLibrary) {
  EXPECT_GT(compare(pelage::allKernels(), PELAGE_REFLECTION), 100);
}

TEST_P(GlLayouts, AreTheDriversInTheKernelsOfTheseTests) {
  EXPECT_GT(compare(runtime_test::allKernels(), PELAGE_RUNTIME_TEST_REFLECTION), 15);
}

TEST_P(GlLayouts, AreMadeThroughTheGeneratedTemplates) {
  const Result<const gl::Layout*> layout =
      required(runtime_test::CreateRuntimeComputeLayout(*runtime_));
  const std::vector<gl::Layout::Slot>& slots = (*layout)->slots;
  ASSERT_EQ(slots.size(), 4u);
  EXPECT_EQ(slots[runtime_test::RuntimeComputeEntry::accumulateConstants].target,
            GLenum{GL_UNIFORM_BUFFER});
  const gl::Layout::Slot target = slots[runtime_test::RuntimeComputeEntry::target];
  EXPECT_EQ(target.target, GLenum{GL_SHADER_STORAGE_BUFFER});
  EXPECT_EQ(target.binding, 0u) << "each permutation numbers its storage buffers";
  const Result<const gl::Layout*> again =
      required(runtime_test::CreateRuntimeComputeLayout(*runtime_));
  EXPECT_EQ(*again, *layout);
}

}  // namespace
}  // namespace pelage::test
