// Contact of a vertex with a tapered capsule.
#pragma once

#include "rod_settings.h"

namespace pelage::reference {

/// A collider in the solver's precision and at the solver's sub-step.
template <class Real>
struct ContactShape {
  Vector3<Real> head, tail, headBefore, tailBefore;
  Real headRadius = 0, tailRadius = 0, friction = 0;

  /// The part begin..end (0..1) of the collider's motion.
  ContactShape(const RodCollider& c, Real begin, Real end)
      : head(between(c.headBefore, c.head, end)),
        tail(between(c.tailBefore, c.tail, end)),
        headBefore(between(c.headBefore, c.head, begin)),
        tailBefore(between(c.tailBefore, c.tail, begin)),
        headRadius(static_cast<Real>(c.headRadius)),
        tailRadius(static_cast<Real>(c.tailRadius)),
        friction(static_cast<Real>(c.friction)) {}

 private:
  static Vector3<Real> between(const Vector3d& from, const Vector3d& to, Real share) {
    const Vector3<Real> a(from), b(to);
    return a + (b - a) * share;
  }
};

template <class Real>
struct Contact {
  Vector3<Real> normal;         ///< unit, out of the collider
  Real penetration = 0;         ///< [m]; negative outside
  Vector3<Real> surfaceMotion;  ///< of the collider at the contact, in this step [m]
};

/// Distance to the union of the spheres between two ends: the minimum over t of
/// |p - c(t)| - r(t). With z along the axis and d from it, the derivative vanishes where
/// z - t L = d k / sqrt(1 - k^2), k = (r0 - r1) / L. For k outside -1..1 one end holds the other.
template <class Real>
Contact<Real> findContact(const ContactShape<Real>& shape, const Vector3<Real>& p) {
  const Vector3<Real> axis = shape.tail - shape.head;
  const Vector3<Real> arm = p - shape.head;
  const Real squared = dot(axis, axis);
  const Real taper = shape.headRadius - shape.tailRadius;
  Real t = taper >= Real(0) ? Real(0) : Real(1);
  if (squared > taper * taper && squared > Real(1e-16)) {
    const Real along = dot(arm, axis) / squared;
    const Vector3<Real> off = arm - axis * along;
    const Real shift = squareRoot(dot(off, off)) * taper /
                       squareRoot(squared * std::max(squared - taper * taper, Real(1e-16)));
    t = std::min(std::max(along - shift, Real(0)), Real(1));
  }
  const Vector3<Real> center = shape.head + axis * t;
  const Vector3<Real> out = p - center;
  const Real distance = squareRoot(std::max(dot(out, out), Real(1e-20)));
  Contact<Real> contact;
  contact.normal = out * (Real(1) / distance);
  contact.penetration = shape.headRadius - taper * t - distance;
  const Vector3<Real> before = shape.headBefore + (shape.tailBefore - shape.headBefore) * t;
  contact.surfaceMotion = center - before;
  return contact;
}

}  // namespace pelage::reference
