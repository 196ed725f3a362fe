// Tests skip what needs a driver where there is none. A machine that has to have all of them, as CI
// has, sets PELAGE_REQUIRE_DEVICES=1: then a missing driver or validation layer is a failure.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <string_view>

/// GTEST_SKIP() for lack of a driver or of a validation layer.
#define PELAGE_SKIP_WITHOUT_DEVICE()                                       \
  return GTEST_MESSAGE_("", ::pelage::test::devicesRequired()              \
                                ? ::testing::TestPartResult::kFatalFailure \
                                : ::testing::TestPartResult::kSkip)

namespace pelage::test {

inline bool devicesRequired() {
  const char* wanted = std::getenv("PELAGE_REQUIRE_DEVICES");
  return wanted != nullptr && std::string_view(wanted) == "1";
}

/// A test that goes on without a device fails where devices are required. \param why what is
/// missing.
inline void missingDevice(const std::string& why) {
  if (devicesRequired()) ADD_FAILURE() << "PELAGE_REQUIRE_DEVICES is set, but: " << why;
}

}  // namespace pelage::test
