// docs/limits.md is made from the tables of the kernels; this test makes it anew and compares. To
// write it: build the target limits_page, or run this test with PELAGE_UPDATE_GOLDEN=1.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/kernels.h"
#include "pelage/tier.h"
#include "support/test_folder.h"

namespace pelage::test {
namespace {

struct Feature {
  const char* name;
  std::vector<std::string> kernels;
};

// Features that readers know, and the kernels that each runs. Every kernel is in at least one.
const std::vector<Feature>& features() {
  static const std::vector<Feature> kFeatures = {
      {"Simulation, classic solver",
       {"skin_roots", "simulate_classic", "skin_classic_strands", "rewrite_classic_positions",
        "update_follow_hairs", "shift_positions", "move_rigidly"}},
      {"Simulation, exact solver",
       {"skin_roots", "select_awake_tiles", "simulate_exact", "skin_exact_strands",
        "interpolate_guides", "rewrite_exact_positions", "update_follow_hairs", "shift_positions",
        "move_rigidly"}},
      {"Hair-hair contact",
       {"clear_hair_grid", "splat_hair_grid", "measure_hair_grid", "apply_hair_grid"}},
      {"Contact with colliders",
       {"find_contacts", "eliminate_strands", "solve_contacts", "roll_out_strands"}},
      {"Contact of follow hairs", {"find_follow_contacts", "collide_follow_hairs"}},
      {"Picture of the contacts", {"contact_vertex", "contact_pixel"}},
      {"SDF of a mesh",
       {"compute_points", "clear_sdf", "find_moved_triangles", "scatter_triangles",
        "scatter_big_triangles", "update_surface", "count_sdf_columns", "finalize_sdf",
        "fill_interior"}},
      {"Collision of vertices with an SDF", {"collide_vertices"}},
      {"Picture of an SDF",
       {"marching_cubes_count", "marching_cubes_offsets", "marching_cubes_emit",
        "marching_cubes_pad", "iso_surface_vertex", "iso_surface_pixel"}},
      {"Skinning of meshes", {"skin_vertices"}},
      {"Bones in a buffer of an engine", {"convert_bones"}},
      {"Roots on a mesh that an engine deforms", {"follow_surface"}},
      {"Field of forces of an engine", {"sample_force_field"}},
      {"SDF of an engine", {"import_sdf"}},
      {"Texture of an engine on strands", {"sample_strand_colors"}},
      {"Shadow",
       {"clear_strand_shadow", "splat_strand_depths", "splat_strand_opacity",
        "accumulate_strand_shadow"}},
      {"Shadow of opaque geometry on hair", {"copy_opaque_shadow"}},
      {"Hair read by the vertex stage, which Tier::kWide draws", {"strand_vertex"}},
      {"Depth of hair", {"transform_strands", "strand_record_vertex", "strand_depth_pixel"}},
      {"Hair between two states", {"keep_positions", "interpolate_strands", "interpolate_roots"}},
      {"Motion of hair, Tier::kWide", {"keep_positions", "strand_motion_vertex"}},
      {"Motion of hair, other tiers",
       {"keep_positions", "transform_strands", "transform_motion", "motion_record_vertex",
        "strand_depth_pixel"}},
      {"Transparency: kAlphaTest, kStochastic",
       {"transform_strands", "strand_record_vertex", "strand_pixel"}},
      {"Transparency: kWindowed",
       {"transform_strands", "strand_record_vertex", "clear_ppll", "ppll_build", "oit_tile_vertex",
        "ppll_read"}},
      {"Transparency: kHybrid4 to kHybrid16",
       {"transform_strands", "strand_record_vertex", "clear_hybrid", "hybrid_depths",
        "hybrid_colors", "oit_tile_vertex", "hybrid_read"}},
      {"Transparency: kShortCut",
       {"transform_strands", "strand_record_vertex", "clear_short_cut", "short_cut_depths_alpha",
        "short_cut_resolve_depth", "short_cut_fill_colors", "short_cut_resolve_color",
        "oit_tile_vertex"}},
      {"Transparency: kTiles",
       {"transform_strands", "clear_strand_tiles", "raster_strands", "sum_strand_tiles",
        "offset_strand_tiles", "allocate_strand_tiles", "weigh_strand_tiles", "shade_strand_tiles",
        "gather_strand_tiles", "oit_tile_vertex", "show_strand_tiles"}},
  };
  return kFeatures;
}

const Kernel* find(const std::string& name) {
  for (const Kernel* kernel : allKernels())
    if (name == kernel->name) return kernel;
  return nullptr;
}

uint32_t storageBuffers(const KernelVariant& variant) {
  uint32_t count = 0;
  for (const VariantBinding& binding : variant.bindings) {
    const auto& entries = variant.kernel->layouts[binding.set]->entries;
    count += entries[binding.entry].kind == ResourceKind::kStorageBuffer;
  }
  return count;
}

std::string range(std::vector<uint32_t> values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return *low == *high ? std::to_string(*low) : fmt::format("{} to {}", *low, *high);
}

std::string lineOf(std::string_view kernel, std::string_view buffers, std::string_view threads,
                   std::string_view shared, std::string_view tier) {
  return fmt::format("    {:<28}{:<10}{:<10}{:<9}{}\n", kernel, buffers, threads, shared, tier);
}

// A line for the permutations of a kernel that have one tier; up to four of them have lines of
// their own below it where others have another tier.
std::string linesOf(const Kernel& kernel, Tier tier) {
  std::vector<uint32_t> buffers, threads, shared;
  std::string keys;
  size_t count = 0;
  for (const KernelVariant* variant : kernel.variants) {
    if (variant->tier != tier) continue;
    buffers.push_back(storageBuffers(*variant));
    threads.push_back(variant->groupSize[0] * variant->groupSize[1] * variant->groupSize[2]);
    shared.push_back(variant->sharedBytes);
    if (count++ < 4) keys += fmt::format("      {}\n", variant->key);
  }
  if (count == 0) return "";
  if (count == kernel.variants.size()) keys = "";
  if (count < kernel.variants.size() && count > 4)
    keys += fmt::format("      {} more\n", count - 4);
  const bool compute = kernel.stage == Stage::kCompute;
  const char* const stage = kernel.stage == Stage::kVertex ? "vertex" : "pixel";
  return lineOf(kernel.name, range(buffers), compute ? range(threads) : stage,
                compute ? range(shared) : "-", tierName(tier)) +
         keys;
}

// The tier of a feature: that of its cheapest permutations, and that of all.
std::pair<Tier, Tier> tiersOf(const Feature& feature) {
  Tier least = Tier::kEs, all = Tier::kEs;
  for (const std::string& name : feature.kernels) {
    const Kernel* kernel = find(name);
    if (kernel == nullptr) continue;
    Tier cheapest = Tier::kWide;
    for (const KernelVariant* variant : kernel->variants) {
      cheapest = std::min(cheapest, variant->tier);
      all = std::max(all, variant->tier);
    }
    least = std::max(least, cheapest);
  }
  return {least, all};
}

std::string limitRow(const char* what, const auto& value) {
  std::string row = fmt::format("| {} |", what);
  for (const Tier tier : kTiers) row += fmt::format(" {} |", value(limitsOf(tier)));
  return row + "\n";
}

std::string tierTable() {
  std::string text = "| what a kernel may use | `es` | `base` | `wide` |\n|---|---|---|---|\n";
  const auto counts = [](const StageCounts& c) {
    return fmt::format("{} / {} / {}", c.compute, c.vertex, c.pixel);
  };
  text += limitRow("storage buffers of a compute / vertex / pixel kernel",
                   [&](const TierLimits& l) { return counts(l.storageBuffers); });
  text += limitRow("storage buffers of both kernels of a draw",
                   [](const TierLimits& l) { return l.drawStorageBuffers; });
  text += limitRow("storage buffer bindings of OpenGL",
                   [](const TierLimits& l) { return l.storageBindings; });
  text += limitRow("images, likewise", [&](const TierLimits& l) { return counts(l.images); });
  text += limitRow("constant blocks", [&](const TierLimits& l) { return counts(l.uniformBlocks); });
  text += limitRow("textures", [&](const TierLimits& l) { return counts(l.textures); });
  text += limitRow("threads of a group", [](const TierLimits& l) { return l.groupThreads; });
  text += limitRow("threads of a group on each axis", [](const TierLimits& l) {
    return fmt::format("{} / {} / {}", l.groupSize[0], l.groupSize[1], l.groupSize[2]);
  });
  text += limitRow("bytes of groupshared memory",
                   [](const TierLimits& l) { return l.groupSharedBytes; });
  return text;
}

std::string page() {
  std::string text =
      "# What devices need\n"
      "A device is of one of three tiers. To see what a small one refuses, treat a large one as "
      "small: `RuntimeDef::maxTier`,\n`HeadlessDef::maxTier`, `pelage-headless --tier base`, or "
      "`PELAGE_TIER=base` for the tests. `Scene::setTier(runtime.tier())`\ntells the scene.\n\n"
      "- `es`: OpenGL ES 3.2.\n- `base`: OpenGL 4.5, and Vulkan and OpenGL ES on common devices.\n"
      "- `wide`: desktop GPUs.\n\n" +
      tierTable() +
      "\nThe build refuses a kernel that needs more than its tier, and a runtime, before it makes "
      "anything, one that needs more\nthan its device. The numbers are those of `pelage/tier.h`: "
      "the "
      "minimum limits of OpenGL 4.5, OpenGL ES 3.2 and Vulkan\n1.0. But Vulkan promises 4 storage "
      "buffers in every stage, fewer than `base`; some drivers of OpenGL ES have fewer in\npixel "
      "kernels than `es`; and OpenGL 4.5 has 1024 threads and 32 KiB of groupshared memory, more "
      "than any kernel needs.\nThe target `limits_page` makes this page from the tables of the "
      "kernels; a test keeps it in sync.\n\n"
      "## Features\n"
      "The tier on which a feature runs in its cheapest form, the one on which all of its "
      "permutations run, and its kernels.\n\n"
      "| feature | runs on | all of it on | kernels |\n|---|---|---|---|\n";
  std::vector<std::string> order;
  for (const Feature& feature : features()) {
    const auto [least, all] = tiersOf(feature);
    std::string names;
    for (const std::string& name : feature.kernels) {
      names += fmt::format("{}`{}`", names.empty() ? "" : ", ", name);
      if (std::find(order.begin(), order.end(), name) == order.end()) order.push_back(name);
    }
    text +=
        fmt::format("| {} | {} | {} | {} |\n", feature.name, tierName(least), tierName(all), names);
  }
  text +=
      "\n## Kernels\n"
      "Storage buffers, threads of a group or the stage, bytes of groupshared memory. A kernel "
      "whose "
      "permutations are of several\ntiers has a line for each, with these permutations.\n\n" +
      lineOf("kernel", "buffers", "threads", "shared", "tier");
  for (const std::string& name : order) {
    const Kernel* kernel = find(name);
    if (kernel == nullptr) continue;
    for (const Tier tier : kTiers) text += linesOf(*kernel, tier);
  }
  return text;
}

TEST(LimitsPage, NamesEveryKernelAndNoOther) {
  std::set<std::string> named;
  for (const Feature& feature : features()) {
    for (const std::string& name : feature.kernels) {
      named.insert(name);
      EXPECT_NE(find(name), nullptr) << feature.name << " names " << name;
    }
  }
  for (const Kernel* kernel : allKernels())
    EXPECT_TRUE(named.contains(kernel->name)) << kernel->name << " belongs to no feature";
}

TEST(LimitsPage, IsInSyncWithTheKernels) {
  const std::string file = std::string(PELAGE_SOURCE_DIR) + "/docs/limits.md";
  const std::string wanted = page();
  if (std::getenv("PELAGE_UPDATE_GOLDEN") != nullptr) {
    std::ofstream(file, std::ios::binary) << wanted;
    GTEST_SKIP() << "wrote " << file;
  }
  EXPECT_EQ(textOf(file), wanted) << "build the target limits_page";
}

}  // namespace
}  // namespace pelage::test
