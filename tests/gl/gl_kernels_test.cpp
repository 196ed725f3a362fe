// codegen's kernels on the OpenGL and OpenGL ES runtime: they run, and the driver lays their blocks
// out as the generated structs say.
#include <GL/glcorearb.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "engine_context.h"
#include "pelage/gl.h"
#include "pelage/headless.h"
#include "pelage/kernels.h"
#include "runtime_test/code.h"
#include "runtime_test/gpu_structs.h"
#include "runtime_test/kernels.h"
#include "runtime_test/layouts.h"
#include "support/required_devices.h"

namespace pelage {
namespace {

using nlohmann::json;
using runtime_test::AccumulateConstants;
using runtime_test::FillConstants;

std::string apiSuffix(const ::testing::TestParamInfo<Api>& info) {
  return info.param == Api::kGles ? "Gles" : "Gl";
}

class GlKernels : public ::testing::TestWithParam<Api> {
 protected:
  void SetUp() override {
    Result<std::unique_ptr<HeadlessDevice>> made = createHeadlessGl({GetParam(), true, -1});
    if (!made) {
      if (made.error().code == ErrorCode::kUnsupported)
        PELAGE_SKIP_WITHOUT_DEVICE() << made.error().message;
      FAIL() << made.error().message;
    }
    device_ = std::move(*made);
    device_->addCode(runtime_test::allCode());
  }
  void TearDown() override {
    if (!device_) return;
    EXPECT_EQ(device_->messageCount(), 0u);
  }

  BufferId add(const char* name, const std::vector<uint32_t>& values,
               BufferUsage usage = BufferUsage::kStorage) {
    const auto bytes = std::as_bytes(std::span(values));
    return table_.add({name, bytes.size(), 4, usage, {bytes.begin(), bytes.end()}});
  }
  std::vector<uint32_t> run(PassList& list, BufferId result) {
    HazardTracker tracker;
    tracker.resolve(list);
    const Result<void> updated = device_->update(table_);
    EXPECT_TRUE(updated) << updated.error().message;
    const Result<void> done = device_->execute(list);
    EXPECT_TRUE(done) << done.error().message;
    const Result<std::vector<std::byte>> bytes = device_->read(result);
    if (!bytes) {
      ADD_FAILURE() << bytes.error().message;
      return {};
    }
    std::vector<uint32_t> values(bytes->size() / 4);
    std::memcpy(values.data(), bytes->data(), values.size() * 4);
    return values;
  }

  std::unique_ptr<HeadlessDevice> device_;
  ResourceTable table_;
};
INSTANTIATE_TEST_SUITE_P(, GlKernels, ::testing::Values(Api::kGl, Api::kGles), apiSuffix);

TEST_P(GlKernels, RunPermutationsInTheOrderOfTheList) {
  const BufferId source = add("source", {1, 2, 3});
  const BufferId target = add("target", {10, 20, 30});
  PassList list;
  for (const bool doubled : {false, true}) {
    ASSERT_TRUE(PassBuilder(list)
                    .dispatch(runtime_test::accumulateVariant({.doubled = doubled}), 3)
                    .bind("g_source", source, 12)
                    .bind("g_target", target, 12)
                    .constants("AccumulateConstants", AccumulateConstants{3, 5, 7, 0})
                    .finish());
  }
  // 3 (3 t + 5 s + 7) + 5 (2 s) + 7
  EXPECT_EQ(run(list, target), (std::vector<uint32_t>{90 + 28 + 25, 180 + 28 + 50, 270 + 28 + 75}));
}

TEST_P(GlKernels, TakeTheirSpecConstants) {
  const BufferId source = add("source", {1, 2, 3});
  const BufferId target = add("target", {0, 0, 0});
  const auto multiply = [&](std::span<const SpecValue> values) {
    PassList list;
    EXPECT_TRUE(PassBuilder(list)
                    .dispatch(runtime_test::multiplyBySpecVariant(), 3)
                    .bind("g_source", source, 12)
                    .bind("g_target", target, 12)
                    .constants("AccumulateConstants", AccumulateConstants{3, 0, 100, 0})
                    .spec(values)
                    .finish());
    return run(list, target);
  };
  EXPECT_EQ(multiply({}), (std::vector<uint32_t>{2, 4, 6}));
  EXPECT_EQ(
      multiply(runtime_test::MultiplyBySpecSpecialization{.kFactor = 7, .kAddBias = true}.values()),
      (std::vector<uint32_t>{107, 114, 121}));
}

TEST_P(GlKernels, DrawWithRowZeroOnTopAndDepthFromZeroToOne) {
  const std::vector<Float4> corners = {{-1, 0, 0, 1}, {1, 0, 0, 1}, {-1, 1, 0, 1},
                                       {-1, 1, 0, 1}, {1, 0, 0, 1}, {1, 1, 0, 1}};
  const auto bytes = std::as_bytes(std::span(corners));
  const BufferId buffer = table_.add(
      {"corners", bytes.size(), 16, BufferUsage::kStorage, {bytes.begin(), bytes.end()}});
  PassList list;
  const auto draw = [&](float depth, Float4 color) {
    FillConstants constants;
    constants.color = color;
    constants.offset = {0, 0, depth, 0};
    ASSERT_TRUE(
        PassBuilder(list)
            .draw(runtime_test::fillVertexVariant(), runtime_test::fillPixelVariant(), {}, 6, 1)
            .bind("g_corners", buffer, bytes.size())
            .constants("FillConstants", constants)
            .finish());
  };
  draw(0.01f, {1, 2, 3, 1});
  draw(0.99f, {9, 9, 9, 9});
  draw(-0.01f, {8, 8, 8, 8});  // in front of the near plane, which a depth of -1..1 would show
  ASSERT_TRUE(device_->update(table_));
  HazardTracker tracker;
  tracker.resolve(list);
  const Result<RenderedImage> image = device_->render(list, {.width = 2, .height = 2});
  ASSERT_TRUE(image) << image.error().message;
  EXPECT_EQ(image->pixels[0], (Float4{1, 2, 3, 1}));
  EXPECT_EQ(image->pixels[1], (Float4{1, 2, 3, 1}));
  EXPECT_EQ(image->pixels[2], (Float4{0, 0, 0, 0}));
  EXPECT_EQ(image->pixels[3], (Float4{0, 0, 0, 0}));
}

// ---------------------------------------------------------------------------------------------

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

class GlLayouts : public ::testing::TestWithParam<Api> {
 protected:
  void SetUp() override {
    context_ = std::make_unique<test::EngineContext>(GetParam());
    if (!context_->current()) PELAGE_SKIP_WITHOUT_DEVICE() << "no OpenGL context through EGL";
    gl::RuntimeDef def;
    def.getProcAddress = test::eglAddress;
    Result<gl::Runtime> made = gl::Runtime::create(std::move(def));
    ASSERT_TRUE(made) << made.error().message;
    runtime_ = std::make_unique<gl::Runtime>(std::move(*made));
    runtime_->addCode(runtime_test::allCode());
  }

  // Variants of every kernel against the structs of the reflection, which are those that the
  // generated header asserts offset by offset. Returns how many members were compared.
  int compare(std::span<const Kernel* const> kernels, const char* reflectionPath) {
    const json reflection = readJson(reflectionPath);
    EXPECT_TRUE(reflection.is_object()) << reflectionPath;
    std::map<std::string, json> structs;
    for (const json& object : reflection.value("structs", json::array()))
      structs[object.at("name")] = object;
    int compared = 0;
    for (const Kernel* kernel : kernels) {
      // A few of each: blocks are laid out alike in all of them, and drivers compile slowly.
      const size_t count = kernel->variants.size(), picked = std::min<size_t>(count, 4);
      for (size_t i = 0; i < picked; ++i) {
        const KernelVariant& variant =
            *kernel->variants[picked > 1 ? i * (count - 1) / (picked - 1) : 0];
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

  std::unique_ptr<test::EngineContext> context_;
  std::unique_ptr<gl::Runtime> runtime_;
};
INSTANTIATE_TEST_SUITE_P(, GlLayouts, ::testing::Values(Api::kGl, Api::kGles), apiSuffix);

TEST_P(GlLayouts, AreTheDriversInEveryKernelOfTheLibrary) {
  EXPECT_GT(compare(pelage::allKernels(), PELAGE_REFLECTION), 100);
}

TEST_P(GlLayouts, AreTheDriversInTheKernelsOfTheseTests) {
  EXPECT_GT(compare(runtime_test::allKernels(), PELAGE_RUNTIME_TEST_REFLECTION), 20);
}

TEST_P(GlLayouts, AreMadeThroughTheGeneratedTemplates) {
  const Result<const gl::Layout*> layout = runtime_test::CreateRuntimeComputeLayout(*runtime_);
  ASSERT_TRUE(layout) << layout.error().message;
  const gl::Layout::Slot target = (*layout)->slots[runtime_test::RuntimeComputeEntry::target];
  EXPECT_EQ(target.target, GLenum{GL_SHADER_STORAGE_BUFFER});
  EXPECT_EQ(target.binding, 0u);
}

}  // namespace
}  // namespace pelage
