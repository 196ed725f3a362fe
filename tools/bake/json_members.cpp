#include "json_members.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>

namespace pelage::bake {

using nlohmann::json;

namespace {

// Escapes a name for a JSON pointer: RFC 6901.
std::string escaped(std::string_view key) {
  std::string text;
  for (const char c : key) text += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
  return text;
}

}  // namespace

void JsonFaults::add(std::string_view pointer, std::string_view text) {
  messages.push_back(fmt::format("{}: {}: {}", file, pointer.empty() ? "/" : pointer, text));
}

Result<void> JsonFaults::result() const {
  if (messages.empty()) return {};
  std::string text = messages.front();
  if (messages.size() > 1) text += fmt::format(" (and {} more)", messages.size() - 1);
  return Error{ErrorCode::kInvalidFile, text};
}

Result<std::string> loadText(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (!file || !(text << file.rdbuf()))
    return Error{ErrorCode::kFileNotFound, path + ": cannot be read"};
  return text.str();
}

Result<json> loadJson(const std::string& path) {
  const auto text = loadText(path);
  if (!text) return text.error();
  try {
    return json::parse(*text);
  } catch (const json::exception& error) {
    return Error{ErrorCode::kInvalidFile, fmt::format("{}: no JSON: {}", path, error.what())};
  }
}

std::optional<double> parseMeters(std::string_view text) {
  const std::string copy(text);
  char* end = nullptr;
  const double value = std::strtod(copy.c_str(), &end);
  if (end == copy.c_str() || !std::isfinite(value)) return std::nullopt;
  const std::string unit(end + std::strspn(end, " "));
  for (const auto& [name, factor] : {std::pair("", 1.0), std::pair("m", 1.0), std::pair("cm", 1e-2),
                                     std::pair("mm", 1e-3), std::pair("um", 1e-6)})
    if (unit == name) return value * factor;
  return std::nullopt;
}

JsonMembers::JsonMembers(const json& object, std::string pointer, JsonFaults& faults,
                         const JsonMembers* defaults)
    : object_(object), pointer_(std::move(pointer)), faults_(faults), defaults_(defaults) {
  if (!object_.is_object()) faults_.add(pointer_, "must be an object");
}

const json* JsonMembers::lookup(std::string_view key) const {
  if (!object_.is_object()) return nullptr;
  const auto found = object_.find(std::string(key));
  return found == object_.end() ? nullptr : &*found;
}

const json* JsonMembers::find(std::string_view key) {
  known_.emplace_back(key);
  if (const json* own = lookup(key); own != nullptr) return own;
  return defaults_ != nullptr ? defaults_->lookup(key) : nullptr;
}

bool JsonMembers::has(std::string_view key) { return find(key) != nullptr; }

std::string JsonMembers::pointerOf(std::string_view key) const {
  const bool fromDefaults =
      lookup(key) == nullptr && defaults_ != nullptr && defaults_->lookup(key) != nullptr;
  return (fromDefaults ? defaults_->pointer_ : pointer_) + "/" + escaped(key);
}

void JsonMembers::fault(std::string_view key, std::string_view text) {
  faults_.add(pointerOf(key), text);
}

template <class T>
T JsonMembers::missing(std::string_view key, const std::optional<T>& fallback, T none) {
  if (fallback) return *fallback;
  if (object_.is_object()) fault(key, "is missing");
  return none;
}

std::string JsonMembers::text(std::string_view key, std::optional<std::string> fallback) {
  const json* value = find(key);
  if (value == nullptr) return missing(key, fallback, std::string());
  if (!value->is_string() || value->get_ref<const std::string&>().empty()) {
    fault(key, "must be text that is not empty");
    return fallback.value_or("");
  }
  return value->get<std::string>();
}

bool JsonMembers::flag(std::string_view key, bool fallback) {
  const json* value = find(key);
  if (value == nullptr) return fallback;
  if (!value->is_boolean()) {
    fault(key, "must be true or false");
    return fallback;
  }
  return value->get<bool>();
}

double JsonMembers::number(std::string_view key, double low, double high,
                           std::optional<double> fallback) {
  const json* value = find(key);
  if (value == nullptr) return missing(key, fallback, low);
  const double read = value->is_number() ? value->get<double>() : std::nan("");
  if (!(read >= low && read <= high)) {
    fault(key, fmt::format("must be a number from {} to {}", low, high));
    return fallback.value_or(low);
  }
  return read;
}

int64_t JsonMembers::integer(std::string_view key, int64_t low, int64_t high,
                             std::optional<int64_t> fallback) {
  const json* value = find(key);
  if (value == nullptr) return missing(key, fallback, low);
  const bool fits = value->is_number_integer() &&
                    (!value->is_number_unsigned() || value->get<uint64_t>() <= uint64_t{1} << 62);
  if (!fits || value->get<int64_t>() < low || value->get<int64_t>() > high) {
    fault(key, fmt::format("must be a whole number from {} to {}", low, high));
    return fallback.value_or(low);
  }
  return value->get<int64_t>();
}

double JsonMembers::meters(std::string_view key, double low, double high,
                           std::optional<double> fallback) {
  const json* value = find(key);
  if (value == nullptr) return missing(key, fallback, low);
  std::optional<double> read;
  if (value->is_number()) read = value->get<double>();
  if (value->is_string()) read = parseMeters(value->get_ref<const std::string&>());
  if (!read || !(*read >= low && *read <= high)) {
    fault(key, fmt::format("must be a length from {} to {} m: 0.0005 or \"0.5mm\"", low, high));
    return fallback.value_or(low);
  }
  return *read;
}

size_t JsonMembers::choice(std::string_view key, const std::vector<std::string>& words,
                           size_t fallback) {
  const json* value = find(key);
  if (value == nullptr) return fallback;
  const auto found = value->is_string()
                         ? std::find(words.begin(), words.end(), value->get<std::string>())
                         : words.end();
  if (found == words.end()) {
    fault(key, fmt::format("must be one of \"{}\"", fmt::join(words, "\", \"")));
    return fallback;
  }
  return static_cast<size_t>(found - words.begin());
}

std::pair<int64_t, int64_t> JsonMembers::range(std::string_view key, int64_t low, int64_t high) {
  const json* value = find(key);
  if (value == nullptr) {
    (void)missing(key, std::optional<int64_t>(), low);
    return {low, low};
  }
  const auto fits = [&](const json& number) {
    return number.is_number_integer() && number.get<double>() >= static_cast<double>(low) &&
           number.get<double>() <= static_cast<double>(high);
  };
  if (!value->is_array() || value->size() != 2 || !fits((*value)[0]) || !fits((*value)[1]) ||
      (*value)[0].get<int64_t>() > (*value)[1].get<int64_t>()) {
    fault(key, fmt::format("must be [first, last], first <= last, whole numbers from {} to {}", low,
                           high));
    return {low, low};
  }
  return {(*value)[0].get<int64_t>(), (*value)[1].get<int64_t>()};
}

std::vector<std::string> JsonMembers::texts(std::string_view key) {
  std::vector<std::string> all;
  const json* values = array(key);
  for (size_t i = 0; values != nullptr && i < values->size(); ++i) {
    if ((*values)[i].is_string())
      all.push_back((*values)[i].get<std::string>());
    else
      faults_.add(fmt::format("{}/{}", pointerOf(key), i), "must be text");
  }
  return all;
}

const json* JsonMembers::object(std::string_view key) {
  const json* value = find(key);
  if (value == nullptr || value->is_object()) return value;
  fault(key, "must be an object");
  return nullptr;
}

const json* JsonMembers::array(std::string_view key) {
  const json* value = find(key);
  if (value == nullptr || value->is_array()) return value;
  fault(key, "must be an array");
  return nullptr;
}

void JsonMembers::finish() {
  finish(*this);
  if (defaults_ != nullptr) finish(*defaults_);
}

void JsonMembers::finish(const JsonMembers& members) {
  if (!members.object_.is_object()) return;
  for (const auto& [key, value] : members.object_.items())
    if (std::find(known_.begin(), known_.end(), key) == known_.end())
      faults_.add(members.pointer_ + "/" + escaped(key), "there is no such setting");
}

}  // namespace pelage::bake
