// The boundary of the API: no exception leaves it.
#pragma once

#include <exception>
#include <new>
#include <stdexcept>

#include "pelage/result.h"

namespace pelage::detail {

/// Runs a function that returns a Result and turns exceptions into errors.
template <class Function>
auto guarded(Function&& function) -> decltype(function()) {
  try {
    return function();
  } catch (const std::bad_alloc&) {
    // Short enough to need no allocation of its own.
    return Error{ErrorCode::kOutOfMemory, "out of memory"};
  } catch (const std::length_error&) {
    return Error{ErrorCode::kOutOfMemory, "out of memory"};
  } catch (const std::exception& e) {
    return Error{ErrorCode::kInvalidArgument, e.what()};
  } catch (...) {
    // Only a function of the caller can throw such a thing.
    return Error{ErrorCode::kInvalidArgument, "a callback threw an exception"};
  }
}

}  // namespace pelage::detail
