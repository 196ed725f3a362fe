#include "executor.h"

#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>
#include <pelage/list_check.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>

void Executor::createBuffers(const pelage::ResourceTable& table) {
  for (uint32_t i = 0; i < table.end(); ++i) {
    const pelage::BufferId id = table.at(i);
    const pelage::BufferDesc* desc = table.find(id);
    if (desc == nullptr || buffers_.contains(static_cast<uint32_t>(id))) continue;
    GLuint name = 0;
    glGenBuffers(1, &name);
    glBindBuffer(GL_SHADER_STORAGE_BUFFER, name);
    const std::vector<std::byte> zeros(desc->initial.empty() ? desc->size : 0);
    glBufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(desc->size),
                 desc->initial.empty() ? zeros.data() : desc->initial.data(), GL_DYNAMIC_DRAW);
    buffers_[static_cast<uint32_t>(id)] = name;
  }
}

unsigned Executor::program(const pelage::KernelVariant& variant) {
  GLuint& program = programs_[&variant];
  if (program != 0) return program;
  const GLuint shader = glCreateShader(GL_COMPUTE_SHADER);
  const pelage::Result<std::string> source = code_.source(variant, pelage::CodeFormat::kGlsl);
  if (!source) {
    std::fprintf(stderr, "%s\n", source.error().message.c_str());
    std::exit(1);
  }
  const GLchar* text = source->data();
  const auto length = static_cast<GLint>(source->size());
  glShaderSource(shader, 1, &text, &length);
  glCompileShader(shader);
  program = glCreateProgram();
  glAttachShader(program, shader);
  glLinkProgram(program);
  GLint linked = 0;
  glGetProgramiv(program, GL_LINK_STATUS, &linked);
  if (linked == 0) {
    char log[4096] = {};
    glGetShaderInfoLog(shader, sizeof(log), nullptr, log);
    std::fprintf(stderr, "%s: %s\n", variant.kernel->name, log);
    std::exit(1);
  }
  glDeleteShader(shader);
  return program;
}

void Executor::run(const pelage::PassList& list, const pelage::ResourceTable& table) {
  for (const auto& checked : {pelage::checkList(list, table), pelage::checkRun(list)}) {
    if (checked) continue;
    std::fprintf(stderr, "%s\n", checked.error().message.c_str());
    std::exit(1);
  }
  for (const pelage::Upload& upload : list.uploads) {
    glBindBuffer(GL_SHADER_STORAGE_BUFFER, buffers_.at(static_cast<uint32_t>(upload.buffer)));
    glBufferSubData(GL_SHADER_STORAGE_BUFFER, static_cast<GLintptr>(upload.offset),
                    static_cast<GLsizeiptr>(upload.size),
                    list.uploadData.data() + upload.dataOffset);
  }
  if (!list.constants.empty()) {
    if (constants_ == 0) glGenBuffers(1, &constants_);
    glBindBuffer(GL_UNIFORM_BUFFER, constants_);
    glBufferData(GL_UNIFORM_BUFFER, static_cast<GLsizeiptr>(list.constants.size()),
                 list.constants.data(), GL_STREAM_DRAW);
  }
  for (const pelage::Pass& pass : list.passes) {
    if (pelage::isDraw(pass.kind)) continue;
    if (pass.barrierCount > 0)
      glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
    glUseProgram(program(*pass.kernel));
    for (const pelage::PassBinding& binding : list.bindingsOf(pass)) {
      const pelage::LayoutEntry& entry =
          pass.kernel->kernel->layouts[binding.set]->entries[binding.entry];
      const auto use =
          std::find_if(pass.kernel->bindings.begin(), pass.kernel->bindings.end(),
                       [&](const pelage::VariantBinding& candidate) {
                         return candidate.set == binding.set && candidate.entry == binding.entry;
                       });
      if (use == pass.kernel->bindings.end()) continue;
      const bool block = entry.kind == pelage::ResourceKind::kUniformBuffer;
      glBindBufferRange(block ? GL_UNIFORM_BUFFER : GL_SHADER_STORAGE_BUFFER, use->glBinding,
                        block ? constants_ : buffers_.at(static_cast<uint32_t>(binding.buffer)),
                        static_cast<GLintptr>(binding.offset),
                        static_cast<GLsizeiptr>(binding.size));
    }
    if (pass.kind == pelage::PassKind::kDispatchIndirect) {
      glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, buffers_.at(static_cast<uint32_t>(pass.indirect)));
      glDispatchComputeIndirect(static_cast<GLintptr>(pass.indirectOffset));
    } else {
      glDispatchCompute(pass.groups[0], pass.groups[1], pass.groups[2]);
    }
  }
  // Else the scene takes the frame for lost, and writes it again.
  pelage::setDelivered(list.run);
}

std::vector<float> Executor::read(pelage::BufferId buffer, size_t floats) const {
  std::vector<float> values(floats);
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, buffers_.at(static_cast<uint32_t>(buffer)));
  glGetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, static_cast<GLsizeiptr>(floats * sizeof(float)),
                     values.data());
  return values;
}
