// An EGL context that a test makes for itself, as an engine would have one of its own.
#pragma once

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <array>

#include "pelage/headless.h"

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

}  // namespace pelage::test
