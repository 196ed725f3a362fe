// Builds acceleration structures from the buffers of RayGeometry, in buffers of the engine, and
// traces pictures of them: rays hit what a CPU's hit, and what is drawn. On devices that trace
// rays.
#include <glslang/Public/ResourceLimits.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <optional>
#include <vector>

#include "pelage/ray_tracing.h"
#include "ray_tracing/ray_scene.h"
#include "support/errors.h"
#include "support/scene_run.h"
#include "vulkan/vulkan_engine.h"

namespace pelage::test {
namespace {

using runtime_test::Engine;
using runtime_test::EngineBuffer;
using runtime_test::EngineRun;
using runtime_test::tagged;

constexpr VkBufferUsageFlags kAddress = VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;

// A ray through the middle of each pixel, as rayScene::rayOf() has it. Primitives are numbered
// from 1.
constexpr const char* kGenerate = R"(#version 460
#extension GL_EXT_ray_tracing : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
layout(buffer_reference, std430) buffer Picture { uint primitives[]; };
layout(push_constant) uniform Trace { uvec2 structure; uvec2 picture; vec2 camera; };
layout(location = 0) rayPayloadEXT uint primitive;
void main() {
  uvec2 at = gl_LaunchIDEXT.xy, size = gl_LaunchSizeEXT.xy;
  vec2 p = (2.0 * (vec2(at) + 0.5) / vec2(size) - 1.0) * camera.x;
  primitive = 0u;
  traceRayEXT(accelerationStructureEXT(structure), gl_RayFlagsOpaqueEXT, 0xffu, 0, 0, 0,
              vec3(0.0, 0.0, camera.y), 0.0, vec3(p.x, -p.y, -1.0), 100.0, 0);
  Picture(picture).primitives[at.y * size.x + at.x] = primitive;
})";
constexpr const char* kMiss = R"(#version 460
#extension GL_EXT_ray_tracing : require
layout(location = 0) rayPayloadInEXT uint primitive;
void main() { primitive = 0u; })";
constexpr const char* kHit = R"(#version 460
#extension GL_EXT_ray_tracing : require
layout(location = 0) rayPayloadInEXT uint primitive;
void main() { primitive = uint(gl_PrimitiveID) + 1u; })";

struct TraceConstants {
  VkDeviceAddress structure = 0, picture = 0;
  float half = rayScene::kHalf, distance = rayScene::kDistance;
};

std::vector<uint32_t> compile(EShLanguage stage, const char* source) {
  glslang::InitializeProcess();
  std::vector<uint32_t> words;
  {
    glslang::TShader shader(stage);
    shader.setStrings(&source, 1);
    shader.setEnvInput(glslang::EShSourceGlsl, stage, glslang::EShClientVulkan, 460);
    shader.setEnvClient(glslang::EShClientVulkan, glslang::EShTargetVulkan_1_2);
    shader.setEnvTarget(glslang::EShTargetSpv, glslang::EShTargetSpv_1_4);
    const auto rules = static_cast<EShMessages>(EShMsgSpvRules | EShMsgVulkanRules);
    EXPECT_TRUE(shader.parse(GetDefaultResources(), 460, false, rules)) << shader.getInfoLog();
    glslang::TProgram program;
    program.addShader(&shader);
    EXPECT_TRUE(program.link(rules)) << program.getInfoLog();
    glslang::GlslangToSpv(*program.getIntermediate(stage), words);
  }
  glslang::FinalizeProcess();
  return words;
}

struct RayFunctions {
  PFN_vkCreateAccelerationStructureKHR create = nullptr;
  PFN_vkDestroyAccelerationStructureKHR destroy = nullptr;
  PFN_vkGetAccelerationStructureBuildSizesKHR sizes = nullptr;
  PFN_vkGetAccelerationStructureDeviceAddressKHR address = nullptr;
  PFN_vkCmdBuildAccelerationStructuresKHR build = nullptr;
  PFN_vkCreateRayTracingPipelinesKHR pipelines = nullptr;
  PFN_vkGetRayTracingShaderGroupHandlesKHR handles = nullptr;
  PFN_vkCmdTraceRaysKHR trace = nullptr;

  explicit RayFunctions(VkDevice device) {
    const auto load = [&]<class F>(F& function, const char* name) {
      function = reinterpret_cast<F>(vkGetDeviceProcAddr(device, name));
      EXPECT_NE(function, nullptr) << name;
    };
    load(create, "vkCreateAccelerationStructureKHR");
    load(destroy, "vkDestroyAccelerationStructureKHR");
    load(sizes, "vkGetAccelerationStructureBuildSizesKHR");
    load(address, "vkGetAccelerationStructureDeviceAddressKHR");
    load(build, "vkCmdBuildAccelerationStructuresKHR");
    load(pipelines, "vkCreateRayTracingPipelinesKHR");
    load(handles, "vkGetRayTracingShaderGroupHandlesKHR");
    load(trace, "vkCmdTraceRaysKHR");
  }
};

VkDeviceAddress aligned(VkDeviceAddress address, VkDeviceAddress alignment) {
  return (address + alignment - 1) / alignment * alignment;
}

VkDeviceAddress addressOf(const Engine& engine, const EngineBuffer& buffer) {
  auto info = tagged<VkBufferDeviceAddressInfo>(VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO);
  info.buffer = buffer.buffer;
  return vkGetBufferDeviceAddress(engine.device(), &info);
}

// Everything before is done, and visible, behind it.
void barrier(VkCommandBuffer commands) {
  auto all = tagged<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
  all.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
  all.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
  vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                       VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 1, &all, 0, nullptr, 0, nullptr);
}

// An acceleration structure of one geometry.
class Structure {
 public:
  Structure(const Engine& engine, const RayFunctions& functions, bool isTop,
            const VkAccelerationStructureGeometryKHR& geometry, uint32_t primitives)
      : engine_(engine), functions_(functions), geometry_(geometry) {
    info_ = tagged<VkAccelerationStructureBuildGeometryInfoKHR>(
        VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR);
    info_.type = isTop ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR
                       : VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR;
    info_.flags = VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR;
    info_.geometryCount = 1;
    info_.pGeometries = &geometry_;
    range_.primitiveCount = primitives;
    auto sizes = tagged<VkAccelerationStructureBuildSizesInfoKHR>(
        VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR);
    functions.sizes(engine.device(), VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &info_,
                    &primitives, &sizes);
    constexpr VkDeviceSize kScratchAlignment = 256;
    memory_ = engine.createBuffer(sizes.accelerationStructureSize,
                                  VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR | kAddress,
                                  false);
    scratch_ = engine.createBuffer(
        std::max(sizes.buildScratchSize, sizes.updateScratchSize) + kScratchAlignment,
        VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | kAddress, false);
    auto create = tagged<VkAccelerationStructureCreateInfoKHR>(
        VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR);
    create.buffer = memory_.buffer;
    create.size = sizes.accelerationStructureSize;
    create.type = info_.type;
    EXPECT_EQ(functions.create(engine.device(), &create, nullptr, &info_.dstAccelerationStructure),
              VK_SUCCESS);
    info_.scratchData.deviceAddress = aligned(addressOf(engine, scratch_), kScratchAlignment);
  }
  ~Structure() {
    functions_.destroy(engine_.device(), info_.dstAccelerationStructure, nullptr);
    engine_.destroyBuffer(memory_);
    engine_.destroyBuffer(scratch_);
  }
  Structure(const Structure&) = delete;
  Structure& operator=(const Structure&) = delete;

  void build(VkCommandBuffer commands, bool update) {
    info_.mode = update ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR
                        : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    info_.srcAccelerationStructure = update ? info_.dstAccelerationStructure : VK_NULL_HANDLE;
    const VkAccelerationStructureBuildRangeInfoKHR* range = &range_;
    functions_.build(commands, 1, &info_, &range);
  }
  VkDeviceAddress address() const {
    auto info = tagged<VkAccelerationStructureDeviceAddressInfoKHR>(
        VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR);
    info.accelerationStructure = info_.dstAccelerationStructure;
    return functions_.address(engine_.device(), &info);
  }

 private:
  const Engine& engine_;
  const RayFunctions& functions_;
  VkAccelerationStructureGeometryKHR geometry_;
  VkAccelerationStructureBuildGeometryInfoKHR info_;
  VkAccelerationStructureBuildRangeInfoKHR range_ = {};
  EngineBuffer memory_, scratch_;
};

// The pipeline, its table of three shaders, and the picture.
class Tracer {
 public:
  Tracer(const Engine& engine, const RayFunctions& functions)
      : engine_(engine), functions_(functions) {
    VkPushConstantRange range = {VK_SHADER_STAGE_RAYGEN_BIT_KHR, 0, sizeof(TraceConstants)};
    auto layout = tagged<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
    layout.pushConstantRangeCount = 1;
    layout.pPushConstantRanges = &range;
    EXPECT_EQ(vkCreatePipelineLayout(engine.device(), &layout, nullptr, &layout_), VK_SUCCESS);
    createPipeline();
    createTable();
    picture_ = engine.createBuffer(
        kPictureBytes,
        VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | kAddress | VK_BUFFER_USAGE_TRANSFER_SRC_BIT, false);
  }
  ~Tracer() {
    vkDestroyPipeline(engine_.device(), pipeline_, nullptr);
    vkDestroyPipelineLayout(engine_.device(), layout_, nullptr);
    engine_.destroyBuffer(table_);
    engine_.destroyBuffer(picture_);
  }
  Tracer(const Tracer&) = delete;
  Tracer& operator=(const Tracer&) = delete;

  void trace(VkCommandBuffer commands, VkDeviceAddress structure) const {
    const TraceConstants constants = {.structure = structure,
                                      .picture = addressOf(engine_, picture_)};
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR, pipeline_);
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_RAYGEN_BIT_KHR, 0, sizeof(constants),
                       &constants);
    const VkStridedDeviceAddressRegionKHR none = {};
    functions_.trace(commands, &regions_[0], &regions_[1], &regions_[2], &none, rayScene::kPixels,
                     rayScene::kPixels, 1);
  }
  // [row][column]
  std::vector<uint32_t> primitives(const Engine::Frame& frame) const {
    const std::vector<std::byte> bytes = engine_.read({picture_.buffer, 0, kPictureBytes}, frame);
    std::vector<uint32_t> words(bytes.size() / sizeof(uint32_t));
    std::memcpy(words.data(), bytes.data(), bytes.size());
    return words;
  }

 private:
  static constexpr VkDeviceSize kPictureBytes =
      VkDeviceSize{rayScene::kPixels} * rayScene::kPixels * sizeof(uint32_t);

  void createPipeline() {
    const struct {
      VkShaderStageFlagBits stage;
      EShLanguage language;
      const char* source;
    } shaders[] = {{VK_SHADER_STAGE_RAYGEN_BIT_KHR, EShLangRayGen, kGenerate},
                   {VK_SHADER_STAGE_MISS_BIT_KHR, EShLangMiss, kMiss},
                   {VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR, EShLangClosestHit, kHit}};
    std::vector<VkPipelineShaderStageCreateInfo> stages;
    std::vector<VkRayTracingShaderGroupCreateInfoKHR> groups;
    for (const auto& [stage, language, source] : shaders) {
      const std::vector<uint32_t> words = compile(language, source);
      auto module = tagged<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
      module.codeSize = words.size() * sizeof(uint32_t);
      module.pCode = words.data();
      auto made = tagged<VkPipelineShaderStageCreateInfo>(
          VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO);
      made.stage = stage;
      made.pName = "main";
      EXPECT_EQ(vkCreateShaderModule(engine_.device(), &module, nullptr, &made.module), VK_SUCCESS);
      auto group = tagged<VkRayTracingShaderGroupCreateInfoKHR>(
          VK_STRUCTURE_TYPE_RAY_TRACING_SHADER_GROUP_CREATE_INFO_KHR);
      group.generalShader = group.closestHitShader = group.anyHitShader = group.intersectionShader =
          VK_SHADER_UNUSED_KHR;
      const bool hit = stage == VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR;
      group.type = hit ? VK_RAY_TRACING_SHADER_GROUP_TYPE_TRIANGLES_HIT_GROUP_KHR
                       : VK_RAY_TRACING_SHADER_GROUP_TYPE_GENERAL_KHR;
      (hit ? group.closestHitShader : group.generalShader) = static_cast<uint32_t>(stages.size());
      stages.push_back(made);
      groups.push_back(group);
    }
    auto info = tagged<VkRayTracingPipelineCreateInfoKHR>(
        VK_STRUCTURE_TYPE_RAY_TRACING_PIPELINE_CREATE_INFO_KHR);
    info.stageCount = static_cast<uint32_t>(stages.size());
    info.pStages = stages.data();
    info.groupCount = static_cast<uint32_t>(groups.size());
    info.pGroups = groups.data();
    info.maxPipelineRayRecursionDepth = 1;
    info.layout = layout_;
    EXPECT_EQ(functions_.pipelines(engine_.device(), VK_NULL_HANDLE, VK_NULL_HANDLE, 1, &info,
                                   nullptr, &pipeline_),
              VK_SUCCESS);
    for (const VkPipelineShaderStageCreateInfo& stage : stages)
      vkDestroyShaderModule(engine_.device(), stage.module, nullptr);
  }
  void createTable() {
    auto limits = tagged<VkPhysicalDeviceRayTracingPipelinePropertiesKHR>(
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_PROPERTIES_KHR);
    auto properties =
        tagged<VkPhysicalDeviceProperties2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2);
    properties.pNext = &limits;
    vkGetPhysicalDeviceProperties2(engine_.physical(), &properties);
    const uint32_t size = limits.shaderGroupHandleSize;
    std::vector<std::byte> handles(size_t{3} * size);
    EXPECT_EQ(functions_.handles(engine_.device(), pipeline_, 0, 3, handles.size(), handles.data()),
              VK_SUCCESS);
    const VkDeviceSize stride = aligned(size, limits.shaderGroupBaseAlignment);
    table_ = engine_.createBuffer(4 * stride,
                                  VK_BUFFER_USAGE_SHADER_BINDING_TABLE_BIT_KHR | kAddress, true);
    const VkDeviceAddress begin = addressOf(engine_, table_);
    const VkDeviceAddress first = aligned(begin, limits.shaderGroupBaseAlignment);
    for (size_t i = 0; i < regions_.size(); ++i) {
      regions_[i] = {first + i * stride, stride, stride};
      std::memcpy(static_cast<std::byte*>(table_.mapped) + (regions_[i].deviceAddress - begin),
                  &handles[i * size], size);
    }
  }

  const Engine& engine_;
  const RayFunctions& functions_;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
  EngineBuffer table_, picture_;
  std::array<VkStridedDeviceAddressRegionKHR, 3> regions_ = {};
};

VkAccelerationStructureGeometryKHR trianglesAt(VkDeviceAddress positions, VkDeviceAddress indices,
                                               uint32_t vertices) {
  auto geometry = tagged<VkAccelerationStructureGeometryKHR>(
      VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR);
  geometry.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
  geometry.flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
  auto& triangles = geometry.geometry.triangles;
  triangles = tagged<VkAccelerationStructureGeometryTrianglesDataKHR>(
      VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR);
  triangles.vertexFormat = VK_FORMAT_R32G32B32_SFLOAT;
  triangles.vertexData.deviceAddress = positions;
  triangles.vertexStride = 3 * sizeof(float);
  triangles.maxVertex = vertices - 1;
  triangles.indexType = VK_INDEX_TYPE_UINT32;
  triangles.indexData.deviceAddress = indices;
  return geometry;
}

VkAccelerationStructureGeometryKHR instancesAt(VkDeviceAddress instances) {
  auto geometry = tagged<VkAccelerationStructureGeometryKHR>(
      VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR);
  geometry.geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
  geometry.flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
  geometry.geometry.instances = tagged<VkAccelerationStructureGeometryInstancesDataKHR>(
      VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR);
  geometry.geometry.instances.data.deviceAddress = instances;
  return geometry;
}

class RayStructures : public testing::Test, protected EngineRun {
 protected:
  void SetUp() override {
    auto addresses = tagged<VkPhysicalDeviceBufferDeviceAddressFeatures>(
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES);
    addresses.bufferDeviceAddress = VK_TRUE;
    auto structures = tagged<VkPhysicalDeviceAccelerationStructureFeaturesKHR>(
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR);
    structures.accelerationStructure = VK_TRUE;
    structures.pNext = &addresses;
    auto pipelines = tagged<VkPhysicalDeviceRayTracingPipelineFeaturesKHR>(
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_FEATURES_KHR);
    pipelines.rayTracingPipeline = VK_TRUE;
    pipelines.pNext = &structures;
    open(
        {}, true,
        {{VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
          VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME, VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME},
         &pipelines});
    if (engine_ != nullptr && !engine_->hasExtensions())
      GTEST_SKIP() << "the device traces no rays";
  }
  void TearDown() override {
    for (const EngineBuffer& buffer : buffers_) engine_->destroyBuffer(buffer);
    close();
  }

  // A buffer of the engine for one of the table, with the usages that a build needs.
  VkDeviceAddress give(const Scene& scene, BufferId id, VkBufferUsageFlags usage) {
    buffers_.push_back(engine_->createBuffer(
        scene.resources().whole(id).size,
        usage | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
            VK_BUFFER_USAGE_TRANSFER_SRC_BIT | kAddress |
            VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR,
        false));
    runtime_->registerBuffer(id, {.buffer = buffers_.back().buffer});
    return addressOf(*engine_, buffers_.back());
  }
  VkDeviceAddress instanceOf(VkDeviceAddress structure) {
    VkAccelerationStructureInstanceKHR instance = {};
    for (int i = 0; i < 3; ++i) instance.transform.matrix[i][i] = 1;
    instance.mask = 0xff;
    instance.accelerationStructureReference = structure;
    buffers_.push_back(engine_->createBuffer(
        sizeof(instance),
        VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR | kAddress, true));
    std::memcpy(buffers_.back().mapped, &instance, sizeof(instance));
    return addressOf(*engine_, buffers_.back());
  }

  std::vector<EngineBuffer> buffers_;
};

TEST_F(RayStructures, TraceWhatIsDrawnAndFollowTheHair) {
  vulkan::RuntimeDef runtime = engine_->runtimeDef();
  runtime.code.push_back(rayTracingCode());
  createRuntime(runtime);
  Scene scene;
  HairObject& hair = scene.hair(*required(scene.addHair(rayScene::strands(), rayScene::def())));
  hair.simulated = false;
  RayGeometry rays = *required(
      RayGeometry::create(scene.resources(), hair, {.kind = RayGeometryKind::kTriangles}));
  const VkDeviceAddress positions =
      give(scene, rays.positions(), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
  const VkDeviceAddress indices = give(scene, rays.indices(), VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
  const RayFunctions functions(engine_->device());
  Structure bottom(*engine_, functions, false, trianglesAt(positions, indices, rays.vertexCount()),
                   rays.primitiveCount());
  Structure top(*engine_, functions, true, instancesAt(instanceOf(bottom.address())), 1);
  const Tracer tracer(*engine_, functions);

  SceneRun drawn(Api::kVulkan);
  drawn.add(rayScene::strands(), rayScene::def()).simulated = false;
  PassList list;
  expectOk(drawn.scene.simulate(0, list));
  drawn.execute(list);

  std::vector<bool> first, last;
  // Built once; then the hair falls, and the structure is updated.
  for (int frame = 0; frame < 9; ++frame) {
    SCOPED_TRACE(frame);
    const Engine::Frame& slot = beginFrame();
    hair.simulated = frame > 0;
    Result<Frame> made = required(scene.simulate(1.0f / 60));
    required(rays.addPass(hair, made->addList()));
    required(runtime_->record(*made, slot.commands));
    barrier(slot.commands);
    bottom.build(slot.commands, frame > 0);
    barrier(slot.commands);
    top.build(slot.commands, frame > 0);
    barrier(slot.commands);
    tracer.trace(slot.commands, top.address());
    submit(slot);
    waitForFrames();

    const std::vector<uint32_t> primitives = tracer.primitives(copies_);
    const auto words = [&]<class T>(BufferId id, std::vector<T> values) {
      const std::vector<std::byte> bytes = read(id);
      values.resize(bytes.size() / sizeof(T));
      std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
      return values;
    };
    rayScene::Triangles triangles = {words(rays.positions(), std::vector<float>()),
                                     words(rays.indices(), std::vector<uint32_t>())};
    triangles.indices.resize(rays.indexCount());
    const std::vector<bool> expected = rayScene::trace(triangles);
    std::vector<bool> hits;
    size_t others = 0, wrong = 0;
    for (size_t i = 0; i < primitives.size(); ++i) {
      hits.push_back(primitives[i] > 0);
      others += hits[i] != expected[i] ? 1 : 0;
      if (!hits[i]) continue;
      ASSERT_LE(primitives[i], rays.primitiveCount());
      const auto x = static_cast<uint32_t>(i % rayScene::kPixels);
      const auto y = static_cast<uint32_t>(i / rayScene::kPixels);
      wrong += triangles.isHit(primitives[i] - 1, rayScene::rayOf(x, y), 1e-3f) ? 0 : 1;
    }
    // Rays that graze an edge may hit or not.
    EXPECT_LE(others, 4u);
    EXPECT_EQ(wrong, 0u);
    if (frame == 0) {
      rayScene::expectDrawn(hits, drawn.render({0, 0, rayScene::kDistance}, rayScene::kPixels));
      first = hits;
    }
    last = hits;
  }
  EXPECT_NE(last, first) << "the hair did not move";
  rays.remove(scene.resources());
}

}  // namespace
}  // namespace pelage::test
