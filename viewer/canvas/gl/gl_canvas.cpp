// OpenGL 4.5 core, in the window's context. Row 0 of the scene's target is the top row; the picture
// is flipped for the window.
#define GL_GLEXT_PROTOTYPES
#include <GL/glcorearb.h>

#include <backends/imgui_impl_opengl3.h>
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>

#include "canvas/canvas.h"
#include "pelage/gl.h"
#include "pelage/list_check.h"
#include "sample/code.h"
#include "viewer_kernels/code.h"
#include "window/glfw.h"
#include "window/window.h"

namespace viewer {

using pelage::Error;
using pelage::ErrorCode;
using pelage::Result;

namespace {

constexpr const char* kCacheFolder = "viewer_gl";
constexpr size_t kTimers = 3;

void APIENTRY onMessage(GLenum, GLenum type, GLuint, GLenum severity, GLsizei,
                        const GLchar* message, const void* user) {
  const bool error = type == GL_DEBUG_TYPE_ERROR || type == GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR;
  if (!error && severity != GL_DEBUG_SEVERITY_HIGH) return;
  ++*const_cast<uint32_t*>(static_cast<const uint32_t*>(user));
  std::fprintf(stderr, "pelage-viewer: OpenGL: %s\n", message);
}

std::string stringOf(GLenum name) {
  const auto* string = reinterpret_cast<const char*>(glGetString(name));
  return string != nullptr ? string : "";
}

// Returns the sum of the sample counts among 1, 2, 4 and 8 that textures of a format have.
uint32_t sampleCountsOf(GLenum format) {
  GLint count = 0;
  glGetInternalformativ(GL_TEXTURE_2D_MULTISAMPLE, format, GL_NUM_SAMPLE_COUNTS, 1, &count);
  std::vector<GLint> samples(static_cast<size_t>(std::max(count, 0)));
  if (count > 0)
    glGetInternalformativ(GL_TEXTURE_2D_MULTISAMPLE, format, GL_SAMPLES, count, samples.data());
  uint32_t sum = 1;
  for (const GLint n : samples)
    if (n == 2 || n == 4 || n == 8) sum |= static_cast<uint32_t>(n);
  return sum;
}

// The target of the scene. Row 0 of its framebuffer is the top row, as in buffers.
class GlTarget {
 public:
  Result<void> make(const CanvasTarget& target);
  void release();
  /// Without a size there is no target.
  const CanvasTarget& size() const { return size_; }
  GLuint color() const { return color_; }
  void bind(bool clears) const;
  /// Takes the mean of the samples of each pixel.
  void resolve() const;
  void copyDepth(const pelage::PixelArea& area, GLuint buffer) const;

 private:
  GLuint color_ = 0, depth_ = 0, framebuffer_ = 0;
  GLuint samples_ = 0,
         resolved_ = 0;  // with several samples a pixel: their color, and the framebuffer of color_
  CanvasTarget size_;
};

void GlTarget::release() {
  for (GLuint* framebuffer : {&framebuffer_, &resolved_}) {
    glDeleteFramebuffers(1, framebuffer);
    *framebuffer = 0;
  }
  for (GLuint* texture : {&color_, &samples_, &depth_}) {
    glDeleteTextures(1, texture);
    *texture = 0;
  }
  size_ = {};
}

Result<void> GlTarget::make(const CanvasTarget& target) {
  const auto columns = static_cast<GLsizei>(target.width);
  const auto rows = static_cast<GLsizei>(target.height);
  const auto samples = static_cast<GLsizei>(target.samples);
  const bool resolves = samples > 1;
  const auto check = [&](GLuint framebuffer) -> Result<void> {
    const GLenum status = glCheckNamedFramebufferStatus(framebuffer, GL_FRAMEBUFFER);
    if (status == GL_FRAMEBUFFER_COMPLETE) return {};
    return Error{ErrorCode::kOutOfMemory,
                 fmt::format("a target of {} x {} pixels with {} samples each: framebuffer status "
                             "{:#x}",
                             target.width, target.height, target.samples, status)};
  };
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &color_);
  glTextureStorage3D(color_, 1, GL_RGBA16F, columns, rows, 1);
  glTextureParameteri(color_, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTextureParameteri(color_, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glCreateFramebuffers(1, &framebuffer_);
  if (resolves) {
    glCreateTextures(GL_TEXTURE_2D_MULTISAMPLE, 1, &samples_);
    glTextureStorage2DMultisample(samples_, samples, GL_RGBA16F, columns, rows, GL_TRUE);
    glCreateTextures(GL_TEXTURE_2D_MULTISAMPLE, 1, &depth_);
    glTextureStorage2DMultisample(depth_, samples, GL_DEPTH_COMPONENT32F, columns, rows, GL_TRUE);
    glNamedFramebufferTexture(framebuffer_, GL_COLOR_ATTACHMENT0, samples_, 0);
    glCreateFramebuffers(1, &resolved_);
    glNamedFramebufferTextureLayer(resolved_, GL_COLOR_ATTACHMENT0, color_, 0, 0);
    if (Result<void> complete = check(resolved_); !complete) return complete;
  } else {
    glCreateTextures(GL_TEXTURE_2D, 1, &depth_);
    glTextureStorage2D(depth_, 1, GL_DEPTH_COMPONENT32F, columns, rows);
    glNamedFramebufferTextureLayer(framebuffer_, GL_COLOR_ATTACHMENT0, color_, 0, 0);
  }
  glNamedFramebufferTexture(framebuffer_, GL_DEPTH_ATTACHMENT, depth_, 0);
  if (Result<void> complete = check(framebuffer_); !complete) return complete;
  size_ = target;
  return {};
}

void GlTarget::bind(bool clears) const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  if (!clears) return;
  // These states of earlier draws also affect clears.
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthMask(GL_TRUE);
  glDisable(GL_SCISSOR_TEST);
  const GLfloat color[4] = {}, depth = size_.reversedDepth ? 0.0f : 1.0f;
  glClearBufferfv(GL_COLOR, 0, color);
  glClearBufferfv(GL_DEPTH, 0, &depth);
}

void GlTarget::resolve() const {
  if (resolved_ == 0) return;
  const auto width = static_cast<GLint>(size_.width), height = static_cast<GLint>(size_.height);
  glDisable(GL_SCISSOR_TEST);
  glBlitNamedFramebuffer(framebuffer_, resolved_, 0, 0, width, height, 0, 0, width, height,
                         GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

void GlTarget::copyDepth(const pelage::PixelArea& area, GLuint buffer) const {
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, buffer);
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glReadPixels(static_cast<GLint>(area.x), static_cast<GLint>(area.y),
               static_cast<GLsizei>(area.width), static_cast<GLsizei>(area.height),
               GL_DEPTH_COMPONENT, GL_FLOAT, nullptr);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
}

// GPU times of passes, which are read two frames late.
class GlTimers {
 public:
  void make(pelage::gl::Runtime& runtime) {
    for (auto& timer : timers_) timer.emplace(runtime);
  }
  void release() {
    for (auto& timer : timers_) timer.reset();
  }
  /// Begins a frame. \return the times of the earlier frame that used its timer.
  std::vector<pelage::PassTiming> begin() { return timers_[++frame_ % kTimers]->read(); }
  pelage::gl::PassTimer& current() { return *timers_[frame_ % kTimers]; }

 private:
  std::array<std::optional<pelage::gl::PassTimer>, kTimers> timers_;
  uint64_t frame_ = 0;
};

void listen(uint32_t& messages) {
  glEnable(GL_DEBUG_OUTPUT);
  glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
  glDebugMessageControl(GL_DONT_CARE, GL_DONT_CARE, GL_DONT_CARE, 0, nullptr, GL_TRUE);
  glDebugMessageCallback(&onMessage, &messages);
}

pelage::DeviceInfo infoOf(const pelage::gl::Runtime& runtime) {
  pelage::DeviceInfo info;
  info.api = pelage::Api::kGl;
  info.name = stringOf(GL_RENDERER);
  info.driver = stringOf(GL_VENDOR);
  info.version = stringOf(GL_VERSION);
  std::string lower = info.name;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const char* software : {"llvmpipe", "softpipe", "swrast", "swiftshader"})
    info.software |= lower.find(software) != std::string::npos;
  info.sampleCounts = sampleCountsOf(GL_RGBA16F) & sampleCountsOf(GL_DEPTH_COMPONENT32F);
  info.maxSamples = std::bit_floor(info.sampleCounts);
  info.maxBufferBytes = runtime.limits().storageBlockBytes;
  info.tier = runtime.tier();
  return info;
}

sample::ByteImage readPicture(uint32_t width, uint32_t height) {
  sample::ByteImage picture;
  picture.width = width;
  picture.height = height;
  picture.rgb.resize(size_t{3} * width * height);
  std::vector<uint8_t> rows(picture.rgb.size());
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadBuffer(GL_BACK);
  glReadPixels(0, 0, static_cast<GLsizei>(width), static_cast<GLsizei>(height), GL_RGB,
               GL_UNSIGNED_BYTE, rows.data());
  const size_t row = size_t{3} * width;
  for (size_t y = 0; y < height; ++y)
    std::copy_n(rows.begin() + static_cast<ptrdiff_t>((height - 1 - y) * row), row,
                picture.rgb.begin() + static_cast<ptrdiff_t>(y * row));
  return picture;
}

class GlCanvas final : public Canvas {
 public:
  GlCanvas(CanvasDef def, Window& window) : def_(std::move(def)), window_(window) {}
  ~GlCanvas() override;
  Result<void> open();

  const pelage::DeviceInfo& info() const override { return info_; }
  Result<void> supports(const pelage::TransparencySettings& settings) const override {
    return runtime_->supports(settings, {.followHairs = true});
  }
  Result<void> setCode(pelage::KernelCodeList code) override;
  Result<void> setTarget(const CanvasTarget& target) override;
  Result<void> begin() override;
  Result<void> show(const CanvasFrame& frame) override;
  Result<std::vector<std::byte>> read(pelage::BufferId buffer) override {
    return runtime_->read(buffer);
  }
  CanvasMemory memory() const override { return {runtime_->statistics().bufferBytes, 0}; }
  uint32_t messageCount() const override { return messages_; }
  void saveCache() override {}  // the runtime stores programs when it links them

 private:
  Result<void> makeRuntime(pelage::KernelCodeList code);
  Result<void> draw(const pelage::FrameStep& step, const CanvasFrame& frame, uint32_t views);

  CanvasDef def_;
  Window& window_;
  std::optional<pelage::gl::Runtime> runtime_;
  GlTimers timers_;
  pelage::DeviceInfo info_;
  pelage::TextureId scene_ = pelage::newTextureId();
  GlTarget target_;
  bool hasInterface_ = false;
  uint32_t messages_ = 0;
};

GlCanvas::~GlCanvas() {
  if (hasInterface_) ImGui_ImplOpenGL3_Shutdown();
  target_.release();
  timers_.release();
  runtime_.reset();
  if (def_.validation) glDebugMessageCallback(nullptr, nullptr);
}

Result<void> GlCanvas::makeRuntime(pelage::KernelCodeList code) {
  pelage::gl::RuntimeDef def;
  // The first table with a permutation is used.
  if (!code.empty()) def.code.insert(def.code.begin(), code);
  def.getProcAddress = [](const char* name) {
    return reinterpret_cast<void*>(glfwGetProcAddress(name));
  };
  if (!def_.cache.empty())
    def.programCache = pelage::gl::directoryProgramCache((def_.cache / kCacheFolder).string());
  def.debug = def_.validation;
  Result<pelage::gl::Runtime> runtime = pelage::gl::Runtime::create(std::move(def));
  if (!runtime) return runtime.error();
  runtime_.emplace(*std::move(runtime));
  runtime_->addCode(sample::allCode());
  runtime_->addCode(viewer_kernels::allCode());
  timers_.make(*runtime_);
  return {};
}

Result<void> GlCanvas::setCode(pelage::KernelCodeList code) {
  timers_.release();
  runtime_.reset();
  timings_.clear();
  Result<void> made = makeRuntime(code);
  if (made && target_.size().width > 0)
    runtime_->registerTexture(scene_, {.target = GL_TEXTURE_2D_ARRAY, .name = target_.color()});
  return made;
}

Result<void> GlCanvas::open() {
  if (Result<void> done = makeRuntime({}); !done) return done;
  if (def_.validation) listen(messages_);
  info_ = infoOf(*runtime_);
  hasInterface_ = ImGui_ImplOpenGL3_Init("#version 450");
  if (!hasInterface_)
    return Error{ErrorCode::kDevice, "the user interface cannot be drawn with OpenGL"};
  return {};
}

Result<void> GlCanvas::setTarget(const CanvasTarget& target) {
  if (target == target_.size()) return {};
  if (Result<void> can = checkSamples(info_, target.samples); !can) return can;
  target_.release();
  if (Result<void> made = target_.make(target); !made) {
    target_.release();
    return made;
  }
  runtime_->registerTexture(scene_, {.target = GL_TEXTURE_2D_ARRAY, .name = target_.color()});
  return {};
}

Result<void> GlCanvas::begin() {
  std::vector<pelage::PassTiming> read = timers_.begin();
  if (!read.empty()) timings_ = std::move(read);
  ImGui_ImplOpenGL3_NewFrame();
  return {};
}

Result<void> GlCanvas::draw(const pelage::FrameStep& step, const CanvasFrame& frame,
                            uint32_t views) {
  const bool isPicture = step.view == views;
  if (isPicture) {
    target_.resolve();
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
  } else
    target_.bind(step.view == 0 && step.listOfView == 0);
  const CanvasView whole = {{0, 0, target_.size().width, target_.size().height}};
  const CanvasView& on = isPicture ? whole : frame.views[step.view];
  const pelage::gl::DrawTarget target = {on.area.x, on.area.y, on.area.width, on.area.height};
  if (Result<void> done = runtime_->recordDraws(*step.list, target, &timers_.current()); !done)
    return done;
  if (step.listOfView == 0 && on.depthCopy != pelage::BufferId::kInvalid)
    target_.copyDepth(on.area, runtime_->bufferName(on.depthCopy));
  return {};
}

Result<void> GlCanvas::show(const CanvasFrame& frame) {
  const uint32_t views = frame.frame->viewCount();
  const CanvasTarget& size = target_.size();
  Result<pelage::PassList> picture =
      pictureList(scene_, size.width, size.height, true, frame.coarseness);
  if (!picture) return picture.error();
  if (const auto added = frame.frame->addView(*std::move(picture)); !added) return added.error();
  pelage::FrameExecutor executor;
  executor.update = [&](const pelage::ResourceTable& table) { return runtime_->update(table); };
  executor.record = [&](const pelage::FrameStep& step) {
    return runtime_->record(*step.list, &timers_.current());
  };
  executor.draw = [&](const pelage::FrameStep& step) { return draw(step, frame, views); };
  if (Result<void> done = frame.frame->run(executor); !done) return done;

  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  // ImGui needs another depth range and origin than the kernels.
  glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  if (frame.interface != nullptr) ImGui_ImplOpenGL3_RenderDrawData(frame.interface);
  if (frame.captures) captured_ = readPicture(size.width, size.height);
  window_.swapBuffers();
  return {};
}

}  // namespace

Result<std::unique_ptr<Canvas>> createGlCanvas(const CanvasDef& def, Window& window) {
  auto canvas = std::make_unique<GlCanvas>(def, window);
  if (Result<void> opened = canvas->open(); !opened) return opened.error();
  return std::unique_ptr<Canvas>(std::move(canvas));
}

}  // namespace viewer
