#include "pelage/settings/parameter.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <optional>

#include "pelage/assert.h"

namespace pelage {
namespace {

std::string rangeText(const Parameter& parameter) {
  if (parameter.isPowerOfTwo)
    return fmt::format("a power of two in {}..{}", parameter.low, parameter.high);
  const bool hasLow = std::isfinite(parameter.low), hasHigh = std::isfinite(parameter.high);
  if (!hasLow) return hasHigh ? fmt::format("at most {}", parameter.high) : "finite";
  // As the header has it, not as a double shows a float.
  const auto low = static_cast<float>(parameter.low), high = static_cast<float>(parameter.high);
  if (parameter.lowIsOpen) return fmt::format("above {}", low);
  if (!hasHigh) return fmt::format("at least {}", low);
  if (parameter.type == ParameterType::kCount)
    return fmt::format("in {:.0f}..{:.0f}", parameter.low, parameter.high);
  return fmt::format("in {}..{}", low, high);
}

Error outOfRange(const Parameter& parameter, std::string_view name, std::string_view value) {
  return {ErrorCode::kInvalidArgument,
          fmt::format("'{}' is {}, but must be {}", name, value, rangeText(parameter))};
}

// Returns the error of one number of a value.
std::optional<Error> wrong(const Parameter& parameter, float value, std::string_view name) {
  if (std::isnan(value)) return outOfRange(parameter, name, "not a number");
  if (std::isinf(value)) {
    if (value > 0 && parameter.takesInfinity) return std::nullopt;
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("'{}' is infinite, but must be {}", name, rangeText(parameter))};
  }
  const bool low = parameter.lowIsOpen ? !(value > parameter.low) : !(value >= parameter.low);
  if (low || !(value <= parameter.high))
    return outOfRange(parameter, name, fmt::format("{}", value));
  return std::nullopt;
}

std::optional<Error> wrong(const Parameter& parameter, uint64_t value, std::string_view name) {
  if (parameter.type == ParameterType::kChoice) {
    if (value < parameter.choices.size()) return std::nullopt;
    std::string names;
    for (const std::string_view choice : parameter.choices)
      names += fmt::format("{}{}", names.empty() ? "" : ", ", choice);
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("'{}' is {}, but must be one of {}", name, value, names)};
  }
  const auto number = static_cast<double>(value);
  if (number >= parameter.low && number <= parameter.high &&
      (!parameter.isPowerOfTwo || std::has_single_bit(value)))
    return std::nullopt;
  return outOfRange(parameter, name, fmt::format("{}", value));
}

std::optional<Error> wrong(const Parameter&, bool, std::string_view) { return std::nullopt; }

std::optional<Error> wrong(const Parameter& parameter, const Float3& value, std::string_view name) {
  for (const float number : {value.x, value.y, value.z})
    if (auto error = wrong(parameter, number, name)) return error;
  if (!parameter.takesZero && value == Float3{})
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("'{}' is (0, 0, 0), but must have a length above 0", name)};
  return std::nullopt;
}

std::optional<Error> wrong(const Parameter& parameter, const ParameterCurve& value,
                           std::string_view name) {
  for (const float number : value)
    if (auto error = wrong(parameter, number, name)) return error;
  return std::nullopt;
}

bool isOfType(const Parameter& parameter, const ParameterValue& value) {
  return value.index() == parameter.defaultValue.index();
}

bool sameBits(bool a, bool b) { return a == b; }
bool sameBits(uint64_t a, uint64_t b) { return a == b; }
bool sameBits(float a, float b) { return std::bit_cast<uint32_t>(a) == std::bit_cast<uint32_t>(b); }
bool sameBits(const Float3& a, const Float3& b) {
  return sameBits(a.x, b.x) && sameBits(a.y, b.y) && sameBits(a.z, b.z);
}
bool sameBits(const ParameterCurve& a, const ParameterCurve& b) {
  return std::equal(a.begin(), a.end(), b.begin(), [](float x, float y) { return sameBits(x, y); });
}

}  // namespace

Result<void> check(const Parameter& parameter, const ParameterValue& value, std::string_view name) {
  PELAGE_ASSERT(isOfType(parameter, value), "the value has another type than the parameter");
  if (name.empty()) name = parameter.path;
  const std::optional<Error> error =
      std::visit([&](const auto& of) { return wrong(parameter, of, name); }, value);
  if (error) return *error;
  return {};
}

bool haveSameBits(const ParameterValue& a, const ParameterValue& b) {
  if (a.index() != b.index()) return false;
  return std::visit(
      [&](const auto& of) { return sameBits(of, std::get<std::decay_t<decltype(of)>>(b)); }, a);
}

std::string plainText(std::string_view markdown) {
  std::string text;
  for (size_t i = 0; i < markdown.size(); ++i) {
    const char c = markdown[i];
    if (c == '`' || c == '*' || c == '[') continue;
    // A link's target.
    if (c == ']' && i + 1 < markdown.size() && markdown[i + 1] == '(') {
      const size_t end = markdown.find(')', i);
      i = end == std::string_view::npos ? markdown.size() : end;
      continue;
    }
    text += c;
  }
  return text;
}

std::string pictureFile(const Parameter& parameter) {
  return fmt::format("{}.{}.png", parameter.owner, parameter.field);
}

std::string choiceName(std::string_view constant) {
  std::string name(constant.substr(constant.starts_with('k') ? 1 : 0));
  if (!name.empty()) name[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(name[0])));
  return name;
}

}  // namespace pelage
