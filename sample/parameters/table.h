// Every parameter of a scene that a program sets: one table, from which the list, the page and the
// pictures are made.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "setup.h"

namespace sample {

/// Pictures of one parameter, side by side.
struct Picture {
  std::vector<std::string> values;  ///< from left to right
  std::function<Setup(size_t index)> make;
  std::string caption;  ///< what there is to see
};

struct Parameter {
  std::string owner;  ///< the struct or class
  std::string field;
  std::string defaultText;  ///< from the struct itself
  std::string unit;         ///< empty where it has none
  std::string range;        ///< empty where all values are good
  std::string meaning;
  std::optional<Picture> picture;
  std::string solver = {};  ///< that uses it alone: "exact" or "classic"
};

/// The fields of one struct.
struct ParameterGroup {
  std::string owner;
  std::string header;  ///< below include/
  std::string intro;
  std::vector<Parameter> parameters;
};

/// All groups in the order of the page.
const std::vector<ParameterGroup>& parameterTable();

/// The file of a parameter's picture, in the folder of the pictures.
std::string pictureFile(const Parameter& parameter);

/// A line for each parameter: name, unit, range, default.
std::string parameterList();
/// The page docs/parameters.md.
std::string parameterPage();

}  // namespace sample
