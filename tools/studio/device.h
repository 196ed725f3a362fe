// The choice of a runtime and a device.
#pragma once

#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "pelage/headless.h"
#include "pelage/result.h"

namespace sample {

/// "vulkan", "gl" or "gles"; nothing for anything else.
std::optional<pelage::Api> parseApi(std::string_view name);

/// A device of the runtime that def.api names. Errors: those of the runtime; a runtime that this
/// build does not have.
pelage::Result<std::unique_ptr<pelage::HeadlessDevice>> createDevice(
    const pelage::HeadlessDef& def);

/// All devices of an API in the driver's order. An error when there is none.
pelage::Result<std::vector<pelage::DeviceInfo>> listDevices(pelage::Api api);

}  // namespace sample
