// Shared by the functions of the C interface: handles, structs with a size, and calls that end in
// an error code.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "base/guard.h"
#include "pelage/pelage_c.h"
#include "pelage/result.h"

namespace pelage::c {

/// The name of a type of the header, for messages.
template <class T>
inline constexpr const char* kName = nullptr;
#define PELAGE_C_NAME(type) \
  template <>               \
  inline constexpr const char* pelage::c::kName<type> = #type

template <class... T>
Error invalid(fmt::format_string<T...> message, T&&... values) {
  return {ErrorCode::kInvalidArgument, fmt::format(message, std::forward<T>(values)...)};
}

/// The objects behind handles. A handle is a number that is never given twice, so that one of a
/// destroyed object is told from others; it is no address.
class Handles {
 public:
  /// It is not destroyed: programs may call until their end, and drivers may be gone by then.
  static Handles& all() {
    static auto* handles = new Handles;
    return *handles;
  }

  template <class T>
  T* add(std::shared_ptr<T> object) {
    const std::lock_guard lock(mutex_);
    objects_.emplace(last_ + 1, Entry{kName<T>, std::move(object)});
    return reinterpret_cast<T*>(++last_);  // NOLINT(performance-no-int-to-ptr)
  }
  /// nullptr where the handle is of another kind, or of none.
  template <class T>
  std::shared_ptr<T> find(const void* handle) const {
    const std::lock_guard lock(mutex_);
    const auto found = objects_.find(reinterpret_cast<uintptr_t>(handle));
    if (found == objects_.end() || std::string_view(found->second.kind) != kName<T>) return nullptr;
    return std::static_pointer_cast<T>(found->second.object);
  }
  template <class T>
  Result<std::shared_ptr<T>> get(const T* handle) const {
    if (auto object = find<T>(handle)) return object;
    return why(handle, kName<T>);
  }
  Error why(const void* handle, std::string_view wanted) const {
    if (handle == nullptr) return invalid("the {} is NULL", wanted);
    const std::lock_guard lock(mutex_);
    const auto found = objects_.find(reinterpret_cast<uintptr_t>(handle));
    if (found != objects_.end()) return invalid("the {} is a {}", wanted, found->second.kind);
    return invalid("the {} is no handle of this library, or was destroyed", wanted);
  }
  Result<void> destroy(void* handle) {
    std::unique_lock lock(mutex_);
    const auto node = objects_.extract(reinterpret_cast<uintptr_t>(handle));
    lock.unlock();  // a destructor may take long
    if (node.empty()) return why(handle, "handle");
    return {};
  }

 private:
  struct Entry {
    const char* kind;
    std::shared_ptr<void> object;
  };
  mutable std::mutex mutex_;
  std::unordered_map<uintptr_t, Entry> objects_;
  uintptr_t last_ = 0;
};

/// Keeps the message for pelage_last_error(). Allocates nothing.
void setLastError(std::string&& message) noexcept;

/// Runs a function that returns a Result<void>; no exception leaves it.
template <class Function>
pelage_result call(Function&& function) noexcept {
  try {
    Result<void> result = detail::guarded(function);
    if (result) return PELAGE_OK;
    setLastError(std::string(result.error().message));
    return static_cast<pelage_result>(static_cast<int>(result.error().code) + 1);
  } catch (...) {
    // Not even the message had room.
    setLastError({});
    return PELAGE_ERROR_OUT_OF_MEMORY;
  }
}

/// Whether an exception has left an object as it must not be used: scenes and their frames.
template <class T>
bool isSpoiled(const T& object) {
  if constexpr (requires { object.spoiled; })
    return *object.spoiled;
  else
    return false;
}
template <class T>
void spoil(T& object) {
  if constexpr (requires { object.spoiled; }) *object.spoiled = true;
}

/// Calls a function with the objects of handles; an error where one is not valid.
template <class Function, class... T>
auto withObjects(Function& function, T*... handles) -> decltype(function(*handles...)) {
  const std::tuple found = {Handles::all().get(handles)...};
  const Error* wrong = nullptr;
  std::apply([&](auto&... of) { ((wrong = wrong || of ? wrong : &of.error()), ...); }, found);
  if (wrong != nullptr) return *wrong;
  return std::apply(
      [&](auto&... of) -> decltype(function(*handles...)) {
        if ((isSpoiled(**of) || ...))
          return invalid("a scene ran out of memory in an earlier call: destroy it");
        try {
          return function(**of...);
        } catch (...) {
          (spoil(**of), ...);
          throw;
        }
      },
      found);
}

inline Error nullOutput() { return invalid("the pointer that takes the result is NULL"); }

/// with(handles...)(function): calls a function with the objects of handles.
template <class... T>
auto with(T*... handles) {
  return [=](auto function) noexcept {
    return call([&]() -> Result<void> { return withObjects(function, handles...); });
  };
}
/// The same of a function that returns a value beside the error code: that of its Result, or
/// nothing after an error.
template <class Out, class... T>
auto produce(Out* out, T*... handles) {
  return [=](auto function) noexcept {
    if (out != nullptr) *out = {};
    return call([&]() -> Result<void> {
      if (out == nullptr) return nullOutput();
      auto made = withObjects(function, handles...);
      if (!made) return made.error();
      *out = static_cast<Out>(*std::move(made));
      return {};
    });
  };
}
/// The same of a function that makes an object, for which it gives a handle.
template <class Object, class... T>
auto make(Object** out, T*... handles) {
  return [=](auto function) noexcept {
    return produce(out, handles...)([&](auto&... objects) -> Result<Object*> {
      Result<Object> made = function(objects...);
      if (!made) return made.error();
      return Handles::all().add(std::make_shared<Object>(*std::move(made)));
    });
  };
}

// NOLINTBEGIN(bugprone-macro-parentheses): names and types.

/// A variable with the value of a Result; the function returns where that is an error.
#define PELAGE_C_TRY(name, expression)            \
  auto name##Result = (expression);               \
  if (!name##Result) return name##Result.error(); \
  auto& name = *name##Result

/// A struct as it is made.
template <class T>
T defaultsOf() {
  return {};
}

inline Error wrongSize(const char* name, uint64_t given, size_t own) {
  return invalid(
      "{0} has {1} bytes, but {2} in this library, version {3}.{4}.{5}: call {0}_init(), and use "
      "the header of the library",
      name, given, own, PELAGE_VERSION_MAJOR, PELAGE_VERSION_MINOR, PELAGE_VERSION_PATCH);
}
template <class T>
pelage_result init(T* out, size_t size) noexcept {
  return call([&]() -> Result<void> {
    if (out == nullptr) return nullOutput();
    if (size != sizeof(T)) return wrongSize(kName<T>, size, sizeof(T));
    *out = defaultsOf<T>();
    out->struct_size = sizeof(T);
    return {};
  });
}
/// The name of a struct and its function with the defaults.
#define PELAGE_C_STRUCT(type) \
  PELAGE_C_NAME(type);        \
  pelage_result type##_init(type* out, size_t size) { return pelage::c::init(out, size); }

// NOLINTEND(bugprone-macro-parentheses)

/// A copy of a struct, checked.
template <class T>
Result<T> read(const T* given) {
  if (given == nullptr) return invalid("the {} is NULL", kName<T>);
  if (given->struct_size != sizeof(T)) return wrongSize(kName<T>, given->struct_size, sizeof(T));
  return *given;
}
template <class T>
Result<T> readOr(const T* given) {
  return given == nullptr ? Result<T>(defaultsOf<T>()) : read(given);
}

}  // namespace pelage::c
