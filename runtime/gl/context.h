// Facts about the context, for every part of the GL runtime.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "functions.h"
#include "pelage/gl.h"
#include "pelage/list_check.h"

namespace pelage::gl {

/// Draw buffers of a framebuffer that any driver has today.
inline constexpr uint32_t kMostDrawBuffers = 16;

struct Context {
  Functions gl;
  Profile profile = Profile::kCore;
  Limits limits;
  std::string renderer;  ///< for messages
  std::string identity;  ///< every string that tells one driver from another
  std::vector<GLint> binaryFormats;
  uint32_t drawBuffers = 1;    ///< of a framebuffer, at most kMostDrawBuffers
  bool disjointTimer = false;  ///< the clock may jump, and the context says when it did
  bool debug = false;
};

/// Loads the functions of the current context, and reads what it offers. Errors: no context; a
/// version, function or limit that pelage needs is missing.
Result<std::shared_ptr<const Context>> readContext(const RuntimeDef& def);

/// "GL_INVALID_OPERATION".
std::string errorName(GLenum error);

/// Clears the error flag.
void clearErrors(const Functions& gl);

}  // namespace pelage::gl
