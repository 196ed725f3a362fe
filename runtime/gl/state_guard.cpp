#include <algorithm>
#include <array>
#include <vector>

#include "runtime_impl.h"

namespace pelage::gl {

struct IndexedBinding {
  GLuint name = 0;
  GLint64 start = 0, size = 0;
};

struct DrawBuffer {
  GLboolean blend = GL_FALSE;
  GLboolean mask[4] = {};
  GLint equationRgb = 0, equationAlpha = 0;
  GLint sourceRgb = 0, sourceAlpha = 0, destinationRgb = 0, destinationAlpha = 0;
};

namespace {

struct IndexedTarget {
  GLenum target, binding, start, size;
};
constexpr IndexedTarget kIndexedTargets[] = {
    {GL_UNIFORM_BUFFER, GL_UNIFORM_BUFFER_BINDING, GL_UNIFORM_BUFFER_START, GL_UNIFORM_BUFFER_SIZE},
    {GL_SHADER_STORAGE_BUFFER, GL_SHADER_STORAGE_BUFFER_BINDING, GL_SHADER_STORAGE_BUFFER_START,
     GL_SHADER_STORAGE_BUFFER_SIZE}};

struct PlainTarget {
  GLenum target, binding;
};
constexpr PlainTarget kPlainTargets[] = {
    {GL_UNIFORM_BUFFER, GL_UNIFORM_BUFFER_BINDING},
    {GL_SHADER_STORAGE_BUFFER, GL_SHADER_STORAGE_BUFFER_BINDING},
    {GL_COPY_READ_BUFFER, GL_COPY_READ_BUFFER_BINDING},
    {GL_COPY_WRITE_BUFFER, GL_COPY_WRITE_BUFFER_BINDING},
    {GL_DISPATCH_INDIRECT_BUFFER, GL_DISPATCH_INDIRECT_BUFFER_BINDING},
    {GL_DRAW_INDIRECT_BUFFER, GL_DRAW_INDIRECT_BUFFER_BINDING}};

// The query for the texture of a unit at a target; 0: textures of this target cannot be registered.
GLenum textureBinding(GLenum target) {
  switch (target) {
    case GL_TEXTURE_2D:
      return GL_TEXTURE_BINDING_2D;
    case GL_TEXTURE_2D_ARRAY:
      return GL_TEXTURE_BINDING_2D_ARRAY;
    case GL_TEXTURE_3D:
      return GL_TEXTURE_BINDING_3D;
    case GL_TEXTURE_CUBE_MAP:
      return GL_TEXTURE_BINDING_CUBE_MAP;
    case GL_TEXTURE_CUBE_MAP_ARRAY:
      return GL_TEXTURE_BINDING_CUBE_MAP_ARRAY;
    case GL_TEXTURE_BUFFER:
      return GL_TEXTURE_BINDING_BUFFER;
    case GL_TEXTURE_2D_MULTISAMPLE:
      return GL_TEXTURE_BINDING_2D_MULTISAMPLE;
    case GL_TEXTURE_2D_MULTISAMPLE_ARRAY:
      return GL_TEXTURE_BINDING_2D_MULTISAMPLE_ARRAY;
    default:
      return 0;
  }
}

}  // namespace

struct StateGuard::Impl {
  std::shared_ptr<const Context> context;
  GLint program = 0, vertexArray = 0;
  std::vector<IndexedBinding> indexed[std::size(kIndexedTargets)];
  GLint plain[std::size(kPlainTargets)] = {};

  GLfloat viewport[4] = {};
  GLdouble depthRange[2] = {};
  GLboolean scissor = GL_FALSE, depthTest = GL_FALSE, depthMask = GL_FALSE, restart = GL_FALSE;
  GLint depthFunction = 0, clipOrigin = 0, clipDepth = 0, polygonMode[2] = {};
  GLboolean disabled[std::size(kDisabledInDraws)] = {};
  std::vector<DrawBuffer> drawBuffers;

  // Where textures are registered.
  std::vector<GLenum> textureTargets;
  GLint activeUnit = 0, samplers[kMaxTextures] = {};
  std::vector<GLint> textures[kMaxTextures];  // [unit][target]

  explicit Impl(const Runtime::Impl& runtime) : context(runtime.context) {
    for (const auto& [id, texture] : runtime.textures) {
      const auto known = std::find(textureTargets.begin(), textureTargets.end(), texture.target);
      if (known == textureTargets.end() && textureBinding(texture.target) != 0)
        textureTargets.push_back(texture.target);
    }
    save();
    saveTextures();
  }

  void saveTextures() {
    if (textureTargets.empty()) return;
    const Functions& gl = context->gl;
    gl.glGetIntegerv(GL_ACTIVE_TEXTURE, &activeUnit);
    for (GLuint unit = 0; unit < kMaxTextures; ++unit) {
      gl.glActiveTexture(GL_TEXTURE0 + unit);
      gl.glGetIntegerv(GL_SAMPLER_BINDING, &samplers[unit]);
      for (const GLenum target : textureTargets)
        gl.glGetIntegerv(textureBinding(target), &textures[unit].emplace_back(0));
    }
    gl.glActiveTexture(static_cast<GLenum>(activeUnit));
  }

  void restoreTextures() const {
    if (textureTargets.empty()) return;
    const Functions& gl = context->gl;
    for (GLuint unit = 0; unit < kMaxTextures; ++unit) {
      gl.glActiveTexture(GL_TEXTURE0 + unit);
      gl.glBindSampler(unit, static_cast<GLuint>(samplers[unit]));
      for (size_t i = 0; i < textureTargets.size(); ++i)
        gl.glBindTexture(textureTargets[i], static_cast<GLuint>(textures[unit][i]));
    }
    gl.glActiveTexture(static_cast<GLenum>(activeUnit));
  }

  bool core() const { return context->profile == Profile::kCore; }

  void save() {
    const Functions& gl = context->gl;
    gl.glGetIntegerv(GL_CURRENT_PROGRAM, &program);
    gl.glGetIntegerv(GL_VERTEX_ARRAY_BINDING, &vertexArray);
    for (size_t t = 0; t < std::size(kIndexedTargets); ++t) {
      const IndexedTarget& target = kIndexedTargets[t];
      const uint32_t count = std::min(
          kMaxBindings, t == 0 ? context->limits.uniformBindings : context->limits.storageBindings);
      indexed[t].resize(count);
      for (GLuint i = 0; i < count; ++i) {
        GLint name = 0;
        gl.glGetIntegeri_v(target.binding, i, &name);
        indexed[t][i].name = static_cast<GLuint>(name);
        gl.glGetInteger64i_v(target.start, i, &indexed[t][i].start);
        gl.glGetInteger64i_v(target.size, i, &indexed[t][i].size);
      }
    }
    for (size_t t = 0; t < std::size(kPlainTargets); ++t)
      gl.glGetIntegerv(kPlainTargets[t].binding, &plain[t]);

    if (core()) {
      gl.glGetFloati_v(GL_VIEWPORT, 0, viewport);
      gl.glGetDoublei_v(GL_DEPTH_RANGE, 0, depthRange);
      scissor = gl.glIsEnabledi(GL_SCISSOR_TEST, 0);
      gl.glGetIntegerv(GL_CLIP_ORIGIN, &clipOrigin);
      gl.glGetIntegerv(GL_CLIP_DEPTH_MODE, &clipDepth);
      gl.glGetIntegerv(GL_POLYGON_MODE, polygonMode);
      restart = gl.glIsEnabled(GL_PRIMITIVE_RESTART);
    } else {
      gl.glGetFloatv(GL_VIEWPORT, viewport);
      GLfloat range[2] = {};
      gl.glGetFloatv(GL_DEPTH_RANGE, range);
      std::copy(range, range + 2, depthRange);
      scissor = gl.glIsEnabled(GL_SCISSOR_TEST);
    }
    depthTest = gl.glIsEnabled(GL_DEPTH_TEST);
    gl.glGetBooleanv(GL_DEPTH_WRITEMASK, &depthMask);
    gl.glGetIntegerv(GL_DEPTH_FUNC, &depthFunction);
    for (size_t i = 0; i < std::size(kDisabledInDraws); ++i)
      disabled[i] = gl.glIsEnabled(kDisabledInDraws[i]);

    drawBuffers.resize(context->drawBuffers);
    for (GLuint i = 0; i < drawBuffers.size(); ++i) {
      DrawBuffer& buffer = drawBuffers[i];
      buffer.blend = gl.glIsEnabledi(GL_BLEND, i);
      gl.glGetBooleani_v(GL_COLOR_WRITEMASK, i, buffer.mask);
      gl.glGetIntegeri_v(GL_BLEND_EQUATION_RGB, i, &buffer.equationRgb);
      gl.glGetIntegeri_v(GL_BLEND_EQUATION_ALPHA, i, &buffer.equationAlpha);
      gl.glGetIntegeri_v(GL_BLEND_SRC_RGB, i, &buffer.sourceRgb);
      gl.glGetIntegeri_v(GL_BLEND_SRC_ALPHA, i, &buffer.sourceAlpha);
      gl.glGetIntegeri_v(GL_BLEND_DST_RGB, i, &buffer.destinationRgb);
      gl.glGetIntegeri_v(GL_BLEND_DST_ALPHA, i, &buffer.destinationAlpha);
    }
  }

  void set(GLenum capability, GLboolean enabled) const {
    if (enabled != GL_FALSE) {
      context->gl.glEnable(capability);
    } else {
      context->gl.glDisable(capability);
    }
  }

  void setIndexed(GLenum capability, GLuint index, GLboolean enabled) const {
    if (enabled != GL_FALSE) {
      context->gl.glEnablei(capability, index);
    } else {
      context->gl.glDisablei(capability, index);
    }
  }

  void restore() const {
    const Functions& gl = context->gl;
    gl.glUseProgram(static_cast<GLuint>(program));
    gl.glBindVertexArray(static_cast<GLuint>(vertexArray));
    for (size_t t = 0; t < std::size(kIndexedTargets); ++t) {
      const GLenum target = kIndexedTargets[t].target;
      for (GLuint i = 0; i < indexed[t].size(); ++i) {
        const IndexedBinding& binding = indexed[t][i];
        // Bound as a whole, a buffer reports the size 0.
        if (binding.name == 0 || binding.size == 0) {
          gl.glBindBufferBase(target, i, binding.name);
        } else {
          gl.glBindBufferRange(target, i, binding.name, static_cast<GLintptr>(binding.start),
                               static_cast<GLsizeiptr>(binding.size));
        }
      }
    }
    // After the indexed ones, which change these too.
    for (size_t t = 0; t < std::size(kPlainTargets); ++t)
      gl.glBindBuffer(kPlainTargets[t].target, static_cast<GLuint>(plain[t]));

    if (core()) {
      gl.glViewportIndexedf(0, viewport[0], viewport[1], viewport[2], viewport[3]);
      gl.glDepthRangeIndexed(0, depthRange[0], depthRange[1]);
      setIndexed(GL_SCISSOR_TEST, 0, scissor);
      gl.glClipControl(static_cast<GLenum>(clipOrigin), static_cast<GLenum>(clipDepth));
      gl.glPolygonMode(GL_FRONT_AND_BACK, static_cast<GLenum>(polygonMode[0]));
      set(GL_PRIMITIVE_RESTART, restart);
    } else {
      gl.glViewport(static_cast<GLint>(viewport[0]), static_cast<GLint>(viewport[1]),
                    static_cast<GLsizei>(viewport[2]), static_cast<GLsizei>(viewport[3]));
      gl.glDepthRangef(static_cast<GLfloat>(depthRange[0]), static_cast<GLfloat>(depthRange[1]));
      set(GL_SCISSOR_TEST, scissor);
    }
    set(GL_DEPTH_TEST, depthTest);
    gl.glDepthMask(depthMask);
    gl.glDepthFunc(static_cast<GLenum>(depthFunction));
    for (size_t i = 0; i < std::size(kDisabledInDraws); ++i) set(kDisabledInDraws[i], disabled[i]);
    for (GLuint i = 0; i < drawBuffers.size(); ++i) {
      const DrawBuffer& buffer = drawBuffers[i];
      setIndexed(GL_BLEND, i, buffer.blend);
      gl.glColorMaski(i, buffer.mask[0], buffer.mask[1], buffer.mask[2], buffer.mask[3]);
      gl.glBlendEquationSeparatei(i, static_cast<GLenum>(buffer.equationRgb),
                                  static_cast<GLenum>(buffer.equationAlpha));
      gl.glBlendFuncSeparatei(
          i, static_cast<GLenum>(buffer.sourceRgb), static_cast<GLenum>(buffer.destinationRgb),
          static_cast<GLenum>(buffer.sourceAlpha), static_cast<GLenum>(buffer.destinationAlpha));
    }
  }
};

StateGuard::StateGuard(const Runtime& runtime) : impl_(std::make_unique<Impl>(*runtime.impl_)) {}
StateGuard::~StateGuard() {
  impl_->restore();
  impl_->restoreTextures();
}

}  // namespace pelage::gl
