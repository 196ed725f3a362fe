// Pictures that the engine of the OpenGL tests draws into.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

#include "gl/engine_context.h"

namespace pelage::test {

/// A picture with depth that an engine draws into; a rich one has stencil, too, and two attachments
/// more.
class GlTarget {
 public:
  GlTarget(uint32_t width, uint32_t height, bool rich = false)
      : width_(width), height_(height), rich_(rich) {
    call<PFNGLGENFRAMEBUFFERSPROC>("glGenFramebuffers")(1, &framebuffer_);
    call<PFNGLGENRENDERBUFFERSPROC>("glGenRenderbuffers")(4, buffers_);
    bind();
    attach(0, GL_RGBA16F, GL_COLOR_ATTACHMENT0);
    if (rich) {
      attach(1, GL_DEPTH32F_STENCIL8, GL_DEPTH_STENCIL_ATTACHMENT);
      attach(2, GL_RGBA8, GL_COLOR_ATTACHMENT1);
      attach(3, GL_R32UI, GL_COLOR_ATTACHMENT2);
      const GLenum buffers[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT2};
      call<PFNGLDRAWBUFFERSPROC>("glDrawBuffers")(3, buffers);
    } else {
      attach(1, GL_DEPTH_COMPONENT32F, GL_DEPTH_ATTACHMENT);
    }
    EXPECT_EQ(call<PFNGLCHECKFRAMEBUFFERSTATUSPROC>("glCheckFramebufferStatus")(GL_FRAMEBUFFER),
              GLenum{GL_FRAMEBUFFER_COMPLETE});
  }
  ~GlTarget() {
    call<PFNGLDELETEFRAMEBUFFERSPROC>("glDeleteFramebuffers")(1, &framebuffer_);
    call<PFNGLDELETERENDERBUFFERSPROC>("glDeleteRenderbuffers")(4, buffers_);
  }
  GlTarget(const GlTarget&) = delete;
  GlTarget& operator=(const GlTarget&) = delete;

  void begin(bool first) const {
    bind();
    if (!first) return;
    call<PFNGLCOLORMASKPROC>("glColorMask")(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    call<PFNGLDEPTHMASKPROC>("glDepthMask")(GL_TRUE);
    const float color[4] = {}, depth = 1, other[4] = {0.2f, 0.2f, 0.2f, 0.2f};
    const auto clear = call<PFNGLCLEARBUFFERFVPROC>("glClearBufferfv");
    clear(GL_COLOR, 0, color);
    clear(GL_DEPTH, 0, &depth);
    if (!rich_) return;
    const GLint stencil = kStencil;
    const GLuint id[4] = {kId, 0, 0, 0};
    call<PFNGLSTENCILMASKPROC>("glStencilMask")(~0u);
    clear(GL_COLOR, 1, other);
    call<PFNGLCLEARBUFFERUIVPROC>("glClearBufferuiv")(GL_COLOR, 2, id);
    call<PFNGLCLEARBUFFERIVPROC>("glClearBufferiv")(GL_STENCIL, 0, &stencil);
  }
  /// Leaves a stencil test on that nothing passes, and that counts.
  static void rejectByStencil() {
    call<PFNGLENABLEPROC>("glEnable")(GL_STENCIL_TEST);
    call<PFNGLSTENCILFUNCPROC>("glStencilFunc")(GL_NEVER, 0, ~0u);
    call<PFNGLSTENCILOPPROC>("glStencilOp")(GL_INCR, GL_INCR, GL_INCR);
  }
  gl::DrawTarget area() const { return {0, 0, width_, height_}; }
  std::vector<float> pixels() const {
    bind();
    return read<float>(GL_COLOR_ATTACHMENT0, GL_RGBA, GL_FLOAT, 4);
  }
  void expectOthersUntouched(bool es) const {
    bind();
    for (const uint32_t word : read<uint32_t>(GL_COLOR_ATTACHMENT1, GL_RGBA, GL_UNSIGNED_BYTE, 1))
      ASSERT_EQ(word, 0x33333333u);  // 0.2 is 51 of 255
    const std::vector<uint32_t> ids =
        read<uint32_t>(GL_COLOR_ATTACHMENT2, GL_RGBA_INTEGER, GL_UNSIGNED_INT, 4);
    for (size_t i = 0; i < ids.size(); i += 4) ASSERT_EQ(ids[i], kId);
    if (es) return;  // OpenGL ES does not give stencil back
    for (const uint32_t value :
         read<uint32_t>(GL_COLOR_ATTACHMENT0, GL_STENCIL_INDEX, GL_UNSIGNED_INT, 1))
      ASSERT_EQ(value, static_cast<uint32_t>(kStencil));
  }

 private:
  static constexpr GLint kStencil = 7;
  static constexpr GLuint kId = 0x01020304;
  template <class Function>
  static Function call(const char* name) {
    return glFunction<Function>(name);
  }
  void attach(size_t index, GLenum format, GLenum point) const {
    call<PFNGLBINDRENDERBUFFERPROC>("glBindRenderbuffer")(GL_RENDERBUFFER, buffers_[index]);
    call<PFNGLRENDERBUFFERSTORAGEPROC>("glRenderbufferStorage")(
        GL_RENDERBUFFER, format, static_cast<GLsizei>(width_), static_cast<GLsizei>(height_));
    call<PFNGLFRAMEBUFFERRENDERBUFFERPROC>("glFramebufferRenderbuffer")(
        GL_FRAMEBUFFER, point, GL_RENDERBUFFER, buffers_[index]);
  }
  template <class T>
  std::vector<T> read(GLenum buffer, GLenum format, GLenum type, size_t perPixel) const {
    std::vector<T> all(perPixel * width_ * height_);
    call<PFNGLREADBUFFERPROC>("glReadBuffer")(buffer);
    call<PFNGLREADPIXELSPROC>("glReadPixels")(0, 0, static_cast<GLsizei>(width_),
                                              static_cast<GLsizei>(height_), format, type,
                                              all.data());
    return all;
  }
  void bind() const {
    call<PFNGLBINDFRAMEBUFFERPROC>("glBindFramebuffer")(GL_FRAMEBUFFER, framebuffer_);
  }
  uint32_t width_, height_;
  bool rich_;
  GLuint framebuffer_ = 0;
  GLuint buffers_[4] = {};
};

}  // namespace pelage::test
