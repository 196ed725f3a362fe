#include "simulation/bench_device.h"

#include <fmt/format.h>

#include "baseline/code.h"
#include "device.h"

namespace bench {

pelage::Result<std::unique_ptr<pelage::HeadlessDevice>> createDevice(
    const pelage::HeadlessDef& def) {
  auto device = sample::createDevice(def);
  if (device) (*device)->addCode(baseline::allCode());
  return device;
}

pelage::Result<std::unique_ptr<pelage::HeadlessDevice>> openDevice(pelage::Api api, int index) {
  pelage::HeadlessDef def;
  def.api = api;
  def.deviceIndex = index;
  auto device = createDevice(def);
  if (!device && device.error().code == pelage::ErrorCode::kUnsupported) {
    fmt::print("{}: skipped, {}\n", pelage::apiName(api), device.error().message);
    return std::unique_ptr<pelage::HeadlessDevice>();
  }
  return device;
}

}  // namespace bench
