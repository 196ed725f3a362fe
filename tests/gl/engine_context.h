// An EGL context that a test makes for itself, as an engine would have one of its own.
#pragma once

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/glcorearb.h>
#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <utility>

#include "pelage/gl.h"
#include "pelage/headless.h"
#include "runtime_test/code.h"
#include "support/required_devices.h"

namespace pelage::test {

inline void* eglAddress(const char* name) {
  return reinterpret_cast<void*>(eglGetProcAddress(name));
}

template <class Function>
Function glFunction(const char* name) {
  return reinterpret_cast<Function>(eglAddress(name));
}

class EngineContext {
 public:
  explicit EngineContext(Api api) {
    const auto getDisplay = glFunction<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
    const auto queryDevices = glFunction<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
    std::array<EGLDeviceEXT, 16> devices{};
    EGLint count = 0;
    if (getDisplay == nullptr || queryDevices == nullptr ||
        queryDevices(static_cast<EGLint>(devices.size()), devices.data(), &count) != EGL_TRUE)
      return;
    for (EGLint i = 0; i < count && context_ == EGL_NO_CONTEXT; ++i) {
      display_ = getDisplay(EGL_PLATFORM_DEVICE_EXT, devices[static_cast<size_t>(i)], nullptr);
      if (display_ == EGL_NO_DISPLAY || eglInitialize(display_, nullptr, nullptr) != EGL_TRUE)
        continue;
      const bool es = api == Api::kGles;
      eglBindAPI(es ? EGL_OPENGL_ES_API : EGL_OPENGL_API);
      const EGLint core[] = {EGL_CONTEXT_MAJOR_VERSION,
                             4,
                             EGL_CONTEXT_MINOR_VERSION,
                             5,
                             EGL_CONTEXT_OPENGL_PROFILE_MASK,
                             EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                             EGL_NONE};
      const EGLint esAttributes[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 2,
                                     EGL_NONE};
      context_ =
          eglCreateContext(display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, es ? esAttributes : core);
    }
    current_ = context_ != EGL_NO_CONTEXT &&
               eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE;
  }
  ~EngineContext() {
    if (context_ == EGL_NO_CONTEXT) return;
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
  }
  EngineContext(const EngineContext&) = delete;
  EngineContext& operator=(const EngineContext&) = delete;
  bool current() const { return current_; }

 private:
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
  bool current_ = false;
};

/// Runtimes on the context of an "engine", which is the test.
class GlContextTest : public testing::TestWithParam<Api> {
 protected:
  void SetUp() override {
    context_ = std::make_unique<EngineContext>(GetParam());
    if (!context_->current()) PELAGE_SKIP_WITHOUT_DEVICE() << "no OpenGL context through EGL";
  }
  void TearDown() override {
    if (!context_->current()) return;
    EXPECT_EQ(glGetError_(), GLenum{GL_NO_ERROR});
  }

  gl::Runtime makeRuntime(gl::ProgramCache cache = {}) {
    gl::RuntimeDef def;
    def.getProcAddress = address_;
    def.programCache = std::move(cache);
    def.debug = true;
    Result<gl::Runtime> runtime = gl::Runtime::create(std::move(def));
    EXPECT_TRUE(runtime) << runtime.error().message;
    runtime->addCode(runtime_test::allCode());
    return std::move(*runtime);
  }

  std::unique_ptr<EngineContext> context_;
  void* (*address_)(const char*) = eglAddress;
  PFNGLGETERRORPROC glGetError_ = glFunction<PFNGLGETERRORPROC>("glGetError");
};

}  // namespace pelage::test
