// The core takes these from the C++20 library, and emscripten 3.1.6 of Debian 12 lacks them.
// Included before every source.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <string>
#include <system_error>
#include <type_traits>
#include <version>

namespace std {

#if !defined(__cpp_lib_bit_cast)
template <class To, class From>
constexpr To bit_cast(const From& from) noexcept {
  return __builtin_bit_cast(To, from);
}
#endif

#if !defined(__cpp_lib_ranges)
namespace ranges {

template <class Range, class Predicate>
bool any_of(Range&& range, Predicate predicate) {
  return std::any_of(std::begin(range), std::end(range), predicate);
}
template <class Range, class Predicate>
bool none_of(Range&& range, Predicate predicate) {
  return std::none_of(std::begin(range), std::end(range), predicate);
}
template <class A, class B, class... Predicate>
bool equal(A&& a, B&& b, Predicate... predicate) {
  return std::equal(std::begin(a), std::end(a), std::begin(b), std::end(b), predicate...);
}
template <class Range, class T>
auto find(Range&& range, const T& value) {
  return std::find(std::begin(range), std::end(range), value);
}
template <class Range, class Predicate>
auto find_if(Range&& range, Predicate predicate) {
  return std::find_if(std::begin(range), std::end(range), predicate);
}
template <class Range>
auto distance(Range&& range) {
  return std::distance(std::begin(range), std::end(range));
}
template <class Range, class... Less>
void sort(Range&& range, Less... less) {
  std::sort(std::begin(range), std::end(range), less...);
}

}  // namespace ranges
#endif

// A number in decimal form at the front of the text.
template <class T, enable_if_t<is_floating_point_v<T>, int> = 0>
from_chars_result from_chars(const char* first, const char* last, T& value) {
  const string text(first, last);
  if (text.empty() || text[0] == '+' || text[0] == ' ') return {first, errc::invalid_argument};
  char* end = nullptr;
  const double read = strtod(text.c_str(), &end);
  if (end == text.c_str()) return {first, errc::invalid_argument};
  value = static_cast<T>(read);
  return {first + (end - text.c_str()), errc()};
}

}  // namespace std
