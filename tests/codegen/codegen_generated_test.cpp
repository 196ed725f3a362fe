// The generated code of the fixture, as an engine would use it.
#include <gtest/gtest.h>

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <type_traits>
#include <vector>

#include "codegen/spirv_reader.h"
#include "fixture/gpu/bindings.h"
#include "fixture/gpu/code.h"
#include "fixture/gpu/constants.h"
#include "fixture/gpu/gpu_structs.h"
#include "fixture/gpu/kernels.h"
#include "fixture/gpu/layouts.h"
#include "pelage/bindings.h"
#include "pelage/code.h"
#include "pelage/gpu_structs.h"
#include "pelage/kernels.h"
#include "pelage/layouts.h"
#include "support/errors.h"

namespace {

namespace gpu = fixture::gpu;
using pelage::Access;
using pelage::codegen::SpirvInstruction;
using pelage::codegen::SpirvReader;
using pelage::test::expectHas;

// True when the variant template accepts the key.
template <gpu::MoveParticlesKey K>
concept Compiles = requires {
  gpu::moveParticlesVariant<K>();
};

constexpr gpu::MoveParticlesKey kAllowed{.airDrag = true,
                                         .subSteps = gpu::MoveParticlesSubSteps::k4};
constexpr gpu::MoveParticlesKey kIncomplete{.bounce = true,
                                            .subSteps = gpu::MoveParticlesSubSteps::k1};
constexpr gpu::MoveParticlesKey kConflict{.bounce = true,
                                          .subSteps = gpu::MoveParticlesSubSteps::k4};

TEST(GeneratedKernels, DoNotCompileForAnExcludedKey) {
  static_assert(Compiles<gpu::MoveParticlesKey{}>);
  static_assert(Compiles<kAllowed>);
  static_assert(!Compiles<kConflict>);
  static_assert(!Compiles<kIncomplete>);
  static_assert(gpu::exists(kAllowed) && !gpu::exists(kConflict) && !gpu::exists(kIncomplete));
  EXPECT_EQ(gpu::moveParticlesVariant(kConflict), nullptr);
  EXPECT_EQ(gpu::moveParticlesVariant(kAllowed), &gpu::moveParticlesVariant<kAllowed>());
}

TEST(GeneratedKernels, CompleteAKeyThatTheManifestExcludes) {
  static_assert(completeKey(kAllowed) == kAllowed);
  static_assert(completeKey(kIncomplete) ==
                gpu::MoveParticlesKey{
                    .airDrag = true, .bounce = true, .subSteps = gpu::MoveParticlesSubSteps::k1});
  static_assert(!exists(completeKey(kConflict)));
  static_assert(completeKey(gpu::CountParticlesKey{.unused = true}).unused);
  EXPECT_EQ(gpu::moveParticlesVariant(kIncomplete), nullptr);
  EXPECT_NE(gpu::moveParticlesVariant(completeKey(kIncomplete)), nullptr);
}

TEST(GeneratedKernels, OfPelageGiveRareFeaturesTheCommonOnes) {
  static_assert(completeKey(pelage::FindContactsKey{.denseSdf = true}) ==
                pelage::FindContactsKey{.sdf = true, .denseSdf = true});
  // Whatever a scene has, there is a kernel for it.
  for (int bits = 0; bits < 4; ++bits) {
    const pelage::FindContactsKey key{(bits & 1) != 0, (bits & 2) != 0};
    EXPECT_NE(findContactsVariant(completeKey(key)), nullptr) << bits;
    EXPECT_EQ(completeKey(key) == key, exists(key)) << bits;
  }
}

TEST(GeneratedKernels, HaveAVariantOfTheirOwnForEachKey) {
  EXPECT_EQ(gpu::moveParticlesVariant({})->key, std::string("airDrag=0 bounce=0 subSteps=2"))
      << "the first value of an axis is the default";
  std::set<const pelage::KernelVariant*> found;
  for (const bool drag : {false, true}) {
    for (const bool bounce : {false, true}) {
      for (const auto steps : {gpu::MoveParticlesSubSteps::k1, gpu::MoveParticlesSubSteps::k2,
                               gpu::MoveParticlesSubSteps::k4}) {
        const pelage::KernelVariant* variant = gpu::moveParticlesVariant({drag, bounce, steps});
        if (variant == nullptr) continue;
        found.insert(variant);
        const std::string key = variant->key;
        expectHas(key, drag ? "airDrag=1" : "airDrag=0");
        expectHas(key, bounce ? "bounce=1" : "bounce=0");
        expectHas(key, "subSteps=" + std::to_string(static_cast<int>(steps)));
        EXPECT_EQ(variant->kernel, &gpu::kMoveParticlesKernel);
      }
    }
  }
  EXPECT_EQ(found.size(), 9u);
  EXPECT_EQ(gpu::kMoveParticlesKernel.variants.size(), 9u);
}

TEST(GeneratedKernels, StoreEqualVariantsOnce) {
  EXPECT_EQ(&gpu::countParticlesVariant({.unused = false}),
            &gpu::countParticlesVariant({.unused = true}));
  EXPECT_EQ(gpu::kCountParticlesKernel.variants.size(), 1u);
}

TEST(GeneratedKernels, KnowGroupSizeStageAndLayouts) {
  const pelage::KernelVariant& count = gpu::countParticlesVariant();
  EXPECT_EQ(count.groupSize[0], 32u);
  EXPECT_EQ(count.groupSize[1], 2u);
  EXPECT_EQ(count.groupSize[2], 1u);
  EXPECT_EQ(gpu::pointVertexVariant().groupSize[0], 0u);
  EXPECT_EQ(gpu::kPointVertexKernel.stage, pelage::Stage::kVertex);
  EXPECT_EQ(gpu::kPointPixelKernel.stage, pelage::Stage::kPixel);
  ASSERT_EQ(gpu::kCountParticlesKernel.layouts.size(), 2u);
  EXPECT_EQ(gpu::kCountParticlesKernel.layouts[0], &gpu::kParticlesLayout);
  EXPECT_EQ(gpu::kCountParticlesKernel.layouts[1], &gpu::kForcesLayout);
  EXPECT_EQ(gpu::allKernels().size(), 4u);
}

Access accessOf(const pelage::KernelVariant& variant, uint8_t set, uint8_t entry) {
  for (const pelage::VariantBinding& binding : variant.bindings) {
    if (binding.set == set && binding.entry == entry) return binding.access;
  }
  return Access::kNone;
}

TEST(GeneratedKernels, KnowWhatEachVariantReadsAndWrites) {
  const pelage::KernelVariant& move = *gpu::moveParticlesVariant({});
  EXPECT_EQ(accessOf(move, 0, gpu::ParticlesEntry::particles), Access::kReadWrite);
  EXPECT_EQ(accessOf(move, 0, gpu::ParticlesEntry::cellCounts), Access::kNone);
  EXPECT_EQ(accessOf(move, 1, gpu::ForcesEntry::wells), Access::kRead)
      << "read in a helper function";
  EXPECT_EQ(accessOf(move, 1, gpu::ForcesEntry::trail), Access::kWrite);
  EXPECT_EQ(accessOf(move, 1, gpu::ForcesEntry::noise), Access::kRead);
  EXPECT_EQ(accessOf(move, 1, gpu::ForcesEntry::noiseSampler), Access::kRead);
  const pelage::KernelVariant& count = gpu::countParticlesVariant();
  EXPECT_EQ(accessOf(count, 0, gpu::ParticlesEntry::particles), Access::kRead);
  EXPECT_EQ(accessOf(count, 0, gpu::ParticlesEntry::cellCounts), Access::kReadWrite) << "an atomic";
  EXPECT_EQ(accessOf(count, 1, gpu::ForcesEntry::log), Access::kWrite);
}

// (set, binding) of all resources of a module.
std::set<std::pair<uint32_t, uint32_t>> moduleBindings(const SpirvReader& module) {
  std::set<std::pair<uint32_t, uint32_t>> bindings;
  for (const SpirvInstruction& i : module.instructions()) {
    if (i.op != SpvOpVariable) continue;
    const auto set = module.decoration(i.result, SpvDecorationDescriptorSet);
    const auto binding = module.decoration(i.result, SpvDecorationBinding);
    if (set && binding) bindings.insert({*set, *binding});
  }
  return bindings;
}

const pelage::KernelCodes& codes() {
  static const pelage::KernelCodes all = [] {
    pelage::KernelCodes both(gpu::allCode());
    both.add(pelage::allCode());
    return both;
  }();
  return all;
}

std::vector<uint32_t> spirvOf(const pelage::KernelVariant& variant) {
  const pelage::Result<std::vector<uint32_t>> words = codes().spirv(variant);
  EXPECT_TRUE(words) << words.error().message;
  return words ? *words : std::vector<uint32_t>();
}

std::string sourceOf(const pelage::KernelVariant& variant, pelage::CodeFormat format) {
  const pelage::Result<std::string> text = codes().source(variant, format);
  EXPECT_TRUE(text) << text.error().message;
  return text ? *text : std::string();
}
std::string glslOf(const pelage::KernelVariant& variant) {
  return sourceOf(variant, pelage::CodeFormat::kGlsl);
}
std::string esslOf(const pelage::KernelVariant& variant) {
  return sourceOf(variant, pelage::CodeFormat::kEssl);
}

// Calls visit(kernel, variant, module) for each variant of all kernels.
template <class Visit>
void forEachModule(const Visit& visit) {
  for (const auto kernels : {gpu::allKernels(), pelage::allKernels()}) {
    for (const pelage::Kernel* kernel : kernels) {
      for (const pelage::KernelVariant* variant : kernel->variants) {
        SCOPED_TRACE(std::string(kernel->name) + " " + variant->key);
        const std::vector<uint32_t> words = spirvOf(*variant);
        const std::optional<SpirvReader> module = SpirvReader::parse(words);
        ASSERT_TRUE(module);
        visit(*kernel, *variant, *module);
      }
    }
  }
}

TEST(GeneratedKernels, CarrySpirvWithThePlannedBindingsAndNoNames) {
  forEachModule([](const pelage::Kernel& kernel, const pelage::KernelVariant& variant,
                   const SpirvReader& module) {
    std::set<std::pair<uint32_t, uint32_t>> planned;
    for (const pelage::VariantBinding& binding : variant.bindings)
      planned.insert({binding.set, kernel.layouts[binding.set]->entries[binding.entry].binding});
    EXPECT_EQ(moduleBindings(module), planned);
    for (const SpirvInstruction& instruction : module.instructions()) {
      EXPECT_NE(instruction.op, SpvOpName);
      EXPECT_NE(instruction.op, SpvOpLine);
      EXPECT_NE(instruction.op, SpvOpString);
    }
    EXPECT_TRUE(glslOf(variant).starts_with("#version 450\n"));
    EXPECT_TRUE(esslOf(variant).starts_with("#version 320 es\n"));
    EXPECT_NE(variant.hash, 0u);
  });
}

TEST(GeneratedKernels, BindByNumberInGlsl) {
  for (const std::string& text :
       {glslOf(*gpu::moveParticlesVariant({})), esslOf(*gpu::moveParticlesVariant({}))}) {
    expectHas(text, "layout(binding = 0, std140) uniform ForceConstants");
    expectHas(text, "layout(binding = 0, std430) buffer g_particles");
    expectHas(text, "layout(binding = 1, std430) readonly buffer g_wells");
    expectHas(text, "layout(binding = 0) uniform");
  }
}

size_t countOf(std::string_view text, std::string_view part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != std::string_view::npos; at = text.find(part, at + 1))
    ++count;
  return count;
}

// Instructions that read or write an element of a storage buffer.
size_t bufferAccesses(const SpirvReader& module) {
  const auto inBuffer = [&](uint32_t id) {
    const SpirvInstruction* pointer = module.definition(id);
    const SpirvInstruction* type =
        pointer != nullptr ? module.definition(pointer->resultType) : nullptr;
    return type != nullptr && type->op == SpvOpTypePointer &&
           type->operands[0] == SpvStorageClassStorageBuffer;
  };
  size_t count = 0;
  for (const SpirvInstruction& instruction : module.instructions()) {
    const bool isAccess = instruction.op == SpvOpLoad || instruction.op == SpvOpStore ||
                          (instruction.op >= SpvOpAtomicLoad && instruction.op <= SpvOpAtomicXor);
    if (isAccess && inBuffer(instruction.operands[0])) ++count;
  }
  return count;
}

TEST(GeneratedKernels, ReadABufferInGlslAsOftenAsInSpirv) {
  size_t all = 0;
  forEachModule(
      [&](const pelage::Kernel&, const pelage::KernelVariant& variant, const SpirvReader& module) {
        const size_t accesses = bufferAccesses(module);
        all += accesses;
        for (const std::string& text : {glslOf(variant), esslOf(variant)})
          EXPECT_LE(countOf(text, "._data["), accesses);
      });
  EXPECT_GT(all, 1000u);
}

TEST(GeneratedKernels, StayPreciseInSpirvAndInGlsl) {
  const pelage::KernelVariant& variant =
      *gpu::moveParticlesVariant({.airDrag = true, .bounce = true});
  const std::vector<uint32_t> words = spirvOf(variant);
  const std::optional<SpirvReader> module = SpirvReader::parse(words);
  ASSERT_TRUE(module);
  size_t products = 0;
  for (const SpirvInstruction& i : module->instructions()) {
    if (i.op != SpvOpFMul && i.op != SpvOpFAdd && i.op != SpvOpVectorTimesScalar) continue;
    ++products;
    EXPECT_TRUE(module->decoration(i.result, SpvDecorationNoContraction).has_value());
  }
  EXPECT_GT(products, 10u);
  expectHas(glslOf(variant), "precise ");
  expectHas(esslOf(variant), "precise ");
}

TEST(GeneratedKernels, MapClipSpaceInTheVertexStageAlone) {
  expectHas(glslOf(gpu::pointVertexVariant()), "gl_Position.y = -gl_Position.y");
  expectHas(esslOf(gpu::pointVertexVariant()), "gl_Position.y = -gl_Position.y");
  expectHas(esslOf(gpu::pointVertexVariant()), "2.0 * gl_Position.z - gl_Position.w");
  EXPECT_EQ(glslOf(gpu::pointVertexVariant()).find("SPIRV_Cross_BaseInstance"), std::string::npos);
}

TEST(GeneratedKernels, DeclareThePositionInvariantForDrawsThatMeetAgainAtTheSameDepth) {
  size_t positions = 0;
  forEachModule([&](const pelage::Kernel& kernel, const pelage::KernelVariant& variant,
                    const SpirvReader& module) {
    if (kernel.stage != pelage::Stage::kVertex) return;
    for (const SpirvInstruction& i : module.instructions()) {
      if (i.op != SpvOpDecorate || i.operands[1] != SpvDecorationBuiltIn ||
          i.operands[2] != SpvBuiltInPosition)
        continue;
      ++positions;
      EXPECT_TRUE(module.decoration(i.operands[0], SpvDecorationInvariant).has_value());
    }
    expectHas(glslOf(variant), "invariant gl_Position;");
    expectHas(esslOf(variant), "invariant gl_Position;");
  });
  EXPECT_GT(positions, 5u);
}

TEST(GeneratedSpecialization, GivesTheDefaultsOfTheHlslAndTheBitsOfEachType) {
  const gpu::MoveParticlesSpecialization defaults;
  EXPECT_EQ(defaults.restitution, 0.5f);
  EXPECT_EQ(defaults.wellLimit, 16u);
  EXPECT_TRUE(defaults.attract);
  EXPECT_EQ(defaults.bias, -3);
  static_assert(std::is_same_v<decltype(defaults.wellLimit), uint32_t>);
  gpu::MoveParticlesSpecialization changed;
  changed.restitution = 1.0f;
  changed.attract = false;
  changed.bias = -1;
  const auto values = changed.values();
  ASSERT_EQ(values.size(), 4u);
  EXPECT_EQ(values[0], (pelage::SpecValue{2, 16}));
  EXPECT_EQ(values[1], (pelage::SpecValue{4, 0}));
  EXPECT_EQ(values[2], (pelage::SpecValue{5, 0xffffffffu}));
  EXPECT_EQ(values[3], (pelage::SpecValue{7, 0x3f800000u}));
  ASSERT_EQ(gpu::kMoveParticlesKernel.specConstants.size(), 4u);
  EXPECT_STREQ(gpu::kMoveParticlesKernel.specConstants[3].name, "g_restitution");
  EXPECT_EQ(gpu::kMoveParticlesKernel.specConstants[3].defaultBits, 0x3f000000u);
  expectHas(glslOf(*gpu::moveParticlesVariant({.bounce = true})), "SPIRV_CROSS_CONSTANT_ID_7");
}

TEST(GeneratedConstants, AreThoseOfTheHlsl) {
  namespace limits = gpu::limits;
  static_assert(limits::kMaxParticles == 1048576u);
  static_assert(limits::kDeadFlag == 4u && limits::kStuckFlag == 8u);
  static_assert(limits::kAnyFlag == 0x8000000cu);
  static_assert(limits::kLowestCell == -64);
  static_assert(limits::kRestingSpeed == 1.5f / 65535.0f);
  static_assert(limits::kNowhere == 1e18f);
  static_assert(std::is_same_v<decltype(limits::kMaxParticles), const uint32_t>);
  static_assert(std::is_same_v<decltype(limits::kLowestCell), const int32_t>);
}

TEST(GeneratedKernels, NameTheSizeOfTheirGroups) {
  for (const auto& [kernel, size] :
       {std::pair(&gpu::kMoveParticlesKernel, gpu::kMoveParticlesGroupSize),
        std::pair(&pelage::kFindContactsKernel, pelage::kFindContactsGroupSize)}) {
    for (const pelage::KernelVariant* variant : kernel->variants) {
      EXPECT_EQ(variant->groupSize[0], size.x) << kernel->name;
      EXPECT_EQ(variant->groupSize[1], size.y) << kernel->name;
      EXPECT_EQ(variant->groupSize[2], size.z) << kernel->name;
    }
  }
}

TEST(GeneratedBindings, GiveEachEntryOfTheLayoutItsOwnMember) {
  gpu::ForcesBindings forces;
  forces.forceConstants = gpu::ForceConstants{};
  forces.wells = {pelage::BufferId{1}, 64, 16};
  forces.trail = {pelage::BufferId{2}, 32};
  forces.log = {pelage::BufferId{3}, 8};
  const pelage::LayoutBindings view(forces);
  EXPECT_EQ(&view.layout(), &gpu::kForcesLayout);
  const auto buffer = [&](uint8_t entry) { return view.at(entry).range.buffer; };
  EXPECT_EQ(buffer(gpu::ForcesEntry::wells), pelage::BufferId{1});
  EXPECT_EQ(view.at(gpu::ForcesEntry::wells).range.size, 64u);
  EXPECT_EQ(view.at(gpu::ForcesEntry::wells).range.offset, 16u);
  EXPECT_EQ(buffer(gpu::ForcesEntry::trail), pelage::BufferId{2});
  EXPECT_EQ(buffer(gpu::ForcesEntry::log), pelage::BufferId{3});
  const auto block = view.at(gpu::ForcesEntry::forceConstants).block;
  ASSERT_EQ(block.size(), sizeof(gpu::ForceConstants));
  EXPECT_EQ(static_cast<const void*>(block.data()), &*forces.forceConstants) << "not a copy";
  for (const auto texture : {gpu::ForcesEntry::noise, gpu::ForcesEntry::noiseSampler})
    EXPECT_FALSE(view.at(texture).isBound()) << "pass lists have buffers alone";
}

TEST(GeneratedBindings, AreEmptyAtFirst) {
  const pelage::ExactBindings exact;
  const pelage::LayoutBindings view(exact);
  for (uint8_t entry = 0; entry < pelage::kExactLayout.entries.size(); ++entry)
    EXPECT_FALSE(view.at(entry).isBound()) << pelage::kExactLayout.entries[entry].name;
}

template <class Bindings>
concept HasMisspelt = requires(Bindings bindings) {
  bindings.contcats = {};
};
template <class Bindings>
concept HasContacts = requires(Bindings bindings) {
  bindings.contacts = {};
};

TEST(GeneratedBindings, DoNotCompileWithAMisspeltName) {
  static_assert(HasContacts<pelage::SimBindings> && !HasMisspelt<pelage::SimBindings>);
  static_assert(!HasContacts<pelage::SimPosTanBindings>, "nor with one of another layout");
  static_assert(!std::is_constructible_v<pelage::LayoutBindings, int>);
}

struct Manager {
  std::vector<const pelage::LayoutTable*> made;
  int createLayout(const pelage::LayoutTable& table) {
    made.push_back(&table);
    return static_cast<int>(made.size());
  }
};

TEST(GeneratedLayouts, AreHandedToTheEnginesManager) {
  Manager manager;
  EXPECT_EQ(gpu::CreateParticlesLayout(manager), 1);
  EXPECT_EQ(gpu::CreateForcesLayout(manager), 2);
  EXPECT_EQ(pelage::CreateSimPosTanLayout(manager), 3);
  EXPECT_EQ(pelage::CreateSimLayout(manager), 4);
  EXPECT_EQ(pelage::CreateRenderPosTanLayout(manager), 5);
  EXPECT_EQ(pelage::CreateRenderLayout(manager), 6);
  EXPECT_EQ(manager.made[1], &gpu::kForcesLayout);
  EXPECT_EQ(manager.made[2], &pelage::kSimPosTanLayout);
}

TEST(GeneratedLayouts, NumberBindingsDenselyByClassAndRegister) {
  std::vector<std::string> names;
  for (const pelage::LayoutEntry& entry : gpu::kForcesLayout.entries) {
    EXPECT_EQ(entry.binding, names.size());
    names.push_back(entry.name);
  }
  EXPECT_EQ(names, (std::vector<std::string>{"ForceConstants", "g_noise", "g_wells", "g_trail",
                                             "g_log", "g_noiseSampler"}));
}

// The entry of the kernel's layout that a variant's binding refers to.
const pelage::LayoutEntry& entryOf(const pelage::KernelVariant& variant,
                                   const pelage::VariantBinding& binding) {
  return variant.kernel->layouts[binding.set]->entries[binding.entry];
}

TEST(GeneratedKernels, NumberGlBindingsWithinTheirTierAndWithoutCollisionsInADraw) {
  const auto numbers = [](const pelage::KernelVariant& variant) {
    std::set<uint32_t> used;
    for (const pelage::VariantBinding& binding : variant.bindings) {
      const pelage::LayoutEntry& entry = entryOf(variant, binding);
      if (entry.kind != pelage::ResourceKind::kStorageBuffer) {
        EXPECT_EQ(binding.glBinding, entry.glBinding) << variant.kernel->name << entry.name;
        continue;
      }
      EXPECT_TRUE(used.insert(binding.glBinding).second) << variant.kernel->name << entry.name;
    }
    const pelage::TierLimits limits = pelage::limitsOf(variant.tier);
    EXPECT_LE(used.size(), limits.storageBuffers.of(variant.kernel->stage)) << variant.kernel->name;
    if (!used.empty()) {
      EXPECT_LT(*used.rbegin(), limits.storageBindings) << variant.kernel->name;
    }
    return used;
  };
  int draws = 0;
  for (const auto kernels : {gpu::allKernels(), pelage::allKernels()}) {
    for (const pelage::Kernel* kernel : kernels) {
      for (const pelage::KernelVariant* variant : kernel->variants) {
        const std::set<uint32_t> own = numbers(*variant);
        if (kernel->stage != pelage::Stage::kVertex) {
          EXPECT_TRUE(own.empty() || *own.rbegin() + 1 == own.size()) << "dense from 0";
          continue;
        }
        for (const pelage::Kernel* pixel : kernels) {
          if (pixel->stage != pelage::Stage::kPixel || !pelage::layoutsFit(*kernel, *pixel))
            continue;
          for (const pelage::KernelVariant* other : pixel->variants) {
            ++draws;
            for (const uint32_t number : numbers(*other)) EXPECT_FALSE(own.contains(number));
          }
        }
      }
    }
  }
  EXPECT_GT(draws, 10);
}

TEST(GeneratedLayouts, NumberGlBindingsDenselyForEachKindOverTheSetsOfAGroup) {
  for (const auto kernels : {gpu::allKernels(), pelage::allKernels()}) {
    ASSERT_FALSE(kernels.empty());
    for (const pelage::Kernel* kernel : kernels) {
      // Groups that share their first layouts count them each on its own.
      std::map<pelage::ResourceKind, uint32_t> next;
      for (const pelage::LayoutTable* layout : kernel->layouts) {
        for (const pelage::LayoutEntry& entry : layout->entries) {
          if (entry.kind == pelage::ResourceKind::kSampler) continue;
          if (entry.kind == pelage::ResourceKind::kStorageBuffer) continue;
          EXPECT_EQ(entry.glBinding, next[entry.kind]++) << kernel->name << " " << entry.name;
        }
      }
    }
  }
}

TEST(GeneratedLayouts, JoinAccessAndStagesOfAllKernels) {
  const pelage::LayoutEntry& particles =
      gpu::kParticlesLayout.entries[gpu::ParticlesEntry::particles];
  EXPECT_EQ(particles.access, Access::kReadWrite);
  EXPECT_EQ(particles.stride, sizeof(gpu::Particle));
  const pelage::LayoutEntry& constants = gpu::kDrawLayout.entries[gpu::DrawEntry::drawConstants];
  EXPECT_EQ(constants.stages,
            pelage::stageBit(pelage::Stage::kVertex) | pelage::stageBit(pelage::Stage::kPixel));
  EXPECT_EQ(constants.stride, sizeof(gpu::DrawConstants));
}

// Offsets of the members of the struct that is bound at (set, binding), from the shipped SPIR-V.
std::vector<uint32_t> spirvOffsets(const pelage::KernelVariant& variant, uint32_t set,
                                   uint32_t entry) {
  const std::vector<uint32_t> words = spirvOf(variant);
  const std::optional<SpirvReader> module = SpirvReader::parse(words);
  std::vector<uint32_t> offsets;
  if (!module) return offsets;
  const uint32_t binding = variant.kernel->layouts[set]->entries[entry].binding;
  for (const SpirvInstruction& i : module->instructions()) {
    if (i.op != SpvOpVariable || module->decoration(i.result, SpvDecorationDescriptorSet) != set ||
        module->decoration(i.result, SpvDecorationBinding) != binding) {
      continue;
    }
    uint32_t type = module->definition(i.resultType)->operands[1];
    const SpirvInstruction* last = module->definition(module->definition(type)->operands.back());
    if (last->op == SpvOpTypeRuntimeArray) type = last->operands[0];
    for (uint32_t m = 0; m < module->definition(type)->operands.size(); ++m) {
      offsets.push_back(module->memberDecoration(type, m, SpvDecorationOffset).value_or(~0u));
    }
  }
  return offsets;
}

TEST(GeneratedStructs, HaveTheOffsetsOfTheSpirv) {
  using gpu::ForceConstants;
  using gpu::Particle;
  using gpu::Well;
  const pelage::KernelVariant& variant =
      *gpu::moveParticlesVariant({.airDrag = true, .bounce = true});
  EXPECT_EQ(spirvOffsets(variant, 1, gpu::ForcesEntry::forceConstants),
            (std::vector<uint32_t>{
                offsetof(ForceConstants, planes), offsetof(ForceConstants, gravity),
                offsetof(ForceConstants, timeStep), offsetof(ForceConstants, particleCount),
                offsetof(ForceConstants, wellCount), offsetof(ForceConstants, drag),
                offsetof(ForceConstants, gridOrigin), offsetof(ForceConstants, lastOne),
                offsetof(ForceConstants, window)}));
  EXPECT_EQ(spirvOffsets(variant, 0, gpu::ParticlesEntry::particles),
            (std::vector<uint32_t>{offsetof(Particle, position), offsetof(Particle, size),
                                   offsetof(Particle, kind), offsetof(Particle, lives),
                                   offsetof(Particle, cell), offsetof(Particle, history),
                                   offsetof(Particle, last)}));
  EXPECT_EQ(spirvOffsets(variant, 1, gpu::ForcesEntry::wells),
            (std::vector<uint32_t>{offsetof(Well, center), offsetof(Well, strength),
                                   offsetof(Well, radius)}));
  static_assert(sizeof(ForceConstants) % 16 == 0);
}

}  // namespace
