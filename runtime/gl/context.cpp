#include "context.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <tuple>
#include <utility>

namespace pelage::gl {
namespace {

Error unsupported(std::string message) {
  return Error{ErrorCode::kUnsupported, std::move(message)};
}

std::string stringOf(const Functions& gl, GLenum name) {
  const auto* text = reinterpret_cast<const char*>(gl.glGetString(name));
  return text != nullptr ? text : "";
}

struct Version {
  Profile profile = Profile::kCore;
  int major = 0, minor = 0;
};

// "4.5 (Core Profile) Mesa 22.3.6", "OpenGL ES 3.2 NVIDIA 535.104".
Version parseVersion(const std::string& text) {
  Version version;
  const char* digits = text.c_str();
  constexpr char kEsPrefix[] = "OpenGL ES ";
  if (text.starts_with(kEsPrefix)) {
    version.profile = Profile::kEs;
    digits += sizeof(kEsPrefix) - 1;
  }
  if (std::sscanf(digits, "%d.%d", &version.major, &version.minor) != 2) version.major = 0;
  return version;
}

bool hasExtension(const Functions& gl, const char* wanted) {
  GLint count = 0;
  gl.glGetIntegerv(GL_NUM_EXTENSIONS, &count);
  for (GLint i = 0; i < count; ++i) {
    const auto* name =
        reinterpret_cast<const char*>(gl.glGetStringi(GL_EXTENSIONS, static_cast<GLuint>(i)));
    if (name != nullptr && std::strcmp(name, wanted) == 0) return true;
  }
  return false;
}

uint32_t integer(const Functions& gl, GLenum name) {
  GLint value = 0;
  gl.glGetIntegerv(name, &value);
  return value > 0 ? static_cast<uint32_t>(value) : 0;
}

uint64_t integer64(const Functions& gl, GLenum name) {
  GLint64 value = 0;
  gl.glGetInteger64v(name, &value);
  return value > 0 ? static_cast<uint64_t>(value) : 0;
}

Limits readLimits(const Functions& gl) {
  Limits limits;
  limits.storageBindings = integer(gl, GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS);
  limits.uniformBindings = integer(gl, GL_MAX_UNIFORM_BUFFER_BINDINGS);
  limits.computeStorageBlocks = integer(gl, GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS);
  limits.vertexStorageBlocks = integer(gl, GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS);
  limits.pixelStorageBlocks = integer(gl, GL_MAX_FRAGMENT_SHADER_STORAGE_BLOCKS);
  limits.combinedStorageBlocks = integer(gl, GL_MAX_COMBINED_SHADER_STORAGE_BLOCKS);
  for (GLuint axis = 0; axis < 3; ++axis) {
    GLint count = 0, size = 0;
    gl.glGetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_COUNT, axis, &count);
    gl.glGetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_SIZE, axis, &size);
    limits.groupCount[axis] = static_cast<uint32_t>(std::max(count, 0));
    limits.groupSize[axis] = static_cast<uint32_t>(std::max(size, 0));
  }
  limits.groupThreads = integer(gl, GL_MAX_COMPUTE_WORK_GROUP_INVOCATIONS);
  limits.uniformBlockBytes = integer64(gl, GL_MAX_UNIFORM_BLOCK_SIZE);
  limits.storageBlockBytes = integer64(gl, GL_MAX_SHADER_STORAGE_BLOCK_SIZE);
  limits.uniformAlignment = integer(gl, GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT);
  limits.storageAlignment = integer(gl, GL_SHADER_STORAGE_BUFFER_OFFSET_ALIGNMENT);
  return limits;
}

void lowerTo(Tier tier, Limits& limits) {
  const TierLimits most = limitsOf(tier);
  const auto lower = [](uint32_t& limit, uint32_t value) { limit = std::min(limit, value); };
  lower(limits.storageBindings, most.storageBindings);
  lower(limits.computeStorageBlocks, most.storageBuffers.compute);
  lower(limits.vertexStorageBlocks, most.storageBuffers.vertex);
  lower(limits.pixelStorageBlocks, most.storageBuffers.pixel);
  lower(limits.combinedStorageBlocks, most.drawStorageBuffers);
  lower(limits.groupThreads, most.groupThreads);
  for (int axis = 0; axis < 3; ++axis) lower(limits.groupSize[axis], most.groupSize[axis]);
}

// The version is checked before functions are looked for: an old context is told so.
Result<void> loadContext(const RuntimeDef& def, Context& context) {
  Functions& gl = context.gl;
  gl.glGetString = reinterpret_cast<PFNGLGETSTRINGPROC>(def.getProcAddress("glGetString"));
  if (gl.glGetString == nullptr)
    return unsupported("getProcAddress does not know glGetString: it must load core functions too");
  const std::string versionText = stringOf(gl, GL_VERSION);
  if (versionText.empty())
    return Error{ErrorCode::kInvalidArgument,
                 "no OpenGL context is current: make one current first"};
  const Version version = parseVersion(versionText);
  context.profile = version.profile;
  const bool core = version.profile == Profile::kCore;
  const int have = version.major * 10 + version.minor;
  if (have < (core ? 45 : 32)) {
    return unsupported("the context has '" + versionText + "'; pelage needs OpenGL " +
                       (core ? "4.5 core" : "ES 3.2") + " or later");
  }
  std::string missing = loadCommonFunctions(gl, def.getProcAddress);
  if (missing.empty() && core) missing = loadCoreFunctions(gl, def.getProcAddress);
  if (missing.empty() && core) missing = loadTimerFunctions(gl, def.getProcAddress, "");
  if (!missing.empty())
    return unsupported("getProcAddress does not know " + missing + " of '" + versionText + "'");
  clearErrors(gl);
  context.renderer = stringOf(gl, GL_RENDERER);
  context.identity = stringOf(gl, GL_VENDOR) + '\n' + context.renderer + '\n' + versionText + '\n' +
                     stringOf(gl, GL_SHADING_LANGUAGE_VERSION);
  return {};
}

Result<void> checkLimits(const Context& context) {
  const Limits& limits = context.limits;
  for (const auto& [value, least, name] :
       {std::tuple{limits.storageBindings, 4u, "GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS"},
        std::tuple{limits.computeStorageBlocks, 4u, "GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS"},
        std::tuple{limits.groupCount[0], 65535u, "GL_MAX_COMPUTE_WORK_GROUP_COUNT"},
        std::tuple{limits.groupThreads, 128u, "GL_MAX_COMPUTE_WORK_GROUP_INVOCATIONS"}}) {
    if (value >= least) continue;
    return unsupported(context.renderer + " has " + name + " = " + std::to_string(value) +
                       "; pelage needs at least " + std::to_string(least));
  }
  if (limits.uniformAlignment == 0 || PassList::kConstantAlignment % limits.uniformAlignment != 0) {
    return unsupported(context.renderer + " has GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT = " +
                       std::to_string(limits.uniformAlignment) + ", which does not divide " +
                       std::to_string(PassList::kConstantAlignment));
  }
  return {};
}

// Functions and limits that pelage can do without.
void loadOptional(const RuntimeDef& def, Context& context) {
  Functions& gl = context.gl;
  const bool core = context.profile == Profile::kCore;
  bool timer = core;
  if (!core && hasExtension(gl, "GL_EXT_disjoint_timer_query")) {
    timer = loadTimerFunctions(gl, def.getProcAddress, "EXT").empty();
    context.disjointTimer = timer;
  }
  if (timer) {
    GLint bits = 0;
    gl.glGetQueryiv(GL_TIMESTAMP, GL_QUERY_COUNTER_BITS, &bits);
    context.limits.timestamps = bits > 0;
  }
  // Both versions have it; contexts without robustness never report a reset.
  if (!loadRobustFunctions(gl, def.getProcAddress, "").empty() &&
      !loadRobustFunctions(gl, def.getProcAddress, "KHR").empty())
    gl.glGetGraphicsResetStatus = nullptr;
  // Allow as many compiler threads as the driver supports: some use one until they are asked.
  for (const char* suffix : {"KHR", "ARB"}) {
    const std::string extension = std::string("GL_") + suffix + "_parallel_shader_compile";
    if (!hasExtension(gl, extension.c_str())) continue;
    if (!loadParallelFunctions(gl, def.getProcAddress, suffix).empty()) continue;
    gl.glMaxShaderCompilerThreads(~GLuint{0});
    break;
  }
  GLint formats = 0;
  gl.glGetIntegerv(GL_NUM_PROGRAM_BINARY_FORMATS, &formats);
  if (formats > 0) {
    context.binaryFormats.resize(static_cast<size_t>(formats));
    gl.glGetIntegerv(GL_PROGRAM_BINARY_FORMATS, context.binaryFormats.data());
    context.limits.programBinaries = true;
  }
}

}  // namespace

Result<std::shared_ptr<const Context>> readContext(const RuntimeDef& def) {
  if (!def.getProcAddress)
    return Error{ErrorCode::kInvalidArgument, "gl::RuntimeDef::getProcAddress is empty"};
  const auto context = std::make_shared<Context>();
  context->debug = def.debug;
  if (Result<void> loaded = loadContext(def, *context); !loaded) return loaded.error();
  context->limits = readLimits(context->gl);
  context->drawBuffers =
      std::clamp(integer(context->gl, GL_MAX_DRAW_BUFFERS), 1u, kMostDrawBuffers);
  if (def.maxTier != Tier::kWide) lowerTo(def.maxTier, context->limits);
  if (Result<void> checked = checkLimits(*context); !checked) return checked.error();
  loadOptional(def, *context);
  return std::shared_ptr<const Context>(context);
}

std::string errorName(GLenum error) {
  switch (error) {
    case GL_INVALID_ENUM:
      return "GL_INVALID_ENUM";
    case GL_INVALID_VALUE:
      return "GL_INVALID_VALUE";
    case GL_INVALID_OPERATION:
      return "GL_INVALID_OPERATION";
    case GL_INVALID_FRAMEBUFFER_OPERATION:
      return "GL_INVALID_FRAMEBUFFER_OPERATION";
    case GL_OUT_OF_MEMORY:
      return "GL_OUT_OF_MEMORY";
    case GL_CONTEXT_LOST:
      return "GL_CONTEXT_LOST";
    default:
      return "GL error " + std::to_string(error);
  }
}

void clearErrors(const Functions& gl) {
  // A lost context reports its loss for ever.
  for (int i = 0; i < 16 && gl.glGetError() != GL_NO_ERROR; ++i) {
  }
}

}  // namespace pelage::gl
