// Results of benchmarks as CSV.
#pragma once

#include <string>
#include <vector>

#include "pelage/headless.h"
#include "pelage/result.h"

namespace bench {

/// Appends lines, behind a header where the file is new. Lines end in a newline. Errors: the file
/// cannot be opened or written.
pelage::Result<void> appendLines(const std::string& path, const char* header,
                                 const std::vector<std::string>& lines);

/// A number of 6 digits; nothing if it is not known.
std::string csvNumber(double value, bool known);

/// The last two fields of a line. Names of devices hold commas, so they are quoted.
std::string csvEnd(const pelage::DeviceInfo& device);

/// The path of a file beside another one: "a/NAME.csv" and "_passes" give "a/NAME_passes.csv".
std::string besidePath(const std::string& path, const char* suffix);

}  // namespace bench
