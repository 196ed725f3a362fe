// Result<T>: a value or an Error. Functions that depend on data, a device or a driver return one;
// no exception crosses the API.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "pelage/assert.h"

namespace pelage {

/// The kind of an error; the message has the details and says what to do.
enum class ErrorCode {
  kInvalidArgument,  ///< a parameter is out of its documented range
  kFileNotFound,     ///< a file does not exist or cannot be opened
  kInvalidFile,      ///< a file is truncated or holds impossible values; the message has the offset
  kOutOfMemory,      ///< host or device memory is exhausted
  kUnsupported,      ///< the device or driver lacks something; the message names it
  kDevice,           ///< the driver reported a failure
  kDeviceLost,       ///< the device or context is gone: make another one (docs/scene.md)
};

/// An error with a message of one line that the reader can act on: it names the file, the byte
/// offset or the resource, and what to do.
struct Error {
  ErrorCode code = ErrorCode::kInvalidArgument;
  std::string message;
};

/// A value of type T, or the Error that explains its absence.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : data_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : data_(std::in_place_index<1>, std::move(error)) {}

  explicit operator bool() const { return data_.index() == 0; }
  bool ok() const { return data_.index() == 0; }

  T& value() & {
    PELAGE_ASSERT(ok(), "Result::value() on an error");
    return *std::get_if<0>(&data_);
  }
  const T& value() const& {
    PELAGE_ASSERT(ok(), "Result::value() on an error");
    return *std::get_if<0>(&data_);
  }
  /// Returns by value, so that `for (auto& x : *f())` does not iterate over a dead temporary.
  T value() && {
    PELAGE_ASSERT(ok(), "Result::value() on an error");
    return std::move(*std::get_if<0>(&data_));
  }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  const Error& error() const {
    PELAGE_ASSERT(!ok(), "Result::error() on a value");
    return *std::get_if<1>(&data_);
  }

 private:
  std::variant<T, Error> data_;
};

/// Success, or the Error that explains the failure.
template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)) {}

  explicit operator bool() const { return !error_; }
  bool ok() const { return !error_; }
  const Error& error() const {
    PELAGE_ASSERT(!ok(), "Result::error() on success");
    return *error_;
  }

 private:
  std::optional<Error> error_;
};

}  // namespace pelage
