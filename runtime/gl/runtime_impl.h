#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "context.h"
#include "program.h"

namespace pelage::gl {

/// Capabilities that a draw needs off, on both APIs; StateGuard saves them.
inline constexpr GLenum kDisabledInDraws[] = {
    GL_CULL_FACE,           GL_STENCIL_TEST,
    GL_POLYGON_OFFSET_FILL, GL_RASTERIZER_DISCARD,
    GL_SAMPLE_COVERAGE,     GL_SAMPLE_ALPHA_TO_COVERAGE,
    GL_SAMPLE_MASK,         GL_PRIMITIVE_RESTART_FIXED_INDEX,
};

/// Usage of a buffer that the engine registered before the table had it.
inline constexpr BufferUsage kAnyUsage = BufferUsage::kStorage | BufferUsage::kIndex |
                                         BufferUsage::kIndirect | BufferUsage::kUpload |
                                         BufferUsage::kReadback | BufferUsage::kVertex;

struct Buffer {
  BufferId id = BufferId::kInvalid;
  GLuint name = 0;
  uint64_t size = 0;
  GLenum usage = GL_DYNAMIC_DRAW;
  BufferUsage tableUsage = kAnyUsage;
  bool owned = false;
  std::string label;
};

struct Runtime::Impl {
  struct Bound {
    GLuint name = 0;
    uint64_t offset = 0, size = 0;
    bool operator==(const Bound&) const = default;
  };

  std::shared_ptr<const Context> context;
  Statistics statistics;
  ProgramStore programs;
  std::vector<Buffer> buffers;  // [BufferId]
  const ExecutorId executor = newExecutorId();
  uint64_t table = 0;  // ResourceTable::id(); 0: none was seen yet
  std::unordered_map<TextureId, ExternalTexture> textures;
  std::unordered_map<const LayoutTable*, std::unique_ptr<Layout>> layouts;
  GLuint constants = 0;
  uint64_t constantBytes = 0;
  GLuint vertexArray = 0;
  const VertexInput* vertexInput = nullptr;  // that the vertex array is set up for
  std::vector<std::byte> zeros;
  std::vector<PixelArea> areas;      // of the targets of a frame
  std::vector<GLuint> passPrograms;  // of the passes that check() went through
  std::array<Bound, kMaxBindings> boundUniform, boundStorage;
  GLuint currentProgram = 0;

  Impl(std::shared_ptr<const Context> glContext, ProgramCache cache);
  ~Impl();

  const Buffer* find(BufferId id) const;
  std::string label(BufferId id) const;
  Result<void> createBuffer(Buffer& buffer, const BufferDesc& desc);
  void release(Buffer& buffer);

  std::optional<KnownBuffer> known(BufferId id) const;
  Result<void> check(Runtime& runtime, const PassList& list, ListPart part);
  Result<void> checkTextures(const PassList& list, ListPart part) const;
  Result<void> makePrograms(Runtime& runtime, const PassList& list, ListPart part);

  void memoryBarrier(std::span<const Barrier> barriers);
  void uploadConstants(const PassList& list);
  void forgetBindings();
  void use(GLuint program);
  void bind(const PassList& list, const Pass& pass);
  void bindTexture(const PassBinding& binding, uint32_t unit) const;
  void bindVertices(const Pass& pass);
  void setDrawDefaults(const DrawTarget& target);
  void setDrawState(const DrawState& state);
  Result<void> finish(const char* call);
  /// Error kDeviceLost where the context was reset, now or earlier.
  Result<void> checkLost(const char* call);
  GLenum lost = GL_NO_ERROR;  // as GL said once
};

struct PassTimer::Impl {
  struct Entry {
    const char* name;
    size_t begin, end;  // indices into queries
    size_t passes;      // that run between them, this one among them
  };
  std::shared_ptr<const Context> context;
  std::vector<GLuint> queries;
  size_t used = 0;
  std::vector<Entry> entries;

  explicit Impl(std::shared_ptr<const Context> glContext) : context(std::move(glContext)) {}
  ~Impl();
  /// Notes the GPU's time when it gets here; returns the query's index.
  size_t mark();
  /// Ends passes that began at a mark; returns the mark where the next ones begin.
  size_t close(std::span<const Pass> passes, size_t begin);
};

}  // namespace pelage::gl
