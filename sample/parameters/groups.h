// Helpers of the files that have the table's rows.
#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pelage/hair_depth.h"
#include "pelage/hair_object.h"
#include "pelage/sdf_collider.h"
#include "pelage/simulation_settings.h"
#include "pelage/transparency.h"
#include "pelage/types.h"
#include "pelage/view.h"
#include "table.h"

namespace sample {

std::vector<ParameterGroup> simulationGroups();
std::vector<ParameterGroup> hairGroups();
std::vector<ParameterGroup> colliderGroups();
std::vector<ParameterGroup> materialGroups();
std::vector<ParameterGroup> viewGroups();
std::vector<ParameterGroup> groomGroups();

/// A value as the page shows it.
std::string text(float value);
std::string text(bool value);
std::string text(uint32_t value);
std::string text(uint64_t value);
std::string text(const std::string& value);
std::string text(const pelage::Float2& value);
std::string text(const pelage::Float3& value);
std::string text(const pelage::Matrix4& value);
std::string text(const pelage::ParameterCurve& value);
std::string text(pelage::Solver value);
std::string text(pelage::SkinningMethod value);
std::string text(pelage::CollidingHair value);
std::string text(pelage::HairShadow value);
std::string text(pelage::ShadingModel value);
std::string text(pelage::Transparency value);
std::string text(pelage::HairDepthColor value);
std::string text(pelage::HairStyle value);
std::string text(pelage::BufferId value);
std::string text(pelage::SkeletonId value);
std::string text(pelage::TextureId value);
std::string text(const pelage::EngineLights* value);
template <class T>
std::string text(std::span<const T> value) {
  return value.empty() ? "empty" : std::to_string(value.size()) + " elements";
}
/// Rows of structs whose fields are a group of their own.
template <class T>
requires std::same_as<T, pelage::WindSettings> || std::same_as<T, pelage::ParameterCurves> ||
    std::same_as<T, pelage::SleepSettings> || std::same_as<T, pelage::HairContactSettings> ||
    std::same_as<T, pelage::SimulationSettings> || std::same_as<T, pelage::StrandMaterial> ||
    std::same_as<T, pelage::ColorTexture> || std::same_as<T, pelage::StrandTexture> ||
    std::same_as<T, pelage::OpaqueShadow> || std::same_as<T, pelage::EnvironmentLight>
        std::string text(const T&) {
  return "its own";
}

/// The row of a parameter that pelage::settings knows: its texts are those of the table there.
Parameter tuned(std::string_view owner, std::string_view field,
                std::optional<Picture> picture = {});

/// The rows of all these parts, one after the other.
template <class... Part>
std::vector<Parameter> joined(Part&&... part) {
  std::vector<Parameter> rows;
  const auto append = [&rows](std::vector<Parameter> more) {
    for (Parameter& row : more) rows.push_back(std::move(row));
  };
  (append(std::forward<Part>(part)), ...);
  return rows;
}

/// An object as it is made.
template <class T>
const T& untouched() {
  static const T value{};
  return value;
}
template <>
const pelage::HairObject& untouched<pelage::HairObject>();
template <>
const pelage::SdfCollider& untouched<pelage::SdfCollider>();

/// Pictures of a base setup with these values.
/// \param apply sets one of them: (Setup&, const T&).
template <class T, class Apply>
Picture show(Setup base, std::vector<T> values, Apply apply, std::string caption) {
  Picture picture;
  for (const auto& value : values) picture.values.push_back(text(static_cast<const T&>(value)));
  picture.make = [base = std::move(base), values, apply](size_t index) {
    Setup setup = base;
    apply(setup, values[index]);
    return setup;
  };
  picture.caption = std::move(caption);
  return picture;
}

/// A setup with a change.
template <class Change>
Setup with(Setup setup, Change change) {
  change(setup);
  return setup;
}

}  // namespace sample

/// The first members of a Parameter: the default is that of the field of this name.
#define PELAGE_FIELD(Owner, field) \
#Owner, #field, ::sample::text(::sample::untouched <pelage::Owner>().field)
