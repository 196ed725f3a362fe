#include "program.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <utility>

namespace pelage::gl {
namespace {

constexpr uint64_t kHashStart = 0xcbf29ce484222325ull;

// FNV-1a (Fowler, Noll, Vo), 64 bits.
uint64_t hashBytes(const void* data, size_t size, uint64_t hash) {
  const auto* bytes = static_cast<const unsigned char*>(data);
  for (size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 0x100000001b3ull;
  return hash;
}

template <class T>
uint64_t hashValue(const T& value, uint64_t hash) {
  return hashBytes(&value, sizeof(value), hash);
}

// In front of every stored binary. `check` is a second hash of the key's contents; with both, 128
// bits would have to collide for a wrong program to be taken.
struct BinaryHeader {
  char magic[4];
  uint32_t version;
  uint64_t check;
  uint64_t payloadHash;
  uint32_t format;
  uint32_t size;
};
constexpr char kMagic[4] = {'P', 'L', 'G', 'B'};
constexpr uint32_t kBinaryVersion = 1;

using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

GLenum shaderType(Stage stage) {
  switch (stage) {
    case Stage::kCompute:
      return GL_COMPUTE_SHADER;
    case Stage::kVertex:
      return GL_VERTEX_SHADER;
    case Stage::kPixel:
      return GL_FRAGMENT_SHADER;
  }
  return GL_COMPUTE_SHADER;
}

const char* stageName(Stage stage) {
  switch (stage) {
    case Stage::kCompute:
      return "compute";
    case Stage::kVertex:
      return "vertex";
    case Stage::kPixel:
      return "pixel";
  }
  return "";
}

bool hasConstant(const KernelVariant* variant, uint32_t id) {
  if (variant == nullptr) return false;
  const auto constants = variant->kernel->specConstants;
  return std::any_of(constants.begin(), constants.end(),
                     [id](const SpecConstant& constant) { return constant.id == id; });
}

uint32_t storageBlocks(const KernelVariant& variant, const char** first = nullptr) {
  uint32_t count = 0;
  for (const VariantBinding& binding : variant.bindings) {
    const LayoutEntry& entry = variant.kernel->layouts[binding.set]->entries[binding.entry];
    if (entry.kind != ResourceKind::kStorageBuffer) continue;
    if (count++ == 0 && first != nullptr) *first = entry.name;
  }
  return count;
}

bool isSpace(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

// The declared type of the constant that SPIRV-Cross writes as
//   const uint kName = SPIRV_CROSS_CONSTANT_ID_3;
// which is the only place where GLSL still knows it. Empty when the permutation does not use it.
std::string_view constantType(std::string_view source, const std::string& macro) {
  const size_t use = source.find("= " + macro + ";");
  if (use == std::string_view::npos) return {};
  const auto wordBefore = [&](size_t end) {
    while (end > 0 && isSpace(source[end - 1])) --end;
    size_t begin = end;
    while (begin > 0 && !isSpace(source[begin - 1])) --begin;
    return std::pair{begin, source.substr(begin, end - begin)};
  };
  const auto [nameBegin, name] = wordBefore(use);
  return wordBefore(nameBegin).second;
}

std::string trimmed(std::string text) {
  while (!text.empty() && (isSpace(text.back()) || text.back() == '\0')) text.pop_back();
  return text.empty() ? "(the driver says nothing)" : text;
}

Result<void> checkLimits(const Context& context, const KernelVariant& variant) {
  const Limits& limits = context.limits;
  const Stage stage = variant.kernel->stage;
  const std::string kernel = "kernel " + variantName(variant);

  const char* first = "";
  const uint32_t blocks = storageBlocks(variant, &first);
  const auto [allowed, constant] =
      stage == Stage::kCompute
          ? std::pair{limits.computeStorageBlocks, "GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS"}
      : stage == Stage::kVertex
          ? std::pair{limits.vertexStorageBlocks, "GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS"}
          : std::pair{limits.pixelStorageBlocks, "GL_MAX_FRAGMENT_SHADER_STORAGE_BLOCKS"};
  if (blocks > allowed) {
    return Error{ErrorCode::kUnsupported,
                 kernel + " needs " + std::to_string(blocks) + " storage buffers in the " +
                     stageName(stage) + " stage ('" + first + "' first); " + context.renderer +
                     " allows " + std::to_string(allowed) + " (" + constant +
                     "): use Vulkan, OpenGL core or another device"};
  }
  const uint32_t points = std::min(limits.storageBindings, kMaxBindings);
  for (const VariantBinding& binding : variant.bindings) {
    const LayoutEntry& entry = variant.kernel->layouts[binding.set]->entries[binding.entry];
    if (entry.kind != ResourceKind::kStorageBuffer || binding.glBinding < points) continue;
    return Error{ErrorCode::kUnsupported, kernel + ": '" + entry.name + "' has GL binding " +
                                              std::to_string(binding.glBinding) + "; " +
                                              context.renderer + " and pelage allow " +
                                              std::to_string(points) + " of its kind"};
  }
  if (stage != Stage::kCompute) return {};

  uint64_t threads = 1;
  for (int axis = 0; axis < 3; ++axis) {
    threads *= variant.groupSize[axis];
    if (variant.groupSize[axis] > limits.groupSize[axis]) {
      return Error{ErrorCode::kUnsupported,
                   kernel + " has " + std::to_string(variant.groupSize[axis]) +
                       " threads a group on axis " + "xyz"[axis] + "; " + context.renderer +
                       " allows " + std::to_string(limits.groupSize[axis]) +
                       " (GL_MAX_COMPUTE_WORK_GROUP_SIZE)"};
    }
  }
  if (threads > limits.groupThreads) {
    return Error{ErrorCode::kUnsupported, kernel + " has " + std::to_string(threads) +
                                              " threads a group; " + context.renderer + " allows " +
                                              std::to_string(limits.groupThreads) +
                                              " (GL_MAX_COMPUTE_WORK_GROUP_INVOCATIONS)"};
  }
  return {};
}

Result<void> checkLimits(const Context& context, const KernelVariant& kernel,
                         const KernelVariant* pixel) {
  if (Result<void> fits = checkLimits(context, kernel); !fits) return fits;
  if (pixel == nullptr) return {};
  if (Result<void> fits = checkLimits(context, *pixel); !fits) return fits;
  const uint32_t both = storageBlocks(kernel) + storageBlocks(*pixel);
  if (both <= context.limits.combinedStorageBlocks) return {};
  return Error{ErrorCode::kUnsupported,
               "kernels " + variantName(kernel) + " and " + variantName(*pixel) + " need " +
                   std::to_string(both) + " storage buffers together; " + context.renderer +
                   " allows " + std::to_string(context.limits.combinedStorageBlocks) +
                   " (GL_MAX_COMBINED_SHADER_STORAGE_BLOCKS)"};
}

struct StageSource {
  const KernelVariant* variant;
  std::string text;
};

std::string namesOf(std::span<const StageSource> stages) {
  std::string names;
  for (const StageSource& stage : stages)
    names += (names.empty() ? "" : " + ") + variantName(*stage.variant);
  return names;
}

// Asks for nothing that would wait: a driver with threads of its own compiles while the next
// program is handed over.
ProgramBuild compileAndLink(const Context& context, const ProgramCache& cache,
                            std::span<const StageSource> stages, bool separable) {
  const Functions& gl = context.gl;
  ProgramBuild build;
  build.names = namesOf(stages);
  build.program = gl.glCreateProgram();
  for (const StageSource& stage : stages) {
    const GLuint shader = gl.glCreateShader(shaderType(stage.variant->kernel->stage));
    const GLchar* text = stage.text.c_str();
    const GLint length = static_cast<GLint>(stage.text.size());
    gl.glShaderSource(shader, 1, &text, &length);
    gl.glCompileShader(shader);
    gl.glAttachShader(build.program, shader);
    build.shaders.push_back({stage.variant, shader});
  }
  if (separable) gl.glProgramParameteri(build.program, GL_PROGRAM_SEPARABLE, GL_TRUE);
  if (cache.store && context.limits.programBinaries)
    gl.glProgramParameteri(build.program, GL_PROGRAM_BINARY_RETRIEVABLE_HINT, GL_TRUE);
  gl.glLinkProgram(build.program);
  return build;
}

std::string infoLog(GLuint object, decltype(Functions::glGetShaderiv) getSize,
                    decltype(Functions::glGetShaderInfoLog) getLog) {
  GLint length = 0;
  getSize(object, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<size_t>(std::max(length, 1)), '\0');
  getLog(object, static_cast<GLsizei>(log.size()), nullptr, log.data());
  return trimmed(std::move(log));
}

// Waits for the driver. After an error the program is deleted.
Result<void> finish(const Context& context, const ProgramBuild& build) {
  const Functions& gl = context.gl;
  std::optional<Error> error;
  for (const auto& [variant, shader] : build.shaders) {
    GLint compiled = GL_FALSE;
    gl.glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled == GL_FALSE && !error) {
      error = Error{ErrorCode::kDevice,
                    "kernel " + variantName(*variant) + " does not compile on " + context.renderer +
                        ": " + infoLog(shader, gl.glGetShaderiv, gl.glGetShaderInfoLog)};
    }
  }
  GLint linked = GL_FALSE;
  gl.glGetProgramiv(build.program, GL_LINK_STATUS, &linked);
  if (linked == GL_FALSE && !error) {
    error = Error{ErrorCode::kDevice,
                  "kernel " + build.names + " does not link on " + context.renderer + ": " +
                      infoLog(build.program, gl.glGetProgramiv, gl.glGetProgramInfoLog)};
  }
  // They live on as long as the program does.
  for (const auto& [variant, shader] : build.shaders) gl.glDeleteShader(shader);
  if (!error) {
    if (context.debug) gl.glObjectLabel(GL_PROGRAM, build.program, -1, build.names.c_str());
    return {};
  }
  gl.glDeleteProgram(build.program);
  clearErrors(gl);
  return *error;
}

// The program of a stored binary; 0 when there is no usable one.
GLuint loadBinary(const Context& context, const ProgramCache& cache, uint64_t key, uint64_t check) {
  const Functions& gl = context.gl;
  if (!cache.load || !context.limits.programBinaries) return 0;
  const std::vector<std::byte> bytes = cache.load(key);
  BinaryHeader header;
  if (bytes.size() < sizeof(header)) return 0;
  std::memcpy(&header, bytes.data(), sizeof(header));
  const std::byte* payload = bytes.data() + sizeof(header);
  const size_t payloadSize = bytes.size() - sizeof(header);
  if (std::memcmp(header.magic, kMagic, sizeof(kMagic)) != 0 || header.version != kBinaryVersion ||
      header.check != check || header.size != payloadSize ||
      header.payloadHash != hashBytes(payload, payloadSize, kHashStart))
    return 0;
  // Drivers report GL_INVALID_ENUM for a format that they do not have.
  const auto& formats = context.binaryFormats;
  if (std::find(formats.begin(), formats.end(), static_cast<GLint>(header.format)) == formats.end())
    return 0;
  const GLuint program = gl.glCreateProgram();
  gl.glProgramBinary(program, header.format, payload, static_cast<GLsizei>(payloadSize));
  GLint linked = GL_FALSE;
  gl.glGetProgramiv(program, GL_LINK_STATUS, &linked);
  if (linked != GL_FALSE) return program;
  gl.glDeleteProgram(program);
  clearErrors(gl);
  return 0;
}

void storeBinary(const Context& context, const ProgramCache& cache, const ProgramBuild& build) {
  const GLuint program = build.program;
  const Functions& gl = context.gl;
  if (!cache.store || !context.limits.programBinaries) return;
  GLint size = 0;
  gl.glGetProgramiv(program, GL_PROGRAM_BINARY_LENGTH, &size);
  if (size <= 0) return;
  std::vector<std::byte> bytes(sizeof(BinaryHeader) + static_cast<size_t>(size));
  std::byte* payload = bytes.data() + sizeof(BinaryHeader);
  GLenum format = 0;
  GLsizei written = 0;
  gl.glGetProgramBinary(program, size, &written, &format, payload);
  if (written <= 0) {
    clearErrors(gl);
    return;
  }
  bytes.resize(sizeof(BinaryHeader) + static_cast<size_t>(written));
  payload = bytes.data() + sizeof(BinaryHeader);
  BinaryHeader header;
  std::memcpy(header.magic, kMagic, sizeof(kMagic));
  header.version = kBinaryVersion;
  header.check = build.check;
  header.payloadHash = hashBytes(payload, static_cast<size_t>(written), kHashStart);
  header.format = format;
  header.size = static_cast<uint32_t>(written);
  std::memcpy(bytes.data(), &header, sizeof(header));
  cache.store(build.key, bytes);
}

}  // namespace

Result<std::string> assembleSource(const KernelVariant& variant, std::string_view text,
                                   std::span<const SpecValue> values) {
  const size_t lineEnd = text.find('\n');
  if (!text.starts_with("#version") || lineEnd == std::string_view::npos) {
    return Error{ErrorCode::kInvalidFile,
                 "the source of kernel " + variantName(variant) + " does not begin with #version"};
  }
  std::string defines;
  for (const SpecValue& value : values) {
    if (!hasConstant(&variant, value.id)) continue;
    const std::string macro = "SPIRV_CROSS_CONSTANT_ID_" + std::to_string(value.id);
    const std::string_view type = constantType(text, macro);
    std::string literal;
    if (type == "uint") {
      literal = std::to_string(value.bits) + "u";
    } else if (type == "int") {
      literal = "int(" + std::to_string(value.bits) + "u)";
    } else if (type == "bool") {
      literal = value.bits != 0 ? "true" : "false";
    } else if (type == "float") {
      // Bits, not decimals: every value survives, infinities too.
      literal = "uintBitsToFloat(" + std::to_string(value.bits) + "u)";
    } else if (text.find(macro) == std::string_view::npos) {
      continue;  // the permutation has optimised it away
    } else {
      return Error{ErrorCode::kUnsupported,
                   "kernel " + variantName(variant) + ": specialization constant " +
                       std::to_string(value.id) + " has type '" + std::string(type) +
                       "' in GLSL; bool, int, uint and float can be set"};
    }
    defines.append("#define ").append(macro).append(" ").append(literal).append("\n");
  }
  std::string source;
  source.reserve(text.size() + defines.size());
  source.append(text.substr(0, lineEnd + 1)).append(defines).append(text.substr(lineEnd + 1));
  return source;
}

ProgramStore::ProgramStore(std::shared_ptr<const Context> context, ProgramCache cache,
                           Statistics& statistics)
    : context_(std::move(context)), cache_(std::move(cache)), statistics_(statistics) {}

ProgramStore::~ProgramStore() {
  const Functions& gl = context_->gl;
  for (const auto& [hash, entries] : programs_) {
    for (const Entry& entry : entries) {
      gl.glDeleteProgram(entry.build ? entry.build->program : entry.program);
      if (!entry.build) continue;
      for (const auto& [variant, shader] : entry.build->shaders) gl.glDeleteShader(shader);
    }
  }
}

GLuint ProgramStore::ready(const KernelVariant& kernel, const KernelVariant* pixel,
                           std::span<const SpecValue> values) {
  const Entry* entry = known(entriesOf(kernel, pixel, values), kernel, pixel);
  return entry != nullptr ? entry->program : 0;
}

void ProgramStore::begin(const KernelVariant& kernel, const KernelVariant* pixel,
                         std::span<const SpecValue> values) {
  std::vector<Entry>& entries = entriesOf(kernel, pixel, values);
  if (known(entries, kernel, pixel) != nullptr) return;
  // find() reports errors.
  Result<Entry> entry = start(kernel, pixel, wanted_);
  if (entry) entries.push_back(*std::move(entry));
}

Result<GLuint> ProgramStore::find(const KernelVariant& kernel, const KernelVariant* pixel,
                                  std::span<const SpecValue> values) {
  std::vector<Entry>& entries = entriesOf(kernel, pixel, values);
  Entry* entry = known(entries, kernel, pixel);
  if (entry == nullptr) {
    Result<Entry> started = start(kernel, pixel, wanted_);
    if (!started) return started.error();
    entry = &entries.emplace_back(*std::move(started));
  }
  if (!entry->build) return entry->program;
  const std::unique_ptr<ProgramBuild> build = std::move(entry->build);
  if (Result<void> linked = finish(*context_, *build); !linked) {
    entries.erase(entries.begin() + (entry - entries.data()));
    return linked.error();
  }
  entry->program = build->program;
  ++statistics_.programsCompiled;
  storeBinary(*context_, cache_, *build);
  times_.push_back({build->names, millisecondsSince(build->start)});
  return entry->program;
}

// Values of constants that neither stage has do not make another program.
std::vector<ProgramStore::Entry>& ProgramStore::entriesOf(const KernelVariant& kernel,
                                                          const KernelVariant* pixel,
                                                          std::span<const SpecValue> values) {
  wanted_.clear();
  for (const SpecValue& value : values)
    if (hasConstant(&kernel, value.id) || hasConstant(pixel, value.id)) wanted_.push_back(value);

  uint64_t hash = hashValue(reinterpret_cast<uintptr_t>(&kernel), kHashStart);
  hash = hashValue(reinterpret_cast<uintptr_t>(pixel), hash);
  for (const SpecValue& value : wanted_) hash = hashValue(value.bits, hashValue(value.id, hash));
  return programs_[hash];
}

ProgramStore::Entry* ProgramStore::known(std::vector<Entry>& entries, const KernelVariant& kernel,
                                         const KernelVariant* pixel) const {
  for (Entry& entry : entries)
    if (entry.kernel == &kernel && entry.pixel == pixel && entry.values == wanted_) return &entry;
  return nullptr;
}

Result<void> ProgramStore::checkSupport(const KernelVariant& kernel,
                                        const KernelVariant* pixel) const {
  if (Result<void> fits = checkLimits(*context_, kernel, pixel); !fits) return fits;
  for (const KernelVariant* variant : {&kernel, pixel}) {
    if (variant == nullptr) continue;
    if (const Result<std::string> source = sourceOf(*variant, {}); !source) return source.error();
  }
  return {};
}

Result<std::string> ProgramStore::sourceOf(const KernelVariant& variant,
                                           std::span<const SpecValue> values) const {
  const bool core = context_->profile == Profile::kCore;
  const Result<std::string> text =
      codes_.source(variant, core ? CodeFormat::kGlsl : CodeFormat::kEssl);
  if (!text) return text;
  return assembleSource(variant, *text, values);
}

Result<ProgramStore::Entry> ProgramStore::start(const KernelVariant& kernel,
                                                const KernelVariant* pixel,
                                                std::span<const SpecValue> values) {
  const Clock::time_point begin = Clock::now();
  if (Result<void> fits = checkLimits(*context_, kernel, pixel); !fits) return fits.error();
  std::vector<StageSource> stages;
  for (const KernelVariant* variant : {&kernel, pixel}) {
    if (variant == nullptr) continue;
    Result<std::string> source = sourceOf(*variant, values);
    if (!source) return source.error();
    stages.push_back({variant, std::move(*source)});
  }

  uint64_t key = hashValue(kBinaryVersion, kHashStart);
  uint64_t check = hashValue(kBinaryVersion, ~kHashStart);
  const auto add = [&](std::string_view text) {
    key = hashValue(text.size(), hashBytes(text.data(), text.size(), key));
    check = hashValue(text.size(), hashBytes(text.data(), text.size(), check));
  };
  add(context_->identity);
  for (const StageSource& stage : stages) add(stage.text);

  Entry entry = {&kernel, pixel, {values.begin(), values.end()}, 0, nullptr};
  if (const GLuint loaded = loadBinary(*context_, cache_, key, check)) {
    ++statistics_.programsLoaded;
    entry.program = loaded;
    times_.push_back({namesOf(stages), millisecondsSince(begin)});
    return entry;
  }
  entry.build = std::make_unique<ProgramBuild>(compileAndLink(*context_, cache_, stages, false));
  entry.build->start = begin;
  entry.build->key = key;
  entry.build->check = check;
  return entry;
}

Result<GLuint> ProgramStore::makeStage(const KernelVariant& variant) {
  if (Result<void> fits = checkLimits(*context_, variant); !fits) return fits.error();
  Result<std::string> source = sourceOf(variant, {});
  if (!source) return source.error();
  const StageSource stage{&variant, std::move(*source)};
  // Desktop GL links a vertex stage alone, and refuses a separable one that does not redeclare
  // gl_PerVertex; ES has it the other way round.
  const bool whole = context_->profile == Profile::kCore && variant.kernel->stage == Stage::kVertex;
  const ProgramBuild build = compileAndLink(*context_, cache_, {&stage, 1}, !whole);
  if (Result<void> linked = finish(*context_, build); !linked) return linked.error();
  return build.program;
}

}  // namespace pelage::gl
