#include "codegen/back_end.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <optional>
#include <spirv-tools/libspirv.hpp>
#include <spirv-tools/optimizer.hpp>
#include <spirv_cross/spirv_glsl.hpp>
#include <spirv_cross/spirv_parser.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/checks/checks.h"
#include "codegen/front_end.h"
#include "codegen/reflect.h"
#include "codegen/spirv_reader.h"

namespace pelage::codegen {
namespace {

constexpr spv_target_env kEnvironment = SPV_ENV_VULKAN_1_1;

const BindingPatch* findPatch(const std::vector<BindingPatch>& patches, uint32_t set,
                              uint32_t rawBinding) {
  const auto found = std::find_if(patches.begin(), patches.end(), [&](const BindingPatch& p) {
    return p.set == set && p.rawBinding == rawBinding;
  });
  return found == patches.end() ? nullptr : &*found;
}

// Writes the Vulkan bindings into the module.
std::vector<uint32_t> patchBindings(std::span<const uint32_t> words,
                                    const std::vector<BindingPatch>& patches) {
  std::vector<uint32_t> patched(words.begin(), words.end());
  const std::optional<SpirvReader> module = SpirvReader::parse(words);
  if (!module) return patched;
  constexpr auto kBinding = static_cast<uint32_t>(SpvDecorationBinding);
  for (const SpirvInstruction& instruction : module->instructions()) {
    if (instruction.op != SpvOpDecorate || instruction.operands[1] != kBinding) continue;
    const uint32_t set =
        module->decoration(instruction.operands[0], SpvDecorationDescriptorSet).value_or(0);
    if (const BindingPatch* patch = findPatch(patches, set, instruction.operands[2])) {
      patched[instruction.wordOffset + 3] = patch->binding;
    }
  }
  return patched;
}

// Draws with the same vertex kernel and different pixel kernels must produce the same bits of
// depth.
std::vector<uint32_t> makePositionInvariant(const std::vector<uint32_t>& words) {
  const std::optional<SpirvReader> module = SpirvReader::parse(words);
  if (!module) return words;
  std::vector<uint32_t> result;
  size_t done = 0;
  for (const SpirvInstruction& instruction : module->instructions()) {
    if (instruction.op != SpvOpDecorate || instruction.operands[1] != SpvDecorationBuiltIn ||
        instruction.operands[2] != SpvBuiltInPosition)
      continue;
    constexpr uint32_t kWords = 3;
    const size_t end = instruction.wordOffset + kWords + 1;
    result.insert(result.end(), words.begin() + done, words.begin() + end);
    result.insert(result.end(), {kWords << 16 | uint32_t{SpvOpDecorate}, instruction.operands[0],
                                 uint32_t{SpvDecorationInvariant}});
    done = end;
  }
  result.insert(result.end(), words.begin() + done, words.end());
  return result;
}

spvtools::MessageConsumer collect(std::string& text) {
  return
      [&text](spv_message_level_t level, const char*, const spv_position_t&, const char* message) {
        if (level > SPV_MSG_WARNING) return;
        if (!text.empty()) text += "; ";
        text += message;
      };
}

// One line, so that it fits a diagnostic.
std::string oneLine(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  std::string result;
  for (const char c : text) {
    if (c == '\n') {
      result += " | ";
    } else if (c != '\r') {
      result += c;
    }
  }
  return result;
}

// Runs the registered passes, and gives ids without gaps.
std::optional<std::vector<uint32_t>> run(spvtools::Optimizer& optimizer,
                                         const std::vector<uint32_t>& words) {
  optimizer.RegisterPass(spvtools::CreateCompactIdsPass());
  spvtools::OptimizerOptions options;
  options.set_run_validator(false);
  std::vector<uint32_t> result;
  if (!optimizer.Run(words.data(), words.size(), &result, options)) return std::nullopt;
  return result;
}

std::optional<std::vector<uint32_t>> optimise(const std::vector<uint32_t>& words,
                                              std::string& messages) {
  spvtools::Optimizer optimizer(kEnvironment);
  optimizer.SetMessageConsumer(collect(messages));
  // HLSL may pass resources to functions; SPIR-V may not, until everything is inlined.
  optimizer.RegisterLegalizationPasses();
  optimizer.RegisterPerformancePasses();
  return run(optimizer, words);
}

std::optional<std::vector<uint32_t>> strip(const std::vector<uint32_t>& words) {
  spvtools::Optimizer optimizer(kEnvironment);
  optimizer.RegisterPass(spvtools::CreateStripDebugInfoPass());
  optimizer.RegisterPass(spvtools::CreateStripReflectInfoPass());
  return run(optimizer, words);
}

bool validate(const std::vector<uint32_t>& words, std::string& messages) {
  spvtools::SpirvTools tools(kEnvironment);
  tools.SetMessageConsumer(collect(messages));
  return tools.Validate(words);
}

// Combined image-samplers take the texture's binding; two samplers on one texture would need two.
void bindCombinedSamplers(spirv_cross::CompilerGLSL& compiler, const BackEndInput& input,
                          std::vector<BackEndError>& errors) {
  const spirv_cross::VariableID dummy = compiler.build_dummy_sampler_for_combined_images();
  if (dummy != spirv_cross::VariableID(0)) {
    compiler.set_name(dummy, "noSampler");
  }
  compiler.build_combined_image_samplers();
  std::vector<uint32_t> images;
  for (const spirv_cross::CombinedImageSampler& combined : compiler.get_combined_image_samplers()) {
    const std::string name = compiler.get_name(combined.image_id);
    if (std::find(images.begin(), images.end(), uint32_t{combined.image_id}) != images.end()) {
      errors.push_back({"PK406",
                        "texture '" + name +
                            "' is read through two samplers, or with and without one; GL has one "
                            "combined unit for it: declare a second texture",
                        true});
      continue;
    }
    images.push_back(combined.image_id);
    compiler.set_name(combined.combined_id, name);
    const uint32_t set = compiler.get_decoration(combined.image_id, spv::DecorationDescriptorSet);
    const uint32_t binding = compiler.get_decoration(combined.image_id, spv::DecorationBinding);
    for (const BindingPatch& patch : input.patches) {
      if (patch.set == set && patch.binding == binding &&
          patch.kind == ResourceKind::kSampledTexture) {
        compiler.set_decoration(combined.combined_id, spv::DecorationBinding, patch.glBinding);
      }
    }
  }
}

void bindForGl(spirv_cross::CompilerGLSL& compiler, const BackEndInput& input) {
  const spirv_cross::ShaderResources resources = compiler.get_shader_resources();
  const auto bind = [&](const spirv_cross::SmallVector<spirv_cross::Resource>& list) {
    for (const spirv_cross::Resource& resource : list) {
      const uint32_t set = compiler.get_decoration(resource.id, spv::DecorationDescriptorSet);
      const uint32_t binding = compiler.get_decoration(resource.id, spv::DecorationBinding);
      for (const BindingPatch& patch : input.patches) {
        if (patch.set != set || patch.binding != binding) continue;
        compiler.set_decoration(resource.id, spv::DecorationBinding, patch.glBinding);
        compiler.unset_decoration(resource.id, spv::DecorationDescriptorSet);
      }
    }
  };
  bind(resources.uniform_buffers);
  bind(resources.storage_images);
}

constexpr std::string_view kVertexBlock = "vertex_";

// Each permutation has its own numbers. A buffer that both stages of a program use has two, which
// GL takes for two blocks only when they have two names.
void bindStorageBuffers(spirv_cross::CompilerGLSL& compiler, const BackEndInput& input,
                        const std::vector<uint32_t>& words) {
  const std::optional<SpirvReader> module = SpirvReader::parse(words);
  if (!module) return;
  const auto numbers = storageBufferNumbers(*module, input.firstStorageBinding);
  for (const spirv_cross::Resource& buffer : compiler.get_shader_resources().storage_buffers) {
    const uint32_t set = compiler.get_decoration(buffer.id, spv::DecorationDescriptorSet);
    const uint32_t binding = compiler.get_decoration(buffer.id, spv::DecorationBinding);
    const auto number = numbers.find({set, binding});
    if (number == numbers.end()) continue;
    compiler.set_decoration(buffer.id, spv::DecorationBinding, number->second);
    compiler.unset_decoration(buffer.id, spv::DecorationDescriptorSet);
    if (input.stage != Stage::kVertex) continue;
    // Buffers of one type: the first block has the name of the type, the others that of the
    // variable.
    for (const uint32_t id : {uint32_t{buffer.base_type_id}, uint32_t{buffer.id}}) {
      const std::string name = compiler.get_name(id);
      if (!name.empty() && !name.starts_with(kVertexBlock))
        compiler.set_name(id, std::string(kVertexBlock) + name);
    }
  }
}

// The module as SPIRV-Cross reads it, or its reason not to.
struct ParsedModule {
  std::optional<spirv_cross::ParsedIR> ir;
  std::string error;
};

// SPIRV-Cross reports by exceptions; they end here and in crossCompile().
ParsedModule parseModule(const std::vector<uint32_t>& words) {
  ParsedModule module;
  try {
    spirv_cross::Parser parser(words);
    parser.parse();
    module.ir = std::move(parser.get_parsed_ir());
  } catch (const std::exception& e) {
    module.error = e.what();
  }
  return module;
}

// Writes a variable for each value that a kernel reads from a buffer. SPIRV-Cross would write the
// read at each of its uses, in loops, too, and compilers of GLSL do not take these together where
// something is written in between.
class GlslWriter : public spirv_cross::CompilerGLSL {
 public:
  GlslWriter(const spirv_cross::ParsedIR& parsed, const std::vector<uint32_t>& words)
      : CompilerGLSL(parsed) {
    const std::optional<SpirvReader> module = SpirvReader::parse(words);
    if (!module) return;
    for (const SpirvInstruction& instruction : module->instructions()) {
      if (instruction.op != SpvOpLoad) continue;
      const SpirvInstruction* pointer = module->definition(instruction.operands[0]);
      const SpirvInstruction* type = module->definition(pointer->resultType);
      if (type->operands[0] == SpvStorageClassStorageBuffer)
        forced_temporaries.insert(instruction.result);
    }
  }
};

// Text that means the same, and that NVIDIA's compiler of GLSL is done with in a fraction of the
// time: loops are not unrolled, and what SPIRV-Cross writes as `do { ... } while(false)`, a block
// that is left by `break`, is a switch, which is no loop.
std::string forGlCompilers(const std::string& text) {
  constexpr std::string_view kBegin = "do", kEnd = "} while(false);";
  constexpr std::string_view kLoopEnd = "} while", kVersion = "#version";
  std::vector<std::string> lines;
  std::vector<size_t> open;  // lines with a `do` whose end has not come
  for (size_t from = 0; from < text.size();) {
    const size_t end = std::min(text.find('\n', from), text.size());
    std::string line = text.substr(from, end - from);
    from = end + 1;
    const size_t indent = std::min(line.find_first_not_of(' '), line.size());
    const std::string_view code = std::string_view(line).substr(indent);
    const bool isVersion = code.starts_with(kVersion);
    if (code == kBegin) {
      open.push_back(lines.size());
    } else if (code.starts_with(kLoopEnd) && !open.empty()) {
      if (code == kEnd) {
        lines[open.back()].replace(indent, kBegin.size(), "switch (0u)");
        lines[open.back() + 1] += " default: {";
        line.replace(indent, kEnd.size(), "} }");
      }
      open.pop_back();
    }
    lines.push_back(std::move(line));
    if (isVersion) lines.emplace_back("#pragma optionNV(unroll none)");
  }
  return fmt::format("{}\n", fmt::join(lines, "\n"));
}

std::string crossCompile(const ParsedModule& module, const std::vector<uint32_t>& words,
                         const BackEndInput& input, bool es, std::vector<BackEndError>& errors) {
  const auto fail = [&](std::string reason) {
    errors.push_back({es ? "PK405" : "PK404",
                      std::string("SPIRV-Cross cannot write ") + (es ? "ESSL 320" : "GLSL 450") +
                          " from it: " + oneLine(std::move(reason)),
                      true});
    return std::string();
  };
  if (!module.ir) return fail(module.error);
  try {
    GlslWriter compiler(*module.ir, words);
    spirv_cross::CompilerGLSL::Options options;
    options.version = es ? 320 : 450;
    options.es = es;
    options.enable_420pack_extension = true;
    options.emit_push_constant_as_uniform_buffer = true;
    // Loop variables; Mesa reports them as uninitialized if the head of a for loop declares them.
    options.force_zero_initialized_variables = true;
    options.vertex.support_nonzero_base_instance = false;
    if (input.stage == Stage::kVertex) {
      // HLSL's clip space (y up, depth 0..1) to GL's, with row 0 of the picture at the top.
      options.vertex.fixup_clipspace = true;
      options.vertex.flip_vert_y = true;
    }
    options.fragment.default_float_precision = spirv_cross::CompilerGLSL::Options::Highp;
    options.fragment.default_int_precision = spirv_cross::CompilerGLSL::Options::Highp;
    compiler.set_common_options(options);
    bindCombinedSamplers(compiler, input, errors);
    bindForGl(compiler, input);
    bindStorageBuffers(compiler, input, words);
    return forGlCompilers(compiler.compile());
  } catch (const std::exception& e) {
    return fail(e.what());
  }
}

}  // namespace

BackEndOutput runBackEnd(const BackEndInput& input) {
  BackEndOutput output;
  const auto fail = [&](const char* code, std::string message) {
    output.errors.push_back({code, std::move(message), true});
  };
  std::vector<uint32_t> module = patchBindings(input.rawSpirv, input.patches);
  if (input.precise) module = forbidContraction(module);
  if (input.stage == Stage::kVertex) module = makePositionInvariant(module);

  std::string messages;
  std::optional<std::vector<uint32_t>> optimised = optimise(module, messages);
  if (!optimised) {
    fail("PK402", "spirv-opt refuses the module: " + oneLine(messages));
    return output;
  }
  output.optimised = *optimised;
  // Stripping takes away nothing but names and lines, so one validation does for both modules. The
  // one with names is validated, for better messages.
  std::optional<std::vector<uint32_t>> stripped = strip(*optimised);
  messages.clear();
  if (!stripped || !validate(*stripped, messages)) {
    std::string named;
    const bool valid = validate(*optimised, named);
    fail("PK403", valid ? "spirv-val on the stripped module: " + oneLine(messages)
                        : "spirv-val: " + oneLine(named));
    return output;
  }
  output.spirv = std::move(*stripped);

  const ParsedModule parsed = parseModule(*optimised);
  output.glsl = crossCompile(parsed, *optimised, input, false, output.errors);
  std::vector<BackEndError> esErrors;
  output.essl = crossCompile(parsed, *optimised, input, true, esErrors);
  const auto reparse = [&](std::string& text, const char* code, const char* language,
                           std::vector<BackEndError>& errors) {
    if (text.empty()) return;
    const std::string log = parseGlsl(text, input.stage);
    if (log.empty()) return;
    errors.push_back(
        {code,
         std::string("the ") + language + " that SPIRV-Cross wrote does not parse: " + oneLine(log),
         true});
    text.clear();
  };
  reparse(output.glsl, "PK407", "GLSL 450", output.errors);
  reparse(output.essl, "PK408", "ESSL 320", esErrors);
  for (BackEndError& error : esErrors) {
    // A kernel of the wide tier may use features that GLES lacks; it then has no ESSL.
    error.isError = input.tier != Tier::kWide;
    if (std::find_if(output.errors.begin(), output.errors.end(), [&](const BackEndError& e) {
          return e.message == error.message;
        }) == output.errors.end()) {
      output.errors.push_back(std::move(error));
    }
  }
  return output;
}

std::string backEndVersion() {
  return std::string(spvSoftwareVersionDetailsString()) + " SPIRV-Cross " +
         std::to_string(SPV_REVISION);
}

}  // namespace pelage::codegen
