// Makes errors.
#pragma once

#include <string>
#include <utility>

#include "pelage/result.h"

namespace pelage::detail {

inline Error invalid(std::string message) {
  return {ErrorCode::kInvalidArgument, std::move(message)};
}

}  // namespace pelage::detail
