// Contact of a vertex with spheres, tapered capsules and half-spaces: what kernels/contact and
// kernels/common/colliders.hlsli find, and the record of it that the solver takes.
#pragma once

#include <array>
#include <vector>

#include "rod_settings.h"

namespace pelage::reference {

/// A collider in the solver's precision and at the solver's sub-step.
template <class Real>
struct ContactShape {
  Vector3<Real> head, tail, headBefore, tailBefore;
  Real headRadius = 0, tailRadius = 0, friction = 0;
  Vector3<Real> spin;    ///< in the sub-step [rad]
  Vector3<Real> normal;  ///< of a half-space; otherwise 0

  /// The part begin..end (0..1) of the collider's motion.
  ContactShape(const RodCollider& c, Real begin, Real end)
      : head(between(c.headBefore, c.head, end)),
        tail(between(c.tailBefore, c.tail, end)),
        headBefore(between(c.headBefore, c.head, begin)),
        tailBefore(between(c.tailBefore, c.tail, begin)),
        headRadius(static_cast<Real>(c.headRadius)),
        tailRadius(static_cast<Real>(c.tailRadius)),
        friction(static_cast<Real>(c.friction)),
        spin(Vector3<Real>(c.spin) * (end - begin)),
        normal(c.normal) {}

  bool isPlane() const { return dot(normal, normal) > Real(0); }

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
  if (shape.isPlane())
    return {shape.normal, -dot(shape.normal, p - shape.head), shape.head - shape.headBefore};
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
  const Real radius = shape.headRadius - taper * t;
  Contact<Real> contact;
  contact.normal = out * (Real(1) / distance);
  contact.penetration = radius - distance;
  const Vector3<Real> before = shape.headBefore + (shape.tailBefore - shape.headBefore) * t;
  contact.surfaceMotion = center - before + cross(shape.spin, contact.normal * radius);
  return contact;
}

/// As findContact() for a point that goes from `from` to `to`. A point that meets the surface in
/// between, on a path of more than a quarter of the smaller radius, gets the plane in which it
/// does.
template <class Real>
Contact<Real> sweepContact(const ContactShape<Real>& shape, const Vector3<Real>& from,
                           const Vector3<Real>& to) {
  constexpr Real kSweepFrom = Real(0.25), kSweepTouch = Real(1e-5);
  constexpr int kSweepSteps = 16;
  const Contact<Real> last = findContact(shape, to);
  if (shape.isPlane()) return last;
  // Relative to the surface, which is where it is in the end.
  const Vector3<Real> start = from + last.surfaceMotion, path = to - start;
  const Real size = length(path);
  if (!(size > kSweepFrom * std::min(shape.headRadius, shape.tailRadius))) return last;
  Contact<Real> contact = findContact(shape, start);
  if (!(contact.penetration < Real(0))) return last;
  const Vector3<Real> direction = path * (Real(1) / std::max(size, Real(1e-20)));
  Real s = 0;
  for (int i = 0; i < kSweepSteps; ++i) {
    if (contact.penetration > -kSweepTouch) {
      contact.penetration -= dot(contact.normal, to - (start + direction * s));
      contact.surfaceMotion = last.surfaceMotion;
      return contact;
    }
    s -= contact.penetration;
    if (!(s < size)) return last;
    contact = findContact(shape, start + direction * s);
  }
  return last;
}

/// A plane that a vertex stays in front of, and the force that keeps it there.
template <class Real>
struct ContactRecord {
  enum class Friction { kUnknown, kSticks, kSlides };

  Vector3<Real> normal;      ///< unit, out of the collider
  Real distance = 0;         ///< signed, of `found` from the plane [m]
  Vector3<Real> found;       ///< where the vertex was expected [m]
  Vector3<Real> surface;     ///< displacement of the collider's surface in the sub-step [m]
  Real friction = 0;         ///< Coulomb's coefficient
  Vector3<Real> tangential;  ///< friction, for unit linear density [m2/s2]
  Real normalForce = 0;      ///< >= 0
  Friction state = Friction::kUnknown;
  bool active = false;  ///< the normal force was in the last solve
  int collider = -1;

  Real gap(const Vector3<Real>& x) const { return distance + dot(normal, x - found); }
  Vector3<Real> tangentialPart(const Vector3<Real>& v) const { return v - normal * dot(v, normal); }
  /// \param moved displacement of the vertex in the world
  Vector3<Real> slip(const Vector3<Real>& moved) const { return tangentialPart(moved - surface); }
};

/// Records of a vertex: of the colliders that it penetrates deepest.
template <class Real>
class ContactRecords {
 public:
  static constexpr int kMaxContacts = 2;

  ContactRecord<Real>* begin() { return records_.data(); }
  ContactRecord<Real>* end() { return records_.data() + count_; }
  const ContactRecord<Real>* begin() const { return records_.data(); }
  const ContactRecord<Real>* end() const { return records_.data() + count_; }
  bool empty() const { return count_ == 0; }
  void clear() { count_ = 0; }

  /// Finds them for a vertex that goes from `from` to `to`. Forces of the record that it had with
  /// the same collider go on.
  void find(const std::vector<ContactShape<Real>>& shapes, const Vector3<Real>& from,
            const Vector3<Real>& to, Real reach) {
    const ContactRecords old = *this;
    std::array<Contact<Real>, kMaxContacts> deepest;
    std::array<int, kMaxContacts> which;
    count_ = 0;
    for (size_t s = 0; s < shapes.size(); ++s) {
      const Contact<Real> contact = sweepContact(shapes[s], from, to);
      if (!(contact.penetration > -reach)) continue;
      int at = count_;
      while (at > 0 && contact.penetration > deepest[at - 1].penetration) --at;
      for (int k = std::min(count_, kMaxContacts - 1); k > at; --k) {
        deepest[k] = deepest[k - 1];
        which[k] = which[k - 1];
      }
      if (at == kMaxContacts) continue;
      deepest[at] = contact;
      which[at] = static_cast<int>(s);
      count_ = std::min(count_ + 1, kMaxContacts);
    }
    for (int k = 0; k < count_; ++k) {
      ContactRecord<Real>& record = records_[k] = {};
      record.normal = deepest[k].normal;
      record.distance = -deepest[k].penetration;
      record.found = to;
      record.surface = deepest[k].surfaceMotion;
      record.friction = shapes[static_cast<size_t>(which[k])].friction;
      record.collider = which[k];
      for (const ContactRecord<Real>& before : old) {
        if (before.collider != record.collider) continue;
        record.tangential = record.tangentialPart(before.tangential);
        record.normalForce = before.normalForce;
        record.state = before.state;
      }
    }
  }

 private:
  std::array<ContactRecord<Real>, kMaxContacts> records_;
  int count_ = 0;
};

}  // namespace pelage::reference
