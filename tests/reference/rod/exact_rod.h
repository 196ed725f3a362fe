// The exact strand solver: an inextensible Kirchhoff rod, implicit in time, one Newton step solved
// exactly in O(n) by a Riccati elimination from the tip to the root. A readable CPU statement of
// kernels/simulation/exact, in float or double.
//
// The rod. Vertices 0..n-1, edges 0..n-2 of fixed length l_i with a frame q_i whose x axis is the
// tangent; vertices 0 and 1 and edge 0 follow the root. Unknowns of a step are the rotations of the
// edges alone, so no step can stretch an edge. Bending and twist energy of vertex i is that of the
// discrete Kirchhoff rod (Bergou et al., "Discrete Elastic Rods", ACM Trans. Graph. 27(3), 2008,
// section 4.2) in the half-angle form s = tan(angle / 4): 4 tan(angle / 4) instead of the angle.
//
// The step. BDF2 gives each free vertex a target y_i and a weight am_i; the step minimises
//   sum_i am_i/2 |x_i - y_i|^2 + bending energy
// over the rotations. Linearised about an iterate this is a linear-quadratic control problem along
// the strand: dx_i+1 = dx_i + dphi_i x e_i, with control dphi_i. Its value function over the state
// (dx_i, dphi_i-1),
//   V = 1/2 dx.M dx + dx.N dphi + 1/2 dphi.D dphi + px.dx + pf.dphi,
// obeys a Riccati recursion (Bertsekas, Dynamic Programming and Optimal Control, volume I, section
// 3.1), from the tip, where it is known, to the root; the rotations follow from root to tip.
//
// Contact. A contact is a plane that a vertex stays in front of (rod_contact.h). Its normal force
// f_n and friction f_t are the multipliers of an augmented Lagrangian (Nocedal and Wright,
// Numerical Optimization, section 17.4) with the penalty k = 30 weight L. A pass adds, to gradient
// and matrix,
//   normal      f_n - k g at the gap g, where that is above 0
//   friction    sticks: f_t - k s at the slip s; slides: mu f_n against the slip
// and then takes the forces that the solve has used. A vertex changes between sticking and sliding
// where the solve leaves the friction cone, or turns round. The next step starts from these forces.
// What the passes leave of a penetration is taken from the positions alone: the edge to the vertex
// is turned, the next edges go back to where the solve led, and the history of the displacements
// does not learn of it. Strands without a collider within reach are solved as if there were none.
//
// Rounding. Positions enter as differences over the step, each summed along the strand from
// differences of tangents, and never as differences of positions that were summed in two ways: the
// weights am multiply an error of 1e-7 m into 1e-3 m/s2, and the rest shape would not be at rest.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "rod_contact.h"

namespace pelage::reference {

/// Each of these was found necessary, by trying without it (see the notes beside them).
template <class Real>
struct RodTuning {
  /// Largest rotation of an edge by its rate in the guess, and by a Newton step [rad].
  static constexpr Real kGuessLimit = Real(0.5), kStepLimit = Real(1);
  /// Rotary inertia about the tangent over am l^2. Without one the twist has no mass, and the guess
  /// that extrapolates it makes energy grow without bound. It acts against the guess, so that it is
  /// an error of first order in the step where it stays as it is (a curl's falls with the power
  /// of 1.3 from 8 to 16 sub-steps), and of second order where it goes down with the step (1.9).
  /// With its square undamped strands gain 2 % of mgL.
  static Real twistInertia(double h) { return Real(0.005 * std::min(60 * h, 1.0)); }
  /// Turn of an edge in a step [rad] at which the guess extrapolates half of its twist; less of
  /// slower edges. When all of it is, one Newton pass does not let a loose curl come to rest: it
  /// creeps about on a cycle of 0.1 % L, as wide as the second pass allows. At 0.01 some still do;
  /// from 0.1 on energy grows without drag. What is left out damps the twist, the more the shorter
  /// the step is, so that the angle goes down with its square below 1/240 s.
  /// With air drag the twist is left out more and more. It has no mass, so that nothing makes it go
  /// on turning: extrapolated, one pass lets it swing by up to 1 rad from step to step.
  static Real slowTurn(double h, double drag) {
    const double share = std::min(240 * h, 1.0), slow = drag * std::pow(std::min(60 * h, 1.0), 2);
    return Real(0.02 * share * share + slow * slow);
  }
  /// Share of what the last guess missed that the guess adds to an edge's last turn.
  static Real guessTrend(double drag) { return Real(0.5 * std::min(drag, 1.0)); }
  /// Largest rotation of a first pass without a second one [rad], as the runtime chooses it
  /// (docs/decisions/0005-second-pass.md).
  /// Strands that twist far more easily than they bend tremble by as much as a first pass may
  /// leave, for ever: 0.1 m/s at a twist of 0.1 to 0.3 of the bending.
  static double passTolerance(double h, double drag, double twistRatio) {
    if (twistRatio < 0.4) return 2e-4;
    const double c = std::min(drag, 3.0) * std::min(60 * h, 1.0);
    return 0.04 + 0.2 * c * c;
  }
  /// Least stiffness against twist, and least pivot, over the trace of the system. In exact
  /// arithmetic the sub-chain has no stiffness against twist but D's: what is there in float is
  /// rounding of either sign.
  static constexpr Real kTwistFloor = Real(2e-6), kPivotFloor = Real(2e-7), kTiny = Real(1e-22);
  /// Penalty of contacts over weight L, the inertia of the whole strand: a pass leaves a thirtieth
  /// of a gap at most. At 10 strands over an edge take 15 s to come to rest, at 100 some gain
  /// energy.
  static constexpr Real kContactStiffness = Real(30);
  /// A vertex that rests on a surface is on either side by rounding [m].
  static constexpr Real kContactTouch = Real(2e-5);
  /// Gaps that a further pass is for [m].
  static constexpr Real kContactTolerance = Real(1e-4);
  /// Rotation of an edge in a pass [rad] above which strands with contacts take another one; they
  /// do also where a force or a state has changed. Where moving strands do not, the forces of limp
  /// ones swing by a factor of four from step to step, and nothing that friction holds stays in its
  /// place.
  static constexpr Real kContactTurn = Real(0.2);
  /// Slips below this have no direction to trust [m].
  static constexpr Real kLeastSlip = Real(1e-5);
  /// How far from where a contact was found its plane is good for [m]. Farther off, contacts are
  /// found again and the step goes on from its result.
  static constexpr Real kContactRange = Real(0.03);
  /// A vertex within this distance of a surface has a record [m]; or as near as it falls further.
  static constexpr Real kContactReach = Real(1e-3);
  /// Longest displacement that an expectation goes on with [m].
  static constexpr Real kLongestStep = Real(1);
  /// Goal spring of a held tip [1/s2]; at 1e8 the Newton passes no longer converge.
  static constexpr Real kHoldStiffness = Real(1e6);
};

template <class Real>
class ExactRod {
 public:
  using Vector = Vector3<Real>;
  using Rotation = Quaternion<Real>;

  struct Statistics {
    long steps = 0;          ///< sub-steps
    long passes = 0;         ///< Newton passes
    long contactSteps = 0;   ///< sub-steps with contacts
    long contactPasses = 0;  ///< passes in them
    long again = 0;          ///< times that contacts were found again
  };

  ExactRod(const RestStrand& rest, const RootPose& pose) : rest_(rest) {
    rootRest_ = Rotation(rest.relative[0]);
    for (int i = 0; i + 1 < rest.size(); ++i) {
      lengths_.push_back(static_cast<Real>(rest.lengths[i]));
      joints_.push_back(i > 0 ? jointOf(rest.relative[i]) : Rotation());
    }
    for (const double region : rest.regions) regions_.push_back(static_cast<Real>(region));
    reset(pose);
  }

  /// Takes the rest shape at `pose`, at rest.
  void reset(const RootPose& pose) {
    const int n = size();
    pose_ = pose;
    rootVelocity_ = Vector3d();
    stepBefore_ = 0;
    frameBefore_ = 0;
    coefficients_ = coefficientsBefore_ = {0, 0};
    frames_.resize(n - 1);
    positions_.resize(n);
    const Root root = rootAt(pose);
    frames_[0] = rootFrame(root);
    positions_[0] = root.position;
    for (int i = 0; i + 1 < n; ++i) {
      if (i > 0) frames_[i] = normalized(frames_[i - 1] * joints_[i]);
      positions_[i + 1] = positions_[i] + axisX(frames_[i]) * lengths_[i];
    }
    carry_ = Motion();
    carryBefore_ = carryEarlier_ = Rotation();
    guessedWay_ = Vector();
    for (auto* ways : {&ways_, &waysBefore_, &waysEarlier_}) ways->assign(n, Vector());
    gains_.resize(n);
    targets_.resize(n);
    start_ = guess_ = iterate_ = frames_;
    halfTurns_.assign(n, Vector());
    nextTurns_.assign(n, Vector());
    moved_ = positionsBefore_ = positions_;
    rootStep_ = Vector();
    records_.assign(n, {});
    corrections_.assign(n, Vector());
  }

  /// Advances by `dt` > 0 seconds to a new pose of the root.
  void step(double dt, const RootPose& pose, const RodSettings& settings) {
    const Vector3d& root = rest_.positions[0];
    const Vector3d velocity = (pose.apply(root) - pose_.apply(root)) * (1 / dt);
    const double between = 0.5 * (dt + (frameBefore_ > 0 ? frameBefore_ : dt));
    const double acceleration = reference::length(velocity - rootVelocity_) / between;
    const double excess = std::clamp(acceleration / settings.carryThreshold - 1, 0.0, 1.0);
    const Real share = Real(settings.carry + (1 - settings.carry) * excess);
    carrying_ = settings.carry > 0 || std::isfinite(settings.carryThreshold);
    const Root from = rootAt(pose_), to = rootAt(pose);
    Root before = from;
    const int count = settings.subSteps;
    for (int k = 0; k < count; ++k) {
      const Real begin = Real(static_cast<double>(k) / count);
      const Real end = Real(static_cast<double>(k + 1) / count);
      Root now = to;
      if (k + 1 < count) {
        now.rotation = interpolate(from.rotation, to.rotation, end);
        now.position = from.position + (to.position - from.position) * end;
      }
      shapes_.clear();
      for (const RodCollider& c : settings.colliders) shapes_.emplace_back(c, begin, end);
      carry_ = carrying_ ? carriedMotion(before, now, share) : Motion();
      findContacts(dt / count, now.position - before.position, settings);
      subStep(dt / count, now, settings);
      before = now;
    }
    pose_ = pose;
    rootVelocity_ = velocity;
    frameBefore_ = dt;
  }

  int size() const { return rest_.size(); }
  const RestStrand& rest() const { return rest_; }
  const Vector& position(int i) const { return positions_[i]; }
  /// BDF2's, at the end of the last step.
  Vector velocity(int i) const {
    if (i < 2 || !(coefficients_.he > 0)) return Vector();
    return (ways_[i] + rotate(carryBefore_, waysBefore_[i]) * Real(coefficients_.a2)) *
           Real(1 / coefficients_.he);
  }
  const Rotation& frame(int i) const { return frames_[i]; }
  const Statistics& statistics() const { return statistics_; }
  std::vector<Vector3d> positions() const { return {positions_.begin(), positions_.end()}; }

  /// Kinetic, potential and elastic energy for unit linear density [m3/s2].
  double energy(const RodSettings& settings) const {
    double sum = 0;
    for (int i = 2; i < size(); ++i) {
      const Vector3d x(positions_[i]), v(velocity(i));
      sum += rest_.regions[i] * (0.5 * dot(v, v) - dot(settings.gravity, x));
    }
    for (int i = 1; i + 1 < size(); ++i) {
      const Quaterniond before(frames_[i - 1]), after(frames_[i]);
      const Quaterniond r =
          normalized((conjugate(before) * after) * conjugate(Quaterniond(joints_[i])));
      const Vector3d angles = r.vector() * ((r.w < 0 ? -4 : 4) / (1 + std::abs(r.w)));
      const double twist = dot(angles, Vector3d(twistAxis(i)));
      sum += 0.5 * rest_.stiffness[i] / rest_.regions[i] *
             (settings.material.bend * (dot(angles, angles) - twist * twist) +
              settings.material.twist * twist * twist);
    }
    return sum;
  }

 private:
  using Symmetric = Symmetric3<Real>;
  using Tuning = RodTuning<Real>;
  using Record = ContactRecord<Real>;
  using Friction = typename Record::Friction;

  /// Columns of the matrices of the control law u_i = -k - Kx dx_i + Kw u_i-1.
  struct Gain {
    Vector k, kx[3], kw[3];
  };
  /// Value function; N by its rows.
  struct Value {
    Symmetric m, d;
    Vector n[3], px, pf;
    Real load = 0;  // bound of the force that the rest of the strand can pull with
  };
  /// Gradient and Gauss-Newton matrix of the bending and twist energy in a relative rotation.
  struct Bending {
    Vector gradient;
    Symmetric matrix;
  };
  /// Numbers of a sub-step.
  struct StepNumbers {
    Real way, wayBefore, wayEarlier;  // y = shares of the last three ways + drift
    Real baseWeight;
    Vector drift;
    Real turnRatio, slowTurn, guessTrend, twistInertia;
    Real goalStiffness, goalRange;
    Real bend, twist, damping;  // damping = tau / h
  };

  /// Where the root is, in the solver's precision.
  struct Root {
    Rotation rotation;  // bind space to world
    Vector position;    // of vertex 0
  };

  Root rootAt(const RootPose& pose) const {
    return {normalized(Rotation(pose.rotation)), Vector(pose.apply(rest_.positions[0]))};
  }
  Rotation rootFrame(const Root& root) const { return normalized(root.rotation * rootRest_); }

  /// A joint at rest. Frames are those of parallel transport, so that there is no rotation about
  /// the edge before: two numbers, that of the half-way point of the stereographic projection.
  static Rotation jointOf(const Quaterniond& q) {
    const double scale = (q.w < 0 ? -1 : 1) / (1 + std::abs(q.w));
    const Real y = Real(q.y * scale), z = Real(q.z * scale);
    const Real factor = Real(2) / (Real(1) + (y * y + z * z));
    return {Real(0), y * factor, z * factor, factor - Real(1)};
  }
  /// Of vertex i, in the frame of edge i - 1: half-way between the two rest tangents. The axis of
  /// edge i - 1 alone makes a curled rod first order in n only.
  Vector twistAxis(int i) const {
    const Rotation& q = joints_[i];
    return {q.w, q.z, -q.y};
  }

  /// Rotation by the vector p to second order, without trigonometry: the Cayley map.
  static Rotation cayley(const Vector& p) { return Rotation(p * Real(0.5), Real(1)); }
  static Vector twiceVector(const Rotation& d) { return d.vector() * Real(d.w < 0 ? -2 : 2); }

  /// p -> rotate(rotation, p) + shift.
  struct Motion {
    Rotation rotation;
    Vector shift;
    Vector operator()(const Vector& p) const { return rotate(rotation, p) + shift; }
  };

  /// The matrix of a rotation, by rows, times a factor.
  struct Turning {
    Vector rows[3];
    Turning(const Rotation& q, Real factor) {
      const Vector x = rotate(q, Vector(1, 0, 0)), y = rotate(q, Vector(0, 1, 0)),
                   z = rotate(q, Vector(0, 0, 1));
      rows[0] = Vector(x.x, y.x, z.x) * factor;
      rows[1] = Vector(x.y, y.y, z.y) * factor;
      rows[2] = Vector(x.z, y.z, z.z) * factor;
    }
    Vector operator()(const Vector& v) const {
      return {dot(rows[0], v), dot(rows[1], v), dot(rows[2], v)};
    }
  };

  // The state as the sub-step starts from it: carried along by a share of the root's rigid motion.
  // What was stored stays as it is.
  Rotation carriedFrame(int i) const {
    return carrying_ ? polished(carry_.rotation * frames_[i]) : frames_[i];
  }

  /// A share of the root's motion.
  static Motion carriedMotion(const Root& from, const Root& to, Real share) {
    const Rotation turn = normalized(to.rotation * conjugate(from.rotation));
    Motion motion;
    motion.rotation = interpolate(Rotation(), turn, share);
    motion.shift = from.position + (to.position - from.position) * share -
                   rotate(motion.rotation, from.position);
    return motion;
  }

  void subStep(double h, const Root& root, const RodSettings& settings) {
    const int n = size();
    const StepNumbers numbers = numbersOf(h, settings);
    contactStiffness_ = numbers.baseWeight * Real(rest_.length()) * Tuning::kContactStiffness;
    const Rotation frame = rootFrame(root);
    const Vector& x0 = root.position;
    const Vector edge0 = axisX(frame) * lengths_[0], x1 = x0 + edge0;
    const Vector rootWay = x1 - (carrying_ ? carry_(positions_[1]) : positions_[1]);
    const Vector oldTip = carrying_ ? carry_(positions_[n - 1]) : positions_[n - 1];
    setGuess(frame, numbers);
    // Of the tip against vertex 1.
    Vector way = carrying_ ? rotate(carry_.rotation, guessedWay_) : guessedWay_;
    if (numbers.turnRatio != 1) {
      way = Vector();
      for (int i = 1; i + 1 < n; ++i) way += (axisX(iterate_[i]) - axisX(start_[i])) * lengths_[i];
    }
    Vector tip = oldTip + (way + rootWay);
    ++statistics_.steps;
    far_ = false;
    if (touching_) ++statistics_.contactSteps;
    const auto solve = [&] {
      for (int pass = 0; pass < (touching_ ? settings.contactPasses : settings.maxPasses); ++pass) {
        eliminate(way + rootWay, tip, root, settings, numbers);
        ++statistics_.passes;
        if (touching_) ++statistics_.contactPasses;
        const RollOut rolled = rollOut(x0, x1, rootWay, way);
        tip = moved_[n - 1];
        if (isEnough(rolled, settings)) break;
      }
    };
    if (n > 2) solve();
    if (far_) {
      findContactsAgain(x0 - positions_[0]);
      if (touching_) solve();
    }
    moved_[0] = x0;
    moved_[1] = x1;
    // The oldest ways make place for the new ones.
    waysEarlier_.swap(waysBefore_);
    waysBefore_.swap(ways_);
    way = guessedWay_ = Vector();
    for (int i = 1; i + 1 < n; ++i) {
      const Vector tangent = axisX(iterate_[i]);
      way += (tangent - axisX(start_[i])) * lengths_[i];
      ways_[i + 1] = rootWay + way;
      if (touching_) ways_[i + 1] -= corrections_[i + 1];
      nextTurns_[i] = nextHalfTurn(iterate_[i], start_[i], halfTurns_[i], numbers);
      const Vector on = halfTurnOn(nextTurns_[i], Real(1));
      guessedWay_ += (axisX(guessFrame(iterate_[i], on)) - tangent) * lengths_[i];
    }
    positionsBefore_ = positions_;
    positions_.swap(moved_);
    frames_ = iterate_;
    carryEarlier_ = carryBefore_;
    carryBefore_ = carry_.rotation;
    stepBefore_ = h;
  }

  StepNumbers numbersOf(double h, const RodSettings& settings) {
    const bool history = stepBefore_ > 0 && !settings.backwardEuler;
    const StepCoefficients c = StepCoefficients::of(h, stepBefore_, history);
    const RodMaterial& material = settings.material;
    const double weight = 1 / (c.he * c.he) + material.airDrag / c.he;
    const double s = settings.globalStiffness;
    StepNumbers numbers;
    // y = xb + vb / (he weight) + drift, with v = (x - xb) / he of each step.
    const StepCoefficients &c1 = coefficients_, &c2 = coefficientsBefore_;
    const double share = 1 / (c.he * weight);
    const double i1 = c1.he > 0 ? 1 / c1.he : 0, i2 = c2.he > 0 ? 1 / c2.he : 0;
    numbers.way = Real(share * (1 - c.a2) * i1 - c.a2);
    numbers.wayBefore = Real(share * ((1 - c.a2) * c1.a2 * i1 + c.a2 * i2));
    numbers.wayEarlier = Real(share * c.a2 * c2.a2 * i2);
    coefficientsBefore_ = coefficients_;
    coefficients_ = c;
    numbers.baseWeight = Real(weight);
    numbers.drift = Vector((settings.gravity + settings.wind * material.airDrag) * (1 / weight));
    numbers.turnRatio = stepBefore_ > 0 ? Real(h / stepBefore_) : Real(0);
    numbers.slowTurn = Tuning::slowTurn(h, material.airDrag);
    numbers.twistInertia = Tuning::twistInertia(h);
    numbers.guessTrend = Tuning::guessTrend(material.airDrag);
    numbers.goalStiffness = Real(s * 3600 / std::max(1 - s, 1e-3));
    numbers.goalRange = Real(settings.globalRange);
    numbers.bend = Real(material.bend);
    numbers.twist = Real(material.twist);
    numbers.damping = Real(material.relaxation / h);
    setTurnings(numbers);
    return numbers;
  }

  // ---- contacts, before a sub-step

  /// A vertex is expected to go on as in the last sub-step, and near the root to follow the root
  /// where that changes its motion. It is swept from where it is to there.
  void findContacts(double h, const Vector& rootDisplacement, const RodSettings& settings) {
    const Real ratio = stepBefore_ > 0 ? Real(h / stepBefore_) : Real(0);
    const bool known = stepBefore_ > 0;
    const Vector now = withinLongest(rootDisplacement, Vector());
    const Vector last = known ? rootStep_ * ratio : now;
    reach_ = Tuning::kContactReach + Real(reference::length(settings.gravity) * h * h);
    touching_ = false;
    for (int i = 2; i < size() && !shapes_.empty(); ++i) {
      const Vector& x = positions_[i];
      const Vector moved = withinLongest((x - positionsBefore_[i]) * ratio, Vector());
      const Real share = Real(1) - Real(i) / Real(size());
      const Vector relative = known ? moved - last : Vector();
      findRecords(i, x, x + moved + (now - last) * share, relative * Real(0.25));
    }
    rootStep_ = now;
  }
  /// The same with vertices swept to where the solve has put them. It has gone wrong by much, so
  /// that more of them may meet a collider.
  void findContactsAgain(const Vector& rootDisplacement) {
    const Vector now = withinLongest(rootDisplacement, Vector());
    ++statistics_.again;
    touching_ = false;
    for (int i = 2; i < size(); ++i) {
      const Vector moved = withinLongest(moved_[i] - positions_[i], now);
      findRecords(i, moved_[i] - moved, moved_[i], moved - now);
    }
  }
  /// \param further how far it may end from `to`
  void findRecords(int i, const Vector& from, const Vector& to, const Vector& further) {
    records_[i].find(shapes_, from, to, reach_ + reference::length(further));
    touching_ = touching_ || !records_[i].empty();
  }
  static Vector withinLongest(const Vector& v, const Vector& otherwise) {
    return dot(v, v) < Tuning::kLongestStep * Tuning::kLongestStep ? v : otherwise;
  }

  /// Where the last three ways lead.
  void setTurnings(const StepNumbers& numbers) {
    const Rotation both = normalized(carry_.rotation * carryBefore_);
    const Rotation all = normalized(both * carryEarlier_);
    const Turning turnings[3] = {
        {carry_.rotation, numbers.way}, {both, numbers.wayBefore}, {all, numbers.wayEarlier}};
    for (int i = 1; i < size(); ++i) {
      targets_[i] = carrying_ ? turnings[0](ways_[i]) + turnings[1](waysBefore_[i]) +
                                    turnings[2](waysEarlier_[i])
                              : ways_[i] * numbers.way + waysBefore_[i] * numbers.wayBefore +
                                    waysEarlier_[i] * numbers.wayEarlier;
      if (touching_ && numbers.way != 0 && numbers.wayBefore != 0 && numbers.wayEarlier != 0)
        targets_[i] = limitedWays(i, turnings, numbers);
      targets_[i] += numbers.drift;
    }
  }

  /// BDF2 goes on with the last change of the displacement: after an impact that would be a rebound
  /// of two thirds of the speed. Here a change goes on only as far as it agrees with the one before
  /// it (a minmod limiter, as LeVeque, Finite Volume Methods for Hyperbolic Problems, section 6.9).
  /// Smooth motion stays as it is.
  Vector limitedWays(int i, const Turning (&turnings)[3], const StepNumbers& numbers) const {
    Vector w0 = ways_[i], w1 = waysBefore_[i], w2 = waysEarlier_[i];
    if (carrying_) {
      w0 = turnings[0](w0) * (Real(1) / numbers.way);
      w1 = turnings[1](w1) * (Real(1) / numbers.wayBefore);
      w2 = turnings[2](w2) * (Real(1) / numbers.wayEarlier);
    }
    Vector change = w0 - w1, changeBefore = w1 - w2;
    const Vector steady = w0 * (numbers.way + numbers.wayBefore + numbers.wayEarlier);
    if (!(dot(change, changeBefore) > Real(0))) return steady;
    const Real four = Real(4), size = dot(change, change), before = dot(changeBefore, changeBefore);
    if (size > four * before) change = change * squareRoot(four * before / size);
    if (before > four * size) changeBefore = changeBefore * squareRoot(four * size / before);
    return steady - change * (numbers.wayBefore + numbers.wayEarlier) -
           changeBefore * numbers.wayEarlier;
  }

  /// The way of vertex i alone, and its weight.
  struct Target {
    Vector way;
    Real weight;
  };
  /// \param x position in the iterate, which is `way` from where the step began
  Target targetOf(int i, const Vector& x, const Vector& way, const Root& root,
                  const RodSettings& settings, const StepNumbers& numbers) const {
    Target target = {targets_[i], numbers.baseWeight};
    const Real spring = goalSpring(i, settings, numbers);
    if (spring > 0) {
      const Vector arm(rest_.positions[i] - rest_.positions[0]);
      const Vector goal = root.position + rotate(root.rotation, arm);
      const Vector goalWay = goal - x + way;
      target.weight = target.weight + spring;
      target.way += (goalWay - target.way) * (spring / target.weight);
    }
    target.weight = regions_[i] * target.weight;
    return target;
  }

  Real goalSpring(int i, const RodSettings& settings, const StepNumbers& numbers) const {
    if (settings.holdTip && i + 1 == size()) return Tuning::kHoldStiffness;
    const Real fade = Real(0.25) * numbers.goalRange;
    if (!(fade > 0)) return Real(0);
    const Real within = (numbers.goalRange + fade - Real(rest_.share[i])) / fade;
    return numbers.goalStiffness * std::clamp(within, Real(0), Real(1));
  }

  /// Turns every edge on.
  void setGuess(const Rotation& root, const StepNumbers& numbers) {
    for (int i = 0; i + 1 < size(); ++i) {
      start_[i] = carriedFrame(i);
      if (i == 0) continue;
      halfTurns_[i] = halfTurnOn(nextTurns_[i], numbers.turnRatio);
      guess_[i] = guessFrame(start_[i], halfTurns_[i]);
    }
    guess_[0] = root;
    iterate_ = guess_;
  }
  /// Half of the rotation vector by which an edge is to turn on in its own axes, after it turned
  /// from `before` to `frame` and `guessed` was the guess: its bending by the turn and a share of
  /// what the guess missed, its twist by the turn or less. As the kernel's state keeps it.
  static Vector nextHalfTurn(const Rotation& frame, const Rotation& before, const Vector& guessed,
                             const StepNumbers& numbers) {
    const Rotation d = conjugate(before) * frame;
    Vector turn = d.vector() * Real(d.w < 0 ? -1 : 1);
    const Real slow = Real(0.25) * numbers.slowTurn * numbers.slowTurn, twisted = dot(turn, turn);
    turn.x = turn.x * (twisted / std::max(twisted + slow, Tuning::kTiny));
    turn.y = turn.y + (turn.y - guessed.y) * numbers.guessTrend;
    turn.z = turn.z + (turn.z - guessed.z) * numbers.guessTrend;
    turn = limitedHalfTurn(turn);
    return stored(turn);
  }
  /// Three numbers of 9 bits with one exponent.
  static Vector stored(const Vector& turn) {
    const float largest =
        static_cast<float>(std::max({std::abs(turn.x), std::abs(turn.y), std::abs(turn.z)}));
    const int binade = static_cast<int>(std::bit_cast<uint32_t>(largest) >> 23);
    const int exponent = std::clamp(binade - 111, 1, 14);
    const Real unit = std::ldexp(Real(1), exponent - 23),
               steps = std::ldexp(Real(1), 23 - exponent);
    const auto rounded = [&](Real x) {
      return std::min(std::floor(x * steps + Real(0.5)), Real(255)) * unit;
    };
    return {rounded(turn.x), rounded(turn.y), rounded(turn.z)};
  }
  static Vector limitedHalfTurn(const Vector& turn) {
    constexpr Real kLimit = Real(0.5) * Tuning::kGuessLimit;
    const Real squared = dot(turn, turn);
    return squared > kLimit * kLimit ? turn * (kLimit * inverseRoot(squared)) : turn;
  }
  /// `ratio` times as far; rounded to the 21 bits that the kernel's gains keep of it.
  static Vector halfTurnOn(const Vector& next, Real ratio) {
    const Vector turn = limitedHalfTurn(next * ratio);
    return {shortened(turn.x), shortened(turn.y), shortened(turn.z)};
  }
  /// The frame turned in its own axes.
  static Rotation guessFrame(const Rotation& frame, const Vector& halfTurn) {
    return normalizedTurned(frame * Rotation(halfTurn, Real(1)));
  }

  /// Energy of vertex i in the relative rotation r: 8 (kb |s|^2 + (kt - kb) (s.a)^2), with s the
  /// rotation's vector over 1 + w. The gradient is in world space, for a rotation of edge i.
  Bending bendingOf(int i, const StepNumbers& numbers, Real inverseRegion) const {
    const Real kb = numbers.bend * inverseRegion, dk = numbers.twist * inverseRegion - kb;
    const Rotation& parent = iterate_[i - 1];
    const Vector axis = twistAxis(i);
    const Rotation relative = conjugate(parent) * iterate_[i];
    const Rotation r = lessJoint(relative, joints_[i]);
    const Vector s = r.vector() * (Real(r.w < 0 ? -1 : 1) / (Real(1) + std::abs(r.w)));
    const Real s2 = dot(s, s), o = Real(1) + s2, sa = dot(s, axis);
    const Vector ra = axis * (Real(1) - s2) + cross(s, axis) * Real(2) + s * (Real(2) * sa);
    Bending bending;
    bending.gradient = rotate(parent, s * (Real(4) * kb * o) + ra * (Real(4) * dk * sa));
    const Vector w = rotate(parent, ra);
    bending.matrix.addDiagonal(kb * o * o);
    bending.matrix.addOuter(w * dk, w);
    if (numbers.damping > 0) {
      // Kelvin-Voigt: the same energy about the last step's relative rotation, times tau / h.
      const Rotation last = conjugate(start_[i - 1]) * start_[i];
      const Rotation change = relative * conjugate(last);
      const Vector turn =
          change.vector() * (Real(change.w < 0 ? -4 : 4) / (Real(1) + std::abs(change.w)));
      const Vector moment = turn * kb + axis * (dk * dot(turn, axis));
      bending.gradient += rotate(parent, moment) * numbers.damping;
      const Real scale = Real(1) + numbers.damping;
      Symmetric& b = bending.matrix;
      b = {b.xx * scale, b.xy * scale, b.xz * scale, b.yy * scale, b.yz * scale, b.zz * scale};
    }
    return bending;
  }

  /// a conj(joint), without the products with the joint's x, which is 0.
  static Rotation lessJoint(const Rotation& a, const Rotation& joint) {
    return {a.x * joint.w - a.y * joint.z + a.z * joint.y,
            a.y * joint.w - a.w * joint.y + a.x * joint.z,
            a.z * joint.w - a.w * joint.z - a.x * joint.y,
            a.w * joint.w + a.y * joint.y + a.z * joint.z};
  }

  /// Adds am/2 |x - y|^2 and the contacts of vertex i, which the iterate moves by `way` to x.
  void addVertex(int i, const Vector& way, const Vector& x, const Target& target, Value& value) {
    const Real am = target.weight;
    value.m.addDiagonal(am);
    const Vector force = (way - target.way) * am;
    value.px += force;
    if (!touching_) return;
    value.load += reference::length(force);
    for (Record& contact : records_[i]) addContact(contact, way, x, target, value);
  }

  void addContact(Record& contact, const Vector& way, const Vector& x, const Target& target,
                  Value& value) const {
    const Vector& n = contact.normal;
    const Real k = contactStiffness_, gap = contact.gap(x);
    // Where the vertex alone would go.
    const Vector free = target.way - way;
    const Real alone = gap + dot(n, free);
    Real press = contact.normalForce - k * gap;
    contact.active = press > 0 || (gap < Tuning::kContactTouch && alone < 0);
    if (!contact.active) return;
    const Vector slip = contact.slip(worldDisplacement(x, way));
    if (!(contact.normalForce > 0)) {
      contact.normalForce = std::max(-alone, Real(0)) * target.weight;
      press = contact.normalForce - k * gap;
    }
    if (contact.friction > 0 && contact.state == Friction::kUnknown) {
      const Vector slipAlone = slip + contact.tangentialPart(free);
      const Real most = contact.friction * contact.normalForce;
      const bool sticks = reference::length(slipAlone) * target.weight <= most;
      contact.state = sticks ? Friction::kSticks : Friction::kSlides;
      contact.tangential = sticks ? Vector() : directionOr(slipAlone * Real(-1), Vector()) * most;
    }
    value.px -= n * press;
    value.m.addOuter(n * k, n);
    value.load += contact.normalForce;
    if (contact.state != Friction::kUnknown && contact.normalForce > 0)
      addFriction(contact, slip, value);
    contact.normalForce = press;
  }

  /// Friction of a contact that presses with its normal force.
  void addFriction(Record& contact, const Vector& slip, Value& value) const {
    Real c = contactStiffness_;
    if (contact.state == Friction::kSticks) {
      contact.tangential -= slip * c;
      value.px -= contact.tangential;
    } else {
      const Vector d = directionOr(contact.tangential, Vector());
      const Real pull = contact.friction * contact.normalForce;
      value.px -= d * pull;
      c = std::min(c, pull / std::max(std::abs(dot(slip, d)), Tuning::kLeastSlip));
      value.m.addOuter(d * -c, d);
    }
    value.m.addDiagonal(c);
    value.m.addOuter(contact.normal * -c, contact.normal);
  }

  /// The displacement in the world of a vertex at x that the iterate moves by `way` against where
  /// it was carried to.
  Vector worldDisplacement(const Vector& x, const Vector& way) const {
    if (!carrying_) return way;
    return x - rotate(conjugate(carry_.rotation), x - way - carry_.shift);
  }

  /// Tip to root: the control law of every edge about the iterate.
  void eliminate(Vector way, Vector x, const Root& root, const RodSettings& settings,
                 const StepNumbers& numbers) {
    const int n = size();
    const auto target = [&](int i) { return targetOf(i, x, way, root, settings, numbers); };
    Target end = target(n - 1);
    Value value;
    addVertex(n - 1, way, x, end, value);
    for (int i = n - 2; i >= 1; --i) {
      const Vector tangent = axisX(iterate_[i]);
      way -= (tangent - axisX(start_[i])) * lengths_[i];
      x -= tangent * lengths_[i];
      eliminateEdge(i, end.weight, numbers, value);
      end = target(i);
      if (i > 1) addVertex(i, way, x, end, value);
    }
  }

  /// V of (dx_i, dphi_i-1) from V of (dx_i+1, dphi_i), without vertex i's own terms.
  void eliminateEdge(int i, Real endWeight, const StepNumbers& numbers, Value& v) {
    const Real inverseRegion = Real(rest_.stiffness[i]) / regions_[i];
    const Bending bending = bendingOf(i, numbers, inverseRegion);
    const Vector t = axisX(iterate_[i]), e = t * lengths_[i];
    const Symmetric& m = v.m;
    // S M with S = [e], by columns; S M S^T; S N.
    const Vector c0 = cross(e, m.column0()), c1 = cross(e, m.column1()), c2 = cross(e, m.column2());
    const Vector r0 = cross(e, Vector(c0.x, c1.x, c2.x));
    const Vector n0 = cross(e, Vector(v.n[0].x, v.n[1].x, v.n[2].x));
    const Vector n1 = cross(e, Vector(v.n[0].y, v.n[1].y, v.n[2].y));
    const Vector n2 = cross(e, Vector(v.n[0].z, v.n[1].z, v.n[2].z));
    // The second derivative of x_i+1 in dphi_i under the tension e.px, made positive.
    Real tension = std::abs(dot(v.px, e));
    // Far from the solution the gradient of a contact is far from its force.
    if (touching_) tension = std::min(tension, v.load * lengths_[i]);
    const Vector tt = t * tension;
    Symmetric a;
    a.xx = r0.x + n0.x + n0.x + v.d.xx + tension - tt.x * t.x;
    a.xy = r0.y + n1.x + n0.y + v.d.xy - tt.x * t.y;
    a.xz = r0.z + n2.x + n0.z + v.d.xz - tt.x * t.z;
    a.yy = (e.z * c0.y - e.x * c2.y) + n1.y + n1.y + v.d.yy + tension - tt.y * t.y;
    a.yz = (e.x * c1.y - e.y * c0.y) + n2.y + n1.z + v.d.yz - tt.y * t.z;
    a.zz = (e.x * c1.z - e.y * c0.z) + n2.z + n2.z + v.d.zz + tension - tt.z * t.z;
    // Along t all but D vanishes in exact arithmetic: its rounding is replaced.
    const Real twistStiffness = numbers.twist * inverseRegion;
    const Real own = std::max(dot(t, v.d * t), Real(0));
    const Real floor = std::max(a.trace() * Tuning::kTwistFloor - twistStiffness - own, Real(0));
    const Real inertia = endWeight * lengths_[i] * lengths_[i] * numbers.twistInertia;
    const Real correction = own - dot(t, a * t) + floor + inertia;
    a.addOuter(t * correction, t);
    a.addDiagonal(Tuning::kTiny);
    const Vector turned = twiceVector(iterate_[i] * conjugate(guess_[i]));
    v.pf += t * (inertia * dot(t, turned));

    const Symmetric& b = bending.matrix;
    const Vector& g = bending.gradient;
    const Symmetric sum = {a.xx + b.xx, a.xy + b.xy, a.xz + b.xz,
                           a.yy + b.yy, a.yz + b.yz, a.zz + b.zz};
    const Symmetric w = inverseOf(sum, sum.trace() * Tuning::kPivotFloor + Tuning::kTiny);
    const Vector q0 = cross(e, v.px) + v.pf, q = q0 + g;
    const Vector x0 = c0 + v.n[0], x1 = c1 + v.n[1], x2 = c2 + v.n[2];
    Gain& gain = gains_[i];
    gain.k = w * q;
    gain.kx[0] = w * x0;
    gain.kx[1] = w * x1;
    gain.kx[2] = w * x2;
    gain.kw[0] = w * b.column0();
    gain.kw[1] = w * b.column1();
    gain.kw[2] = w * b.column2();

    v.m = {m.xx - dot(x0, gain.kx[0]), m.xy - dot(x0, gain.kx[1]), m.xz - dot(x0, gain.kx[2]),
           m.yy - dot(x1, gain.kx[1]), m.yz - dot(x1, gain.kx[2]), m.zz - dot(x2, gain.kx[2])};
    const Vector x[3] = {x0, x1, x2};
    for (int j = 0; j < 3; ++j) {
      v.n[j] = {dot(x[j], gain.kw[0]), dot(x[j], gain.kw[1]), dot(x[j], gain.kw[2])};
    }
    // B W A, which is B - B W B without the cancellation.
    const Vector a0 = a * gain.kw[0], a1 = a * gain.kw[1], a2 = a * gain.kw[2];
    v.d = {a0.x, (a0.y + a1.x) * Real(0.5), (a0.z + a2.x) * Real(0.5),
           a1.y, (a1.z + a2.y) * Real(0.5), a2.z};
    v.px -= Vector(dot(x0, gain.k), dot(x1, gain.k), dot(x2, gain.k));
    v.pf = Vector(dot(gain.kw[0], q0), dot(gain.kw[1], q0), dot(gain.kw[2], q0)) - a * (w * g);
  }

  /// What came of a pass.
  struct RollOut {
    Real largest = 0;      // square of the largest rotation
    bool changed = false;  // contacts want another pass
  };

  bool isEnough(const RollOut& rolled, const RodSettings& settings) const {
    const Real tolerance2 = Real(settings.passTolerance * settings.passTolerance);
    if (!touching_) return rolled.largest <= tolerance2;
    constexpr Real kTurn2 = Tuning::kContactTurn * Tuning::kContactTurn;
    return rolled.largest <= std::min(tolerance2, kTurn2) && !rolled.changed;
  }

  /// Root to tip: turns the edges and places the vertices.
  /// \param way of the tip against vertex 1
  RollOut rollOut(const Vector& x0, const Vector& x1, const Vector& rootWay, Vector& way) {
    way = Vector();
    moved_[0] = x0;
    moved_[1] = x1;
    Vector dx, u, offset;  // offset: from where the solve leads
    far_ = false;
    RollOut rolled;
    for (int i = 1; i + 1 < size(); ++i) {
      const Gain& g = gains_[i];
      u = g.kw[0] * u.x + g.kw[1] * u.y + g.kw[2] * u.z - g.k - g.kx[0] * dx.x - g.kx[1] * dx.y -
          g.kx[2] * dx.z;
      const Real size = std::abs(u.x) + std::abs(u.y) + std::abs(u.z);
      // Scaled before it is squared: the square of a huge step would not be a number.
      if (!(size < Real(1e30))) {
        u = Vector();
      } else if (size > Real(4)) {
        u = u * (Real(4) / size);
      }
      const Real squared = dot(u, u);
      rolled.largest = std::max(rolled.largest, squared);
      if (squared > Tuning::kStepLimit * Tuning::kStepLimit) {
        u = u * (Tuning::kStepLimit * inverseRoot(squared));
      }
      const Vector before = axisX(iterate_[i]);
      iterate_[i] = normalizedTurned(cayley(u) * iterate_[i]);
      if (touching_) {
        if (dot(offset, offset) > Real(1e-18)) iterate_[i] = leadBack(i, iterate_[i], offset);
        for (const Record& contact : records_[i + 1])
          iterate_[i] = keepOut(i, contact, iterate_[i], offset);
      }
      // A state that was not a number: the edge goes on as the one before it.
      if (!isUnit(iterate_[i])) iterate_[i] = iterate_[i - 1];
      const Vector after = axisX(iterate_[i]);
      moved_[i + 1] = moved_[i] + after * lengths_[i];
      // The edges behind do not learn of what keeps this one out.
      dx += touching_ ? turnedBy(u, before * lengths_[i]) : (after - before) * lengths_[i];
      way += (after - axisX(start_[i])) * lengths_[i];
      if (touching_) updateContacts(i + 1, rootWay + way, dx + offset, offset, rolled);
    }
    return rolled;
  }

  /// How a rotation by u changes an edge: as cayley() does, without the rounding of a difference of
  /// tangents. That is 1e-9 m; times the penalty of contacts it would be as large as their forces.
  static Vector turnedBy(const Vector& u, const Vector& edge) {
    const Vector half = u * Real(0.5), turned = cross(half, edge);
    return (turned + cross(half, turned)) * (Real(2) / (Real(1) + dot(half, half)));
  }

  /// The frame, turned so that its tangent is `direction`.
  static Rotation turnFrame(const Rotation& frame, const Vector& direction) {
    const Vector tangent = axisX(frame);
    const Real scalar = std::max(Real(1) + dot(tangent, direction), Real(1e-4));
    return normalized(normalized(Rotation(cross(tangent, direction), scalar)) * frame);
  }

  /// Turns edge i, which starts `offset` from where the solve led, so that it ends where that
  /// leads.
  Rotation leadBack(int i, const Rotation& frame, Vector& offset) const {
    const Real size = lengths_[i];
    const Vector tangent = axisX(frame), arm = tangent * size - offset;
    if (!(dot(arm, arm) > Real(1e-6) * size * size)) return frame;
    const Rotation turned = turnFrame(frame, directionOr(arm, tangent));
    offset += (axisX(turned) - tangent) * size;
    return turned;
  }

  /// Turns edge i so that its end is in front of the plane.
  /// \param offset how far the end is from where the solve leads, in and out
  Rotation keepOut(int i, const Record& contact, const Rotation& frame, Vector& offset) const {
    const Real size = lengths_[i];
    const Vector &n = contact.normal, tangent = axisX(frame);
    const Real gap = contact.gap(moved_[i] + tangent * size), along = dot(tangent, n);
    const Vector flat = tangent - n * along;
    const Real flat2 = dot(flat, flat);
    if (!(gap < -Tuning::kContactTouch && flat2 > Real(1e-10))) return frame;
    const Real height = std::clamp(along * size - gap, -size, size);
    const Real width = squareRoot(std::max(size * size - height * height, Real(0)));
    const Vector arm = n * height + flat * (width * inverseRoot(flat2));
    const Rotation turned = turnFrame(frame, directionOr(arm, tangent));
    offset += (axisX(turned) - tangent) * size;
    return turned;
  }

  /// Takes the forces that the solve has used as those of the contacts of vertex i, which the pass
  /// has moved by `way`.
  /// \param dx from the iterate, as the solve has it
  void updateContacts(int i, const Vector& way, const Vector& dx, const Vector& offset,
                      RollOut& rolled) {
    const Vector& x = moved_[i];
    corrections_[i] = offset;
    if (records_[i].empty()) return;
    const Vector moved = worldDisplacement(x, way);
    for (Record& contact : records_[i]) {
      const Vector off = x - contact.found;
      far_ = far_ || dot(off, off) > Tuning::kContactRange * Tuning::kContactRange;
      const Real gap = contact.gap(x);
      if (!contact.active) {
        contact.normalForce = 0;
        contact.tangential = Vector();
        contact.state = Friction::kUnknown;
        if (gap < -Tuning::kContactTolerance) rolled.changed = true;
        continue;
      }
      const Real k = contactStiffness_;
      contact.normalForce = std::max(contact.normalForce - k * dot(contact.normal, dx), Real(0));
      bool changed = updateFriction(contact, contact.slip(moved), contact.tangentialPart(dx) * k);
      changed = changed || std::abs(gap) > Tuning::kContactTolerance;
      rolled.changed = rolled.changed || changed;
      // The part of the displacement that led out of the collider.
      const Real outward = dot(moved - contact.surface, contact.normal), begun = gap - outward;
      if (begun < 0 && outward > 0) corrections_[i] += contact.normal * std::min(outward, -begun);
      if (!isFinite(contact.tangential) || !(contact.normalForce < Real(1e18))) {
        contact.normalForce = 0;
        contact.tangential = Vector();
      }
    }
  }

  /// Returns whether the vertex has changed between sticking and sliding.
  /// \param stretch how far the solve has stretched the friction of a vertex that sticks
  bool updateFriction(Record& contact, const Vector& slip, const Vector& stretch) const {
    const Real most = contact.friction * contact.normalForce;
    if (contact.state == Friction::kSticks) {
      contact.tangential -= stretch;
      const Real size = reference::length(contact.tangential);
      if (!(size > most)) return false;
      contact.tangential = contact.tangential * (most / size);
      contact.state = Friction::kSlides;
      return true;
    }
    const Vector direction = directionOr(contact.tangential, Vector());
    contact.tangential = Vector();
    if (contact.state == Friction::kUnknown) return false;
    if (dot(slip, direction) > 0) {
      // It came to a stop and turned round.
      contact.state = Friction::kSticks;
      return true;
    }
    contact.tangential = directionOr(slip * Real(-1), direction) * most;
    return false;
  }

  RestStrand rest_;
  std::vector<Real> lengths_, regions_;
  Rotation rootRest_;             // frame of edge 0 in bind space
  std::vector<Rotation> joints_;  // from edge i - 1 to edge i at rest

  RootPose pose_;
  Vector3d rootVelocity_;  // of the frame before [m/s]
  double stepBefore_ = 0, frameBefore_ = 0;
  StepCoefficients coefficients_, coefficientsBefore_;  // of the last steps; he = 0 without
  std::vector<Vector> positions_;
  std::vector<Vector> ways_, waysBefore_, waysEarlier_;  // in the last steps, less the carrying
  std::vector<Rotation> frames_;
  Vector guessedWay_;  // of the tip against vertex 1 in the next step's guess

  bool carrying_ = false;
  Motion carry_;                         // of this sub-step
  Rotation carryBefore_, carryEarlier_;  // of the two before
  std::vector<Rotation> start_;          // frames_, carried
  std::vector<Rotation> guess_, iterate_;
  std::vector<Vector> halfTurns_;        // from start to guess
  std::vector<Vector> nextTurns_;        // the same of the next step, if it is as long
  std::vector<Vector> moved_, targets_;  // targets_: ways
  std::vector<Gain> gains_;
  std::vector<ContactShape<Real>> shapes_;
  std::vector<ContactRecords<Real>> records_;  // of the vertices
  std::vector<Vector> positionsBefore_;        // where the last sub-step began
  std::vector<Vector> corrections_;            // of displacements, unknown to the history
  Vector rootStep_;                            // displacement of the root in the last sub-step
  Real reach_ = 0, contactStiffness_ = 0;
  bool touching_ = false;  // there are records
  bool far_ = false;       // a vertex is far from where a contact was found
  Statistics statistics_;
};

}  // namespace pelage::reference
