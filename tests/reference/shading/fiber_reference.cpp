#include "reference/shading/fiber_reference.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

namespace pelage::reference {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

/// log I0(x). std::cyl_bessel_i overflows from about 700 on; the series for large arguments
/// (Abramowitz and Stegun 9.7.1) has converged long before.
double logBessel(double x) {
  if (x < 50) return std::log(std::cyl_bessel_i(0.0, x));
  double term = 1, sum = 1;
  for (int k = 1; k < 12; ++k) {
    term *= (2.0 * k - 1) * (2.0 * k - 1) / (8.0 * x * k);
    sum += term;
  }
  return x - 0.5 * std::log(2 * pi * x) + std::log(sum);
}

/// d'Eon et al. 2011, equation 7, in logarithms.
double longitudinal(double variance, double thetaLight, double thetaEye) {
  const double a = std::abs(std::cos(thetaLight) * std::cos(thetaEye)) / variance;
  const double b = std::sin(thetaLight) * std::sin(thetaEye) / variance;
  const double inverse = 1 / variance;
  // log(2 v sinh(1 / v))
  const double norm = inverse + std::log1p(-std::exp(-2 * inverse)) + std::log(variance);
  return std::exp(logBessel(a) - b - norm);
}

/// Chiang et al. 2016, equation 11.
double azimuthal(double angle, double scale) {
  const double x = std::remainder(angle, 2 * pi);
  const auto share = [&](double y) { return 1 / (1 + std::exp(-y / scale)); };
  const double density = share(x) * share(-x) / scale;
  return density / (share(pi) - share(-pi));
}

double fresnel(double cosine, double ior) {
  const double outside = std::acos(std::clamp(cosine, 0.0, 1.0));
  const double inside = std::asin(std::sin(outside) / ior);
  const double s =
      (std::cos(outside) - ior * std::cos(inside)) / (std::cos(outside) + ior * std::cos(inside));
  const double p =
      (ior * std::cos(outside) - std::cos(inside)) / (ior * std::cos(outside) + std::cos(inside));
  return (s * s + p * p) / 2;
}

struct Angles {
  double light, eye, azimuth;
};

Angles anglesOf(const Vector3d& tangent, const Vector3d& toEye, const Vector3d& toLight) {
  const auto theta = [&](const Vector3d& v) {
    return std::asin(std::clamp(tangent.dot(v), -1.0, 1.0));
  };
  const Vector3d x = (toEye - tangent * tangent.dot(toEye)).normalized();
  const Vector3d y = tangent.cross(x);
  return {theta(toLight), theta(toEye), std::atan2(toLight.dot(y), toLight.dot(x))};
}

/// The lobes R, TT, TRT and the rest for one ray to the eye.
struct Lobes {
  double scale;  // of the logistic
  double reflected, chord;
  std::array<double, 4> variance, thetaEye, turn;
};

Lobes lobesOf(const Fiber& fiber, double thetaEye, double offset) {
  // Chiang et al. 2016, equations 7, 8 and 12.
  const double m =
      0.726 * fiber.betaM + 0.812 * std::pow(fiber.betaM, 2) + 3.7 * std::pow(fiber.betaM, 20);
  Lobes lobes;
  lobes.scale = std::sqrt(pi / 8) * (0.265 * fiber.betaN + 1.194 * std::pow(fiber.betaN, 2) +
                                     5.372 * std::pow(fiber.betaN, 22));
  lobes.variance = {m * m, m * m / 4, 4 * m * m, 4 * m * m};
  lobes.thetaEye = {thetaEye + 2 * fiber.tilt, thetaEye - fiber.tilt, thetaEye - 4 * fiber.tilt,
                    thetaEye};

  const double gamma = std::asin(offset);
  const double inside = std::asin(std::sin(thetaEye) / fiber.ior);
  const double crossIor =
      std::sqrt(fiber.ior * fiber.ior - std::pow(std::sin(thetaEye), 2)) / std::cos(thetaEye);
  const double gammaInside = std::asin(offset / crossIor);
  lobes.reflected = fresnel(std::cos(thetaEye) * std::cos(gamma), fiber.ior);
  lobes.chord = 2 * std::cos(gammaInside) / std::cos(inside);
  for (size_t p = 0; p < 3; ++p)
    lobes.turn[p] = 2 * gamma + static_cast<double>(p) * (pi - 2 * gammaInside);
  lobes.turn[3] = 0;
  return lobes;
}

/// Shares of the light in the lobes.
std::array<double, 4> sharesOf(const Lobes& lobes, double absorption) {
  const double r = lobes.reflected, through = std::exp(-absorption * lobes.chord);
  const double tt = (1 - r) * (1 - r) * through, trt = tt * through * r;
  // The last: all further reflections.
  return {r, tt, trt, trt * through * r / (1 - through * r)};
}

/// Densities of the lobes in a direction of light.
std::array<double, 4> densitiesOf(const Lobes& lobes, const Angles& at) {
  std::array<double, 4> densities;
  for (size_t p = 0; p < 4; ++p) {
    const double around = p < 3 ? azimuthal(at.azimuth - lobes.turn[p], lobes.scale) : 1 / (2 * pi);
    densities[p] = longitudinal(lobes.variance[p], at.light, lobes.thetaEye[p]) * around;
  }
  return densities;
}

double sumOf(const std::array<double, 4>& shares, const std::array<double, 4>& densities) {
  return std::inner_product(shares.begin(), shares.end(), densities.begin(), 0.0);
}

double scattering(const Fiber& fiber, const Angles& at, double offset) {
  const Lobes lobes = lobesOf(fiber, at.eye, offset);
  return sumOf(sharesOf(lobes, fiber.absorption), densitiesOf(lobes, at));
}

}  // namespace

double absorptionOf(double albedo, double betaN) {
  const double b = betaN;
  const double fit = 5.969 - 0.215 * b + 2.532 * b * b - 10.73 * std::pow(b, 3) +
                     5.574 * std::pow(b, 4) + 0.245 * std::pow(b, 5);
  return std::pow(std::log(albedo) / fit, 2);
}

double nearScattering(const Fiber& fiber, const Vector3d& tangent, const Vector3d& toEye,
                      const Vector3d& toLight, double offset) {
  return scattering(fiber, anglesOf(tangent, toEye, toLight), offset);
}

void nearScattering(const Fiber& fiber, std::span<const double> absorptions,
                    const Vector3d& tangent, const Vector3d& toEye, const Vector3d& toLight,
                    double offset, std::span<double> light) {
  const Angles at = anglesOf(tangent, toEye, toLight);
  const Lobes lobes = lobesOf(fiber, at.eye, offset);
  const std::array<double, 4> densities = densitiesOf(lobes, at);
  for (size_t i = 0; i < absorptions.size(); ++i)
    light[i] = sumOf(sharesOf(lobes, absorptions[i]), densities);
}

Vector3d sampleScattering(const Fiber& fiber, std::span<const double> absorptions,
                          const Vector3d& tangent, const Vector3d& toEye, double offset,
                          const std::array<double, 4>& random, std::span<double> weights) {
  const double thetaEye = anglesOf(tangent, toEye, toEye).eye;
  const Lobes lobes = lobesOf(fiber, thetaEye, offset);
  std::array<double, 4> light = {};
  for (size_t i = 0; i < absorptions.size(); ++i) {
    const std::array<double, 4> shares = sharesOf(lobes, absorptions[i]);
    for (size_t p = 0; p < 4; ++p) light[p] += weights[i] * shares[p];
  }
  const double all = light[0] + light[1] + light[2] + light[3];
  double left = random[0] * all;
  size_t p = 0;
  while (p < 3 && left >= light[p]) left -= light[p++];
  for (size_t i = 0; i < absorptions.size(); ++i)
    weights[i] *= sharesOf(lobes, absorptions[i])[p] * all / light[p];

  // d'Eon et al. 2011, section 4.
  const double v = lobes.variance[p];
  const double u = std::max(random[1], 1e-12);
  const double cosine = 1 + v * std::log(u + (1 - u) * std::exp(-2 / v));
  const double sine = std::sqrt(std::max(1 - cosine * cosine, 0.0));
  const double sinLight =
      std::clamp(-cosine * std::sin(lobes.thetaEye[p]) +
                     sine * std::cos(2 * pi * random[2]) * std::abs(std::cos(lobes.thetaEye[p])),
                 -1.0, 1.0);
  double azimuth = 2 * pi * random[3];
  if (p < 3) {
    const double low = 1 / (1 + std::exp(pi / lobes.scale));
    const double share = low + (1 - 2 * low) * random[3];
    azimuth = lobes.turn[p] - lobes.scale * std::log(1 / share - 1);
  }
  const Vector3d x = (toEye - tangent * tangent.dot(toEye)).normalized();
  const Vector3d y = tangent.cross(x);
  const double cosLight = std::sqrt(1 - sinLight * sinLight);
  return tangent * sinLight + (x * std::cos(azimuth) + y * std::sin(azimuth)) * cosLight;
}

double farScattering(const Fiber& fiber, const Vector3d& tangent, const Vector3d& toEye,
                     const Vector3d& toLight, int steps) {
  const Angles angles = anglesOf(tangent, toEye, toLight);
  double sum = 0;
  for (int i = 0; i < steps; ++i) {
    const double gamma = ((i + 0.5) / steps - 0.5) * pi;
    sum += scattering(fiber, angles, std::sin(gamma)) * std::cos(gamma);
  }
  return sum * pi / (2 * steps);
}

}  // namespace pelage::reference
