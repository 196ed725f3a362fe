// Objects of the C interface in tests: handles that are destroyed with their scope, and
// expectations on error codes.
#pragma once

#include <gtest/gtest.h>

#include <string_view>
#include <utility>
#include <vector>

#include "pelage/pelage_c.h"
#include "support/errors.h"

namespace pelage::test {

inline constexpr float kDt = 1.0f / 60;

inline void expectOk(pelage_result result) { EXPECT_EQ(result, PELAGE_OK) << pelage_last_error(); }

/// Fails unless a call ended with this code, and the last message has all of the words.
inline void expectError(pelage_result result, pelage_result code,
                        std::initializer_list<std::string_view> words) {
  EXPECT_EQ(result, code) << pelage_last_error();
  for (const std::string_view word : words) expectHas(pelage_last_error(), word);
}
inline void expectInvalid(pelage_result result, std::string_view word) {
  expectError(result, PELAGE_ERROR_INVALID_ARGUMENT, {word});
}

/// A handle. Handle<pelage_scene> scene(pelage_scene_create);
template <class T>
class Handle {
 public:
  /// \param create  a function whose last argument takes the handle
  template <class Function, class... Arguments>
  explicit Handle(Function create, Arguments... arguments) {
    expectOk(create(arguments..., &handle_));
  }
  Handle(Handle&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  ~Handle() { expectOk(pelage_destroy(handle_)); }
  operator T*() const { return handle_; }
  void destroy() { expectOk(pelage_destroy(std::exchange(handle_, nullptr))); }

 private:
  T* handle_ = nullptr;
};

/// A struct with its defaults: made<pelage_view>(pelage_view_init).
template <class T>
T made(pelage_result (*init)(T*, size_t)) {
  T value;
  expectOk(init(&value, sizeof(T)));
  return value;
}

inline pelage_hair_info infoOf(pelage_scene* scene, pelage_id hair) {
  auto info = made(pelage_hair_info_init);
  expectOk(pelage_scene_get_hair_info(scene, hair, &info));
  return info;
}

}  // namespace pelage::test
