// Expectations on results: success, or an error with its code and the words of its message.
#pragma once

#include <gtest/gtest.h>

#include <initializer_list>
#include <source_location>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "pelage/result.h"

namespace pelage::test {

/// Fails the test with the message of an error.
inline void expectOk(const Result<void>& result) {
  EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().message);
}

/// The result. One that is an error ends the test by an exception, with its message.
template <class T>
Result<T> required(Result<T> result,
                   const std::source_location& at = std::source_location::current()) {
  if (!result)
    throw std::runtime_error(std::string(at.file_name()) + ":" + std::to_string(at.line()) + ": " +
                             result.error().message);
  return result;
}
inline void required(const Result<void>& result,
                     const std::source_location& at = std::source_location::current()) {
  if (!result) (void)required<int>(result.error(), at);
}

/// Fails unless `text` has `part`.
inline void expectHas(std::string_view text, std::string_view part) {
  EXPECT_NE(text.find(part), std::string_view::npos) << "'" << part << "' is not in: " << text;
}

/// Fails unless `result` is an error whose message has all of the words.
template <class R>
void expectError(const R& result, std::initializer_list<std::string_view> words) {
  ASSERT_FALSE(result) << "no error, but it should have one that says '" << *words.begin() << "'";
  for (const std::string_view word : words) expectHas(result.error().message, word);
}
template <class R>
void expectError(const R& result, const char* word) {
  expectError(result, {std::string_view(word)});
}
/// Checks its code, too.
template <class R>
void expectError(const R& result, ErrorCode code, std::initializer_list<std::string_view> words) {
  expectError(result, words);
  if (result) return;
  EXPECT_EQ(result.error().code, code) << result.error().message;
}
template <class R>
void expectError(const R& result, ErrorCode code, const char* word) {
  expectError(result, code, {std::string_view(word)});
}

/// The value; a default one after a failure, which fails the test with the error's message.
template <class T>
T valueOf(Result<T> result) {
  EXPECT_TRUE(result) << result.error().message;
  return result ? std::move(*result) : T();
}

}  // namespace pelage::test
