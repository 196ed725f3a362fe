#include "codegen/msl.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <map>
#include <optional>
#include <spirv_cross/spirv_msl.hpp>
#include <tuple>

#include "codegen/reflect.h"
#include "codegen/spirv_reader.h"

namespace pelage::codegen {
namespace {

constexpr const char* kTableNames[] = {"buffer", "texture", "sampler"};

class MslWriter {
 public:
  explicit MslWriter(std::span<const uint32_t> words)
      : words_(words), compiler_(words.data(), words.size()) {}

  MslModule write(uint32_t vertexBuffers) {
    checkGroup();
    const auto active = compiler_.get_active_interface_variables();
    const spirv_cross::ShaderResources resources = compiler_.get_shader_resources(active);
    compiler_.set_enabled_interface_variables(active);
    collect(resources.uniform_buffers, MetalTable::kBuffer, true);
    collect(resources.storage_buffers, MetalTable::kBuffer, false);
    collect(resources.separate_images, MetalTable::kTexture, false);
    collect(resources.storage_images, MetalTable::kTexture, false);
    collect(resources.separate_samplers, MetalTable::kSampler, false);
    std::sort(module_.bindings.begin(), module_.bindings.end(), [](const auto& a, const auto& b) {
      return std::tie(a.set, a.entry) < std::tie(b.set, b.entry);
    });
    const spirv_cross::EntryPoint entry = compiler_.get_entry_points_and_stages()[0];
    for (MetalBinding& binding : module_.bindings) {
      binding.slot = take(binding.table, names_[{binding.set, binding.entry}]);
      spirv_cross::MSLResourceBinding slot;
      slot.stage = entry.execution_model;
      slot.desc_set = binding.set;
      slot.binding = binding.entry;
      slot.count = 1;
      slot.msl_buffer = slot.msl_texture = slot.msl_sampler = binding.slot;
      compiler_.add_msl_resource_binding(slot);
    }
    if (!module_.errors.empty()) return std::move(module_);

    spirv_cross::CompilerGLSL::Options common;
    common.force_zero_initialized_variables = true;
    compiler_.set_common_options(common);
    spirv_cross::CompilerMSL::Options options;
    options.set_msl_version(2, 1);  // the first one with [[invariant]] positions
    options.buffer_size_buffer_index = next_[0];
    compiler_.set_msl_options(options);
    module_.source = compiler_.compile();
    if (compiler_.needs_buffer_size_buffer())
      module_.sizes = take(MetalTable::kBuffer, "the sizes of buffers");
    if (vertexBuffers > 0) module_.vertexBuffer = static_cast<uint8_t>(next_[0]);
    for (uint32_t i = 0; i < vertexBuffers; ++i) take(MetalTable::kBuffer, "vertex inputs");
    module_.function = compiler_.get_cleansed_entry_point_name(entry.name, entry.execution_model);
    if (!module_.errors.empty()) module_.source.clear();
    return std::move(module_);
  }

 private:
  void collect(const spirv_cross::SmallVector<spirv_cross::Resource>& resources, MetalTable table,
               bool isBlock) {
    for (const spirv_cross::Resource& resource : resources) {
      MetalBinding binding{};
      binding.set =
          static_cast<uint8_t>(compiler_.get_decoration(resource.id, spv::DecorationDescriptorSet));
      binding.entry =
          static_cast<uint8_t>(compiler_.get_decoration(resource.id, spv::DecorationBinding));
      binding.table = table;
      if (isBlock) {
        const size_t bytes =
            compiler_.get_declared_struct_size(compiler_.get_type(resource.base_type_id));
        binding.bytes = static_cast<uint32_t>((bytes + 15) / 16 * 16);
      }
      module_.bindings.push_back(binding);
      // A constant block has the name of its type only.
      const std::string& name = compiler_.get_name(resource.id);
      names_[{binding.set, binding.entry}] =
          "'" + (name.empty() ? compiler_.get_name(resource.base_type_id) : name) + "'";
    }
  }

  uint8_t take(MetalTable table, const std::string& what) {
    const auto index = static_cast<size_t>(table);
    const uint32_t slot = next_[index]++;
    const uint32_t count = kMetalLimits.slots[index];
    if (slot >= count)
      refuse(fmt::format("has no {} slot for {}: Metal has {}", kTableNames[index], what, count));
    return static_cast<uint8_t>(slot);
  }

  void checkGroup() {
    const std::optional<SpirvReader> module = SpirvReader::parse(words_);
    if (!module) return;
    const ModuleReflection reflection = reflectModule(*module);
    const uint64_t threads =
        uint64_t{reflection.groupSize[0]} * reflection.groupSize[1] * reflection.groupSize[2];
    if (threads > kMetalLimits.threads)
      refuse(fmt::format("has {} threads in a group, Metal has {}", threads, kMetalLimits.threads));
    if (reflection.sharedBytes > kMetalLimits.threadgroupBytes)
      refuse(fmt::format("has {} bytes of groupshared memory, Metal has {}", reflection.sharedBytes,
                         kMetalLimits.threadgroupBytes));
  }

  void refuse(std::string why) { module_.errors.push_back({"PK415", std::move(why), true}); }

  std::span<const uint32_t> words_;
  spirv_cross::CompilerMSL compiler_;
  std::map<std::pair<uint32_t, uint32_t>, std::string> names_;  // by (set, entry), for messages
  uint32_t next_[3] = {0, 0, 0};                                // free slot of each table
  MslModule module_;
};

}  // namespace

MslModule writeMsl(std::span<const uint32_t> spirv, uint32_t vertexBuffers) {
  try {
    return MslWriter(spirv).write(vertexBuffers);
  } catch (const std::exception& e) {
    MslModule failed;
    failed.errors.push_back(
        {"PK416", std::string("cannot be written as MSL: SPIRV-Cross: ") + e.what(), true});
    return failed;
  }
}

}  // namespace pelage::codegen
