#include "settings_file.h"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>
#include <type_traits>
#include <utility>

namespace pelage::program {
namespace {

using nlohmann::json;

/// Takes the members of an object one by one and remembers which were there.
class Reader {
 public:
  Reader(const json& object, std::string prefix, std::vector<std::string>& names)
      : object_(object), prefix_(std::move(prefix)), names_(names) {}

  template <class T>
  void take(const char* name, T& value) {
    known_.insert(name);
    const auto found = object_.find(name);
    if (found == object_.end() || error_) return;
    const char* wanted = convert(*found, value);
    if (wanted != nullptr)
      error_ = fmt::format("'{}{}' must be {}", prefix_, name, wanted);
    else
      names_.push_back(prefix_ + name);
  }

  /// The members of an object inside, by a function of a Reader.
  template <class Function>
  void inside(const char* name, Function&& function) {
    known_.insert(name);
    const auto found = object_.find(name);
    if (found == object_.end() || error_) return;
    if (!found->is_object()) {
      error_ = fmt::format("'{}{}' must be an object", prefix_, name);
      return;
    }
    Reader reader(*found, prefix_ + name + ".", names_);
    function(reader);
    error_ = reader.finish();
  }

  /// What was wrong, or the first name that is none of those taken.
  std::optional<std::string> finish() const {
    if (error_) return error_;
    for (const auto& [name, value] : object_.items()) {
      if (known_.contains(name)) continue;
      std::string list;
      for (const std::string& known : known_) list += (list.empty() ? "" : ", ") + known;
      return fmt::format("'{}{}' is no setting; there are: {}", prefix_, name, list);
    }
    return std::nullopt;
  }

 private:
  // Returns what the value must be if it is not, else nullptr.
  static const char* convert(const json& from, float& to) {
    if (!from.is_number()) return "a number";
    to = from.get<float>();
    return nullptr;
  }
  static const char* convert(const json& from, bool& to) {
    if (!from.is_boolean()) return "true or false";
    to = from.get<bool>();
    return nullptr;
  }
  static const char* convert(const json& from, uint32_t& to) {
    if (!from.is_number_unsigned() || from.get<uint64_t>() > 0xffffffffu)
      return "a whole number of at least 0";
    to = from.get<uint32_t>();
    return nullptr;
  }
  static const char* convert(const json& from, Solver& to) {
    if (from != "exact" && from != "classic") return "\"exact\" or \"classic\"";
    to = from == "exact" ? Solver::kExact : Solver::kClassic;
    return nullptr;
  }
  static const char* convert(const json& from, Float3& to) {
    float values[3];
    if (!convert(from, values)) return "an array of 3 numbers";
    to = {values[0], values[1], values[2]};
    return nullptr;
  }
  static const char* convert(const json& from, ParameterCurve& to) {
    float values[std::tuple_size_v<ParameterCurve>];
    if (!convert(from, values)) return "an array of 8 numbers";
    std::copy(std::begin(values), std::end(values), to.begin());
    return nullptr;
  }
  template <size_t kCount>
  static bool convert(const json& from, float (&to)[kCount]) {
    if (!from.is_array() || from.size() != kCount) return false;
    for (size_t i = 0; i < kCount; ++i) {
      if (!from[i].is_number()) return false;
      to[i] = from[i].get<float>();
    }
    return true;
  }

  const json& object_;
  std::string prefix_;
  std::vector<std::string>& names_;
  std::set<std::string> known_;
  std::optional<std::string> error_;
};

void takeGroups(Reader& reader, SimulationSettings& s) {
  reader.inside("wind", [&](Reader& in) {
    in.take("velocity", s.wind.velocity);
    in.take("gustStrength", s.wind.gustStrength);
    in.take("gustPeriod", s.wind.gustPeriod);
    in.take("strandVariation", s.wind.strandVariation);
  });
  reader.inside("curves", [&](Reader& in) {
    in.take("stiffness", s.curves.stiffness);
    in.take("globalStiffness", s.curves.globalStiffness);
    in.take("damping", s.curves.damping);
  });
  reader.inside("sleep", [&](Reader& in) {
    in.take("enabled", s.sleep.enabled);
    in.take("speed", s.sleep.speed);
    in.take("time", s.sleep.time);
    in.take("wakeDistance", s.sleep.wakeDistance);
  });
  reader.inside("contact", [&](Reader& in) {
    in.take("stiffness", s.contact.stiffness);
    in.take("friction", s.contact.friction);
    in.take("cellSize", s.contact.cellSize);
  });
}

// What was wrong, if anything.
std::optional<std::string> takeAll(const json& object, SimulationSettings& s,
                                   std::vector<std::string>& names) {
  Reader reader(object, "", names);
  reader.take("solver", s.solver);
  reader.take("gravity", s.gravity);
  reader.take("damping", s.damping);
  reader.take("bendLength", s.bendLength);
  reader.take("twistRatio", s.twistRatio);
  reader.take("relaxationTime", s.relaxationTime);
  reader.take("subSteps", s.subSteps);
  reader.take("localStiffness", s.localStiffness);
  reader.take("localIterations", s.localIterations);
  reader.take("globalStiffness", s.globalStiffness);
  reader.take("globalRange", s.globalRange);
  reader.take("vspCoefficient", s.vspCoefficient);
  reader.take("vspThreshold", s.vspThreshold);
  reader.take("airDrag", s.airDrag);
  reader.take("lengthIterations", s.lengthIterations);
  reader.take("maxSpeed", s.maxSpeed);
  reader.take("tipSeparation", s.tipSeparation);
  takeGroups(reader, s);
  return reader.finish();
}

// The JSON, with an error for a name that is in one object twice.
Result<json> parseJson(std::string_view text, std::string_view name) {
  std::vector<std::set<std::string>> open;
  std::string twice;
  const auto check = [&](int, json::parse_event_t event, json& value) {
    if (event == json::parse_event_t::object_start) open.emplace_back();
    if (event == json::parse_event_t::object_end) open.pop_back();
    if (event == json::parse_event_t::key && !open.back().insert(value.get<std::string>()).second)
      twice = value.get<std::string>();
    return true;
  };
  const auto fail = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidFile, fmt::format("{}: {}", name, what)};
  };
  try {
    json parsed = json::parse(text, check);
    if (!twice.empty()) return fail(fmt::format("'{}' is there twice", twice));
    if (!parsed.is_object()) return fail("it must be a JSON object: { ... }");
    return parsed;
  } catch (const json::parse_error& error) {
    return fail(fmt::format("byte {}: the JSON is damaged here, or is none", error.byte));
  } catch (const json::exception& error) {
    return fail(error.what());
  }
}

}  // namespace

struct SettingsFile::Values {
  json object;
};

Result<SettingsFile> SettingsFile::load(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  if (!file || !(text << file.rdbuf()))
    return Error{ErrorCode::kFileNotFound, path.string() + ": no such file, or nothing in it"};
  return parse(text.str(), path.string());
}

Result<SettingsFile> SettingsFile::parse(std::string_view text, std::string_view name) {
  auto object = parseJson(text, name);
  if (!object) return object.error();
  SettingsFile file;
  SimulationSettings settings;
  if (const auto wrong = takeAll(*object, settings, file.names_))
    return Error{ErrorCode::kInvalidFile, fmt::format("{}: {}", name, *wrong)};
  if (auto r = validate(settings); !r)
    return Error{ErrorCode::kInvalidFile, fmt::format("{}: {}", name, r.error().message)};
  file.values_ = std::make_shared<const Values>(Values{*std::move(object)});
  return file;
}

void SettingsFile::apply(SimulationSettings& settings) const {
  std::vector<std::string> names;
  if (values_) (void)takeAll(values_->object, settings, names);
}

}  // namespace pelage::program
