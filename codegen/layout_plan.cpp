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

void LayoutPlan::add(const ManifestKernel& kernel, const ModuleReflection& reflection,
                     const FrontEndResult& front, Diagnostics& diagnostics) {
  const ManifestGroup& group = manifest_.groups[kernel.group];
  const auto locate = [&](const std::string& name) {
    const auto found = front.declarations.find(name);
    return found == front.declarations.end() ? SourceLocation{kernel.file, 1} : found->second;
  };
  for (const Resource& resource : reflection.resources) {
    const SourceLocation where = locate(resource.name);
    const auto error = [&](const char* code, std::string message) {
      diagnostics.error(where.file, where.line, code, std::move(message));
    };
    if (!resource.hasRegister) {
      if (front.diagnostics.hasErrors()) continue;
      error("PK501",
            "'" + resource.name +
                "' has no register: write : register(xN, spaceM), where M is the index of its "
                "layout in group \"" +
                group.name + "\"");
      continue;
    }
    if (resource.isArray) {
      if (front.diagnostics.hasErrors()) continue;
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
        if (sameSlot && other.name == entry.name) {
          known = true;
          other.stages = static_cast<StageMask>(other.stages | entry.stages);
          if (other.structName != entry.structName || other.kind != entry.kind ||
              other.stride != entry.stride) {
            error("PK506", "'" + entry.name + "' is a " + entry.structName + " of " +
                               std::to_string(entry.stride) + " bytes here and a " +
                               other.structName + " of " + std::to_string(other.stride) +
                               " bytes at " + at(other.location));
          }
        } else if (sameSlot) {
          error("PK504", "'" + entry.name + "' and '" + other.name + "' (" + at(other.location) +
                             ") both are " + slotName(entry, resource.space) + " of group \"" +
                             group.name + "\"");
          diagnostics.error(other.location.file, other.location.line, "PK504",
                            "'" + other.name + "' and '" + entry.name + "' (" + at(where) +
                                ") both are " + slotName(entry, resource.space) + " of group \"" +
                                group.name + "\"");
          known = true;
        } else if (other.name == entry.name) {
          error("PK505", "'" + entry.name + "' is " + slotName(entry, resource.space) +
                             " here and " + slotName(other, set) + " at " + at(other.location));
          diagnostics.error(other.location.file, other.location.line, "PK505",
                            "'" + entry.name + "' is " + slotName(other, set) + " here and " +
                                slotName(entry, resource.space) + " at " + at(where));
          known = true;
        }
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
          diagnostics.error(entry.location.file, entry.location.line, "PK700",
                            "'" + entry.name + "' would be " + limit.what + " binding " +
                                std::to_string(entry.glBinding) + " of group \"" +
                                manifest_.groups[group].name + "\" on GL, the last one is " +
                                std::to_string(limit.count - 1) + ": split the group");
        }
        const std::string host = hostName(entry.name);
        for (uint32_t j = 0; j < i; ++j) {
          if (hostName(entries[j].name) != host) continue;
          diagnostics.error(entry.location.file, entry.location.line, "PK507",
                            "'" + entry.name + "' and '" + entries[j].name + "' (" +
                                at(entries[j].location) + ") have the same C++ name '" + host +
                                "'");
        }
        if (!isIdentifier(host)) {
          diagnostics.error(entry.location.file, entry.location.line, "PK507",
                            "'" + entry.name + "' gives '" + host + "', which is no C++ name");
        }
      }
    }
  }
}

std::vector<BindingPatch> LayoutPlan::patches(const ManifestKernel& kernel,
                                              const ModuleReflection& reflection) const {
  std::vector<BindingPatch> patches;
  for (const Resource& resource : reflection.resources) {
    for (const PlannedEntry& entry : layout(kernel.group, resource.space).entries) {
      if (entry.name != resource.name) continue;
      patches.push_back({resource.space, rawBinding(entry.registerClass, entry.registerNumber),
                         entry.binding, entry.glBinding, entry.kind});
    }
  }
  return patches;
}

}  // namespace pelage::codegen
