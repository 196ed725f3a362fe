// Options that groom, bind and collision have in common: the unit and the axes of a file.
#pragma once

#include "pelage/authoring/hair_curves.h"

namespace CLI {
class App;
class Validator;
}  // namespace CLI

namespace pelage::convert {

/// --scale, --up-axis, --invert-z. \param of  owner of the axes in the help texts
void addAxisOptions(CLI::App& command, const char* of, float& scale, UpAxis& upAxis, bool& invertZ);

const char* toString(UpAxis axis);

/// For options where 0, which stands for "not given" in the library, would do nothing.
CLI::Validator isAboveZero();
/// For unsigned options: the parser would make a large number of a negative one.
CLI::Validator isNotNegative();

}  // namespace pelage::convert
