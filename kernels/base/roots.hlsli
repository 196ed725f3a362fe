// Square roots with the same bits on every API and device that multiplies and adds according to
// IEEE 754.
//
// Drivers differ in the built-in sqrt(): on NVIDIA 580 its last bit differs between Vulkan and
// OpenGL for 4 of 10 arguments, while sums, products and quotients agree. So the root is computed
// from products alone: a first guess from the bits of x (within 3.5 %; Lomont, "Fast inverse square
// root", Purdue University, 2003), then Newton's y <- y + y (1 - x y^2) / 2. It takes four steps:
// the third reaches rounding, and the fourth makes the root of 1 exactly 1, which unit vectors that
// must not change need.
#ifndef PELAGE_BASE_ROOTS_HLSLI
#define PELAGE_BASE_ROOTS_HLSLI

// 1 / sqrt(x) within 1e-7 of its size, for x in 1e-30..1e38. Not for 0, infinity and NaN.
float inverseRoot(float x) {
  precise float y = asfloat(0x5f375a86u - (asuint(x) >> 1));
  // Unrolled: a loop, or a branch, would keep compilers from interleaving independent roots.
  precise float missing = 1.0 - (x * y) * y;
  y = y + (y * 0.5) * missing;
  missing = 1.0 - (x * y) * y;
  y = y + (y * 0.5) * missing;
  missing = 1.0 - (x * y) * y;
  y = y + (y * 0.5) * missing;
  missing = 1.0 - (x * y) * y;
  y = y + (y * 0.5) * missing;
  return y;
}

// sqrt(x) within 1e-7 of its size. 0 for x below 1e-30; infinity and NaN for themselves.
float squareRoot(float x) {
  if (asuint(x) >= 0x7f800000u && asuint(x) < 0x80000000u) return x;
  if (!(x >= 1e-30)) return 0.0;
  precise float y = inverseRoot(x);
  precise float root = x * y;
  precise float r = root + (y * 0.5) * (x - root * root);
  return r;
}

#endif
