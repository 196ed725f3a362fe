// The exact strand solver against independent references, in single precision as on a GPU. Every
// test prints the figures that it holds the solver to: "[ FIGURE ] what: measured (at most limit)".
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "../reference/rod/exact_rod.h"
#include "../reference/rod/planar_chain.h"
#include "../reference/rod/rod_fuzz.h"
#include "../reference/rod/static_rod.h"

namespace pelage::reference {
namespace {

using std::numbers::pi;
using Motion = std::function<RootPose(double)>;
using Points = std::vector<Vector3d>;

constexpr double kFrame = 1 / 60.0;

// The two long tests run in full length in optimised builds; in others they find crashes and NaN.
#ifdef NDEBUG
constexpr int kEnergyFrames = 2000, kFuzzStrands = 3000;
#else
constexpr int kEnergyFrames = 100, kFuzzStrands = 150;
#endif

/// PELAGE_STRESS=full: every strand, as in the stress suite.
bool fullStress() {
  const char* wanted = std::getenv("PELAGE_STRESS");
  return wanted != nullptr && std::string_view(wanted) == "full";
}

void expectAtMost(const char* what, double measured, double limit) {
  std::printf("[ FIGURE ] %s: %.4g (at most %.4g)\n", what, measured, limit);
  EXPECT_LE(measured, limit) << what;
}

RootPose still(double) { return {}; }

/// Fast turns and shifts of a head; it starts smoothly from rest.
RootPose shakenHead(double time) {
  double s = std::clamp(time / 0.6, 0.0, 1.0);
  s = s * s * s * (10 - 15 * s + 6 * s * s);
  const Quaterniond turn = axisAngle(Vector3d(0, 1, 0), s * 0.8 * std::sin(2 * pi * 1.2 * time)) *
                           axisAngle(Vector3d(0, 0, 1), s * 0.3 * std::sin(2 * pi * 1.9 * time));
  const Vector3d shift(s * 0.05 * std::sin(9 * time), 0, s * 0.03 * std::sin(7 * time));
  return {turn, rotate(turn, Vector3d(0.1, 0, 0)) + shift};
}

/// Root on a circle of 0.1 m, to 720 degrees/s within 0.3 s, stopped at 1.5 s.
RootPose spun(double time) {
  const double t = std::min(time, 1.5);
  const double angle = t < 0.3 ? 4 * pi * t * t / 0.6 : 4 * pi * (t - 0.15);
  const Quaterniond turn = axisAngle(Vector3d(0, 1, 0), angle);
  return {turn, rotate(turn, Vector3d(0.1, 0, 0))};
}

/// Side to side without turning, as a head that passes over a sphere.
RootPose swayed(double time) {
  return {Quaterniond(), Vector3d(0.1 * std::sin(4 * time), 0, 0.05 * std::sin(3 * time))};
}

double largestStretch(const ExactRod<float>& rod) {
  double largest = 0;
  for (int j = 1; j + 1 < rod.size(); ++j) {
    const double size = length(Vector3d(rod.position(j + 1)) - Vector3d(rod.position(j)));
    largest = std::max(largest, std::abs(size / rod.rest().lengths[j] - 1));
  }
  return largest;
}

/// Positions of all frames; the strand settles at the motion's start first. Every frame has `parts`
/// steps, with the root where the motion has it at each of them.
template <class Real>
std::vector<Points> trajectory(const RestStrand& rest, const RodSettings& settings,
                               const Motion& motion, int settleFrames, int frames, int parts) {
  ExactRod<Real> rod(rest, motion(0));
  for (int f = 0; f < settleFrames; ++f) rod.step(kFrame, motion(0), settings);
  std::vector<Points> result;
  for (int f = 0; f < frames; ++f) {
    for (int k = 1; k <= parts; ++k) {
      const double time = (f + static_cast<double>(k) / parts) * kFrame;
      rod.step(kFrame / parts, motion(time), settings);
    }
    result.push_back(rod.positions());
  }
  return result;
}

/// Root mean square distance of all vertices in all frames, in percent of the strand's length.
double errorPercent(const std::vector<Points>& a, const std::vector<Points>& b, double size) {
  double sum = 0;
  size_t count = 0;
  for (size_t f = 0; f < a.size(); ++f) {
    for (size_t i = 0; i < a[f].size(); ++i) {
      const Vector3d d = a[f][i] - b[f][i];
      sum += dot(d, d);
      ++count;
    }
  }
  return 100 * std::sqrt(sum / static_cast<double>(count)) / size;
}

RodSettings converged() {
  RodSettings settings;
  settings.maxPasses = 4;
  settings.passTolerance = 0;
  return settings;
}

// ---- the references themselves

TEST(PlanarChain, KeepsItsEnergyWithoutDrag) {
  const RestStrand rest(straightPoints(16, 0.3, Vector3d(std::cos(1.0), -std::sin(1.0), 0)));
  PlanarChain chain(rest, 1e-4, 0, 9.81);
  const double before = chain.energy();
  for (int k = 0; k < 2000; ++k) chain.step(1 / 6000.0);
  expectAtMost("drift of the chain's energy over mgL", std::abs(chain.energy() - before) / 0.8829,
               1e-9);
}

TEST(StaticRod, BendsUnderASmallLoadAsABeamDoes) {
  StaticRod rod;
  rod.length = 0.2;
  rod.bend = rod.twist = 1;
  rod.gravity = Vector3d(0, -0.1, 0);
  rod.curls = [](double) { return Vector3d(); };
  const auto curve = rod.solve();
  ASSERT_TRUE(curve.has_value());
  // Uniformly loaded cantilever: w L^4 / (8 B).
  const double beam = 0.1 * std::pow(0.2, 4) / 8;
  EXPECT_NEAR(-curve->back().y, beam, 1e-5 * beam);
}

// ---- at rest

TEST(ExactRod, StaysInItsRestShapeWithoutGravity) {
  for (const auto& points : {straightPoints(32, 0.3, Vector3d(0.6, -0.8, 0)),
                             helixPoints(32, 0.008, 0.06, 4), helixPoints(128, 0.004, 0.02, 8)}) {
    const RestStrand rest(points);
    RodSettings settings;
    settings.gravity = Vector3d();
    settings.material.airDrag = 1;
    ExactRod<float> rod(rest, {});
    for (int f = 0; f < 600; ++f) rod.step(kFrame, {}, settings);
    double drift = 0;
    for (int i = 0; i < rod.size(); ++i) {
      drift = std::max(drift, length(Vector3d(rod.position(i)) - rest.positions[i]));
    }
    expectAtMost("drift from the rest shape in 10 s, % of L", 100 * drift / rest.length(), 1e-3);
  }
}

TEST(ExactRod, HangsAsTheElasticaDoes) {
  const double size = 0.2, bend = 9.81 * 1e-3;
  const int n = 32;
  const double edge = size / (n - 1);
  StaticRod elastica;
  elastica.length = size - edge / 2;  // the clamp is the middle of edge 0
  elastica.bend = bend;
  elastica.twist = 0.75 * bend;
  elastica.curls = [](double) { return Vector3d(); };
  elastica.origin = Vector3d(edge / 2, 0, 0);
  const auto curve = elastica.solve();
  ASSERT_TRUE(curve.has_value());
  RodSettings settings;
  settings.material = {.bend = bend, .twist = 0.75 * bend, .airDrag = 5};
  ExactRod<float> rod(RestStrand(straightPoints(n, size, Vector3d(1, 0, 0))), {});
  for (int f = 0; f < 720; ++f) rod.step(kFrame, {}, settings);
  const double error = length(Vector3d(rod.position(n - 1)) - curve->back());
  expectAtMost("elastica, tip error, % of L", 100 * error / size, 0.1);
}

/// Error of a helix that sags under its weight against the continuous rod, in percent of L.
double helixSagError(int n) {
  const double radius = 0.008, pitch = 0.03, turns = 3, bend = 1e-3, twist = 0.75e-3;
  const double rise = pitch / (2 * pi), speed = std::hypot(radius, rise);
  const double size = 2 * pi * turns * speed, clampAngle = pi * turns / (n - 1);
  StaticRod continuous;
  continuous.length = size - speed * clampAngle;
  continuous.bend = bend;
  continuous.twist = twist;
  continuous.origin = {radius * std::cos(clampAngle) - radius, -rise * clampAngle,
                       radius * std::sin(clampAngle)};
  // Frenet frame: x the tangent, y the inward normal, z the binormal.
  const double c = std::cos(clampAngle), s = std::sin(clampAngle);
  const Vector3d tangent = Vector3d(-radius * s, -rise, radius * c) * (1 / speed);
  const Quaterniond toTangent = rotationBetween(Vector3d(1, 0, 0), tangent);
  const Vector3d y = rotate(toTangent, Vector3d(0, 1, 0)), normal(-c, 0, -s);
  const double roll = std::atan2(dot(cross(y, normal), tangent), dot(y, normal));
  continuous.clamp = axisAngle(tangent, roll) * toTangent;
  const Vector3d darboux(-rise / (speed * speed) * -1, 0, radius / (speed * speed));
  continuous.curls = [darboux](double) { return darboux; };
  const auto curve = continuous.solve();
  EXPECT_TRUE(curve.has_value());
  if (!curve) return 1e9;
  RodSettings settings;
  settings.material = {.bend = bend, .twist = twist, .airDrag = 8};
  ExactRod<float> rod(RestStrand(helixPoints(n, radius, pitch, turns)), {});
  for (int f = 0; f < 1200; ++f) rod.step(kFrame, {}, settings);
  double sum = 0;
  for (int i = 2; i < n; ++i) {
    const Vector3d d = Vector3d(rod.position(i)) - pointAt(*curve, (i - 0.5) / (n - 1.5));
    sum += dot(d, d);
  }
  return 100 * std::sqrt(sum / (n - 2)) / size;
}

TEST(ExactRod, SagsAsAHelicalKirchhoffRodDoesAndConvergesInSecondOrder) {
  const double coarse = helixSagError(32), middle = helixSagError(64), fine = helixSagError(128);
  expectAtMost("helix, rms error, n = 64, % of L", middle, 0.05);
  expectAtMost("helix, 4 / (error at n = 32 over 64)", 4 * middle / coarse, 1.25);
  expectAtMost("helix, 4 / (error at n = 64 over 128)", 4 * fine / middle, 1.25);
}

TEST(ExactRod, SettlesInOneShapeAtEveryFrameRate) {
  double largest = 0, fastest = 0;
  for (const auto& points : {straightPoints(32, 0.25, Vector3d(1, 0, 0)),
                             straightPoints(32, 0.25, Vector3d(0.5, 0.866, 0)),
                             helixPoints(32, 0.008, 0.06, 4), helixPoints(48, 0.02, 0.05, 2)}) {
    const RestStrand rest(points);
    RodSettings settings;
    settings.material.airDrag = 5;
    const auto settled = [&](double rate) {
      ExactRod<float> rod(rest, {});
      for (int f = 0; f < 12 * rate; ++f) rod.step(1 / rate, {}, settings);
      for (int i = 0; rate == 60 && i < rod.size(); ++i) {
        fastest = std::max(fastest, static_cast<double>(length(rod.velocity(i))));
      }
      return rod.positions();
    };
    const Points usual = settled(60);
    for (const double rate : {15.0, 30.0, 120.0, 240.0}) {
      const Points other = settled(rate);
      for (size_t i = 0; i < usual.size(); ++i) {
        largest = std::max(largest, 100 * length(other[i] - usual[i]) / rest.length());
      }
    }
  }
  expectAtMost("speed of a settled strand at 60 Hz [m/s]", fastest, 1e-4);
  expectAtMost("settled shape at 15 to 240 Hz against 60 Hz, largest, % of L", largest, 0.05);
}

TEST(ExactRod, HangsInACatenaryWhenItsTipIsHeld) {
  const int n = 64;
  const double size = 0.3, span = 0.2, sag = std::sqrt(size * size - span * span) / 2;
  Points points;
  for (int i = 0; i < n; ++i) {
    const double s = static_cast<double>(i) / (n - 1);
    points.emplace_back(span * s, -sag * (1 - std::abs(2 * s - 1)), 0);
  }
  const RestStrand rest(points);
  RodSettings settings;
  settings.material = {.bend = 1e-8, .twist = 1e-8, .airDrag = 4};
  settings.holdTip = true;
  ExactRod<float> rod(rest, {});
  for (int f = 0; f < 1800; ++f) rod.step(kFrame, {}, settings);
  const Points x = rod.positions();
  const double held = length(x.back() - rest.positions.back());
  // y = a cosh(x / a) through vertex 1 and the tip, with the arc length between them.
  const double wide = x.back().x - x[1].x, high = x.back().y - x[1].y;
  const double arc = rest.length() - rest.lengths[0];
  double low = 1e-3, top = 1;
  for (int k = 0; k < 200; ++k) {
    const double a = (low + top) / 2;
    (2 * a * std::sinh(wide / (2 * a)) > std::sqrt(arc * arc - high * high) ? low : top) = a;
  }
  const double a = low, middle = wide / 2 - a * std::atanh(high / arc);
  double error = 0;
  for (int i = 1; i < n; ++i) {
    const double y =
        x[1].y + a * (std::cosh((x[i].x - x[1].x - middle) / a) - std::cosh(middle / a));
    error = std::max(error, std::abs(x[i].y - y));
  }
  expectAtMost("catenary, n = 64, largest error, % of L", 100 * error / size, 0.3);
  expectAtMost("held tip, distance [m]", held, 1e-3);
}

TEST(ExactRod, SettlesAtTheSameGlobalShapeAtEveryFrameRate) {
  const RestStrand rest(straightPoints(32, 0.2, Vector3d(1, 0, 0)));
  RodSettings settings;
  settings.material = {.bend = 1e-8, .twist = 1e-8, .airDrag = 5};
  settings.globalStiffness = 0.05;
  const auto tip = [&](double rate) {
    ExactRod<float> rod(rest, {});
    for (int f = 0; f < 10 * rate; ++f) rod.step(1 / rate, {}, settings);
    return Vector3d(rod.position(31));
  };
  const Vector3d usual = tip(60);
  double largest = 0;
  for (const double rate : {15.0, 30.0, 240.0}) {
    largest = std::max(largest, length(tip(rate) - usual));
  }
  expectAtMost("global shape, tip at 15 to 240 Hz against 60 Hz, % of L", 100 * largest / 0.2,
               0.05);
  // The weight of a vertex against its spring: g / k if nothing else held it, and less with the
  // rest.
  EXPECT_LT(usual.y, -0.2 * 9.81 / (0.05 / 0.95 * 3600));
}

// ---- in motion

TEST(ExactRod, SwingsAsARungeKuttaChainDoes) {
  const double angle = -60 * pi / 180;
  const RestStrand rest(straightPoints(32, 0.3, Vector3d(std::cos(angle), std::sin(angle), 0)));
  const double limits[2][3] = {{1, 0.35, 0.12}, {1, 0.35, 0.12}};
  for (int stiff = 0; stiff < 2; ++stiff) {
    RodSettings settings;
    settings.material.bend = settings.material.twist = stiff ? 1e-3 : 0;
    PlanarChain chain(rest, settings.material.bend, 0, 9.81);
    std::vector<Points> reference;
    for (int f = 0; f < 60; ++f) {
      for (int k = 0; k < 100; ++k) chain.step(kFrame / 100);
      reference.push_back(chain.positions());
    }
    for (int k = 0; k < 3; ++k) {
      const auto moved = trajectory<float>(rest, settings, still, 0, 60, 1 << k);
      char what[80];
      std::snprintf(what, sizeof what, "%s swing of 1 s, %d sub-steps, rms error, %% of L",
                    stiff ? "stiff" : "limp", 1 << k);
      expectAtMost(what, errorPercent(moved, reference, 0.3), limits[stiff][k]);
    }
  }
}

TEST(ExactRod, FollowsAHeadWithACurlAsItselfInDoubleDoesAtManySubSteps) {
  const RestStrand rest(helixPoints(32, 0.008, 0.06, 4));
  const RodMaterial material = {.bend = 1e-3, .twist = 1e-3, .airDrag = 3};
  RodSettings exact = converged(), settings;
  exact.material = settings.material = material;
  const auto reference = trajectory<double>(rest, exact, shakenHead, 400, 120, 128);
  const double limits[4] = {3, 1.6, 0.7, 0.3};
  for (int k = 0; k < 4; ++k) {
    settings.subSteps = 1 << k;
    const auto moved = trajectory<float>(rest, settings, shakenHead, 400, 120, 1);
    char what[80];
    std::snprintf(what, sizeof what, "curl with head motion, %d sub-steps, rms error, %% of L",
                  1 << k);
    expectAtMost(what, errorPercent(moved, reference, rest.length()), limits[k]);
  }
}

TEST(ExactRod, NeedsOnePassForACurlInAirThatFollowsAHead) {
  const double drag = -60 * std::log(0.96);
  long passes = 0, steps = 0;
  const Points curls[2] = {helixPoints(32, 0.008, 0.06, 4), helixPoints(32, 0.012, 0.12, 4)};
  const double limits[2] = {3.7, 1.35};
  for (int k = 0; k < 2; ++k) {
    const RestStrand rest(curls[k]);
    RodSettings exact = converged(), settings;
    exact.material = settings.material = {.bend = 1e-3, .twist = 0.75e-3, .airDrag = drag};
    settings.passTolerance = RodTuning<float>::passTolerance(kFrame, drag);
    const auto reference = trajectory<double>(rest, exact, shakenHead, 400, 120, 64);
    ExactRod<float> rod(rest, shakenHead(0));
    for (int f = 0; f < 400; ++f) rod.step(kFrame, shakenHead(0), settings);
    std::vector<Points> moved;
    for (int f = 1; f <= 120; ++f) {
      rod.step(kFrame, shakenHead(f * kFrame), settings);
      moved.push_back(rod.positions());
    }
    passes += rod.statistics().passes;
    steps += rod.statistics().steps;
    expectAtMost("curl in air with head motion, one pass, rms error, % of L",
                 errorPercent(moved, reference, rest.length()), limits[k]);
  }
  expectAtMost("its mean Newton passes", static_cast<double>(passes) / static_cast<double>(steps),
               1.01);
}

TEST(ExactRod, SpinsAsItselfInDoubleDoesAtManySubSteps) {
  const RestStrand rest(straightPoints(32, 0.3, Vector3d(0.3, -0.9539, 0)));
  RodSettings exact = converged(), settings;
  exact.material = settings.material = {.bend = 1e-3, .twist = 0.75e-3, .airDrag = 2};
  const auto reference = trajectory<double>(rest, exact, spun, 0, 90, 64);
  const double limits[3] = {12, 4, 1.5};
  for (int k = 0; k < 3; ++k) {
    const auto moved = trajectory<float>(rest, settings, spun, 0, 90, 1 << k);
    char what[80];
    std::snprintf(what, sizeof what, "spin of 720 degrees/s, %d sub-steps, rms error, %% of L",
                  1 << k);
    expectAtMost(what, errorPercent(moved, reference, 0.3), limits[k]);
  }
}

TEST(ExactRod, SwingsWithThePeriodOfARungeKuttaChain) {
  const double angle = -85 * pi / 180;
  const RestStrand rest(straightPoints(32, 0.3, Vector3d(std::cos(angle), std::sin(angle), 0)));
  // Mean time between the tip's crossings of the vertical through vertex 1.
  const auto periodOf = [](const std::function<double()>& nextOffset) {
    double before = nextOffset(), first = 0, last = 0;
    int crossings = 0;
    for (int f = 2; f <= 600; ++f) {
      const double offset = nextOffset();
      if (before * offset < 0) {
        last = (f - 1 + before / (before - offset)) * kFrame;
        if (crossings++ == 0) first = last;
      }
      before = offset;
    }
    return 2 * (last - first) / (crossings - 1);
  };
  PlanarChain chain(rest, 0, 0, 9.81);
  const double truth = periodOf([&] {
    for (int k = 0; k < 50; ++k) chain.step(kFrame / 50);
    const Points x = chain.positions();
    return x[31].x - x[1].x;
  });
  RodSettings settings;
  settings.material.bend = settings.material.twist = 1e-9;
  ExactRod<float> rod(rest, {});
  const double period = periodOf([&] {
    rod.step(kFrame, {}, settings);
    return static_cast<double>(rod.position(31).x - rod.position(1).x);
  });
  // 2 pi / (1.2024 sqrt(g / L)): the first zero of the Bessel function J0, over two.
  EXPECT_NEAR(truth, 2 * pi / (1.20241 * std::sqrt(9.81 / (0.3 * 30 / 31))), 0.01 * truth);
  expectAtMost("period of a limp strand, error in %", 100 * std::abs(period / truth - 1), 1);
}

TEST(ExactRod, LosesItsSwingAtTheSameRateAtEveryFrameRate) {
  const RestStrand rest(straightPoints(32, 0.3, Vector3d(1, 0, 0)));
  RodSettings settings;
  settings.material = {.bend = 1e-6, .twist = 1e-6, .airDrag = -60 * std::log(0.92)};
  // Largest angle from the vertical after 1 s, between two turning points.
  const auto amplitude = [&](double rate) {
    ExactRod<float> rod(rest, {});
    double largest = 0;
    for (int f = 1; f <= 1.6 * rate; ++f) {
      rod.step(1 / rate, {}, settings);
      const Vector3d arm = Vector3d(rod.position(31)) - Vector3d(rod.position(1));
      if (f >= rate) largest = std::max(largest, std::abs(std::atan2(arm.x, -arm.y)));
    }
    return largest * 180 / pi;
  };
  const double usual = amplitude(60);
  for (const double rate : {30.0, 120.0, 240.0}) {
    char what[80];
    std::snprintf(what, sizeof what, "swing after 1 s at %.0f Hz against %.2f degrees at 60 Hz, %%",
                  rate, usual);
    expectAtMost(what, 100 * std::abs(amplitude(rate) / usual - 1), 10);
  }
}

TEST(ExactRod, DampsBendingAsAKelvinVoigtRodDoes) {
  const double size = 0.1, bend = 1e-2, rate = 960;
  const RestStrand rest(straightPoints(32, size, Vector3d(1, 0, 0)));
  for (const double tau : {0.002, 0.005}) {
    RodSettings settings;
    settings.material = {.bend = bend, .twist = 0.75 * bend, .airDrag = 50, .relaxation = tau};
    settings.gravity = Vector3d(0, -1, 0);
    ExactRod<double> rod(rest, {});
    for (int f = 0; f < 2 * rate; ++f) rod.step(1 / rate, {}, settings);
    settings.gravity = Vector3d();
    settings.material.airDrag = 0;
    std::vector<double> peaks;
    double before = 0, earlier = 0;
    for (int f = 0; f < 1.2 * rate; ++f) {
      rod.step(1 / rate, {}, settings);
      const double height = std::abs(rod.position(31).y);
      if (before > earlier && before > height) peaks.push_back(before);
      earlier = before;
      before = height;
    }
    ASSERT_GT(peaks.size(), 4u);
    const double ratio = std::log(peaks[0] / peaks[4]) / (4 * pi);
    // First mode of a cantilever, clamped in the middle of edge 0; damping ratio omega tau / 2.
    const double free = size * (1 - 0.5 / 31);
    const double theory = 3.516 * std::sqrt(bend) / (free * free) * tau / 2;
    expectAtMost("Kelvin-Voigt damping ratio, error in %", 100 * std::abs(ratio / theory - 1), 5);
  }
}

TEST(ExactRod, MovesWithItsRootWhenTheRootIsTeleported) {
  const RestStrand rest(straightPoints(32, 0.3, Vector3d(0.3, -0.9539, 0)));
  const auto fastestAfter = [&](double threshold, int subSteps) {
    RodSettings settings;
    settings.material = {.bend = 1e-3, .twist = 0.75e-3, .airDrag = 2};
    settings.carryThreshold = threshold;
    settings.subSteps = subSteps;
    ExactRod<float> rod(rest, {});
    double fastest = 0;
    for (int f = 1; f <= 200; ++f) {
      const RootPose away = {axisAngle(Vector3d(0, 1, 0), 2.0), Vector3d(1, 0, 0)};
      rod.step(kFrame, f > 30 ? away : RootPose(), settings);
      for (int i = 2; f > 31 && i < 32; ++i) {
        fastest = std::max(fastest, static_cast<double>(length(rod.velocity(i))));
      }
    }
    return fastest;
  };
  const double never = std::numeric_limits<double>::infinity();
  EXPECT_GT(fastestAfter(never, 1), 5);
  expectAtMost("speed after a teleport of 1 m and 115 degrees [m/s]", fastestAfter(200, 1), 0.5);
  expectAtMost("the same with 4 sub-steps [m/s]", fastestAfter(200, 4), 0.5);
}

TEST(ExactRod, SubStepsAStepAsTheCallerWouldWithInterpolatedPoses) {
  const RestStrand rest(helixPoints(24, 0.01, 0.05, 2));
  RodSettings whole, part;
  whole.subSteps = 3;
  ExactRod<float> a(rest, shakenHead(0)), b(rest, shakenHead(0));
  for (int f = 1; f <= 60; ++f) {
    const RootPose from = shakenHead((f - 1) * kFrame), to = shakenHead(f * kFrame);
    a.step(kFrame, to, whole);
    for (int k = 1; k <= 3; ++k) {
      const RootPose pose = k == 3 ? to : interpolatePoses(from, to, k / 3.0, rest.positions[0]);
      b.step(kFrame / 3, pose, part);
    }
  }
  // Not bit by bit: the caller's poses have another rounding.
  for (int i = 0; i < 24; ++i) EXPECT_LT(length(a.position(i) - b.position(i)), 1e-5) << i;
}

TEST(ExactRod, IsAsGoodAsNewAfterAReset) {
  const RestStrand rest(helixPoints(24, 0.01, 0.05, 2));
  const RodSettings settings;
  ExactRod<float> used(rest, {}), fresh(rest, shakenHead(1));
  for (int f = 0; f < 30; ++f) used.step(kFrame, shakenHead(f * kFrame), settings);
  used.reset(shakenHead(1));
  for (int f = 0; f < 30; ++f) {
    used.step(kFrame, shakenHead(1 + f * kFrame), settings);
    fresh.step(kFrame, shakenHead(1 + f * kFrame), settings);
  }
  for (int i = 0; i < 24; ++i) EXPECT_EQ(length(used.position(i) - fresh.position(i)), 0) << i;
}

TEST(ExactRod, OfTwoVerticesFollowsItsRoot) {
  const RestStrand rest(straightPoints(2, 0.05, Vector3d(0, -1, 0)));
  ExactRod<float> rod(rest, shakenHead(0));
  for (int f = 1; f <= 100; ++f) rod.step(kFrame, shakenHead(f * kFrame), {});
  const RootPose pose = shakenHead(100 * kFrame);
  for (int i = 0; i < 2; ++i) {
    EXPECT_LT(length(Vector3d(rod.position(i)) - pose.apply(rest.positions[i])), 1e-7);
  }
}

// ---- what must never happen

TEST(ExactRod, KeepsEverySegmentsLength) {
  double largest = 0;
  for (const int n : {3, 4, 8, 16, 32, 64, 128}) {
    for (const auto& points :
         {straightPoints(n, 0.3, Vector3d(0.3, -0.9539, 0)), helixPoints(n, 0.008, 0.06, 4)}) {
      RodSettings settings;
      settings.material.airDrag = 2;
      ExactRod<float> rod(RestStrand(points), shakenHead(0));
      for (int f = 1; f <= 300; ++f) {
        rod.step(kFrame, shakenHead(f * kFrame), settings);
        largest = std::max(largest, largestStretch(rod));
      }
    }
  }
  expectAtMost("largest stretch, n = 3 to 128, head motion, %", 100 * largest, 1e-3);
}

TEST(ExactRod, NeverGainsEnergyWithoutDamping) {
  double worst = 0;
  long passes = 0, steps = 0, count = 0;
  for (const int n : {4, 8, 16, 32, 64, 128}) {
    // Three quarters of the time go to the two largest: the ends of the range will do for them.
    const std::vector<double> rates =
        n > 32 && !fullStress() ? std::vector{30., 240.} : std::vector{30., 60., 120., 240.};
    const Points strands[4] = {straightPoints(n, 0.25, Vector3d(1, 0, 0)),
                               helixPoints(n, 0.008, 0.2, 1), helixPoints(n, 0.008, 0.05, 4),
                               helixPoints(n, 0.004, 0.02, 8)};
    for (int curl = 0; curl < 4; ++curl) {
      const RestStrand rest(strands[curl]);
      for (const double bend : {0., 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1.}) {
        for (const double rate : rates) {
          ++count;
          RodSettings settings;
          settings.material = {.bend = bend, .twist = 0.75 * bend};
          if (curl > 0) settings.gravity = Vector3d(9.81, 0, 0);
          ExactRod<float> rod(rest, {});
          const double before = rod.energy(settings), scale = 9.81 * rest.length() * rest.length();
          double most = before;
          for (int f = 0; f < kEnergyFrames; ++f) {
            rod.step(1 / rate, {}, settings);
            if (f % 4 == 3) most = std::max(most, rod.energy(settings));
          }
          ASSERT_TRUE(std::isfinite(most));
          worst = std::max(worst, 100 * (most - before) / scale);
          passes += rod.statistics().passes;
          steps += rod.statistics().steps;
        }
      }
    }
  }
  const std::string what =
      "growth of energy, " + std::to_string(count) + " undamped strands, % of mgL";
  expectAtMost(what.c_str(), worst, 1);
  // The start of a whip takes more passes than its course: a short run has a limit of its own.
  const double mostPasses = kEnergyFrames < 2000 ? 1.7 : 1.3;
  expectAtMost("mean Newton passes", static_cast<double>(passes) / static_cast<double>(steps),
               mostPasses);
}

TEST(ExactRod, NeverGainsEnergyWithDragAndTheToleranceThatGoesWithIt) {
  double worst = -1e9;
  long passes = 0, steps = 0;
  for (const double drag : {0.3, 1.0, 3.0}) {
    for (const double bend : {1e-6, 1e-4, 1e-2}) {
      for (const Points& points :
           {straightPoints(24, 0.25, Vector3d(1, 0, 0)),
            straightPoints(64, 0.25, Vector3d(0.3, 0.9539, 0)), helixPoints(32, 0.008, 0.05, 4)}) {
        const RestStrand rest(points);
        RodSettings settings;
        settings.material = {.bend = bend, .twist = 0.75 * bend, .airDrag = drag};
        settings.passTolerance = RodTuning<float>::passTolerance(kFrame, drag);
        ExactRod<float> rod(rest, {});
        const double before = rod.energy(settings), scale = 9.81 * rest.length() * rest.length();
        for (int f = 0; f < kEnergyFrames / 4; ++f) {
          rod.step(kFrame, {}, settings);
          worst = std::max(worst, 100 * (rod.energy(settings) - before) / scale);
        }
        passes += rod.statistics().passes;
        steps += rod.statistics().steps;
      }
    }
  }
  expectAtMost("growth of energy with drag, % of mgL", worst, 0.05);
  const double mostPasses = kEnergyFrames < 2000 ? 1.7 : 1.3;  // as above
  expectAtMost("mean Newton passes with drag",
               static_cast<double>(passes) / static_cast<double>(steps), mostPasses);
}

TEST(ExactRod, NeverGainsEnergyInTenThousandFrames) {
  const RestStrand rest(straightPoints(32, 0.3, Vector3d(1, 0, 0)));
  RodSettings settings;
  ExactRod<float> rod(rest, {});
  const double before = rod.energy(settings);
  double most = -1e30;
  for (int f = 0; f < 10000; ++f) {
    rod.step(kFrame, {}, settings);
    most = std::max(most, rod.energy(settings));
  }
  expectAtMost("growth of energy in 10,000 frames, % of mgL", 100 * (most - before) / 0.8829, 0);
}

TEST(ExactRod, SurvivesEverythingThatAFileOrAnAnimationCanHold) {
  const int strands = kFuzzStrands, frames = 90;
  int broken = 0, stretched = 0;
  double largest = 0;
  for (int seed = 0; seed < strands; ++seed) {
    const FuzzCase test = makeFuzzCase(static_cast<uint32_t>(seed), frames);
    RodSettings settings = test.settings;
    settings.colliders = test.colliders;
    const RestStrand rest(test.points);
    ExactRod<float> rod(rest, test.poses[0]);
    double worst = 0;
    bool finite = true;
    for (int f = 0; f < frames && finite; ++f) {
      rod.step(test.steps[f], test.poses[f + 1], settings);
      double extent = 0;
      for (int i = 0; i < rod.size(); ++i) {
        const Vector3d x(rod.position(i));
        finite = finite && isFinite(x) && isFinite(rod.velocity(i));
        extent = std::max({extent, std::abs(x.x), std::abs(x.y), std::abs(x.z)});
      }
      for (int j = 1; j + 1 < rod.size(); ++j) {
        const double size = length(Vector3d(rod.position(j + 1)) - Vector3d(rod.position(j)));
        // Coordinates of this extent are 2e-7 extent apart at most: a hundredth of this allowance.
        const double allowed = rest.lengths[j] + extent * 2e-5 + 1e-9;
        worst = std::max(worst, std::abs(size - rest.lengths[j]) / allowed);
      }
    }
    if (!finite) {
      ++broken;
      ADD_FAILURE() << "seed " << seed << " is not finite";
    }
    if (worst > 0.01) ++stretched;
    largest = std::max(largest, worst);
  }
  expectAtMost("fuzzed strands with a NaN", broken, 0);
  expectAtMost("fuzzed strands stretched by more than 1 %", stretched, 0);
  expectAtMost("largest stretch, %", 100 * largest, 1);
}

// ---- contact

double deepestPenetration(const RodCollider& shape, double bend) {
  RodSettings settings;
  settings.material = {.bend = bend, .twist = 0.75 * bend, .airDrag = 2};
  settings.colliders = {&shape, 1};
  ExactRod<float> rod(RestStrand(straightPoints(32, 0.3, Vector3d(0.3, -0.9539, 0))), swayed(0));
  const ContactShape<double> surface(shape, 0, 1);
  double deepest = 0;
  for (int f = 1; f <= 1200; ++f) {
    rod.step(kFrame, swayed(f * kFrame), settings);
    for (int i = 2; f > 120 && i < 32; ++i) {
      deepest = std::max(deepest, findContact(surface, Vector3d(rod.position(i))).penetration);
    }
  }
  return deepest;
}

TEST(ExactRod, StaysOutOfASphere) {
  const RodCollider sphere = RodCollider::sphere(Vector3d(0.02, -0.2, 0), 0.08);
  expectAtMost("penetration of a sphere, B = 1e-3 [mm]", 1e3 * deepestPenetration(sphere, 1e-3),
               0.05);
  expectAtMost("penetration of a sphere, B = 1e-6 [mm]", 1e3 * deepestPenetration(sphere, 1e-6), 1);
}

TEST(ExactRod, StaysOutOfATaperedCapsule) {
  RodCollider capsule = RodCollider::sphere(Vector3d(-0.08, -0.18, 0), 0.06);
  capsule.tail = capsule.tailBefore = Vector3d(0.12, -0.22, 0.02);
  capsule.tailRadius = 0.09;
  expectAtMost("penetration of a tapered capsule, B = 1e-3 [mm]",
               1e3 * deepestPenetration(capsule, 1e-3), 0.05);
}

TEST(RodContact, FindsTheDistanceToATaperedCapsule) {
  RodCollider capsule = RodCollider::sphere(Vector3d(0, 0, 0), 0.3);
  capsule.tail = Vector3d(1, 0, 0);
  capsule.tailRadius = 0.1;
  const ContactShape<double> shape(capsule, 0, 1);
  for (int k = 0; k < 200; ++k) {
    const Vector3d p(-0.6 + 0.01 * k, 0.35 + 0.1 * std::sin(k), 0.2 * std::cos(3 * k));
    double nearest = 1e9;
    for (int j = 0; j <= 20000; ++j) {
      const double t = j / 20000.0;
      nearest = std::min(nearest, length(p - Vector3d(t, 0, 0)) - (0.3 - 0.2 * t));
    }
    EXPECT_NEAR(-findContact(shape, p).penetration, nearest, 1e-8) << k;
  }
}

/// A limp strand lies on a large sphere that slides away sideways; how far the tip went with it, as
/// a share of the sphere's way.
double carriedBySlidingSphere(double friction) {
  RodCollider sphere = RodCollider::sphere(Vector3d(0.15, -1.001, 0), 1.0, friction);
  RodSettings settings;
  settings.material = {.bend = 1e-6, .twist = 1e-6, .airDrag = 1};
  settings.colliders = {&sphere, 1};
  ExactRod<float> rod(RestStrand(straightPoints(32, 0.2, Vector3d(1, 0, 0))), {});
  for (int f = 0; f < 120; ++f) rod.step(kFrame, {}, settings);
  const double before = rod.position(31).z;
  const double way = 0.04, frames = 60;
  for (int f = 0; f < frames; ++f) {
    sphere.headBefore = sphere.tailBefore = sphere.head;
    sphere.head.z += way / frames;
    sphere.tail = sphere.head;
    rod.step(kFrame, {}, settings);
  }
  return (rod.position(31).z - before) / way;
}

TEST(ExactRod, IsDraggedAlongByAColliderWithFriction) {
  const double smooth = carriedBySlidingSphere(0), rough = carriedBySlidingSphere(0.8);
  std::printf("[ FIGURE ] carried along: %.3f without friction, %.3f with 0.8\n", smooth, rough);
  // Without friction it is left behind, and slides down on the other side.
  // How far depends on how it folds up before, which a rounding decides.
  EXPECT_LT(smooth, 0.4);
  EXPECT_GT(rough, 0.7);
  EXPECT_LT(rough, 1.05);
}

}  // namespace
}  // namespace pelage::reference
