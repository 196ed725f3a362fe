// Errors of tools. No exception leaves a function of a public header.
#pragma once

#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>

#include "pelage/result.h"

namespace pelage::tools {

inline Error invalid(std::string message) {
  return {ErrorCode::kInvalidArgument, std::move(message)};
}

/// Runs a function that returns a Result and turns exceptions into errors.
template <class Function>
auto guarded(Function&& function) -> decltype(function()) {
  try {
    return function();
  } catch (const std::bad_alloc&) {
  } catch (const std::length_error&) {
  } catch (const std::exception& e) {
    return invalid(e.what());
  } catch (...) {
    return invalid("a callback threw an exception");
  }
  // Short enough to need no allocation of its own.
  return Error{ErrorCode::kOutOfMemory, "out of memory"};
}

}  // namespace pelage::tools
