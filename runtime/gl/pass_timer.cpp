#include <utility>

#include "runtime_impl.h"

namespace pelage::gl {

PassTimer::Impl::~Impl() {
  if (!queries.empty())
    context->gl.glDeleteQueries(static_cast<GLsizei>(queries.size()), queries.data());
}

size_t PassTimer::Impl::mark() {
  if (!context->limits.timestamps) return 0;
  const Functions& gl = context->gl;
  if (used == 0 && context->disjointTimer) {
    GLint jumped = 0;
    gl.glGetIntegerv(kGpuDisjoint, &jumped);  // reading it clears what happened before
  }
  if (used == queries.size()) {
    GLuint query = 0;
    gl.glGenQueries(1, &query);
    queries.push_back(query);
  }
  gl.glQueryCounter(queries[used], GL_TIMESTAMP);
  return used++;
}

size_t PassTimer::Impl::close(std::span<const Pass> passes, size_t begin) {
  const size_t end = mark();
  for (const Pass& pass : passes) entries.push_back({pass.name, begin, end, passes.size()});
  return end;
}

PassTimer::PassTimer(const Runtime& runtime)
    : impl_(std::make_unique<Impl>(runtime.impl_->context)) {}
PassTimer::PassTimer(PassTimer&&) noexcept = default;
PassTimer& PassTimer::operator=(PassTimer&&) noexcept = default;
PassTimer::~PassTimer() = default;

bool PassTimer::ready() const {
  if (impl_->used == 0) return true;
  GLuint available = GL_FALSE;
  impl_->context->gl.glGetQueryObjectuiv(impl_->queries[impl_->used - 1], GL_QUERY_RESULT_AVAILABLE,
                                         &available);
  return available != GL_FALSE;
}

std::vector<PassTiming> PassTimer::read() {
  const Functions& gl = impl_->context->gl;
  std::vector<GLuint64> nanoseconds(impl_->used);
  for (size_t i = 0; i < impl_->used; ++i)
    gl.glGetQueryObjectui64v(impl_->queries[i], GL_QUERY_RESULT, &nanoseconds[i]);
  GLint jumped = 0;
  if (impl_->context->disjointTimer) gl.glGetIntegerv(kGpuDisjoint, &jumped);

  std::vector<PassTiming> timings;
  timings.reserve(impl_->entries.size());
  for (const Impl::Entry& entry : impl_->entries) {
    double milliseconds = -1;
    if (impl_->context->limits.timestamps && jumped == 0 &&
        nanoseconds[entry.end] >= nanoseconds[entry.begin])
      milliseconds = static_cast<double>(nanoseconds[entry.end] - nanoseconds[entry.begin]) * 1e-6 /
                     static_cast<double>(entry.passes);
    timings.push_back({entry.name, milliseconds});
  }
  impl_->entries.clear();
  impl_->used = 0;
  return timings;
}

}  // namespace pelage::gl
