// Builds the rows of the table.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "pelage/assert.h"
#include "pelage/settings/scene_settings.h"

namespace pelage::settings {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <class T>
struct MemberOf;
template <class Struct, class Field>
struct MemberOf<Field Struct::*> {
  using Owner = Struct;
  using Type = Field;
};

/// A member of a struct, or of a struct in it.
template <auto kFirst, auto... kRest>
auto& member(auto& object) {
  if constexpr (sizeof...(kRest) == 0)
    return object.*kFirst;
  else
    return member<kRest...>(object.*kFirst);
}

template <class T>
constexpr ParameterType typeOf() {
  if constexpr (std::is_same_v<T, bool>) return ParameterType::kBool;
  if constexpr (std::is_same_v<T, float>) return ParameterType::kFloat;
  if constexpr (std::is_same_v<T, Float3>) return ParameterType::kVector;
  if constexpr (std::is_same_v<T, ParameterCurve>) return ParameterType::kCurve;
  if constexpr (std::is_enum_v<T>) return ParameterType::kChoice;
  return ParameterType::kCount;
}

template <auto kFirst, auto... kRest>
ParameterValue readMember(const void* object) {
  using Struct = typename MemberOf<decltype(kFirst)>::Owner;
  const auto& value = member<kFirst, kRest...>(*static_cast<const Struct*>(object));
  using T = std::remove_cvref_t<decltype(value)>;
  if constexpr (typeOf<T>() == ParameterType::kChoice || typeOf<T>() == ParameterType::kCount)
    return static_cast<uint64_t>(value);
  else
    return value;
}

template <auto kFirst, auto... kRest>
void writeMember(void* object, const ParameterValue& value) {
  using Struct = typename MemberOf<decltype(kFirst)>::Owner;
  auto& to = member<kFirst, kRest...>(*static_cast<Struct*>(object));
  using T = std::remove_cvref_t<decltype(to)>;
  constexpr bool kWhole =
      typeOf<T>() == ParameterType::kChoice || typeOf<T>() == ParameterType::kCount;
  const auto* from = std::get_if<std::conditional_t<kWhole, uint64_t, T>>(&value);
  PELAGE_ASSERT(from != nullptr, "the value has another type than the parameter");
  if constexpr (kWhole) {
    using Number = std::conditional_t<std::is_enum_v<T>, uint8_t, T>;
    PELAGE_ASSERT(*from <= std::numeric_limits<Number>::max(), "the value is too large");
    to = static_cast<T>(*from);
  } else {
    to = *from;
  }
}

/// A row that says what it is: PELAGE_PARAMETER(...).says(...).within(0, 1).
struct Row : Parameter {
  Row& says(std::string_view unitText, std::string_view rangeText, std::string_view sentence) {
    unit = unitText;
    range = rangeText;
    meaning = sentence;
    return *this;
  }
  /// Both ends are valid, and those of the slider.
  Row& within(double least, double most) {
    low = sliderLow = least;
    high = sliderHigh = most;
    return *this;
  }
  Row& atLeast(double least) {
    low = least;
    return *this;
  }
  Row& above(double bound) {
    low = bound;
    lowIsOpen = true;
    return *this;
  }
  Row& slider(double from, double to) {
    sliderLow = from;
    sliderHigh = to;
    return *this;
  }
  Row& log() {
    scale = ParameterScale::kLog;
    return *this;
  }
  Row& logSlider(double from, double to) { return slider(from, to).log(); }
  Row& names(std::span<const std::string_view> constants) {
    choices = constants;
    return within(0, static_cast<double>(constants.size() - 1));
  }
  Row& ofSolver(std::string_view name) {
    solver = name;
    return *this;
  }
  Row& color() {
    type = ParameterType::kColor;
    return slider(0, 1);
  }
  Row& pictured() {
    hasPicture = true;
    return *this;
  }
  Row& infinite() {
    takesInfinity = true;
    return *this;
  }
  Row& nonZero() {
    takesZero = false;
    return *this;
  }
  Row& powerOfTwo() {
    isPowerOfTwo = true;
    return *this;
  }
};

template <auto kFirst, auto... kRest>
Row row(std::string_view owner, std::string_view field, std::string_view path) {
  using Struct = typename MemberOf<decltype(kFirst)>::Owner;
  static const Struct untouched{};
  using T = std::remove_cvref_t<decltype(member<kFirst, kRest...>(untouched))>;
  Row made;
  made.owner = owner;
  made.field = field;
  made.path = path;
  made.type = typeOf<T>();
  made.low = -kInfinity;
  made.high = kInfinity;
  if constexpr (typeOf<T>() == ParameterType::kCount)
    made.within(0, static_cast<double>(std::numeric_limits<T>::max()));
  if constexpr (typeOf<T>() == ParameterType::kBool) made.within(0, 1);
  made.get = readMember<kFirst, kRest...>;
  made.set = writeMember<kFirst, kRest...>;
  made.defaultValue = made.get(&untouched);
  return made;
}

/// Rows of a struct, in files of their own.
std::vector<Parameter> simulationParameters();
std::vector<Parameter> materialParameters();
std::vector<Parameter> objectParameters();
std::vector<Parameter> creationParameters();
std::vector<Parameter> followParameters();
std::vector<Parameter> colliderParameters();
std::vector<Parameter> colliderLookParameters();
std::vector<Parameter> contactLookParameters();
std::vector<Parameter> lightParameters();
std::vector<Parameter> transparencyParameters();
std::vector<Parameter> viewParameters();

/// Adds the rows of a part.
inline void append(std::vector<Parameter>& rows, std::vector<Parameter> more) {
  rows.insert(rows.end(), more.begin(), more.end());
}

}  // namespace pelage::settings

/// A member of a public struct.
#define PELAGE_PARAMETER(Owner, field) row<&Owner::field>(#Owner, #field, #field)
/// A member of a struct that is one of another's.
#define PELAGE_INNER_PARAMETER(Outer, member, Owner, field) \
  row<&Outer::member, &Owner::field>(#Owner, #field, #member "." #field)
/// A member of a struct that stands for one of the public API.
#define PELAGE_PARAMETER_AS(owner, Struct, field) row<&Struct::field>(owner, #field, #field)
