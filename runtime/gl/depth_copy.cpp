#include "depth_copy.h"

#include <string>

namespace pelage::gl {
namespace {

constexpr GLuint kGroupSize = 8;

// Row 0 of the framebuffer is the top row: the draws come out of codegen that way.
constexpr char kSource[] = R"(
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D depthTexture;
layout(location = 0) uniform ivec4 area;  // x, y, width, height
layout(std430, binding = 0) writeonly buffer Depths { float depths[]; };
void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, area.zw))) return;
  depths[pixel.y * area.z + pixel.x] = texelFetch(depthTexture, area.xy + pixel, 0).r;
}
)";

}  // namespace

Result<void> DepthCopy::makeProgram(const Functions& gl, Profile profile) {
  const std::string head =
      profile == Profile::kCore
          ? "#version 450\n"
          : "#version 320 es\nprecision highp float;\nprecision highp sampler2D;\n";
  const std::string source = head + kSource;
  const GLuint shader = gl.glCreateShader(GL_COMPUTE_SHADER);
  const GLchar* text = source.c_str();
  gl.glShaderSource(shader, 1, &text, nullptr);
  gl.glCompileShader(shader);
  const GLuint program = gl.glCreateProgram();
  gl.glAttachShader(program, shader);
  gl.glDeleteShader(shader);  // lives on as long as the program does
  gl.glLinkProgram(program);
  GLint linked = GL_FALSE;
  gl.glGetProgramiv(program, GL_LINK_STATUS, &linked);
  if (linked == GL_FALSE) {
    GLchar log[1024] = {};
    gl.glGetProgramInfoLog(program, sizeof(log), nullptr, log);
    gl.glDeleteProgram(program);
    return Error{ErrorCode::kDevice,
                 std::string("the shader that copies depth does not link: ") + log};
  }
  program_ = program;
  return {};
}

void DepthCopy::release(const Functions& gl) {
  if (program_ != 0) gl.glDeleteProgram(program_);
  program_ = 0;
}

Result<void> DepthCopy::run(const Functions& gl, Profile profile, GLuint texture,
                            const PixelArea& area, GLuint buffer) {
  if (program_ == 0) {
    if (Result<void> made = makeProgram(gl, profile); !made) return made;
  }
  // The lists' hazards do not know of this copy: it waits for every use of the buffer before it,
  // and every use after it waits here.
  gl.glMemoryBarrier(GL_ALL_BARRIER_BITS);
  gl.glUseProgram(program_);
  gl.glUniform4i(0, static_cast<GLint>(area.x), static_cast<GLint>(area.y),
                 static_cast<GLint>(area.width), static_cast<GLint>(area.height));
  gl.glActiveTexture(GL_TEXTURE0);
  gl.glBindTexture(GL_TEXTURE_2D, texture);
  gl.glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer);
  gl.glDispatchCompute((area.width + kGroupSize - 1) / kGroupSize,
                       (area.height + kGroupSize - 1) / kGroupSize, 1);
  gl.glMemoryBarrier(GL_ALL_BARRIER_BITS);
  gl.glBindTexture(GL_TEXTURE_2D, 0);
  return {};
}

}  // namespace pelage::gl
