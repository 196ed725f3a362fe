#include "functions.h"

namespace pelage::gl {
namespace {

template <class Function>
bool load(Function& function, const GetProcAddress& getProcAddress, const std::string& name) {
  function = reinterpret_cast<Function>(getProcAddress(name.c_str()));
  return function != nullptr;
}

}  // namespace

#define PELAGE_GL_LOAD(type, name)                                 \
  if (!load(gl.name, getProcAddress, std::string(#name) + suffix)) \
    return std::string(#name) + suffix;

std::string loadCommonFunctions(Functions& gl, const GetProcAddress& getProcAddress) {
  const char* const suffix = "";
  PELAGE_GL_COMMON_FUNCTIONS(PELAGE_GL_LOAD)
  return {};
}

std::string loadCoreFunctions(Functions& gl, const GetProcAddress& getProcAddress) {
  const char* const suffix = "";
  PELAGE_GL_CORE_FUNCTIONS(PELAGE_GL_LOAD)
  return {};
}

std::string loadTimerFunctions(Functions& gl, const GetProcAddress& getProcAddress,
                               const char* suffix) {
  PELAGE_GL_TIMER_FUNCTIONS(PELAGE_GL_LOAD)
  return {};
}

std::string loadParallelFunctions(Functions& gl, const GetProcAddress& getProcAddress,
                                  const char* suffix) {
  PELAGE_GL_PARALLEL_FUNCTIONS(PELAGE_GL_LOAD)
  return {};
}

std::string loadRobustFunctions(Functions& gl, const GetProcAddress& getProcAddress,
                                const char* suffix) {
  PELAGE_GL_ROBUST_FUNCTIONS(PELAGE_GL_LOAD)
  return {};
}

#undef PELAGE_GL_LOAD

}  // namespace pelage::gl
