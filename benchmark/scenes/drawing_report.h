// The results of the rows that draw: a table for a person and CSV files.
#pragma once

#include <string>
#include <vector>

#include "pelage/headless.h"
#include "scenes/drawing_measure.h"

namespace bench {

/// "windowed" or "tiles".
const char* drawingMethodName(pelage::Transparency method);

/// A table of the rows, then one of their passes.
std::string drawingTable(const std::vector<DrawingResult>& results);

/// Appends a row to NAME_drawing.csv, and its passes to NAME_drawing_passes.csv, beside a CSV file
/// NAME.csv. Both get a header where they are new.
pelage::Result<void> appendDrawingCsv(const std::string& path, const DrawingResult& result,
                                      const pelage::DeviceInfo& device, const std::string& commit);

}  // namespace bench
