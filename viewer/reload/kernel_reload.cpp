#include "reload/kernel_reload.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <exception>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "codegen/driver.h"
#include "codegen/file_io.h"
#include "codegen/pack.h"
#include "pelage/code.h"

namespace viewer {

namespace fs = std::filesystem;
using pelage::CodeFormat;
using pelage::codegen::KernelOutput;
using pelage::codegen::Program;
using pelage::codegen::readWholeFile;
using pelage::codegen::VariantOutput;

namespace {

// Headers that host and kernels share. kernels.h has names and keys of kernels.
constexpr const char* kShared[] = {"bindings.h", "constants.h", "gpu_structs.h", "kernels.h",
                                   "layouts.h"};

// A temporary folder for the outputs of a build.
class Scratch {
 public:
  Scratch() {
    static int count = 0;
    path_ = fs::temp_directory_path() / fmt::format("pelage_reload_{}_{}", getpid(), count++);
  }
  ~Scratch() {
    std::error_code error;
    fs::remove_all(path_, error);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

// Finds the new code of a permutation by its key.
const VariantOutput* variantOf(const KernelOutput& kernel, std::string_view key) {
  for (const VariantOutput& variant : kernel.variants)
    for (const auto& permutation : variant.permutations)
      if (pelage::codegen::permutationKey(kernel.kernel, permutation) == key) return &variant;
  return nullptr;
}

std::string codeOf(const VariantOutput& variant, CodeFormat format) {
  if (format == CodeFormat::kGlsl) return variant.glsl;
  if (format == CodeFormat::kEssl) return variant.essl;
  std::string bytes(variant.spirv.size() * sizeof(uint32_t), '\0');
  if (!bytes.empty()) std::memcpy(bytes.data(), variant.spirv.data(), bytes.size());
  return bytes;
}

// Whether a new permutation has the bindings and the group size of the program's.
bool fits(const pelage::KernelVariant& own, const VariantOutput& made) {
  return std::equal(own.bindings.begin(), own.bindings.end(), made.bindings.begin(),
                    made.bindings.end(),
                    [](const pelage::VariantBinding& a, const auto& b) {
                      return a.set == b.set && a.entry == b.entry && a.access == b.access &&
                             a.glBinding == b.glBinding;
                    }) &&
         std::equal(own.groupSize, own.groupSize + 3, made.groupSize);
}

// Adds the permutations whose code differs from the program's. \return an error; empty: none.
std::string addChanges(const pelage::KernelCode& own, const KernelOutput& made,
                       KernelTables& tables) {
  const auto ownVariants = own.kernel->variants;
  if (made.variants.size() != ownVariants.size())
    return fmt::format("kernel {} has {} permutations of different code, and {} in this program",
                       own.kernel->name, made.variants.size(), ownVariants.size());
  std::string all;
  std::vector<pelage::KernelCode::Range> ranges;
  for (const pelage::KernelVariant* variant : ownVariants) {
    const VariantOutput* now = variantOf(made, variant->key);
    if (now == nullptr)
      return fmt::format("kernel {} has no permutation '{}' any more", own.kernel->name,
                         variant->key);
    if (now->hash == variant->hash) continue;
    if (!fits(*variant, *now))
      return fmt::format("kernel {} uses other resources in permutation '{}'", own.kernel->name,
                         variant->key);
    const std::string code = codeOf(*now, own.format);
    if (code.empty()) continue;
    ranges.push_back(
        {variant->hash, static_cast<uint32_t>(all.size()), static_cast<uint32_t>(code.size())});
    all += code;
  }
  if (!ranges.empty())
    tables.add(own.kernel, own.format, pelage::codegen::pack(all),
               static_cast<uint32_t>(all.size()), std::move(ranges));
  return {};
}

KernelBuild failed(const std::string& what) {
  return {nullptr, what + ": build the program again"};
}

KernelBuild compare(const Program& program, const fs::path& made, const fs::path& own) {
  for (const char* header : kShared)
    if (readWholeFile(made / header) != readWholeFile(own / header))
      return failed(
          fmt::format("what the kernels share with the program has changed ({})", header));
  std::map<std::string_view, const KernelOutput*> kernels;
  for (const KernelOutput& kernel : program.kernels) kernels[kernel.kernel.name] = &kernel;
  auto tables = std::make_shared<KernelTables>();
  for (const pelage::KernelCode* code : pelage::allCode()) {
    const auto found = kernels.find(code->kernel->name);
    if (found == kernels.end()) return failed(fmt::format("there is no {}", code->kernel->name));
    const std::string error = addChanges(*code, *found->second, *tables);
    if (!error.empty()) return failed(error);
  }
  return {std::move(tables), {}};
}

}  // namespace

void KernelTables::add(const pelage::Kernel* kernel, CodeFormat format, std::string packed,
                       uint32_t bytes, std::vector<pelage::KernelCode::Range> ranges) {
  auto table = std::make_unique<Table>();
  table->packed = std::move(packed);
  table->ranges = std::move(ranges);
  table->code = {kernel,
                 format,
                 table->packed.data(),
                 static_cast<uint32_t>(table->packed.size()),
                 bytes,
                 table->ranges.data(),
                 static_cast<uint32_t>(table->ranges.size())};
  pointers_.push_back(&table->code);
  tables_.push_back(std::move(table));
  if (std::find(names_.begin(), names_.end(), kernel->name) == names_.end())
    names_.emplace_back(kernel->name);
}

KernelSource builtKernels() {
  KernelSource source;
  source.manifest = PELAGE_VIEWER_KERNELS "/manifest.json";
  source.headers = PELAGE_VIEWER_KERNEL_HEADERS "/pelage";
  source.tool = PELAGE_VIEWER_CODEGEN;
  source.cache = PELAGE_VIEWER_CODEGEN_CACHE;
  std::error_code error;
  const bool there = fs::exists(source.manifest, error) && fs::exists(source.headers, error) &&
                     fs::exists(source.tool, error);
  if (!there) source.manifest.clear();
  return source;
}

KernelBuild buildKernels(const KernelSource& source) {
  try {
    const Scratch scratch;
    pelage::codegen::BuildOptions options;
    options.manifest = source.manifest;
    options.outputDir = scratch.path();
    options.cacheDir = source.cache;
    options.tool = source.tool;
    const pelage::codegen::BuildResult result = pelage::codegen::build(options);
    if (!result.ok) return {nullptr, result.diagnostics.format()};
    return compare(result.program, scratch.path() / "include" / "pelage", source.headers);
  } catch (const std::exception& error) {
    return {nullptr, fmt::format("{}: {}", source.manifest.string(), error.what())};
  }
}

namespace {

constexpr std::chrono::milliseconds kInterval{300};

}  // namespace

uint64_t stateOfFolder(const fs::path& folder) {
  uint64_t state = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    std::error_code gone;
    if (!it->is_regular_file(gone)) continue;
    const auto time = it->last_write_time(gone).time_since_epoch().count();
    const uint64_t size = it->file_size(gone);
    // Files come in any order, so their hashes are added.
    state += std::hash<std::string>()(it->path().string() + ' ' + std::to_string(time) + ' ' +
                                      std::to_string(size));
  }
  return state;
}

KernelReload::KernelReload(KernelSource source)
    : source_(std::move(source)), thread_([this] { watch(); }) {}

KernelReload::~KernelReload() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

std::optional<KernelBuild> KernelReload::take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(built_, std::nullopt);
}

void KernelReload::watch() {
  const fs::path folder = source_.manifest.parent_path();
  uint64_t known = stateOfFolder(folder), last = known;
  std::unique_lock lock(mutex_);
  while (!wake_.wait_for(lock, kInterval, [this] { return ends_; })) {
    lock.unlock();
    const uint64_t now = stateOfFolder(folder);
    // An editor may still be writing: a state is complete when it is the same twice.
    std::optional<KernelBuild> built;
    if (now != known && now == last) {
      known = now;
      built = buildKernels(source_);
    }
    last = now;
    lock.lock();
    if (built) built_ = std::move(built);
  }
}

pelage::Result<void> LiveKernels::open(const fs::path& folder, bool scripted) {
  KernelSource source = builtKernels();
  if (source.manifest.empty() && !folder.empty())
    return pelage::Error{
        pelage::ErrorCode::kUnsupported,
        "--kernels needs the build folder of this program, which is not there any more"};
  if (source.manifest.empty() || (scripted && folder.empty())) return {};
  if (!folder.empty()) source.manifest = folder / "manifest.json";
  reload_ = std::make_unique<KernelReload>(std::move(source));
  return {};
}

}  // namespace viewer
