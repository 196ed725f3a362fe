#include "codegen/layout_plan.h"

#include <algorithm>
#include <tuple>

#include "codegen/names.h"

namespace pelage::codegen {
namespace {

std::string slotName(const PlannedEntry& entry, uint32_t space) {
  return std::string("register(") + registerLetter(entry.registerClass) +
         std::to_string(entry.registerNumber) + ", space" + std::to_string(space) + ")";
}

std::string at(const SourceLocation& location) {
  return location.file + ":" + std::to_string(location.line);
}

// The kinds of binding points that a group numbers on GL, and how many of each a driver must have
// at least: GL 4.5 core table 23.57 ff. and ES 3.2 table 21.40 ff. Each permutation numbers its
// storage buffers by itself.
struct GlLimit {
  ResourceKind kind;
  uint32_t count;
  const char* what;
};
constexpr GlLimit kGlLimits[] = {{ResourceKind::kUniformBuffer, 36, "uniform block"},
                                 {ResourceKind::kSampledTexture, 48, "texture"},
                                 {ResourceKind::kStorageTexture, 4, "image"}};

PlannedEntry entryOf(const Resource& resource, Stage stage, const SourceLocation& where) {
  PlannedEntry entry;
  entry.name = resource.name;
  entry.structName = resource.structName;
  entry.kind = resource.kind;
  entry.registerClass = resource.registerClass;
  entry.registerNumber = resource.registerNumber;
  entry.stride = resource.stride;
  entry.stages = stageBit(stage);
  entry.location = where;
  return entry;
}

// Adds the stages of a resource to those of the same resource in an earlier module.
void merge(const PlannedEntry& entry, PlannedEntry& known, Diagnostics& diagnostics) {
  known.stages = static_cast<StageMask>(known.stages | entry.stages);
  if (known.structName == entry.structName && known.kind == entry.kind &&
      known.stride == entry.stride) {
    return;
  }
  diagnostics.error(entry.location, "PK506",
                    "'" + entry.name + "' is a " + entry.structName + " of " +
                        std::to_string(entry.stride) + " bytes here and a " + known.structName +
                        " of " + std::to_string(known.stride) + " bytes at " + at(known.location));
}

// An error that is reported at both of two resources.
struct Clash {
  const char* code;
  std::string text, otherText;
};

Clash slotClash(const PlannedEntry& entry, const PlannedEntry& other, uint32_t space,
                const std::string& group) {
  const auto text = [&](const PlannedEntry& here, const PlannedEntry& there) {
    return "'" + here.name + "' and '" + there.name + "' (" + at(there.location) + ") both are " +
           slotName(entry, space) + " of group \"" + group + "\"";
  };
  return {"PK504", text(entry, other), text(other, entry)};
}

Clash nameClash(const PlannedEntry& entry, uint32_t space, const PlannedEntry& other,
                uint32_t otherSpace) {
  const std::string slot = slotName(entry, space), otherSlot = slotName(other, otherSpace);
  const std::string here = "'" + entry.name + "' is ";
  return {"PK505", here + slot + " here and " + otherSlot + " at " + at(other.location),
          here + otherSlot + " here and " + slot + " at " + at(entry.location)};
}

}  // namespace

uint32_t rawBinding(RegisterClass registerClass, uint32_t registerNumber) {
  constexpr uint32_t kBases[] = {RegisterBase::kUniform, RegisterBase::kTexture, RegisterBase::kUav,
                                 RegisterBase::kSampler};
  return kBases[static_cast<size_t>(registerClass)] + registerNumber;
}

LayoutPlan::LayoutPlan(const Manifest& manifest) : manifest_(manifest) {
  std::map<std::string, size_t> known;
  for (const ManifestGroup& group : manifest.groups) {
    std::vector<size_t>& indices = indices_.emplace_back();
    for (uint32_t set = 0; set < group.layouts.size(); ++set) {
      const auto [found, added] = known.emplace(group.layouts[set], layouts_.size());
      if (added) layouts_.push_back({group.layouts[set], group.name, set, {}});
      indices.push_back(found->second);
    }
  }
}

std::set<size_t> LayoutPlan::boundWith(size_t layout) const {
  std::set<size_t> result;
  for (const std::vector<size_t>& group : indices_) {
    if (std::find(group.begin(), group.end(), layout) == group.end()) continue;
    result.insert(group.begin(), group.end());
  }
  return result;
}

void LayoutPlan::add(const Unit& unit, Diagnostics& diagnostics) {
  const ManifestKernel& kernel = *unit.kernel;
  const ManifestGroup& group = manifest_.groups[kernel.group];
  for (const Resource& resource : unit.reflection->resources) {
    const SourceLocation where = unit.locate(resource.name);
    const auto error = [&](const char* code, std::string message) {
      diagnostics.error(where, code, std::move(message));
    };
    if (!resource.hasRegister) {
      if (unit.front.diagnostics.hasErrors()) continue;
      error("PK501",
            "'" + resource.name +
                "' has no register: write : register(xN, spaceM), where M is the index of its "
                "layout in group \"" +
                group.name + "\"");
      continue;
    }
    if (resource.isArray) {
      if (unit.front.diagnostics.hasErrors()) continue;
      error("PK502", "'" + resource.name + "' is an array of resources; declare each by itself");
      continue;
    }
    if (resource.space >= group.layouts.size()) {
      error("PK503", "'" + resource.name + "' is in space" + std::to_string(resource.space) +
                         ", but group \"" + group.name + "\" has " +
                         std::to_string(group.layouts.size()) + " layouts");
      continue;
    }
    PlannedEntry entry = entryOf(resource, kernel.stage, where);
    bool known = false;
    const size_t home = indices_[kernel.group][resource.space];
    // A pass offers its resources by name: over all sets that may be bound with this one, a name
    // stands for one resource.
    for (const size_t index : boundWith(home)) {
      for (PlannedEntry& other : layouts_[index].entries) {
        const uint32_t set = layouts_[index].set;
        const bool sameSlot = index == home && other.registerClass == entry.registerClass &&
                              other.registerNumber == entry.registerNumber;
        if (!sameSlot && other.name != entry.name) continue;
        known = true;
        if (sameSlot && other.name == entry.name) {
          merge(entry, other, diagnostics);
          continue;
        }
        const auto [code, text, otherText] =
            sameSlot ? slotClash(entry, other, resource.space, group.name)
                     : nameClash(entry, resource.space, other, set);
        error(code, text);
        diagnostics.error(other.location, code, otherText);
      }
    }
    if (!known) layouts_[home].entries.push_back(std::move(entry));
  }
}

void LayoutPlan::assign(Diagnostics& diagnostics) {
  std::set<size_t> done;
  for (size_t group = 0; group < indices_.size(); ++group) {
    std::map<ResourceKind, uint32_t> next;
    for (const size_t index : indices_[group]) {
      std::vector<PlannedEntry>& entries = layouts_[index].entries;
      if (!done.insert(index).second) {
        // Shared with an earlier group, where the same layouts came before it: the numbers that it
        // has are the next ones here too.
        for (const PlannedEntry& entry : entries) {
          if (entry.kind != ResourceKind::kSampler) ++next[entry.kind];
        }
        continue;
      }
      std::sort(entries.begin(), entries.end(), [](const PlannedEntry& a, const PlannedEntry& b) {
        return std::tie(a.registerClass, a.registerNumber) <
               std::tie(b.registerClass, b.registerNumber);
      });
      for (uint32_t i = 0; i < entries.size(); ++i) {
        PlannedEntry& entry = entries[i];
        entry.binding = i;
        // GL has no samplers of their own here: they are merged into the textures.
        if (entry.kind == ResourceKind::kSampler) continue;
        if (entry.kind != ResourceKind::kStorageBuffer) entry.glBinding = next[entry.kind]++;
        for (const GlLimit& limit : kGlLimits) {
          if (limit.kind != entry.kind || entry.glBinding < limit.count) continue;
          diagnostics.error(entry.location, "PK700",
                            "'" + entry.name + "' would be " + limit.what + " binding " +
                                std::to_string(entry.glBinding) + " of group \"" +
                                manifest_.groups[group].name + "\" on GL, the last one is " +
                                std::to_string(limit.count - 1) + ": split the group");
        }
        const std::string host = hostName(entry.name);
        for (uint32_t j = 0; j < i; ++j) {
          if (hostName(entries[j].name) != host) continue;
          diagnostics.error(entry.location, "PK507",
                            "'" + entry.name + "' and '" + entries[j].name + "' (" +
                                at(entries[j].location) + ") have the same C++ name '" + host +
                                "'");
        }
        if (!isIdentifier(host)) {
          diagnostics.error(entry.location, "PK507",
                            "'" + entry.name + "' gives '" + host + "', which is no C++ name");
        }
      }
    }
  }
}

std::vector<BindingPatch> LayoutPlan::patches(const Unit& unit) const {
  std::vector<BindingPatch> patches;
  for (const Resource& resource : unit.reflection->resources) {
    for (const PlannedEntry& entry : layout(unit.kernel->group, resource.space).entries) {
      if (entry.name != resource.name) continue;
      patches.push_back({resource.space, rawBinding(entry.registerClass, entry.registerNumber),
                         entry.binding, entry.glBinding, entry.kind});
    }
  }
  return patches;
}

}  // namespace pelage::codegen
