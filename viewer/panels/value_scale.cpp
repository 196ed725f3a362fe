#include "value_scale.h"

#include <algorithm>
#include <cmath>

namespace viewer {
namespace {

// A logarithmic slider from 0 has this share of its high end beside 0.
constexpr double kSmallestShare = 1e-4;

double logLow(const pelage::Parameter& parameter) {
  if (parameter.sliderLow > 0) return parameter.sliderLow;
  const double low = kSmallestShare * parameter.sliderHigh;
  return parameter.type == pelage::ParameterType::kCount ? std::max(low, 1.0) : low;
}

double rounded(double value) {
  if (value == 0) return 0;
  const double unit = std::pow(10, std::floor(std::log10(std::abs(value))) - 2);
  return unit < 1 ? std::round(value / unit) / (1 / unit) : std::round(value / unit) * unit;
}

}  // namespace

double shareOf(const pelage::Parameter& parameter, double value) {
  const double low = parameter.sliderLow, high = parameter.sliderHigh;
  if (!(value > low)) return 0;
  if (!(value < high)) return 1;
  if (parameter.scale == pelage::ParameterScale::kLinear) return (value - low) / (high - low);
  const double least = logLow(parameter);
  return std::clamp(std::log(value / least) / std::log(high / least), 0.0, 1.0);
}

double valueAtShare(const pelage::Parameter& parameter, double share) {
  const double low = parameter.sliderLow, high = parameter.sliderHigh;
  if (!(share > 0)) return low;
  if (!(share < 1)) return high;
  double value = low + (high - low) * share;
  if (parameter.scale == pelage::ParameterScale::kLog) {
    const double least = logLow(parameter);
    value = least * std::pow(high / least, share);
  }
  value = parameter.type == pelage::ParameterType::kCount ? std::round(value) : rounded(value);
  return std::clamp(value, low, high);
}

}  // namespace viewer
