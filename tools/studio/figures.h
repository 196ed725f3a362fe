// The cost of each kernel: collected pass by pass, shown as a table, kept as CSV.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pelage/headless.h"
#include "pelage/pass_list.h"
#include "pelage/result.h"

namespace sample {

/// The figures of all passes of one name.
struct PassFigure {
  std::string name;
  uint64_t passes = 0;
  uint64_t bytes = 0;                ///< that they moved at least, in all; 0 when that is not known
  std::vector<double> milliseconds;  ///< of each timed pass; empty without timestamps

  double totalMilliseconds() const;
  double meanMilliseconds() const;  ///< 0 without timings, as are the next two
  double minMilliseconds() const;
  double medianMilliseconds() const;
  /// Bytes of the timed passes over their time [GB/s]; 0 when one of them is not known.
  double gigabytesPerSecond() const;
};

class Figures {
 public:
  /// Adds a list that ran. `timings` is what the device gave for it.
  void add(const pelage::PassList& list, const std::vector<pelage::PassTiming>& timings);
  /// The same for lists that ran one after another.
  void add(const std::vector<pelage::PassList>& lists,
           const std::vector<pelage::PassTiming>& timings);
  /// In the order in which the names came first.
  const std::vector<PassFigure>& passes() const { return passes_; }
  /// Lines for a person: one a pass name.
  std::string table() const;

 private:
  std::vector<PassFigure> passes_;
};

/// The columns that are the same in every row of the CSV file.
struct RunInfo {
  std::string commit;  ///< of the source, as the user says; may be empty
  std::string asset;
  uint32_t guides = 0, follow = 0, verticesPerStrand = 0;
  uint32_t frames = 0;
};

/// Appends one row for each pass name, and the header when the file is new or empty.
pelage::Result<void> appendCsv(const std::string& path, const Figures& figures,
                               const pelage::DeviceInfo& device, const RunInfo& run);

}  // namespace sample
