// The rotation in a matrix, and the bone that stands for a matrix without one. Matrices are given
// by their rows.
#ifndef PELAGE_SKINNING_POLAR_ROTATION_HLSLI
#define PELAGE_SKINNING_POLAR_ROTATION_HLSLI

#include "../base/quaternion.hlsli"

float determinant3(float3 a, float3 b, float3 c) {
  precise float r = dot3(a, cross3(b, c));
  return r;
}

// Returns the rotation of a matrix with rows a, b, c that is a rotation up to rounding (Shepperd
// 1978: the largest component first, so nothing small is divided by).
float4 quaternionOfRotation(float3 a, float3 b, float3 c) {
  precise float xx = 1.0 + a.x - b.y - c.z;
  precise float yy = 1.0 - a.x + b.y - c.z;
  precise float zz = 1.0 - a.x - b.y + c.z;
  precise float ww = 1.0 + a.x + b.y + c.z;
  precise float4 q;
  if (ww >= xx && ww >= yy && ww >= zz) {
    q = float4(c.y - b.z, a.z - c.x, b.x - a.y, ww);
  } else if (xx >= yy && xx >= zz) {
    q = float4(xx, a.y + b.x, a.z + c.x, c.y - b.z);
  } else if (yy >= zz) {
    q = float4(a.y + b.x, yy, b.z + c.y, a.z - c.x);
  } else {
    q = float4(a.z + c.x, b.z + c.y, zz, b.x - a.y);
  }
  return normalizeQuaternion(q);
}

// Returns the rotation R of the polar decomposition M = R S, as a quaternion. A mirrored matrix
// (det < 0) is first mirrored back along the bind space's x axis. Returns the fallback if M has
// (nearly) no volume: |det| below 1e-6 of that of a uniform scale with the same sum of squares.
//
// Newton's iteration X <- (g X + X^-T / g) / 2 with Frobenius scaling g^2 = |X^-1| / |X| (Higham,
// "Computing the polar decomposition - with applications", SIAM J. Sci. Stat. Comput. 7, 1986,
// equation 3.1 and section 4). Four steps: the blend of bones 90 degrees apart is within 0.04
// degrees, a single bone with scales of 1:10 within float rounding.
float4 rotationOfMatrix(float3 a, float3 b, float3 c, float4 fallback) {
  precise float det = determinant3(a, b, c);
  if (det < 0.0) {
    a.x = -a.x;
    b.x = -b.x;
    c.x = -c.x;
  }
  precise float squares = (dot3(a, a) + dot3(b, b) + dot3(c, c)) * (1.0 / 3.0);
  float size = squareRoot(squares);
  if (!(size > 1e-10) || !(size < 1e12)) return fallback;
  precise float inverseSize = 1.0 / size;
  precise float3 ra = a * inverseSize;
  precise float3 rb = b * inverseSize;
  precise float3 rc = c * inverseSize;
  precise float volume = determinant3(ra, rb, rc);
  if (!(volume > 1e-6)) return fallback;
  for (uint i = 0; i < 4; ++i) {
    precise float d = determinant3(ra, rb, rc);
    precise float inverse = 1.0 / max(d, 1e-12);
    // Rows of X^-T: the cofactors over the determinant.
    precise float3 ia = cross3(rb, rc) * inverse;
    precise float3 ib = cross3(rc, ra) * inverse;
    precise float3 ic = cross3(ra, rb) * inverse;
    precise float own = dot3(ra, ra) + dot3(rb, rb) + dot3(rc, rc);
    precise float other = dot3(ia, ia) + dot3(ib, ib) + dot3(ic, ic);
    precise float ratio = other / own;
    float g = squareRoot(squareRoot(ratio));
    precise float ownShare = 0.5 * g;
    precise float otherShare = 0.5 / g;
    ra = ra * ownShare + ia * otherShare;
    rb = rb * ownShare + ib * otherShare;
    rc = rc * ownShare + ic * otherShare;
  }
  return quaternionOfRotation(ra, rb, rc);
}

// Marks a bone that skinning does not use: numbers above 1e18 count as not usable
// (base/quaternion.hlsli), and roots and vertices of the bone stay where they were. Drivers may
// assume that there is no NaN.
static const float kUnusable = 1e30;
float4 unusableRow() { return float4(kUnusable, kUnusable, kUnusable, kUnusable); }

#endif
