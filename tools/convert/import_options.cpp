#include "import_options.h"

#include <CLI/CLI.hpp>
#include <string>

namespace pelage::convert {

void addAxisOptions(CLI::App& command, const char* of, float& scale, UpAxis& upAxis,
                    bool& invertZ) {
  const std::string what(of);
  command.add_option("--scale", scale, "Metres a unit of " + what)->capture_default_str();
  command
      .add_option_function<std::string>(
          "--up-axis",
          [&upAxis](const std::string& axis) {
            upAxis = axis == "x" ? UpAxis::kX : axis == "y" ? UpAxis::kY : UpAxis::kZ;
          },
          "Axis of " + what + " that points up: x, y or z (y)")
      ->check(CLI::IsMember({"x", "y", "z"}))
      ->type_name("AXIS");
  command.add_flag("--invert-z", invertZ, "Mirror z of " + what + ", after the turn");
}

const char* toString(UpAxis axis) {
  return axis == UpAxis::kX ? "x" : axis == UpAxis::kY ? "y" : "z";
}

CLI::Validator isAboveZero() {
  return CLI::Validator(
      [](const std::string& text) {
        double value = 0;
        const bool good = CLI::detail::lexical_cast(text, value) && value > 0;  // false for NaN
        return good ? std::string() : "'" + text + "' must be a number above 0";
      },
      "");
}

CLI::Validator isNotNegative() {
  return CLI::Validator(
      [](const std::string& text) {
        return text.starts_with('-') ? "'" + text + "' must not be negative" : std::string();
      },
      "");
}

}  // namespace pelage::convert
