#include "reference/shading/fiber_reference.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

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

double scattering(const Fiber& fiber, const Angles& at, double offset) {
  // Chiang et al. 2016, equations 7, 8 and 12.
  const double m =
      0.726 * fiber.betaM + 0.812 * std::pow(fiber.betaM, 2) + 3.7 * std::pow(fiber.betaM, 20);
  const double scale = std::sqrt(pi / 8) * (0.265 * fiber.betaN + 1.194 * std::pow(fiber.betaN, 2) +
                                            5.372 * std::pow(fiber.betaN, 22));
  const std::array<double, 4> variance = {m * m, m * m / 4, 4 * m * m, 4 * m * m};
  const std::array<double, 4> tilt = {2 * fiber.tilt, -fiber.tilt, -4 * fiber.tilt, 0};

  const double gamma = std::asin(offset);
  const double inside = std::asin(std::sin(at.eye) / fiber.ior);
  const double crossIor =
      std::sqrt(fiber.ior * fiber.ior - std::pow(std::sin(at.eye), 2)) / std::cos(at.eye);
  const double gammaInside = std::asin(offset / crossIor);
  const double reflected = fresnel(std::cos(at.eye) * std::cos(gamma), fiber.ior);
  const double through = std::exp(-fiber.absorption * 2 * std::cos(gammaInside) / std::cos(inside));

  double sum = reflected * longitudinal(variance[0], at.light, at.eye + tilt[0]) *
               azimuthal(at.azimuth - 2 * gamma, scale);
  double share = (1 - reflected) * (1 - reflected) * through;
  for (size_t p = 1; p < 3; ++p) {
    const double turn = 2 * gamma + static_cast<double>(p) * (pi - 2 * gammaInside);
    sum += share * longitudinal(variance[p], at.light, at.eye + tilt[p]) *
           azimuthal(at.azimuth - turn, scale);
    share *= through * reflected;
  }
  // All further reflections.
  return sum +
         share / (1 - through * reflected) * longitudinal(variance[3], at.light, at.eye) / (2 * pi);
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
