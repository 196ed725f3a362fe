#include <algorithm>
#include <cstring>
#include <new>
#include <utility>

#include "context.h"
#include "pelage/gl.h"
#include "program.h"
#include "runtime_impl.h"

namespace pelage::gl {
namespace {

Error invalid(std::string message) {
  return Error{ErrorCode::kInvalidArgument, std::move(message)};
}

bool fits(uint64_t offset, uint64_t size, uint64_t total) {
  return offset <= total && size <= total - offset;
}

std::string number(BufferId id) { return std::to_string(static_cast<uint32_t>(id)); }

Error inPass(const Pass& pass, Error error) {
  error.message = std::string("pass '") + pass.name + "': " + error.message;
  return error;
}

PixelArea areaOf(const DrawTarget& target) {
  return {target.x, target.y, target.width, target.height};
}

GLenum usageHint(BufferUsage usage) {
  if (contains(usage, BufferUsage::kUpload)) return GL_DYNAMIC_DRAW;
  // Written and read by the GPU alone; a driver keeps it in its own memory.
  return contains(usage, BufferUsage::kStorage) ? GL_DYNAMIC_COPY : GL_STATIC_DRAW;
}

GLenum topologyMode(PrimitiveTopology topology) {
  switch (topology) {
    case PrimitiveTopology::kTriangleList:
      return GL_TRIANGLES;
    case PrimitiveTopology::kTriangleStrip:
      return GL_TRIANGLE_STRIP;
    case PrimitiveTopology::kLineList:
      return GL_LINES;
  }
  return GL_TRIANGLES;
}

GLenum depthFunction(DepthCompare compare) {
  switch (compare) {
    case DepthCompare::kAlways:
      return GL_ALWAYS;
    case DepthCompare::kLess:
      return GL_LESS;
    case DepthCompare::kLessEqual:
      return GL_LEQUAL;
    case DepthCompare::kGreater:
      return GL_GREATER;
    case DepthCompare::kGreaterEqual:
      return GL_GEQUAL;
    case DepthCompare::kEqual:
      return GL_EQUAL;
  }
  return GL_ALWAYS;
}

const VariantBinding* useOf(const KernelVariant& variant, const PassBinding& binding) {
  const auto uses = variant.bindings;
  const auto found = std::find_if(uses.begin(), uses.end(), [&](const VariantBinding& use) {
    return use.set == binding.set && use.entry == binding.entry;
  });
  return found != uses.end() ? &*found : nullptr;
}

}  // namespace

uint32_t memoryBarrierBits(std::span<const Barrier> barriers) {
  uint32_t bits = 0;
  for (const Barrier& barrier : barriers) {
    const bool shaderBefore = barrier.beforeStages != 0;
    if (barrier.afterStages != 0 &&
        (shaderBefore || barrier.beforeIndex || barrier.beforeVertex || barrier.beforeIndirect))
      bits |= GL_SHADER_STORAGE_BARRIER_BIT;
    if (!shaderBefore || !writes(barrier.before)) continue;
    if (barrier.afterUpload) bits |= GL_BUFFER_UPDATE_BARRIER_BIT;
    if (barrier.afterIndirect) bits |= GL_COMMAND_BARRIER_BIT;
    if (barrier.afterIndex) bits |= GL_ELEMENT_ARRAY_BARRIER_BIT;
    if (barrier.afterVertex) bits |= GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT;
  }
  return bits;
}

Runtime::Impl::Impl(std::shared_ptr<const Context> glContext, ProgramCache cache)
    : context(std::move(glContext)), programs(context, std::move(cache), statistics) {
  const Functions& gl = context->gl;
  gl.glGenBuffers(1, &constants);
  gl.glGenVertexArrays(1, &vertexArray);
}

Runtime::Impl::~Impl() {
  const Functions& gl = context->gl;
  for (const Buffer& buffer : buffers)
    if (buffer.owned) gl.glDeleteBuffers(1, &buffer.name);
  gl.glDeleteBuffers(1, &constants);
  gl.glDeleteVertexArrays(1, &vertexArray);
}

Runtime::Runtime(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Runtime::Runtime(Runtime&&) noexcept = default;
Runtime& Runtime::operator=(Runtime&&) noexcept = default;
Runtime::~Runtime() = default;

Profile Runtime::profile() const { return impl_->context->profile; }
const Limits& Runtime::limits() const { return impl_->context->limits; }

Tier Runtime::tier() const {
  const Limits& own = impl_->context->limits;
  TierLimits limits = limitsOf(Tier::kWide);
  limits.storageBuffers = {own.computeStorageBlocks, own.vertexStorageBlocks,
                           own.pixelStorageBlocks};
  limits.drawStorageBuffers = own.combinedStorageBlocks;
  limits.storageBindings = own.storageBindings;
  limits.groupThreads = own.groupThreads;
  std::copy(std::begin(own.groupSize), std::end(own.groupSize), std::begin(limits.groupSize));
  return tierOf(limits).value_or(Tier::kEs);
}

Result<void> Runtime::supports(const PassList& list) const try {
  if (Result<void> checked = checkPasses(list); !checked) return checked;
  for (const Pass& pass : list.passes) {
    if (Result<void> able = impl_->programs.checkSupport(*pass.kernel, pass.pixel); !able)
      return inPass(pass, able.error());
  }
  return {};
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::kOutOfMemory, "no host memory is left for the code of kernels"};
}

Result<void> Runtime::supports(const TransparencySettings& settings,
                               const DrawnFeatures& hair) const {
  const Result<PassList> list = listToDraw(settings, hair, tier());
  if (!list) return list.error();
  return supports(*list);
}

const Statistics& Runtime::statistics() const { return impl_->statistics; }

Result<Runtime> Runtime::create(RuntimeDef def) {
  Result<std::shared_ptr<const Context>> context = readContext(def);
  if (!context) return context.error();
  auto impl = std::make_unique<Impl>(*std::move(context), std::move(def.programCache));
  for (const KernelCodeList list : def.code) impl->programs.addCode(list);
  return Runtime(std::move(impl));
}

const Buffer* Runtime::Impl::find(BufferId id) const {
  const uint32_t tableIndex = ResourceTable::indexOf(id);
  const bool known =
      tableIndex < buffers.size() && buffers[tableIndex].id == id && buffers[tableIndex].name != 0;
  return known ? &buffers[tableIndex] : nullptr;
}

std::string Runtime::Impl::label(BufferId id) const {
  const Buffer* buffer = find(id);
  return buffer != nullptr ? "'" + buffer->label + "'" : "#" + number(id);
}

Result<void> Runtime::Impl::createBuffer(Buffer& buffer, const BufferDesc& desc) {
  const Functions& gl = context->gl;
  GLuint name = 0;
  gl.glGenBuffers(1, &name);
  gl.glBindBuffer(GL_COPY_WRITE_BUFFER, name);
  const GLenum usage = usageHint(desc.usage);
  const bool filled = !desc.initial.empty();
  clearErrors(gl);
  gl.glBufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(desc.size),
                  filled ? desc.initial.data() : nullptr, usage);
  if (const GLenum error = gl.glGetError(); error != GL_NO_ERROR) {
    gl.glDeleteBuffers(1, &name);
    return Error{error == GL_OUT_OF_MEMORY ? ErrorCode::kOutOfMemory : ErrorCode::kDevice,
                 "buffer '" + desc.name + "' of " + std::to_string(desc.size) +
                     " bytes cannot be created on " + context->renderer + ": " + errorName(error)};
  }
  if (!filled) {
    constexpr uint64_t kChunk = 1u << 20;
    zeros.resize(std::max<size_t>(zeros.size(), std::min(desc.size, kChunk)));
    for (uint64_t offset = 0; offset < desc.size; offset += kChunk) {
      gl.glBufferSubData(GL_COPY_WRITE_BUFFER, static_cast<GLintptr>(offset),
                         static_cast<GLsizeiptr>(std::min(kChunk, desc.size - offset)),
                         zeros.data());
    }
  }
  if (context->debug) gl.glObjectLabel(GL_BUFFER, name, -1, desc.name.c_str());
  buffer.name = name;
  buffer.size = desc.size;
  buffer.usage = usage;
  buffer.owned = true;
  statistics.bufferBytes += desc.size;
  return {};
}

void Runtime::Impl::release(Buffer& buffer) {
  if (buffer.owned) {
    context->gl.glDeleteBuffers(1, &buffer.name);
    statistics.bufferBytes -= buffer.size;
  }
  buffer = {};
}

Result<void> Runtime::update(const ResourceTable& resources) try {
  if (Result<void> there = impl_->checkLost("update()"); !there) return there;
  if (impl_->table != 0 && impl_->table != resources.id()) {
    return invalid(
        "update() got another ResourceTable than before; a runtime has the buffers of one: make a "
        "runtime for each scene");
  }
  impl_->table = resources.id();
  std::vector<Buffer>& buffers = impl_->buffers;
  if (buffers.size() < resources.end()) buffers.resize(resources.end());
  for (uint32_t index = 0; index < buffers.size(); ++index) {
    Buffer& buffer = buffers[index];
    // A buffer that the engine registered ahead of its entry is kept.
    if (index >= resources.end()) continue;
    const BufferId id = resources.at(index);
    if (buffer.id != id) impl_->release(buffer);
    const BufferDesc* desc = resources.find(id);
    if (desc == nullptr) continue;
    buffer.id = id;
    buffer.label = desc->name;
    buffer.tableUsage = desc->usage;
    if (buffer.name == 0) {
      if (Result<void> made = impl_->createBuffer(buffer, *desc); !made) return made;
    } else if (!buffer.owned && buffer.size < desc->size) {
      return invalid("the buffer that the engine registered for '" + desc->name + "' has " +
                     std::to_string(buffer.size) + " bytes; it needs " +
                     std::to_string(desc->size));
    }
  }
  return {};
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::kOutOfMemory, "no host memory is left for the table of buffers"};
}

Result<void> Runtime::registerBuffer(BufferId id, uint32_t glName) {
  PELAGE_ASSERT(id != BufferId::kInvalid, "registerBuffer() needs a valid id");
  const Functions& gl = impl_->context->gl;
  if (gl.glIsBuffer(glName) == GL_FALSE)
    return invalid("registerBuffer(): " + std::to_string(glName) + " is not a GL buffer");
  gl.glBindBuffer(GL_COPY_WRITE_BUFFER, glName);
  GLint64 size = 0;
  gl.glGetBufferParameteri64v(GL_COPY_WRITE_BUFFER, GL_BUFFER_SIZE, &size);
  const uint32_t tableIndex = ResourceTable::indexOf(id);
  if (tableIndex >= impl_->buffers.size()) impl_->buffers.resize(size_t{tableIndex} + 1);
  Buffer& buffer = impl_->buffers[tableIndex];
  // Keeps the label and usage that the table gave this id.
  const bool replaces = buffer.id == id;
  std::string label = replaces ? std::move(buffer.label) : "#" + number(id);
  const BufferUsage usage = replaces ? buffer.tableUsage : kAnyUsage;
  impl_->release(buffer);
  buffer.id = id;
  buffer.label = std::move(label);
  buffer.tableUsage = usage;
  buffer.name = glName;
  buffer.size = static_cast<uint64_t>(size);
  return {};
}

void Runtime::registerTexture(TextureId id, const ExternalTexture& texture) {
  PELAGE_ASSERT(id != TextureId::kInvalid, "a texture has an id of newTextureId()");
  impl_->textures.erase(id);
  if (texture.name != 0) impl_->textures.emplace(id, texture);
}

uint32_t Runtime::bufferName(BufferId id) const {
  const Buffer* buffer = impl_->find(id);
  return buffer != nullptr ? buffer->name : 0;
}

std::vector<PipelineTime> Runtime::pipelineTimes() const { return impl_->programs.times(); }

void Runtime::addCode(KernelCodeList code) { impl_->programs.addCode(code); }

Result<const Layout*> Runtime::createLayout(const LayoutTable& table) {
  std::unique_ptr<Layout>& known = impl_->layouts[&table];
  if (known) return known.get();
  Layout layout;
  layout.table = &table;
  const uint32_t allowed = std::min(impl_->context->limits.uniformBindings, kMaxBindings);
  for (const LayoutEntry& entry : table.entries) {
    Layout::Slot slot;
    if (entry.kind == ResourceKind::kStorageBuffer) {
      slot.target = GL_SHADER_STORAGE_BUFFER;
    } else if (entry.kind == ResourceKind::kUniformBuffer) {
      slot.target = GL_UNIFORM_BUFFER;
      slot.binding = entry.glBinding;
    } else if (entry.kind == ResourceKind::kSampledTexture) {
      slot.binding = entry.glBinding;
      if (slot.binding >= kMaxTextures) {
        return Error{ErrorCode::kUnsupported, std::string("layout ") + table.name + ": '" +
                                                  entry.name + "' is texture " +
                                                  std::to_string(slot.binding) +
                                                  " of its group; pelage "
                                                  "binds units below " +
                                                  std::to_string(kMaxTextures)};
      }
    }
    if (slot.target == GL_UNIFORM_BUFFER && entry.glBinding >= allowed) {
      return Error{ErrorCode::kUnsupported,
                   std::string("layout ") + table.name + ": '" + entry.name + "' has GL binding " +
                       std::to_string(entry.glBinding) + "; " + impl_->context->renderer +
                       " and pelage allow " + std::to_string(allowed) + " of its kind"};
    }
    layout.slots.push_back(slot);
  }
  known = std::make_unique<Layout>(std::move(layout));
  return known.get();
}

std::optional<KnownBuffer> Runtime::Impl::known(BufferId id) const {
  const Buffer* buffer = find(id);
  if (buffer == nullptr) return {};
  return KnownBuffer{.name = buffer->label, .size = buffer->size, .usage = buffer->tableUsage};
}

// Everything that can be wrong with a list is found here, so that issuing needs no checks.
Result<void> Runtime::Impl::check(Runtime& runtime, const PassList& list, ListPart part) {
  const Limits& limits = context->limits;
  const DeviceLimits allowed = {
      .groups = {limits.groupCount[0], limits.groupCount[1], limits.groupCount[2]},
      .uniformBytes = limits.uniformBlockBytes,
      .storageBytes = limits.storageBlockBytes,
      .storageAlignment = std::max(limits.storageAlignment, 1u)};
  const auto lookup = [this](BufferId id) { return known(id); };
  if (Result<void> checked = checkList(list, lookup, allowed, part); !checked) return checked;
  if (Result<void> checked = checkTextures(list, part); !checked) return checked;
  return makePrograms(runtime, list, part);
}

Result<void> Runtime::Impl::checkTextures(const PassList& list, ListPart part) const {
  for (const Pass& pass : list.passes) {
    if (part != ListPart::kAll && isDraw(pass.kind) != (part == ListPart::kDraws)) continue;
    for (const PassBinding& binding : list.bindingsOf(pass)) {
      if (binding.texture == TextureId::kInvalid || textures.count(binding.texture) > 0) continue;
      const LayoutEntry& entry = pass.layouts()[binding.set]->entries[binding.entry];
      return invalid("pass " + variantName(pass.pixel != nullptr ? *pass.pixel : *pass.kernel) +
                     ", resource '" + entry.name +
                     "': the runtime does not know the texture: call registerTexture()");
    }
  }
  return {};
}

// Leaves them in passPrograms.
Result<void> Runtime::Impl::makePrograms(Runtime& runtime, const PassList& list, ListPart part) {
  passPrograms.clear();
  const auto isOut = [part](const Pass& pass) {
    return part == (isDraw(pass.kind) ? ListPart::kDispatches : ListPart::kDraws);
  };
  for (const Pass& pass : list.passes) {
    if (isOut(pass)) continue;
    for (const PassBinding& binding : list.bindingsOf(pass)) {
      if (Result<const Layout*> layout = runtime.createLayout(*pass.layouts()[binding.set]);
          !layout)
        return layout.error();
    }
    const std::span<const SpecValue> values = list.specValuesOf(pass);
    if (const GLuint ready = programs.ready(*pass.kernel, pass.pixel, values)) {
      passPrograms.push_back(ready);
      continue;
    }
    // All of the list are begun before the first is waited for.
    for (const Pass& other : list.passes) {
      if (!isOut(other)) programs.begin(*other.kernel, other.pixel, list.specValuesOf(other));
    }
    Result<GLuint> program = programs.find(*pass.kernel, pass.pixel, values);
    if (!program) return inPass(pass, program.error());
    passPrograms.push_back(*program);
  }
  return {};
}

void Runtime::Impl::memoryBarrier(std::span<const Barrier> barriers) {
  if (const uint32_t bits = memoryBarrierBits(barriers)) context->gl.glMemoryBarrier(bits);
}

void Runtime::Impl::uploadConstants(const PassList& list) {
  if (list.constants.empty()) return;
  const Functions& gl = context->gl;
  const uint64_t size = list.constants.size();
  constantBytes = (size + PassList::kConstantAlignment - 1) / PassList::kConstantAlignment *
                  PassList::kConstantAlignment;
  gl.glBindBuffer(GL_UNIFORM_BUFFER, constants);
  // New storage a list: the GPU may still read the last one.
  gl.glBufferData(GL_UNIFORM_BUFFER, static_cast<GLsizeiptr>(constantBytes),
                  size == constantBytes ? list.constants.data() : nullptr, GL_STREAM_DRAW);
  if (size != constantBytes)
    gl.glBufferSubData(GL_UNIFORM_BUFFER, 0, static_cast<GLsizeiptr>(size), list.constants.data());
}

// A sampler's entry has nothing to do: GL has it with its texture.
void Runtime::Impl::bindTexture(const PassBinding& binding, uint32_t unit) const {
  const Functions& gl = context->gl;
  const ExternalTexture& texture = textures.at(binding.texture);
  gl.glActiveTexture(GL_TEXTURE0 + unit);
  gl.glBindTexture(texture.target, texture.name);
  gl.glBindSampler(unit, texture.sampler);
}

void Runtime::Impl::bind(const PassList& list, const Pass& pass) {
  const Functions& gl = context->gl;
  for (const PassBinding& binding : list.bindingsOf(pass)) {
    const Layout& layout = *layouts.find(pass.layouts()[binding.set])->second;
    const Layout::Slot slot = layout.slots[binding.entry];
    const ResourceKind kind = layout.table->entries[binding.entry].kind;
    if (kind == ResourceKind::kSampledTexture) bindTexture(binding, slot.binding);
    if (binding.texture != TextureId::kInvalid) continue;
    const bool uniform = slot.target == GL_UNIFORM_BUFFER;
    const Buffer* stored = uniform ? nullptr : find(binding.buffer);
    PELAGE_ASSERT(uniform || stored != nullptr, "checkList() let an unknown buffer pass");
    Bound wanted{stored != nullptr ? stored->name : constants, binding.offset, binding.size};
    if (uniform) {
      // A driver may round a block's size up to 16 bytes; what follows up to the next block is
      // ours.
      wanted.size = (binding.size + PassList::kConstantAlignment - 1) /
                    PassList::kConstantAlignment * PassList::kConstantAlignment;
      wanted.size = std::min(wanted.size, constantBytes - binding.offset);
    }
    const auto bindAt = [&](uint32_t point) {
      Bound& now = (uniform ? boundUniform : boundStorage)[point];
      if (now == wanted) return;
      now = wanted;
      gl.glBindBufferRange(slot.target, point, wanted.name, static_cast<GLintptr>(wanted.offset),
                           static_cast<GLsizeiptr>(wanted.size));
    };
    if (uniform) {
      bindAt(slot.binding);
      continue;
    }
    // A storage buffer that both stages of a draw use has a number in each.
    for (const KernelVariant* variant : {pass.kernel, pass.pixel}) {
      const VariantBinding* use = variant != nullptr ? useOf(*variant, binding) : nullptr;
      if (use != nullptr) bindAt(use->glBinding);
    }
  }
}

void Runtime::Impl::forgetBindings() {
  // The caller may have bound anything since.
  boundUniform.fill({});
  boundStorage.fill({});
  currentProgram = 0;
}

void Runtime::Impl::use(GLuint program) {
  if (program == currentProgram) return;
  currentProgram = program;
  context->gl.glUseProgram(program);
}

// The vertex array is the runtime's own, and stays as the last draw left it.
void Runtime::Impl::bindVertices(const Pass& pass) {
  const Functions& gl = context->gl;
  const VertexInput* input = pass.kernel->kernel->vertexInput;
  if (vertexInput != input) {
    const size_t before = vertexInput != nullptr ? vertexInput->attributes.size() : 0;
    const size_t now = input != nullptr ? input->attributes.size() : 0;
    for (size_t i = 0; i < now; ++i) {
      const VertexAttribute& attribute = input->attributes[i];
      const auto components = static_cast<GLint>(componentsOf(attribute.format));
      if (isInteger(attribute.format)) {
        gl.glVertexAttribIFormat(attribute.location, components, GL_UNSIGNED_INT, attribute.offset);
      } else {
        gl.glVertexAttribFormat(attribute.location, components, GL_FLOAT, GL_FALSE,
                                attribute.offset);
      }
      gl.glVertexAttribBinding(attribute.location, 0);
      if (i >= before) gl.glEnableVertexAttribArray(attribute.location);
    }
    for (size_t i = now; i < before; ++i)
      gl.glDisableVertexAttribArray(vertexInput->attributes[i].location);
    vertexInput = input;
  }
  if (input == nullptr) return;
  gl.glVertexBindingDivisor(0, input->perInstance ? 1 : 0);
  gl.glBindVertexBuffer(0, find(pass.vertices.buffer)->name,
                        static_cast<GLintptr>(pass.vertices.offset),
                        static_cast<GLsizei>(input->stride));
}

Result<void> Runtime::Impl::checkLost(const char* call) {
  const Functions& gl = context->gl;
  if (lost == GL_NO_ERROR && gl.glGetGraphicsResetStatus != nullptr)
    lost = gl.glGetGraphicsResetStatus();
  if (lost == GL_NO_ERROR) return {};
  const char* why = lost == GL_GUILTY_CONTEXT_RESET     ? "GL_GUILTY_CONTEXT_RESET"
                    : lost == GL_INNOCENT_CONTEXT_RESET ? "GL_INNOCENT_CONTEXT_RESET"
                                                        : "GL_UNKNOWN_CONTEXT_RESET";
  return Error{ErrorCode::kDeviceLost,
               std::string(call) + ": the context on " + context->renderer + " is lost (" + why +
                   "); destroy the runtime, make another context and runtime, and call "
                   "Scene::recover()"};
}

Result<void> Runtime::Impl::finish(const char* call) {
  if (!context->debug) return {};
  const GLenum error = context->gl.glGetError();
  if (error == GL_NO_ERROR) return {};
  clearErrors(context->gl);
  return Error{ErrorCode::kDevice, std::string(call) + ": " + context->renderer + " reports " +
                                       errorName(error) + "; its debug output says more"};
}

Result<void> Runtime::prepare(const PassList& list) {
  // Its buffers need not exist yet.
  if (Result<void> checked = checkPasses(list); !checked) return checked;
  return impl_->makePrograms(*this, list, ListPart::kAll);
}

Result<void> Runtime::record(const PassList& list, PassTimer* timer) {
  if (Result<void> there = impl_->checkLost("record()"); !there) return there;
  if (Result<void> checked = checkTable(list, impl_->table); !checked) return checked;
  if (Result<void> checked = impl_->check(*this, list, ListPart::kDispatches); !checked)
    return checked;
  if (Result<void> ready = checkRun(list, impl_->executor); !ready) return ready;
  const Functions& gl = impl_->context->gl;
  if (impl_->context->debug) clearErrors(gl);
  // Nothing fails from here on that would leave it out.
  setDelivered(list.run, impl_->executor);
  impl_->forgetBindings();

  impl_->memoryBarrier(list.uploadBarriers);
  for (const Upload& upload : list.uploads) {
    const Buffer& buffer = *impl_->find(upload.buffer);
    const std::byte* data = list.uploadData.data() + upload.dataOffset;
    gl.glBindBuffer(GL_COPY_WRITE_BUFFER, buffer.name);
    if (buffer.owned && upload.size == buffer.size) {
      // All of it: new storage, so that nobody waits for the GPU to be done with the old one.
      gl.glBufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(upload.size), data,
                      buffer.usage);
    } else {
      gl.glBufferSubData(GL_COPY_WRITE_BUFFER, static_cast<GLintptr>(upload.offset),
                         static_cast<GLsizeiptr>(upload.size), data);
    }
  }
  const bool any = std::any_of(list.passes.begin(), list.passes.end(),
                               [](const Pass& pass) { return !isDraw(pass.kind); });
  if (!any) return impl_->finish("record()");
  impl_->uploadConstants(list);

  size_t index = 0, level = 0;  // the next pass, and the first one of its level
  size_t mark = timer != nullptr ? timer->impl_->mark() : 0;
  for (const Pass& pass : list.passes) {
    if (isDraw(pass.kind)) continue;
    if (impl_->context->debug) gl.glPushDebugGroup(GL_DEBUG_SOURCE_APPLICATION, 0, -1, pass.name);
    impl_->memoryBarrier(list.barriersOf(pass));
    impl_->use(impl_->passPrograms[index++]);
    impl_->bind(list, pass);
    if (pass.kind == PassKind::kDispatch) {
      gl.glDispatchCompute(pass.groups[0], pass.groups[1], pass.groups[2]);
    } else {
      gl.glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, impl_->find(pass.indirect)->name);
      gl.glDispatchComputeIndirect(static_cast<GLintptr>(pass.indirectOffset));
    }
    if (impl_->context->debug) gl.glPopDebugGroup();
    if (timer == nullptr || !isLastOfLevel(list, index - 1)) continue;
    mark = timer->impl_->close(std::span(list.passes).subspan(level, index - level), mark);
    level = index;
  }
  return impl_->finish("record()");
}

void Runtime::Impl::setDrawDefaults(const DrawTarget& target) {
  const Functions& gl = context->gl;
  if (context->profile == Profile::kCore) {
    gl.glViewportIndexedf(0, static_cast<GLfloat>(target.x), static_cast<GLfloat>(target.y),
                          static_cast<GLfloat>(target.width), static_cast<GLfloat>(target.height));
    gl.glDepthRangeIndexed(0, 0, 1);
    gl.glDisablei(GL_SCISSOR_TEST, 0);
    gl.glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    gl.glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    gl.glDisable(GL_PRIMITIVE_RESTART);
  } else {
    gl.glViewport(static_cast<GLint>(target.x), static_cast<GLint>(target.y),
                  static_cast<GLsizei>(target.width), static_cast<GLsizei>(target.height));
    gl.glDepthRangef(0, 1);
    gl.glDisable(GL_SCISSOR_TEST);
  }
  for (const GLenum capability : kDisabledInDraws) gl.glDisable(capability);
  // Kernels have one color, and what they would leave in further attachments is undefined.
  for (GLuint i = 1; i < context->drawBuffers; ++i)
    gl.glColorMaski(i, GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  gl.glBlendEquation(GL_FUNC_ADD);
  gl.glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);  // premultiplied alpha
}

void Runtime::Impl::setDrawState(const DrawState& state) {
  const Functions& gl = context->gl;
  // GL writes no depth where it does not test it.
  if (state.depthCompare == DepthCompare::kAlways && !state.depthWrite) {
    gl.glDisable(GL_DEPTH_TEST);
  } else {
    gl.glEnable(GL_DEPTH_TEST);
  }
  gl.glDepthFunc(depthFunction(state.depthCompare));
  gl.glDepthMask(state.depthWrite ? GL_TRUE : GL_FALSE);
  const GLboolean color = state.colorWrite ? GL_TRUE : GL_FALSE;
  gl.glColorMaski(0, color, color, color, color);
  if (state.blend == BlendMode::kPremultipliedAlpha) {
    gl.glEnable(GL_BLEND);
  } else {
    gl.glDisable(GL_BLEND);
  }
}

Result<void> Runtime::record(Frame& frame, std::span<const ViewTarget> targets) {
  if (targets.size() != frame.viewCount()) {
    return invalid("the frame has " + std::to_string(frame.viewCount()) + " views, but there are " +
                   std::to_string(targets.size()) + " targets");
  }
  if (Result<void> done = frame.finish(); !done) return done;
  impl_->areas.clear();
  for (const ViewTarget& target : targets) impl_->areas.push_back(areaOf(target.area));
  if (Result<void> fits = frame.checkAreas(impl_->areas); !fits) return fits;
  FrameExecutor executor;
  executor.update = [&](const ResourceTable& resources) { return update(resources); };
  executor.record = [&](const FrameStep& step) { return record(*step.list); };
  executor.draw = [&](const FrameStep& step) {
    const ViewTarget& target = targets[step.view];
    if (target.begin) target.begin(step);
    return recordDraws(*step.list, target.area);
  };
  return frame.run(executor);
}

Result<void> Runtime::recordDraws(const PassList& list, const DrawTarget& target,
                                  PassTimer* timer) {
  if (Result<void> there = impl_->checkLost("recordDraws()"); !there) return there;
  if (target.width == 0 || target.height == 0)
    return invalid("recordDraws(): the target has no pixels");
  if (Result<void> checked = checkArea(list, areaOf(target)); !checked) return checked;
  if (Result<void> checked = impl_->check(*this, list, ListPart::kDraws); !checked) return checked;
  if (impl_->passPrograms.empty()) return {};
  if (Result<void> ready = checkDraws(list); !ready) return ready;
  const Functions& gl = impl_->context->gl;
  if (impl_->context->debug) clearErrors(gl);
  impl_->forgetBindings();

  impl_->memoryBarrier(list.drawBarriers);
  impl_->uploadConstants(list);
  gl.glBindVertexArray(impl_->vertexArray);
  impl_->setDrawDefaults(target);

  size_t index = 0;
  size_t mark = timer != nullptr ? timer->impl_->mark() : 0;
  const DrawState* state = nullptr;
  for (const Pass& pass : list.passes) {
    if (!isDraw(pass.kind)) continue;
    if (impl_->context->debug) gl.glPushDebugGroup(GL_DEBUG_SOURCE_APPLICATION, 0, -1, pass.name);
    impl_->use(impl_->passPrograms[index++]);
    impl_->bind(list, pass);
    impl_->bindVertices(pass);
    if (state == nullptr || *state != pass.state) impl_->setDrawState(pass.state);
    state = &pass.state;
    const GLenum mode = topologyMode(pass.state.topology);
    const auto elements = static_cast<GLsizei>(pass.elementCount);
    const auto instances = static_cast<GLsizei>(pass.instanceCount);
    if (pass.kind == PassKind::kDrawIndirect) {
      gl.glBindBuffer(GL_DRAW_INDIRECT_BUFFER, impl_->find(pass.indirect)->name);
      // NOLINTNEXTLINE(performance-no-int-to-ptr): GL takes the offset as a pointer
      gl.glDrawArraysIndirect(mode, reinterpret_cast<const void*>(pass.indirectOffset));
    } else if (pass.indices != BufferId::kInvalid) {
      gl.glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, impl_->find(pass.indices)->name);
      gl.glDrawElementsInstanced(mode, elements, GL_UNSIGNED_INT, nullptr, instances);
    } else {
      gl.glDrawArraysInstanced(mode, 0, elements, instances);
    }
    if (impl_->context->debug) gl.glPopDebugGroup();
    if (timer != nullptr) mark = timer->impl_->close({&pass, 1}, mark);
  }
  return impl_->finish("recordDraws()");
}

Result<std::vector<std::byte>> Runtime::read(BufferId id, uint64_t offset, uint64_t size) try {
  if (Result<void> there = impl_->checkLost("read()"); !there) return there.error();
  const Functions& gl = impl_->context->gl;
  const Buffer* buffer = impl_->find(id);
  if (buffer == nullptr)
    return invalid("read(): there is no buffer " + number(id) + "; update() creates it");
  if (size == 0 && offset < buffer->size) size = buffer->size - offset;
  if (size == 0 || !fits(offset, size, buffer->size)) {
    return invalid("read(): " + std::to_string(size) + " bytes at " + std::to_string(offset) +
                   " are not inside buffer " + impl_->label(id) + " of " +
                   std::to_string(buffer->size) + " bytes");
  }
  std::vector<std::byte> bytes(static_cast<size_t>(size));
  // Through a copy: mapping the buffer itself would make some drivers move it to host memory for
  // good.
  GLuint staging = 0;
  gl.glGenBuffers(1, &staging);
  gl.glBindBuffer(GL_COPY_WRITE_BUFFER, staging);
  gl.glBindBuffer(GL_COPY_READ_BUFFER, buffer->name);
  clearErrors(gl);
  gl.glBufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(size), nullptr, GL_STREAM_READ);
  gl.glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  gl.glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, static_cast<GLintptr>(offset),
                         0, static_cast<GLsizeiptr>(size));
  const void* mapped =
      gl.glMapBufferRange(GL_COPY_WRITE_BUFFER, 0, static_cast<GLsizeiptr>(size), GL_MAP_READ_BIT);
  bool complete = mapped != nullptr;
  if (complete) {
    std::memcpy(bytes.data(), mapped, bytes.size());
    complete = gl.glUnmapBuffer(GL_COPY_WRITE_BUFFER) == GL_TRUE;
  }
  const GLenum error = gl.glGetError();
  gl.glDeleteBuffers(1, &staging);
  if (!complete || error != GL_NO_ERROR) {
    clearErrors(gl);
    return Error{error == GL_OUT_OF_MEMORY ? ErrorCode::kOutOfMemory : ErrorCode::kDevice,
                 "read(): " + std::to_string(size) + " bytes of buffer " + impl_->label(id) +
                     " could not be copied to the host: " + errorName(error)};
  }
  return bytes;
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::kOutOfMemory,
               "read(): no host memory for buffer " + number(id) + " is left"};
}

}  // namespace pelage::gl
