#include "base/ids.h"

#include <atomic>
#include <cstdlib>
#include <string>

#include "pelage/assert.h"

namespace pelage::detail {

uint32_t nextOwner() {
  static std::atomic<uint32_t> last{0};
  uint32_t owner = ++last;
  while (owner == 0) owner = ++last;
  return owner;
}

Error noSuchThing(const char* call, const char* why) {
  return {ErrorCode::kInvalidArgument, std::string(call) + ": the id " + why};
}

void endForId(const char* call, const char* why) {
  const std::string message = noSuchThing(call, why).message;
  reportAssert("isValid(id)", message.c_str(), __FILE__, __LINE__);
  std::abort();
}

}  // namespace pelage::detail
