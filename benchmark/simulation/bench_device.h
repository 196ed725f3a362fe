// A device for the benchmarks.
#pragma once

#include <memory>

#include "pelage/headless.h"
#include "pelage/result.h"

namespace bench {

/// The device that sample::createDevice() makes, which knows the baselines' kernels, too.
pelage::Result<std::unique_ptr<pelage::HeadlessDevice>> createDevice(
    const pelage::HeadlessDef& def);

/// The device of an API. Nullptr, and a message on stdout, where it is not supported.
pelage::Result<std::unique_ptr<pelage::HeadlessDevice>> openDevice(pelage::Api api, int index);

}  // namespace bench
