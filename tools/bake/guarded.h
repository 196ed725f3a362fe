// The boundary of a thread: no exception leaves it.
#pragma once

#include <exception>
#include <new>

#include "pelage/result.h"

namespace pelage::bake {

/// Runs a function that returns a Result; what the standard library throws becomes an error.
template <class Function>
auto guarded(Function&& function) -> decltype(function()) {
  try {
    return function();
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kOutOfMemory, "out of memory"};
  } catch (const std::exception& error) {
    return Error{ErrorCode::kInvalidFile, error.what()};
  }
}

}  // namespace pelage::bake
