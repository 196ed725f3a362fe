// Members of JSON objects, checked one by one. Errors name the file and the JSON pointer.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pelage/result.h"

namespace pelage::bake {

/// Errors of a file, in the order in which they were found.
struct JsonFaults {
  std::string file;
  std::vector<std::string> messages;
  /// Adds "FILE: POINTER: TEXT"; the pointer of the whole file is written as "/".
  void add(std::string_view pointer, std::string_view text);
  /// The first fault, with the number of others; nothing if there is none.
  Result<void> result() const;
};

/// The text of a file. Errors: it cannot be read.
Result<std::string> loadText(const std::string& path);

/// Parses a file. Errors: those of reading it; what is no JSON, with line and column.
Result<nlohmann::json> loadJson(const std::string& path);

/// Reads the members of an object. A member that is not there takes the value of `defaults`,
/// another object, and then the fallback of the call. What is wrong is a fault, and the fallback is
/// returned.
class JsonMembers {
 public:
  /// \param pointer  of `object` in the file. \param defaults  nullptr: none
  JsonMembers(const nlohmann::json& object, std::string pointer, JsonFaults& faults,
              const JsonMembers* defaults = nullptr);

  bool has(std::string_view key);
  std::string text(std::string_view key, std::optional<std::string> fallback = {});
  bool flag(std::string_view key, bool fallback);
  double number(std::string_view key, double low, double high, std::optional<double> fallback = {});
  int64_t integer(std::string_view key, int64_t low, int64_t high,
                  std::optional<int64_t> fallback = {});
  /// A length: a number of meters, or text with a unit: "0.5mm", "50um", "1cm", "2m".
  double meters(std::string_view key, double low, double high, std::optional<double> fallback = {});
  /// One of several words, by its index.
  size_t choice(std::string_view key, const std::vector<std::string>& words, size_t fallback);
  /// Two integers.
  std::pair<int64_t, int64_t> range(std::string_view key, int64_t low, int64_t high);
  std::vector<std::string> texts(std::string_view key);
  /// An object or an array, with its pointer; nullptr where it is not there or something else.
  const nlohmann::json* object(std::string_view key);
  const nlohmann::json* array(std::string_view key);

  std::string pointerOf(std::string_view key) const;
  void fault(std::string_view key, std::string_view text);
  /// Call it behind all others: a member that none of them has asked for is a fault, here and in
  /// `defaults`.
  void finish();

 private:
  const nlohmann::json* find(std::string_view key);
  const nlohmann::json* lookup(std::string_view key) const;
  void finish(const JsonMembers& members);
  template <class T>
  T missing(std::string_view key, const std::optional<T>& fallback, T none);

  const nlohmann::json& object_;
  std::string pointer_;
  JsonFaults& faults_;
  const JsonMembers* defaults_;
  std::vector<std::string> known_;
};

/// Meters of a number, or of a number with a unit; nothing for other text.
std::optional<double> parseMeters(std::string_view text);

}  // namespace pelage::bake
