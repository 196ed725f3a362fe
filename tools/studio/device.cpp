#include "device.h"

#include <string>

#include "names.h"
#include "sample/code.h"

namespace sample {

using pelage::Api;
using pelage::HeadlessDef;
using pelage::HeadlessDevice;

namespace {

constexpr int kMaxDevices = 64;

[[maybe_unused]] Error notBuilt(const char* option) {
  return {ErrorCode::kUnsupported,
          std::string("this program was built without that runtime: configure with -D") + option +
              "=ON"};
}

Result<std::unique_ptr<HeadlessDevice>> createDeviceOfPelage(const HeadlessDef& def) {
  if (def.api == Api::kVulkan) {
#ifdef PELAGE_STUDIO_VULKAN
    return pelage::createHeadlessVulkan(def);
#else
    return notBuilt("PELAGE_VULKAN");
#endif
  }
#ifdef PELAGE_STUDIO_GL
  return pelage::createHeadlessGl(def);
#else
  return notBuilt("PELAGE_GL");
#endif
}

}  // namespace

std::optional<Api> parseApi(std::string_view name) {
  for (const Api api : {Api::kVulkan, Api::kGl, Api::kGles})
    if (name == pelage::apiName(api)) return api;
  return std::nullopt;
}

Result<std::unique_ptr<HeadlessDevice>> createDevice(const HeadlessDef& def) {
  Result<std::unique_ptr<HeadlessDevice>> device = createDeviceOfPelage(def);
  if (device) (*device)->addCode(allCode());
  return device;
}

Result<std::vector<pelage::DeviceInfo>> listDevices(Api api) {
  std::vector<pelage::DeviceInfo> devices;
  for (int index = 0; index < kMaxDevices; ++index) {
    HeadlessDef def;
    def.api = api;
    def.deviceIndex = index;
    auto device = createDevice(def);
    if (!device) {
      if (devices.empty()) return device.error();
      break;
    }
    devices.push_back((*device)->info());
  }
  return devices;
}

}  // namespace sample
