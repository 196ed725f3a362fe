// Balance. With the weight G_i of all vertices behind edge i, and e_i from vertex i to i + 1, the
// potential of gravity is the sum of -e_i.G_i: it depends on the rotation of each edge alone. A
// strand is at rest where the gradient in the rotation of every edge is 0,
//   g_i - g_i+1 = e_i x G_i,  so  g_i = M_i, the sum of e_k x G_k over k >= i,
// with g_i the gradient of the energy of joint i in the rotation of edge i. These are three numbers
// a joint. The bind shape leaves three open: two of the rest joint, which has no twist, and the
// rotation of the frame of edge i about its tangent, which is the twist that the load makes.
//
// A joint is deformed by r from its rest. With s the vector of r over 1 + w and a the axis half-way
// between the tangents before and behind the joint at rest, the energy is
//   8 (kb |s|^2 + (kt - kb) (s.a)^2)   (kernels/simulation/exact/exact_elimination.hlsli).
// In the bind shape the tangents are given, and the tangent at rest is the one behind the joint,
// rotated back by r: s alone is unknown. Newton's method finds it with the axis of the step before.
//
// Stability. The second derivative of energy and potential in the rotations of all edges is
// positive definite where every pivot of its elimination from tip to root is: joints couple
// neighbors alone. Springs to bind positions make the position a state of the elimination, as in
// the solver.
#include "simulation/sag_balance.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pelage/hair_asset.h"

namespace pelage::detail {

namespace {

using Vector = Vector3<double>;
using Rotation = UnitQuaternion<double>;

// Limit of s, tan(angle / 4): a joint that gravity bends by more than 140 degrees. The moment of a
// joint has no maximum below 180 degrees.
constexpr double kMaxDeformation = 0.7;
// Sum of the tangents at rest, relative to 2: the axis of a joint that is folded back is not
// defined.
constexpr double kMinSum = 0.05;
constexpr int kMaxIterations = 60;
constexpr double kTolerance = 1e-13;  // of a joint's rotation [rad]
// Strands must be stable under this multiple of the load.
constexpr double kMargin = 1.01;
// Halvings of the interval of fractions.
constexpr int kHalvings = 12;

struct Matrix {
  std::array<Vector, 3> columns;
};

Vector operator*(const Matrix& m, const Vector& v) {
  return m.columns[0] * v.x + m.columns[1] * v.y + m.columns[2] * v.z;
}
Matrix operator*(const Matrix& a, const Matrix& b) {
  return {{a * b.columns[0], a * b.columns[1], a * b.columns[2]}};
}
Matrix operator+(const Matrix& a, const Matrix& b) {
  return {{a.columns[0] + b.columns[0], a.columns[1] + b.columns[1], a.columns[2] + b.columns[2]}};
}
Matrix operator*(const Matrix& a, double factor) {
  return {{a.columns[0] * factor, a.columns[1] * factor, a.columns[2] * factor}};
}
Matrix operator-(const Matrix& a, const Matrix& b) { return a + b * -1.0; }
Matrix transposed(const Matrix& m) {
  const auto& [a, b, c] = m.columns;
  return {{Vector{a.x, b.x, c.x}, Vector{a.y, b.y, c.y}, Vector{a.z, b.z, c.z}}};
}
Matrix diagonal(double value) {
  return {{Vector{value, 0, 0}, Vector{0, value, 0}, Vector{0, 0, value}}};
}
Matrix outer(const Vector& a, const Vector& b) { return {{a * b.x, a * b.y, a * b.z}}; }
// v -> a x v
Matrix crossMatrix(const Vector& a) {
  return {{Vector{0, a.z, -a.y}, Vector{-a.z, 0, a.x}, Vector{a.y, -a.x, 0}}};
}
Matrix symmetricPart(const Matrix& m) { return (m + transposed(m)) * 0.5; }

double determinant(const Matrix& m) { return dot(m.columns[0], cross(m.columns[1], m.columns[2])); }
Matrix inverse(const Matrix& m) {
  const auto& [a, b, c] = m.columns;
  const double scale = 1 / determinant(m);
  return transposed({{cross(b, c) * scale, cross(c, a) * scale, cross(a, b) * scale}});
}
// Sylvester's criterion; false for NaN.
bool isPositive(const Matrix& m) {
  const auto& [a, b, c] = m.columns;
  return a.x > 0 && a.x * b.y - a.y * b.x > 0 && determinant(m) > 0;
}

double lengthOf(const Vector& v) { return length(v); }

Rotation rotationOf(const Vector& s) {
  const double s2 = dot(s, s), factor = 1 / (1 + s2);
  return {s.x * 2 * factor, s.y * 2 * factor, s.z * 2 * factor, (1 - s2) * factor};
}
Vector deformationOf(const Rotation& r) {
  const double scale = (r.w < 0 ? -1 : 1) / (1 + std::abs(r.w));
  return {r.x * scale, r.y * scale, r.z * scale};
}
Rotation conjugate(const Rotation& q) { return {-q.x, -q.y, -q.z, q.w}; }

// Change of s by a small rotation w, applied after that of s.
Vector changeOf(const Vector& s, const Vector& w) {
  return (w * (1 - dot(s, s)) + cross(w, s) * 2.0 + s * (2 * dot(s, w))) * 0.25;
}

// Gradient of a joint's energy in the rotation of the edge behind it, and its derivative in the
// same rotation.
struct Gradient {
  Vector value;
  Matrix derivative;
};

Gradient gradientOf(const Vector& s, const Vector& axis, double bend, double twist) {
  const double s2 = dot(s, s), o = 1 + s2, sa = dot(s, axis), dk = twist - bend;
  const Vector ra = axis * (1 - s2) + cross(s, axis) * 2.0 + s * (2 * sa);
  Gradient gradient = {s * (4 * bend * o) + ra * (4 * dk * sa), {}};
  const Vector units[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (size_t k = 0; k < 3; ++k) {
    const Vector ds = changeOf(s, units[k]);
    const double s2Change = 2 * dot(s, ds), saChange = dot(axis, ds);
    const Vector raChange =
        axis * -s2Change + cross(ds, axis) * 2.0 + ds * (2 * sa) + s * (2 * saChange);
    gradient.derivative.columns[k] =
        (ds * o + s * s2Change) * (4 * bend) + (ra * saChange + raChange * sa) * (4 * dk);
  }
  return gradient;
}

Vector limited(const Vector& v, double limit) {
  const double size = lengthOf(v);
  return size > limit ? v * (limit / size) : v;
}

// Finds s of a joint that carries a moment.
// \param restTangent  of the edge behind it, before the load
bool deform(const Vector& before, const Vector& behind, const Vector& moment, double bend,
            double twist, Vector& s, Vector& restTangent) {
  s = {};
  restTangent = behind;
  if (!(dot(moment, moment) > 0)) return true;
  if (!(bend > 0)) return false;
  s = limited(moment * (0.25 / bend), kMaxDeformation);
  for (int i = 0; i < kMaxIterations; ++i) {
    restTangent = rotateInverse(rotationOf(s), behind);
    const Vector sum = before + restTangent;
    const double size = lengthOf(sum);
    if (!(size > 2 * kMinSum)) return false;
    const Gradient gradient = gradientOf(s, sum * (1 / size), bend, twist);
    const Vector step =
        limited(inverse(gradient.derivative) * (moment - gradient.value), kMaxDeformation);
    s = limited(s + changeOf(s, step), kMaxDeformation);
    const double change = lengthOf(step);
    if (change < kTolerance) {
      restTangent = rotateInverse(rotationOf(s), behind);
      return lengthOf(s) < kMaxDeformation;
    }
    if (!std::isfinite(change)) return false;
  }
  return false;
}

double bendOf(const BoundRod& rod, const SagLoad& load, size_t joint) {
  return load.bend * rod.stiffness[joint] / rod.voronoiLengths[joint];
}
double twistOf(const BoundRod& rod, const SagLoad& load, size_t joint) {
  return load.twist * rod.stiffness[joint] / rod.voronoiLengths[joint];
}

// Weights behind edges, and their moments about the beginnings of the edges.
struct EdgeLoads {
  std::array<Vector, kMaxVerticesPerStrand> weights, moments;
};

EdgeLoads edgeLoads(const BoundRod& rod, const SagLoad& load) {
  EdgeLoads loads;
  Vector weight, moment;
  for (size_t i = rod.tangents.size() - 1; i >= 1; --i) {
    weight += load.acceleration * rod.voronoiLengths[i + 1];
    moment += cross(rod.tangents[i] * rod.lengths[i], weight);
    loads.weights[i] = weight;
    loads.moments[i] = moment;
  }
  return loads;
}

SagLoad scaled(SagLoad load, double factor) {
  load.acceleration = load.acceleration * factor;
  return load;
}

}  // namespace

bool operator==(const SagLoad& a, const SagLoad& b) {
  return a.acceleration.x == b.acceleration.x && a.acceleration.y == b.acceleration.y &&
         a.acceleration.z == b.acceleration.z && a.bend == b.bend && a.twist == b.twist &&
         a.targetSpring == b.targetSpring && a.targetRange == b.targetRange;
}

bool balanceJoints(const BoundRod& rod, const SagLoad& load, std::span<SagJoint> joints) {
  const size_t edges = rod.tangents.size();
  if (edges < 2) return true;
  const EdgeLoads loads = edgeLoads(rod, load);
  Rotation frame = rod.rootFrame;
  bool balanced = true;
  for (size_t i = 1; i < edges; ++i) {
    Vector s, restTangent;
    if (balanced) {
      balanced = deform(rod.tangents[i - 1], rod.tangents[i], loads.moments[i],
                        bendOf(rod, load, i), twistOf(rod, load, i), s, restTangent);
    }
    if (!balanced) {
      s = {};
      restTangent = rod.tangents[i];
    }
    const Vector inFrame = rotateInverse(frame, restTangent);
    joints[i].rest = shortestArc(Vector{1, 0, 0}, inFrame);
    const Rotation next = normalized(rotationOf(s) * (frame * joints[i].rest));
    joints[i].bind = normalized(conjugate(frame) * next);
    frame = next;
  }
  return balanced;
}

bool isStable(const BoundRod& rod, const SagLoad& load, std::span<const SagJoint> joints) {
  const size_t edges = rod.tangents.size();
  if (edges < 2) return true;
  const EdgeLoads loads = edgeLoads(rod, load);
  std::array<Gradient, kMaxVerticesPerStrand> gradients;
  Rotation frame = rod.rootFrame;
  for (size_t i = 1; i < edges; ++i) {
    const SagJoint& joint = joints[i];
    // In bind space.
    const Rotation next = normalized(frame * joint.bind);
    const Rotation deformed = next * conjugate(frame * joint.rest);
    const Vector sum = axisX(frame) + axisX(frame * joint.rest);
    gradients[i] = gradientOf(deformationOf(normalized(deformed)), sum * (1 / lengthOf(sum)),
                              bendOf(rod, load, i), twistOf(rod, load, i));
    gradients[i].derivative = symmetricPart(gradients[i].derivative);
    frame = next;
  }
  // x.Mx / 2 + x.Nf + f.Df / 2 is the value of the strand behind vertex i + 1, for its displacement
  // x and the rotation f of edge i.
  Matrix m, n, d;
  const bool springs = !rod.springs.empty();
  for (size_t i = edges - 1; i >= 1; --i) {
    const Vector edge = rod.tangents[i] * rod.lengths[i];
    const Vector weight = loads.weights[i] * kMargin;
    if (springs) m = m + diagonal(rod.springs[i + 1] * rod.voronoiLengths[i + 1]);
    // x_i+1 = x_i + f x edge. -edge.weight of the rotated edge, to second order.
    const Matrix arm = crossMatrix(edge) * -1.0, back = transposed(arm);
    const Matrix own = gradients[i].derivative + d + diagonal(dot(edge, weight)) -
                       symmetricPart(outer(edge, weight));
    const Matrix pivot = springs ? own + back * m * arm + symmetricPart(back * n) * 2.0 : own;
    if (!isPositive(pivot)) return false;
    const Matrix solved = inverse(pivot);
    // With the rotation of the edge before.
    const Matrix coupling = crossMatrix(gradients[i].value) * 0.5 - gradients[i].derivative;
    d = gradients[i].derivative - coupling * solved * transposed(coupling);
    if (!springs) continue;
    const Matrix side = back * m + transposed(n);
    n = transposed(side) * solved * transposed(coupling) * -1.0;
    m = m - transposed(side) * solved * side;
  }
  return true;
}

double balanceSag(const BoundRod& rod, const SagLoad& load, std::span<SagJoint> joints) {
  const auto carries = [&](double fraction) {
    const SagLoad part = scaled(load, fraction);
    return balanceJoints(rod, part, joints) && isStable(rod, part, joints);
  };
  if (carries(1)) return 1;
  double most = 0, least = 1;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (most + least);
    (carries(middle) ? most : least) = middle;
  }
  balanceJoints(rod, scaled(load, most), joints);
  return most;
}

}  // namespace pelage::detail
