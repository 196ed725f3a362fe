// The implicit head that the groom grows on.
#pragma once

#include "base/vector3.h"

namespace pelage::detail {

using Vector = Vector3<double>;

/// Signed distance [m], negative inside; exact at the surface, approximate elsewhere.
double headSurface(const Vector& p);

/// Unit vector along which headSurface() grows.
Vector headNormal(const Vector& p);

/// The same without the ears.
Vector skullNormal(const Vector& p);

/// The head with its ears smoothed over: what falling hair glides on.
double combedSurface(const Vector& p);
Vector combedNormal(const Vector& p);

/// Whether hair grows at a point of the surface. `hairline` [m] moves the edge up.
bool isScalp(const Vector& p, double hairline);

/// How far inside the hairline around the face such a point is [m]; far inside behind the ears.
double insideHairline(const Vector& p, double hairline);

/// Share of the head bone in what moves a point, 0..1; the rest is the neck's.
double headBoneShare(const Vector& p);

}  // namespace pelage::detail
