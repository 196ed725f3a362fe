// All parameters as a table: an editor draws its widgets from it, files of settings are read and
// written by it, and docs/parameters.md has its texts.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "pelage/result.h"
#include "pelage/simulation_settings.h"
#include "pelage/types.h"

namespace pelage {

enum class ParameterType : uint8_t {
  kBool,
  kCount,  ///< a whole number of at least 0
  kFloat,
  kVector,  ///< three numbers
  kColor,   ///< linear RGB
  kCurve,   ///< eight factors along the strand
  kChoice,  ///< one of Parameter::choices
};

/// A value of any parameter: bool; uint64_t of counts, and of choices the index of one; float;
/// Float3 of vectors and colors; ParameterCurve.
using ParameterValue = std::variant<bool, uint64_t, float, Float3, ParameterCurve>;

/// How a slider goes from its low end to its high end.
enum class ParameterScale : uint8_t { kLinear, kLog };

/// A member of a struct of settings. The texts live as long as the program.
struct Parameter {
  std::string_view owner;  ///< struct or class of the public headers: "WindSettings"
  std::string_view field;  ///< its member: "velocity"
  /// Member of the struct that get() and set() take, with a point between a struct and its own:
  /// "wind.velocity". It is the name in files.
  std::string_view path;
  ParameterType type = ParameterType::kFloat;
  std::string_view unit;     ///< empty without one
  std::string_view range;    ///< in words: "0..1"; empty where all values are valid
  std::string_view meaning;  ///< a sentence or two of Markdown: plainText()
  std::string_view solver;   ///< "exact" or "classic" if only one of them uses it, else empty
  /// docs/images/parameters has a picture of it: pictureFile().
  bool hasPicture = false;
  /// kChoice: names of the constants in the order of their values: "kExact".
  std::span<const std::string_view> choices;

  /// Each number is within low..high, and finite; an end without a limit is infinite.
  double low = 0, high = 0;
  bool lowIsOpen = false;      ///< `low` itself is out of range
  bool takesInfinity = false;  ///< +infinity is valid, too; files have it as "infinity"
  bool takesZero = true;       ///< kVector: (0, 0, 0) is valid
  bool isPowerOfTwo = false;   ///< kCount: other numbers are out of range

  /// Ends of a slider, within low..high: where values are of use. A low end of 0 of a logarithmic
  /// one stands for 0 itself.
  double sliderLow = 0, sliderHigh = 0;
  ParameterScale scale = ParameterScale::kLinear;

  /// As the struct has it when it is made.
  ParameterValue defaultValue;
  /// Reads the member of a struct: of the type in whose parametersOf() this is.
  ParameterValue (*get)(const void* object) = nullptr;
  /// Writes it, whether or not it is within its range. Asserts that the value has the parameter's
  /// type, and that the member can hold it.
  void (*set)(void* object, const ParameterValue& value) = nullptr;
};

/// Checks a value. Error: "'damping' is 2, but must be in 0..1", with this name. Asserts that the
/// value has the parameter's type. \param name empty takes Parameter::path.
Result<void> check(const Parameter& parameter, const ParameterValue& value,
                   std::string_view name = {});

/// Whether two values have the same bits: NaN equals itself, and 0 is not -0.
bool haveSameBits(const ParameterValue& a, const ParameterValue& b);

/// A text of the table without its Markdown: no links, no code marks.
std::string plainText(std::string_view markdown);

/// The file of a parameter's picture in docs/images/parameters: "SleepSettings.speed.png".
std::string pictureFile(const Parameter& parameter);

/// A choice as files have it: "exact" for kExact.
std::string choiceName(std::string_view constant);

}  // namespace pelage
