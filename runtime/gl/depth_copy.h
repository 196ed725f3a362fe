// Copies a depth texture to a storage buffer, for the headless device.
#pragma once

#include "functions.h"
#include "pelage/gl.h"
#include "pelage/headless.h"
#include "pelage/result.h"

namespace pelage::gl {

/// A compute shader does it on both APIs: OpenGL ES cannot read depth back.
class DepthCopy {
 public:
  DepthCopy() = default;
  DepthCopy(const DepthCopy&) = delete;
  DepthCopy& operator=(const DepthCopy&) = delete;
  /// Before the context goes.
  void release(const Functions& gl);

  /// Writes the area's width * height floats to the front of the buffer, the row of the lowest
  /// index first. Changes the program, storage binding 0 and texture unit 0.
  Result<void> run(const Functions& gl, Profile profile, GLuint texture, const PixelArea& area,
                   GLuint buffer);

 private:
  Result<void> makeProgram(const Functions& gl, Profile profile);
  GLuint program_ = 0;
};

}  // namespace pelage::gl
