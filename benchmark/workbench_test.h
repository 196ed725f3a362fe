// Tests of benchmarks on a device.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "simulation/bench_device.h"
#include "simulation/copy_reference.h"
#include "simulation/workbench.h"
#include "support/required_devices.h"

namespace bench {

class WorkbenchTest : public testing::TestWithParam<pelage::Api> {
 protected:
  void SetUp() override {
    pelage::HeadlessDef def;
    def.api = GetParam();
    auto device = bench::createDevice(def);
    if (!device && device.error().code == pelage::ErrorCode::kUnsupported)
      PELAGE_SKIP_WITHOUT_DEVICE() << device.error().message;
    ASSERT_TRUE(device.ok()) << device.error().message;
    device_ = std::move(*device);
    workbench_.reset(new Workbench{*device_, {}});
    copies_ = std::make_unique<CopyReference>(*device_, workbench_->scene, kOnce);
  }

  std::unique_ptr<pelage::HeadlessDevice> device_;
  std::unique_ptr<Workbench> workbench_;
  std::unique_ptr<CopyReference> copies_;
};

}  // namespace bench
