// Extremes of many values keep a NaN, wherever it comes.
#include "support/extremes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/not_numbers.h"

namespace pelage::test {
namespace {

double largestOf(const std::vector<double>& values) {
  double largest = 0;
  for (const double value : values) keepLargest(largest, value);
  return largest;
}

double smallestOf(const std::vector<double>& values) {
  double smallest = 10;
  for (const double value : values) keepSmallest(smallest, value);
  return smallest;
}

TEST(Extremes, AreThoseOfAllValues) {
  EXPECT_EQ(largestOf({1, 3, 2}), 3);
  EXPECT_EQ(largestOf({-1}), 0);
  EXPECT_EQ(smallestOf({3, 1, 2}), 1);
  EXPECT_EQ(smallestOf({11}), 10);
}

TEST(Extremes, StayNanOnceAValueIsNan) {
  for (size_t at = 0; at < 3; ++at) {
    std::vector<double> values = {1, 2, 3};
    values[at] = double{kNan};
    EXPECT_TRUE(std::isnan(largestOf(values))) << "value " << at;
    EXPECT_TRUE(std::isnan(smallestOf(values))) << "value " << at;
  }
}

}  // namespace
}  // namespace pelage::test
