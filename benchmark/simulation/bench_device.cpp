#include "simulation/bench_device.h"

#include "baseline/code.h"
#include "device.h"

namespace bench {

pelage::Result<std::unique_ptr<pelage::HeadlessDevice>> createDevice(
    const pelage::HeadlessDef& def) {
  auto device = sample::createDevice(def);
  if (device) (*device)->addCode(baseline::allCode());
  return device;
}

}  // namespace bench
