#include <algorithm>
#include <array>
#include <span>

#include "runtime_impl.h"

namespace pelage::gl {
namespace {

std::string resourceName(const Functions& gl, GLuint program, GLenum interface, GLuint index) {
  const GLenum property = GL_NAME_LENGTH;
  GLint length = 0;
  gl.glGetProgramResourceiv(program, interface, index, 1, &property, 1, nullptr, &length);
  std::string name(static_cast<size_t>(std::max(length, 1)), '\0');
  gl.glGetProgramResourceName(program, interface, index, static_cast<GLsizei>(name.size()), nullptr,
                              name.data());
  name.resize(name.find('\0'));
  return name;
}

template <size_t kCount>
std::array<uint32_t, kCount> properties(const Functions& gl, GLuint program, GLenum interface,
                                        GLuint index, const GLenum (&names)[kCount]) {
  std::array<GLint, kCount> values{};
  gl.glGetProgramResourceiv(program, interface, index, kCount, names, kCount, nullptr,
                            values.data());
  std::array<uint32_t, kCount> result{};
  std::transform(values.begin(), values.end(), result.begin(),
                 [](GLint value) { return static_cast<uint32_t>(std::max(value, 0)); });
  return result;
}

DriverMember readMember(const Functions& gl, GLuint program, GLenum interface, GLuint index) {
  DriverMember member;
  member.name = resourceName(gl, program, interface, index);
  constexpr GLenum kNames[] = {GL_OFFSET, GL_TYPE, GL_ARRAY_SIZE, GL_ARRAY_STRIDE};
  const auto values = properties(gl, program, interface, index, kNames);
  member.offset = values[0];
  member.type = values[1];
  member.arraySize = values[2];
  member.arrayStride = values[3];
  if (interface == GL_BUFFER_VARIABLE) {
    constexpr GLenum kTopNames[] = {GL_TOP_LEVEL_ARRAY_SIZE, GL_TOP_LEVEL_ARRAY_STRIDE};
    const auto top = properties(gl, program, interface, index, kTopNames);
    member.topLevelArraySize = top[0];
    member.topLevelArrayStride = top[1];
  }
  return member;
}

void sortByBinding(std::span<DriverBlock> blocks) {
  std::sort(blocks.begin(), blocks.end(),
            [](const DriverBlock& a, const DriverBlock& b) { return a.binding < b.binding; });
}

void readBlocks(const Functions& gl, GLuint program, ResourceKind kind,
                std::vector<DriverBlock>& blocks) {
  const bool uniform = kind == ResourceKind::kUniformBuffer;
  const GLenum blockInterface = uniform ? GL_UNIFORM_BLOCK : GL_SHADER_STORAGE_BLOCK;
  const GLenum memberInterface = uniform ? GL_UNIFORM : GL_BUFFER_VARIABLE;
  const size_t first = blocks.size();
  GLint count = 0;
  gl.glGetProgramInterfaceiv(program, blockInterface, GL_ACTIVE_RESOURCES, &count);
  for (GLuint index = 0; index < static_cast<GLuint>(count); ++index) {
    DriverBlock block;
    block.name = resourceName(gl, program, blockInterface, index);
    block.kind = kind;
    constexpr GLenum kNames[] = {GL_BUFFER_BINDING, GL_BUFFER_DATA_SIZE, GL_NUM_ACTIVE_VARIABLES};
    const auto values = properties(gl, program, blockInterface, index, kNames);
    block.binding = values[0];
    block.dataSize = values[1];
    std::vector<GLint> members(values[2]);
    if (!members.empty()) {
      const GLenum activeVariables = GL_ACTIVE_VARIABLES;
      gl.glGetProgramResourceiv(program, blockInterface, index, 1, &activeVariables,
                                static_cast<GLsizei>(members.size()), nullptr, members.data());
    }
    for (const GLint member : members)
      block.members.push_back(
          readMember(gl, program, memberInterface, static_cast<GLuint>(member)));
    std::sort(block.members.begin(), block.members.end(),
              [](const DriverMember& a, const DriverMember& b) { return a.offset < b.offset; });
    blocks.push_back(std::move(block));
  }
  sortByBinding(std::span(blocks).subspan(first));
}

bool isSampler(GLenum type) {
  constexpr GLenum kSamplers[] = {
      GL_SAMPLER_2D,     GL_SAMPLER_3D,     GL_SAMPLER_CUBE,           GL_SAMPLER_2D_ARRAY,
      GL_SAMPLER_BUFFER, GL_INT_SAMPLER_2D, GL_UNSIGNED_INT_SAMPLER_2D};
  return std::find(std::begin(kSamplers), std::end(kSamplers), type) != std::end(kSamplers);
}

// A texture is a uniform outside of all blocks, whose value is the unit.
void readTextures(const Functions& gl, GLuint program, std::vector<DriverBlock>& blocks) {
  const size_t first = blocks.size();
  GLint count = 0;
  gl.glGetProgramInterfaceiv(program, GL_UNIFORM, GL_ACTIVE_RESOURCES, &count);
  for (GLuint index = 0; index < static_cast<GLuint>(count); ++index) {
    constexpr GLenum kNames[] = {GL_TYPE, GL_LOCATION};
    const auto values = properties(gl, program, GL_UNIFORM, index, kNames);
    if (!isSampler(values[0])) continue;
    GLint unit = 0;
    gl.glGetUniformiv(program, static_cast<GLint>(values[1]), &unit);
    DriverBlock texture;
    texture.name = resourceName(gl, program, GL_UNIFORM, index);
    texture.kind = ResourceKind::kSampledTexture;
    texture.binding = static_cast<uint32_t>(unit);
    blocks.push_back(std::move(texture));
  }
  sortByBinding(std::span(blocks).subspan(first));
}

}  // namespace

Result<std::vector<DriverBlock>> Runtime::reflectProgram(const KernelVariant& variant) {
  const Functions& gl = impl_->context->gl;
  clearErrors(gl);
  Result<GLuint> program = impl_->programs.makeStage(variant);
  if (!program) return program.error();
  std::vector<DriverBlock> blocks;
  readBlocks(gl, *program, ResourceKind::kUniformBuffer, blocks);
  readBlocks(gl, *program, ResourceKind::kStorageBuffer, blocks);
  readTextures(gl, *program, blocks);
  gl.glDeleteProgram(*program);
  if (const GLenum error = gl.glGetError(); error != GL_NO_ERROR) {
    clearErrors(gl);
    return Error{ErrorCode::kDevice, "kernel " + variantName(variant) + ": " +
                                         impl_->context->renderer + " reports " + errorName(error) +
                                         " when asked for its blocks"};
  }
  return blocks;
}

}  // namespace pelage::gl
