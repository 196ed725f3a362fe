// EGL without a window. Each call makes the device's context current for its duration and puts back
// what was current before, so that several devices live in one process.
#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstdio>
#include <cstring>
#include <new>
#include <optional>
#include <utility>

#include "context.h"
#include "depth_copy.h"
#include "pelage/gl.h"
#include "pelage/headless.h"
#include "pelage/list_check.h"

namespace pelage {
namespace {

using gl::Functions;

Error unsupported(std::string message) {
  return Error{ErrorCode::kUnsupported, std::move(message)};
}

// Whole words of a list that is separated by spaces.
bool listHas(const char* list, std::string_view word) {
  const std::string_view text = list != nullptr ? list : "";
  for (size_t at = text.find(word); at != std::string_view::npos; at = text.find(word, at + 1)) {
    const size_t end = at + word.size();
    if ((at == 0 || text[at - 1] == ' ') && (end == text.size() || text[end] == ' ')) return true;
  }
  return false;
}

std::string eglErrorName() {
  const EGLint error = eglGetError();
  switch (error) {
    case EGL_SUCCESS:
      return "no EGL error";
    case EGL_NOT_INITIALIZED:
      return "EGL_NOT_INITIALIZED";
    case EGL_BAD_ACCESS:
      return "EGL_BAD_ACCESS";
    case EGL_BAD_ALLOC:
      return "EGL_BAD_ALLOC";
    case EGL_BAD_ATTRIBUTE:
      return "EGL_BAD_ATTRIBUTE";
    case EGL_BAD_CONFIG:
      return "EGL_BAD_CONFIG";
    case EGL_BAD_CONTEXT:
      return "EGL_BAD_CONTEXT";
    case EGL_BAD_DISPLAY:
      return "EGL_BAD_DISPLAY";
    case EGL_BAD_MATCH:
      return "EGL_BAD_MATCH";
    case EGL_BAD_PARAMETER:
      return "EGL_BAD_PARAMETER";
    default:
      return "EGL error " + std::to_string(error);
  }
}

// A place to look for a device.
struct Candidate {
  EGLDisplay display = EGL_NO_DISPLAY;
  std::string name;  // for messages
  int rank = 0;      // lower is tried first
};

template <class Function>
Function eglFunction(const char* name) {
  return reinterpret_cast<Function>(eglGetProcAddress(name));
}

// Displays in the order in which they are to be tried.
Result<std::vector<Candidate>> findCandidates(int deviceIndex) {
  const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  const auto getDisplay = eglFunction<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
  std::vector<Candidate> candidates;

  const bool devices =
      getDisplay != nullptr && listHas(client, "EGL_EXT_platform_device") &&
      (listHas(client, "EGL_EXT_device_enumeration") || listHas(client, "EGL_EXT_device_base"));
  EGLint count = 0;
  if (devices) {
    const auto queryDevices = eglFunction<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
    const auto queryString = eglFunction<PFNEGLQUERYDEVICESTRINGEXTPROC>("eglQueryDeviceStringEXT");
    std::vector<EGLDeviceEXT> found;
    if (queryDevices != nullptr && queryDevices(0, nullptr, &count) == EGL_TRUE && count > 0) {
      found.resize(static_cast<size_t>(count));
      if (queryDevices(count, found.data(), &count) != EGL_TRUE) count = 0;
    }
    for (EGLint i = 0; i < count; ++i) {
      if (deviceIndex >= 0 && i != deviceIndex) continue;
      const EGLDeviceEXT device = found[static_cast<size_t>(i)];
      const char* extensions =
          queryString != nullptr ? queryString(device, EGL_EXTENSIONS) : nullptr;
      // EGL does not say which devices are discrete; CUDA is the surest sign.
      const int rank = listHas(extensions, "EGL_MESA_device_software") ? 3
                       : listHas(extensions, "EGL_NV_device_cuda")     ? 0
                                                                       : 1;
      candidates.push_back({getDisplay(EGL_PLATFORM_DEVICE_EXT, device, nullptr),
                            "EGL device " + std::to_string(i), rank});
    }
  }
  if (deviceIndex >= 0) {
    if (candidates.empty()) {
      return Error{ErrorCode::kInvalidArgument, "there is no EGL device " +
                                                    std::to_string(deviceIndex) + "; EGL has " +
                                                    std::to_string(count) + ", from 0"};
    }
    return candidates;
  }
  if (getDisplay != nullptr && listHas(client, "EGL_MESA_platform_surfaceless")) {
    candidates.push_back({getDisplay(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr),
                          "the surfaceless platform", 2});
  }
  candidates.push_back({eglGetDisplay(EGL_DEFAULT_DISPLAY), "the default display", 4});
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.rank < b.rank; });
  return candidates;
}

// A context and, where the driver needs one, a pixel buffer to make it current with.
class EglContext {
 public:
  EglContext() = default;
  EglContext(EglContext&& other) noexcept { swap(other); }
  EglContext& operator=(EglContext&& other) noexcept {
    swap(other);
    return *this;
  }
  ~EglContext() {
    // The display stays initialised: it belongs to the process, and others may use it.
    if (context_ != EGL_NO_CONTEXT) eglDestroyContext(display_, context_);
    if (surface_ != EGL_NO_SURFACE) eglDestroySurface(display_, surface_);
  }

  static Result<EglContext> create(const Candidate& candidate, Api api, bool debug);

  EGLDisplay display() const { return display_; }
  EGLSurface surface() const { return surface_; }
  EGLContext context() const { return context_; }
  EGLenum api() const { return api_; }

 private:
  void swap(EglContext& other) noexcept {
    std::swap(display_, other.display_);
    std::swap(surface_, other.surface_);
    std::swap(context_, other.context_);
    std::swap(api_, other.api_);
  }

  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLSurface surface_ = EGL_NO_SURFACE;
  EGLContext context_ = EGL_NO_CONTEXT;
  EGLenum api_ = EGL_OPENGL_API;
};

Result<EglContext> EglContext::create(const Candidate& candidate, Api api, bool debug) {
  const auto fail = [&](const std::string& what) {
    return unsupported(candidate.name + ": " + what + " (" + eglErrorName() + ")");
  };
  EglContext egl;
  egl.display_ = candidate.display;
  if (egl.display_ == EGL_NO_DISPLAY) return fail("no display");
  EGLint major = 0, minor = 0;
  if (eglInitialize(egl.display_, &major, &minor) != EGL_TRUE) return fail("cannot be initialised");
  const char* extensions = eglQueryString(egl.display_, EGL_EXTENSIONS);
  const bool es = api == Api::kGles;
  egl.api_ = es ? EGL_OPENGL_ES_API : EGL_OPENGL_API;
  if (eglBindAPI(egl.api_) != EGL_TRUE)
    return fail(es ? "has no OpenGL ES" : "has no desktop OpenGL");
  const bool version15 = major > 1 || minor >= 5;
  if (!version15 && !listHas(extensions, "EGL_KHR_create_context"))
    return fail("lacks EGL_KHR_create_context");

  const bool surfaceless = listHas(extensions, "EGL_KHR_surfaceless_context");
  const bool configless = listHas(extensions, "EGL_KHR_no_config_context");
  EGLConfig config = EGL_NO_CONFIG_KHR;
  if (!surfaceless || !configless) {
    const EGLint attributes[] = {EGL_SURFACE_TYPE, surfaceless ? 0 : EGL_PBUFFER_BIT,
                                 EGL_RENDERABLE_TYPE, es ? EGL_OPENGL_ES3_BIT : EGL_OPENGL_BIT,
                                 EGL_NONE};
    EGLint count = 0;
    if (eglChooseConfig(egl.display_, attributes, &config, 1, &count) != EGL_TRUE || count == 0)
      return fail("has no config for a pixel buffer");
    if (!surfaceless) {
      const EGLint size[] = {EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
      egl.surface_ = eglCreatePbufferSurface(egl.display_, config, size);
      if (egl.surface_ == EGL_NO_SURFACE) return fail("makes no pixel buffer");
    }
  }

  std::vector<EGLint> attributes = {EGL_CONTEXT_MAJOR_VERSION, es ? 3 : 4,
                                    EGL_CONTEXT_MINOR_VERSION, es ? 2 : 5};
  if (!es) {
    attributes.insert(attributes.end(),
                      {EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT});
  }
  if (debug) {
    if (version15) {
      attributes.insert(attributes.end(), {EGL_CONTEXT_OPENGL_DEBUG, EGL_TRUE});
    } else {
      attributes.insert(attributes.end(),
                        {EGL_CONTEXT_FLAGS_KHR, EGL_CONTEXT_OPENGL_DEBUG_BIT_KHR});
    }
  }
  attributes.push_back(EGL_NONE);
  egl.context_ = eglCreateContext(egl.display_, config, EGL_NO_CONTEXT, attributes.data());
  if (egl.context_ == EGL_NO_CONTEXT)
    return fail(es ? "has no OpenGL ES 3.2" : "has no OpenGL 4.5 core");
  return egl;
}

// Makes a context current, and puts back the one before.
class ScopedCurrent {
 public:
  explicit ScopedCurrent(const EglContext& egl)
      : api_(eglQueryAPI()),
        display_(eglGetCurrentDisplay()),
        draw_(eglGetCurrentSurface(EGL_DRAW)),
        read_(eglGetCurrentSurface(EGL_READ)),
        context_(eglGetCurrentContext()),
        ours_(egl.display()) {
    eglBindAPI(egl.api());
    current_ =
        eglMakeCurrent(egl.display(), egl.surface(), egl.surface(), egl.context()) == EGL_TRUE;
  }
  ~ScopedCurrent() {
    if (context_ == EGL_NO_CONTEXT) {
      eglMakeCurrent(ours_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
      eglBindAPI(api_);
    } else {
      eglBindAPI(api_);
      eglMakeCurrent(display_, draw_, read_, context_);
    }
  }
  ScopedCurrent(const ScopedCurrent&) = delete;
  ScopedCurrent& operator=(const ScopedCurrent&) = delete;

  Result<void> check() const {
    if (current_) return {};
    return Error{ErrorCode::kDevice,
                 "the context cannot be made current: is it current in another thread? (" +
                     eglErrorName() + ")"};
  }

 private:
  EGLenum api_;
  EGLDisplay display_;
  EGLSurface draw_, read_;
  EGLContext context_;
  EGLDisplay ours_;
  bool current_ = false;
};

// Counts every API error, all undefined behavior, and other severe messages.
void APIENTRY onDebugMessage(GLenum, GLenum type, GLuint id, GLenum severity, GLsizei length,
                             const GLchar* message, const void* user) {
  const bool error = type == GL_DEBUG_TYPE_ERROR || type == GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR;
  if (!error && severity != GL_DEBUG_SEVERITY_HIGH) return;
  ++*const_cast<uint32_t*>(static_cast<const uint32_t*>(user));
  const size_t size = length >= 0 ? static_cast<size_t>(length) : std::strlen(message);
  std::string_view text(message, size);
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())))
    text.remove_suffix(1);
  std::fprintf(stderr, "OpenGL %s %u: %.*s\n",
               error                               ? "error"
               : type == GL_DEBUG_TYPE_PERFORMANCE ? "performance warning"
                                                   : "warning",
               id, static_cast<int>(text.size()), text.data());
}

GLenum colorFormatOf(const RenderTargetDef& target) {
  return target.float32Color ? GL_RGBA32F : GL_RGBA16F;
}

// Sum of those of 1, 2, 4 and 8 that the format has. GL rounds other counts up without a word.
uint32_t sampleCountsOf(const Functions& gl, GLenum format) {
  GLint count = 0;
  gl.glGetInternalformativ(GL_RENDERBUFFER, format, GL_NUM_SAMPLE_COUNTS, 1, &count);
  std::vector<GLint> samples(static_cast<size_t>(std::max(count, 0)));
  if (count > 0)
    gl.glGetInternalformativ(GL_RENDERBUFFER, format, GL_SAMPLES, count, samples.data());
  uint32_t sum = 1;
  for (const GLint n : samples)
    if (n == 2 || n == 4 || n == 8) sum |= static_cast<uint32_t>(n);
  return sum;
}

// The sample counts of a target of a color format.
uint32_t targetSampleCounts(const Functions& gl, GLenum color) {
  return sampleCountsOf(gl, color) & sampleCountsOf(gl, GL_DEPTH_COMPONENT32F);
}

GLint64 sizeOf(const Functions& gl, GLuint buffer) {
  GLint64 size = 0;
  if (buffer == 0) return size;
  gl.glBindBuffer(GL_COPY_WRITE_BUFFER, buffer);
  gl.glGetBufferParameteri64v(GL_COPY_WRITE_BUFFER, GL_BUFFER_SIZE, &size);
  return size;
}

// The target of render(), kept between frames of one size.
class RenderTarget {
 public:
  explicit RenderTarget(const Functions& gl) : gl_(gl) {}
  // Before the context goes.
  void release() {
    releaseImages();
    depthCopy_.release(gl_);
  }
  // \param device  its name, for messages
  Result<void> make(const RenderTargetDef& target, const std::string& device);
  void bind() const { gl_.glBindFramebuffer(GL_FRAMEBUFFER, framebuffers_[0]); }
  void clear(const RenderTargetDef& target) const;
  Result<void> copyDepth(gl::Profile profile, const PixelArea& area, GLuint buffer) {
    return depthCopy_.run(gl_, profile, depthTexture_, area, buffer);
  }
  // Reads the colors, samples averaged.
  void read(const RenderTargetDef& target, std::span<Float4> pixels) const;

 private:
  void releaseImages();

  const Functions& gl_;
  uint32_t width_ = 0, height_ = 0, samples_ = 0;
  bool float32_ = false;
  GLuint framebuffers_[2] = {};   // [0] is drawn to, [1] takes the average of its samples
  GLuint renderbuffers_[3] = {};  // color, depth of several samples, average
  GLuint depthTexture_ = 0;       // depth of one sample: what depthCopy_ can read
  gl::DepthCopy depthCopy_;
};

void RenderTarget::releaseImages() {
  gl_.glDeleteFramebuffers(2, framebuffers_);
  gl_.glDeleteRenderbuffers(3, renderbuffers_);
  gl_.glDeleteTextures(1, &depthTexture_);
  depthTexture_ = 0;
  std::fill(std::begin(framebuffers_), std::end(framebuffers_), 0u);
  std::fill(std::begin(renderbuffers_), std::end(renderbuffers_), 0u);
  width_ = height_ = samples_ = 0;
}

// Device `name` cannot make a target.
Error targetError(const std::string& name, const RenderTargetDef& target, GLenum error,
                  GLenum status) {
  return Error{error == GL_OUT_OF_MEMORY ? ErrorCode::kOutOfMemory : ErrorCode::kUnsupported,
               name + " cannot draw to " + std::to_string(target.width) + " x " +
                   std::to_string(target.height) + (target.float32Color ? " RGBA32F" : " RGBA16F") +
                   " pixels with " + std::to_string(target.samples) +
                   " samples and 32-bit depth (" +
                   (error != GL_NO_ERROR ? gl::errorName(error)
                                         : "framebuffer status " + std::to_string(status)) +
                   ")"};
}

Result<void> RenderTarget::make(const RenderTargetDef& target, const std::string& device) {
  if (width_ == target.width && height_ == target.height && samples_ == target.samples &&
      float32_ == target.float32Color)
    return {};
  releaseImages();
  const auto width = static_cast<GLsizei>(target.width);
  const auto height = static_cast<GLsizei>(target.height);
  const GLenum color = colorFormatOf(target);
  const GLsizei samples = target.samples > 1 ? static_cast<GLsizei>(target.samples) : 0;
  gl_.glGenFramebuffers(2, framebuffers_);
  gl_.glGenRenderbuffers(3, renderbuffers_);
  gl::clearErrors(gl_);
  const auto storage = [&](int index, GLenum format, GLsizei count) {
    gl_.glBindRenderbuffer(GL_RENDERBUFFER, renderbuffers_[index]);
    gl_.glRenderbufferStorageMultisample(GL_RENDERBUFFER, count, format, width, height);
  };
  storage(0, color, samples);
  if (samples > 0) {
    storage(1, GL_DEPTH_COMPONENT32F, samples);
    storage(2, color, 0);
  } else {
    gl_.glGenTextures(1, &depthTexture_);
    gl_.glActiveTexture(GL_TEXTURE0);
    gl_.glBindTexture(GL_TEXTURE_2D, depthTexture_);
    gl_.glTexStorage2D(GL_TEXTURE_2D, 1, GL_DEPTH_COMPONENT32F, width, height);
    gl_.glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl_.glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl_.glBindTexture(GL_TEXTURE_2D, 0);
  }
  GLenum status = GL_FRAMEBUFFER_COMPLETE;
  const auto attach = [&](int framebuffer, int colour, bool depth) {
    gl_.glBindFramebuffer(GL_FRAMEBUFFER, framebuffers_[framebuffer]);
    gl_.glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                                  renderbuffers_[colour]);
    if (depth && samples > 0) {
      gl_.glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER,
                                    renderbuffers_[1]);
    } else if (depth) {
      gl_.glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depthTexture_,
                                 0);
    }
    const GLenum now = gl_.glCheckFramebufferStatus(GL_FRAMEBUFFER);
    if (now != GL_FRAMEBUFFER_COMPLETE) status = now;
  };
  const GLenum error = gl_.glGetError();
  if (error == GL_NO_ERROR) {
    attach(0, 0, true);
    if (samples > 0) attach(1, 2, false);
  }
  if (error != GL_NO_ERROR || status != GL_FRAMEBUFFER_COMPLETE) {
    releaseImages();
    return targetError(device, target, error, status);
  }
  width_ = target.width;
  height_ = target.height;
  samples_ = target.samples;
  float32_ = target.float32Color;
  return {};
}

void RenderTarget::clear(const RenderTargetDef& target) const {
  bind();
  // Clears obey these, and the draws of an earlier frame have set them.
  gl_.glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  gl_.glDepthMask(GL_TRUE);
  gl_.glDisable(GL_SCISSOR_TEST);
  gl_.glDisable(GL_RASTERIZER_DISCARD);
  const Float4& color = target.clearColor;
  const GLfloat values[4] = {color.x, color.y, color.z, color.w};
  gl_.glClearBufferfv(GL_COLOR, 0, values);
  gl_.glClearBufferfv(GL_DEPTH, 0, &target.clearDepth);
}

void RenderTarget::read(const RenderTargetDef& target, std::span<Float4> pixels) const {
  const auto width = static_cast<GLint>(target.width), height = static_cast<GLint>(target.height);
  if (target.samples > 1) {
    gl_.glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffers_[0]);
    gl_.glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffers_[1]);
    gl_.glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT,
                          GL_NEAREST);
    gl_.glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffers_[1]);
  }
  gl::clearErrors(gl_);
  static_assert(sizeof(Float4) == 4 * sizeof(float));
  gl_.glReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, pixels.data());
}

constexpr uint32_t kLargestTarget = 16384;

class HeadlessGl final : public HeadlessDevice {
 public:
  static Result<std::unique_ptr<HeadlessDevice>> create(const Candidate& candidate,
                                                        const HeadlessDef& def);
  ~HeadlessGl() override {
    const ScopedCurrent current(egl_);
    target_.release();
    gl_.glDeleteTextures(static_cast<GLsizei>(textures_.size()), textures_.data());
    timer_.reset();
    runtime_.reset();
  }

  const DeviceInfo& info() const override { return info_; }

  Result<void> update(const ResourceTable& resources) override {
    const ScopedCurrent current(egl_);
    if (Result<void> ok = current.check(); !ok) return ok;
    return runtime_->update(resources);
  }

  Result<TextureId> createTexture(const TextureDef& texture) override;

  Result<void> execute(const PassList& list, std::vector<PassTiming>* timings) override {
    const ScopedCurrent current(egl_);
    if (Result<void> ok = current.check(); !ok) return ok;
    Result<void> recorded = runtime_->record(list, timings != nullptr ? &*timer_ : nullptr);
    return finish(std::move(recorded), timings);
  }

  using HeadlessDevice::render;
  Result<RenderedImage> render(std::span<const PassList* const> lists,
                               const RenderTargetDef& target,
                               std::vector<PassTiming>* timings) override;

  Result<std::vector<std::byte>> read(BufferId buffer, uint64_t offset, uint64_t size) override {
    const ScopedCurrent current(egl_);
    if (Result<void> ok = current.check(); !ok) return ok.error();
    return runtime_->read(buffer, offset, size);
  }

  using HeadlessDevice::supports;
  Result<void> supports(const PassList& list) const override { return runtime_->supports(list); }
  void addCode(KernelCodeList code) override { runtime_->addCode(code); }
  uint64_t bufferBytes() const override { return runtime_->statistics().bufferBytes; }
  uint32_t messageCount() const override { return messageCount_; }

 private:
  explicit HeadlessGl(EglContext egl) : egl_(std::move(egl)) {}
  Result<void> initialise(const HeadlessDef& def);
  Result<void> finish(Result<void> recorded, std::vector<PassTiming>* timings);
  Result<void> recordLists(std::span<const PassList* const> lists, const RenderTargetDef& target,
                           gl::PassTimer* timer);

  EglContext egl_;
  Functions gl_;
  uint32_t messageCount_ = 0;
  DeviceInfo info_;
  std::optional<gl::Runtime> runtime_;
  std::optional<gl::PassTimer> timer_;
  RenderTarget target_{gl_};
  std::vector<GLuint> textures_;  // of createTexture()
};

std::string text(const Functions& gl, GLenum name) {
  const auto* string = reinterpret_cast<const char*>(gl.glGetString(name));
  return string != nullptr ? string : "";
}

// "4.5 (Core Profile) Mesa 22.3.6" -> {"4.5 (Core Profile)", "Mesa 22.3.6"}.
std::pair<std::string, std::string> splitVersion(const std::string& version) {
  size_t at = version.find_first_of("0123456789");
  at = at == std::string::npos ? version.size() : version.find(' ', at);
  constexpr std::string_view kProfile = " (Core Profile)";
  if (at != std::string::npos && version.compare(at, kProfile.size(), kProfile) == 0)
    at += kProfile.size();
  if (at == std::string::npos || at >= version.size()) return {version, ""};
  return {version.substr(0, at), version.substr(at + 1)};
}

Result<void> HeadlessGl::initialise(const HeadlessDef& def) {
  const ScopedCurrent current(egl_);
  if (Result<void> ok = current.check(); !ok) return ok;
  gl::RuntimeDef runtimeDef;
  runtimeDef.getProcAddress = [](const char* name) {
    return reinterpret_cast<void*>(eglGetProcAddress(name));
  };
  runtimeDef.debug = def.validation;
  runtimeDef.maxTier = def.maxTier;
  const gl::GetProcAddress getProcAddress = runtimeDef.getProcAddress;
  Result<gl::Runtime> runtime = gl::Runtime::create(std::move(runtimeDef));
  if (!runtime) return runtime.error();
  if (const std::string missing = gl::loadCommonFunctions(gl_, getProcAddress); !missing.empty())
    return unsupported("EGL does not know " + missing);
  runtime_ = std::move(*runtime);
  timer_.emplace(*runtime_);

  if (def.validation) {
    GLint flags = 0;
    gl_.glGetIntegerv(GL_CONTEXT_FLAGS, &flags);
    if ((flags & GL_CONTEXT_FLAG_DEBUG_BIT) == 0)
      return unsupported("HeadlessDef::validation: the driver gives no debug context");
    gl_.glEnable(GL_DEBUG_OUTPUT);
    gl_.glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    gl_.glDebugMessageControl(GL_DONT_CARE, GL_DONT_CARE, GL_DONT_CARE, 0, nullptr, GL_TRUE);
    gl_.glDebugMessageCallback(&onDebugMessage, &messageCount_);
  }

  info_.api = def.api;
  info_.name = text(gl_, GL_RENDERER);
  std::tie(info_.version, info_.driver) = splitVersion(text(gl_, GL_VERSION));
  if (info_.driver.empty()) info_.driver = text(gl_, GL_VENDOR);
  std::string lower = info_.name;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const char* software : {"llvmpipe", "softpipe", "swrast", "swiftshader", "software"})
    info_.software |= lower.find(software) != std::string::npos;
  info_.sampleCounts = targetSampleCounts(gl_, GL_RGBA16F);
  info_.maxSamples = std::bit_floor(info_.sampleCounts);
  info_.maxBufferBytes = runtime_->limits().storageBlockBytes;
  info_.tier = runtime_->tier();
  return {};
}

Result<std::unique_ptr<HeadlessDevice>> HeadlessGl::create(const Candidate& candidate,
                                                           const HeadlessDef& def) {
  Result<EglContext> egl = EglContext::create(candidate, def.api, def.validation);
  if (!egl) return egl.error();
  std::unique_ptr<HeadlessGl> device(new HeadlessGl(std::move(*egl)));
  if (Result<void> ready = device->initialise(def); !ready) {
    Error error = ready.error();
    error.message = candidate.name + ": " + error.message;
    return error;
  }
  return std::unique_ptr<HeadlessDevice>(std::move(device));
}

Result<void> HeadlessGl::finish(Result<void> recorded, std::vector<PassTiming>* timings) {
  gl_.glFinish();
  // Read even after a failure: the timer must be empty for the next list.
  std::vector<PassTiming> read = timer_->read();
  if (recorded && timings != nullptr) *timings = std::move(read);
  return recorded;
}

Result<TextureId> HeadlessGl::createTexture(const TextureDef& def) {
  const Result<std::vector<std::byte>> texels = textureBytes(def);
  if (!texels) return texels.error();
  const ScopedCurrent current(egl_);
  if (Result<void> ok = current.check(); !ok) return ok.error();
  const bool cube = def.shape == TextureShape::kCube, plane = def.shape == TextureShape::kPlane;
  const GLenum target = cube ? GL_TEXTURE_CUBE_MAP : plane ? GL_TEXTURE_2D : GL_TEXTURE_2D_ARRAY;
  const bool single = def.channels == 1;
  const GLenum stored = single ? GL_R32F : GL_RGBA16F;
  const GLenum given = single ? GL_RED : GL_RGBA, type = single ? GL_FLOAT : GL_HALF_FLOAT;
  const auto width = static_cast<GLsizei>(def.width), height = static_cast<GLsizei>(def.height);
  GLuint name = 0;
  gl::clearErrors(gl_);
  gl_.glGenTextures(1, &name);
  textures_.push_back(name);
  gl_.glActiveTexture(GL_TEXTURE0);
  gl_.glBindTexture(target, name);
  if (cube) {
    gl_.glTexStorage2D(target, 1, stored, width, height);
    const size_t face = texels->size() / 6;
    for (GLenum i = 0; i < 6; ++i)
      gl_.glTexSubImage2D(GL_TEXTURE_CUBE_MAP_POSITIVE_X + i, 0, 0, 0, width, height, given, type,
                          texels->data() + i * face);
  } else if (plane) {
    const auto levels = static_cast<GLsizei>(def.mipLevels);
    gl_.glTexStorage2D(target, levels, stored, width, height);
    const std::byte* next = texels->data();
    for (uint32_t i = 0; i < def.mipLevels; ++i) {
      const uint32_t columns = sizeOfLevel(def.width, i), rows = sizeOfLevel(def.height, i);
      gl_.glTexSubImage2D(target, static_cast<GLint>(i), 0, 0, static_cast<GLsizei>(columns),
                          static_cast<GLsizei>(rows), given, type, next);
      next += size_t{columns} * rows * (single ? sizeof(float) : 4 * sizeof(uint16_t));
    }
  } else {
    const auto layers = static_cast<GLsizei>(def.layers);
    gl_.glTexStorage3D(target, 1, stored, width, height, layers);
    gl_.glTexSubImage3D(target, 0, 0, 0, 0, width, height, layers, given, type, texels->data());
  }
  const GLint filter = single ? GL_NEAREST : GL_LINEAR;
  const GLint between = single ? GL_NEAREST_MIPMAP_NEAREST : GL_LINEAR_MIPMAP_LINEAR;
  gl_.glTexParameteri(target, GL_TEXTURE_MIN_FILTER, def.mipLevels > 1 ? between : filter);
  gl_.glTexParameteri(target, GL_TEXTURE_MAG_FILTER, filter);
  for (const GLenum parameter : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
    gl_.glTexParameteri(target, parameter, plane ? GL_REPEAT : GL_CLAMP_TO_EDGE);
  gl_.glBindTexture(target, 0);
  if (const GLenum error = gl_.glGetError(); error != GL_NO_ERROR) {
    return Error{error == GL_OUT_OF_MEMORY ? ErrorCode::kOutOfMemory : ErrorCode::kUnsupported,
                 info_.name + " has no texture of " + std::to_string(def.width) + " x " +
                     std::to_string(def.height) + " texels in " + std::to_string(def.layers) +
                     " layers (" + gl::errorName(error) + ")"};
  }
  const TextureId id = newTextureId();
  runtime_->registerTexture(id, {.target = target, .name = name});
  return id;
}

Result<void> HeadlessGl::recordLists(std::span<const PassList* const> lists,
                                     const RenderTargetDef& target, gl::PassTimer* timer) {
  // An error is found before anything runs.
  const Result<PixelArea> area = drawArea(target);
  if (!area) return area.error();
  for (const PassList* list : lists) {
    if (Result<void> fits = checkArea(*list, *area); !fits) return fits;
    if (Result<void> ready = runtime_->prepare(*list); !ready) return ready;
  }
  target_.clear(target);
  for (size_t i = 0; i < lists.size(); ++i) {
    if (Result<void> done = runtime_->record(*lists[i], timer); !done) return done;
    target_.bind();
    Result<void> drawn =
        runtime_->recordDraws(*lists[i], {area->x, area->y, area->width, area->height}, timer);
    if (!drawn) return drawn;
    if (target.depthCopy == BufferId::kInvalid || i != target.depthCopyAfter) continue;
    Result<void> copied =
        target_.copyDepth(runtime_->profile(), *area, runtime_->bufferName(target.depthCopy));
    if (!copied) return copied;
  }
  return {};
}

Result<RenderedImage> HeadlessGl::render(std::span<const PassList* const> lists,
                                         const RenderTargetDef& target,
                                         std::vector<PassTiming>* timings) try {
  if (target.width == 0 || target.height == 0 || target.width > kLargestTarget ||
      target.height > kLargestTarget) {
    return Error{ErrorCode::kInvalidArgument, "RenderTargetDef: " + std::to_string(target.width) +
                                                  " x " + std::to_string(target.height) +
                                                  " pixels; each is 1 to 16384"};
  }
  if (target.samples == 0 || (target.samples & (target.samples - 1)) != 0 || target.samples > 8) {
    return Error{
        ErrorCode::kInvalidArgument,
        "RenderTargetDef::samples is " + std::to_string(target.samples) + "; it is 1, 2, 4 or 8"};
  }
  const ScopedCurrent current(egl_);
  if (Result<void> ok = current.check(); !ok) return ok.error();
  const uint32_t counts =
      target.float32Color ? targetSampleCounts(gl_, colorFormatOf(target)) : info_.sampleCounts;
  if ((counts & target.samples) == 0) {
    return unsupported(std::to_string(target.samples) + " samples a pixel: " + info_.name +
                       " has no such target; it has up to " + std::to_string(info_.maxSamples));
  }
  if (Result<void> ok = checkDepthCopy(
          target, lists.size(),
          static_cast<uint64_t>(sizeOf(gl_, runtime_->bufferName(target.depthCopy))));
      !ok)
    return ok.error();
  RenderedImage image;
  image.width = target.width;
  image.height = target.height;
  image.pixels.resize(size_t{target.width} * target.height);
  if (Result<void> made = target_.make(target, info_.name); !made) return made.error();

  gl::PassTimer* timer = timings != nullptr ? &*timer_ : nullptr;
  Result<void> recorded = recordLists(lists, target, timer);
  if (recorded) {
    target_.read(target, image.pixels);
    if (const GLenum error = gl_.glGetError(); error != GL_NO_ERROR) {
      recorded = Error{ErrorCode::kDevice,
                       info_.name + " does not give the picture back: " + gl::errorName(error)};
    }
  }
  if (Result<void> done = finish(std::move(recorded), timings); !done) return done.error();
  return image;
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::kOutOfMemory, "no host memory is left for a picture of " +
                                            std::to_string(target.width) + " x " +
                                            std::to_string(target.height) + " pixels"};
}

}  // namespace

Result<std::unique_ptr<HeadlessDevice>> createHeadlessGl(const HeadlessDef& def) {
  PELAGE_ASSERT(def.api != Api::kVulkan, "createHeadlessGl() makes OpenGL and OpenGL ES devices");
  if (!def.deviceUuid.empty())
    return unsupported("devices of OpenGL have no UUID: choose one by HeadlessDef::deviceIndex");
  Result<std::vector<Candidate>> candidates = findCandidates(def.deviceIndex);
  if (!candidates) return candidates.error();
  std::string reasons;
  for (const Candidate& candidate : *candidates) {
    Result<std::unique_ptr<HeadlessDevice>> device = HeadlessGl::create(candidate, def);
    if (device) return device;
    reasons += "; " + device.error().message;
  }
  return unsupported(
      std::string("no device for OpenGL ") + (def.api == Api::kGles ? "ES 3.2" : "4.5 core") +
      " was found through EGL: install a driver (Debian: libegl-mesa0 for the CPU)" + reasons);
}

}  // namespace pelage
