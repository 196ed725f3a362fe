// The table of parameters against the headers, and docs/parameters.md against the table.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "pelage/settings/settings_file.h"
#include "pelage/simulation_settings.h"
#include "support/test_folder.h"
#include "table.h"

namespace {

using pelage::test::textOf;

const std::filesystem::path kSource = PELAGE_SOURCE_DIR;

// Structs of these headers that a program does not set: results, buffers and assets; options of
// loaders are in docs/assets.md.
const std::set<std::string> kNoParameters = {"TransparencyPlan",
                                             "TransparencyTiles",
                                             "DrawnStrands",
                                             "TransparencyCounters",
                                             "TransparencyWork",
                                             "TransparencyCost",
                                             "SimulationCounters",
                                             "HairOutputs",
                                             "SdfGrid",
                                             "SdfCounters",
                                             "SdfOutputs",
                                             "TfxFileLayout",
                                             "FollowHair",
                                             "HairAsset",
                                             "TfxLoadOptions",
                                             "TfxLoadReport",
                                             "Groom",
                                             "ContactCounters",
                                             "FollowContactCounters",
                                             "DenseSdf",
                                             "SdfData",
                                             "HairSize",
                                             "UnitGuess"};

// The names that one declaration without initialisers declares.
void addNames(const std::string& declaration, std::set<std::string>& names) {
  std::istringstream parts(declaration);
  for (std::string part; std::getline(parts, part, ',');) {
    std::smatch name;
    if (std::regex_search(part, name, std::regex(R"((\w+)\s*$)"))) names.insert(name[1]);
  }
}

// Public data members of each struct and class that a header of the house's style defines.
std::map<std::string, std::set<std::string>> fieldsOf(std::string header) {
  header = std::regex_replace(header, std::regex("//[^\n]*"), "");
  std::map<std::string, std::set<std::string>> fields;
  const std::regex start(R"(\n(struct|class) (?:PELAGE_API )?(\w+) \{)");
  for (std::sregex_iterator it(header.begin(), header.end(), start), end; it != end; ++it) {
    const auto from = static_cast<size_t>(it->position() + it->length());
    std::string body = header.substr(from, header.find("\n};", from) - from);
    body = body.substr(0, body.find("\n private:"));
    body = std::regex_replace(body, std::regex(R"(\n public:)"), "");
    body = std::regex_replace(body, std::regex(R"(bool operator==[^;]*;)"), "");
    body = std::regex_replace(body, std::regex(R"(\)\s*(const)?\s*\{[^{}]*\})"), ");");
    // A nested struct's own fields are not the outer one's.
    body = std::regex_replace(body, std::regex(R"(struct \w+ \{[^{}]*\};)"), "");
    for (const char* pattern : {R"(\{[^{}]*\})", R"(\{[^{}]*\})", "<[^<>]*>", "=[^,;]*"})
      body = std::regex_replace(body, std::regex(pattern), "");
    std::set<std::string>& names = fields[(*it)[2]];
    std::istringstream declarations(body);
    for (std::string one; std::getline(declarations, one, ';');)
      if (one.find('(') == std::string::npos) addNames(one, names);
  }
  return fields;
}

std::map<std::string, std::set<std::string>> fieldsOfTable() {
  std::map<std::string, std::set<std::string>> fields;
  for (const sample::ParameterGroup& group : sample::parameterTable())
    for (const sample::Parameter& parameter : group.parameters)
      fields[group.owner].insert(parameter.field);
  return fields;
}

TEST(ParameterTable, ReadsFieldsOfAHeader) {
  const auto fields = fieldsOf(
      "\nstruct A {\n  float x = 0, y = 0;  // z\n  Float3 a[3] = {{1, 0, 0}, {0, 1, 0}};\n"
      "  std::array<float, 3> c = {};\n"
      "  uint64_t b = uint64_t{512} << 20;\n  bool operator==(const A&) const = default;\n};\n"
      "\nclass PELAGE_API B {\n public:\n  int f() const { return g_; }\n  void h(int k);\n  bool "
      "open = "
      "true;\n\n private:\n  int g_;\n};\n");
  EXPECT_EQ(fields.at("A"), (std::set<std::string>{"x", "y", "b", "c"}));
  EXPECT_EQ(fields.at("B"), std::set<std::string>{"open"});
}

TEST(ParameterTable, HasEveryFieldOfItsStructsAndNoOther) {
  std::map<std::string, std::set<std::string>> headers;
  for (const sample::ParameterGroup& group : sample::parameterTable())
    if (headers.count(group.owner) == 0)
      headers.merge(fieldsOf(textOf(kSource / "include" / group.header)));
  for (const auto& [owner, fields] : fieldsOfTable()) EXPECT_EQ(headers[owner], fields) << owner;
}

// The names that the error of a settings file with an unknown name lists.
std::set<std::string> settingsOfFiles(const std::string& text) {
  const auto file = pelage::SettingsFile::parse(text, "a.json");
  std::set<std::string> names;
  if (file) return names;
  const std::string& message = file.error().message;
  addNames(message.substr(message.find("there are: ") + 11), names);
  return names;
}

TEST(ParameterTable, HasTheSettingsThatAFileOfThemCanHave) {
  const auto fields = fieldsOfTable();
  EXPECT_EQ(settingsOfFiles(R"({"simulation": {"zzz": 0}})"), fields.at("SimulationSettings"));
  EXPECT_EQ(settingsOfFiles(R"({"wind": {"zzz": 0}})"), fields.at("WindSettings"));
  EXPECT_EQ(settingsOfFiles(R"({"curves": {"zzz": 0}})"), fields.at("ParameterCurves"));
  EXPECT_EQ(settingsOfFiles(R"({"sleep": {"zzz": 0}})"), fields.at("SleepSettings"));
  EXPECT_EQ(settingsOfFiles(R"({"contact": {"zzz": 0}})"), fields.at("HairContactSettings"));
}

// Members that no file of settings and no editor sets, of structs that they do set: structs whose
// own members are parameters; what belongs to a groom, a camera or a window; handles.
const std::map<std::string, std::set<std::string>> kNotTuned = {
    {"SimulationSettings", {"wind", "curves", "sleep", "contact"}},
    {"HairObject", {"settings", "material", "strandTexture"}},
    {"HairDef",
     {"name", "settings", "material", "influences", "boneCount", "skeleton", "strandFactors",
      "followHairs", "baseTexture", "strandUvs"}},
    {"Light", {"environment", "opaque"}},
    {"OpaqueShadow", {"depth", "width", "height", "worldToClip", "reversedDepth"}},
    {"View", {"worldToClip", "eye", "x", "y", "width", "height"}},
    {"TransparencySettings", {"opaqueDepth", "engineLights"}}};
// The same of whole structs: of a groom, a collider or a frame.
const std::set<std::string> kNotTunedStructs = {
    "StrandFactors",   "ColorTexture",   "StrandTexture",     "ProcessDef",
    "CapsuleCollider", "SdfColliderDef", "HairDepthSettings", "GroomDef"};

TEST(ParameterTable, HasEveryOtherParameterInFilesAndEditors) {
  std::map<std::string, std::set<std::string>> wanted = fieldsOfTable(), tuned;
  for (const std::string& owner : kNotTunedStructs) EXPECT_EQ(wanted.erase(owner), 1u) << owner;
  for (const auto& [owner, fields] : kNotTuned)
    for (const std::string& field : fields)
      EXPECT_EQ(wanted[owner].erase(field), 1u) << owner << "::" << field;
  for (const pelage::SettingsSection& section : pelage::settingsSections())
    for (const pelage::Parameter& p : section.parameters)
      EXPECT_TRUE(tuned[std::string(p.owner)].insert(std::string(p.field)).second) << p.field;
  EXPECT_EQ(tuned, wanted);
}

TEST(ParameterTable, HasEveryStructOfItsHeadersThatIsSet) {
  const auto table = fieldsOfTable();
  std::set<std::string> headers;
  for (const sample::ParameterGroup& group : sample::parameterTable()) headers.insert(group.header);
  for (const std::string& header : headers)
    for (const auto& [owner, fields] : fieldsOf(textOf(kSource / "include" / header)))
      EXPECT_TRUE(table.count(owner) + kNoParameters.count(owner) == 1)
          << owner << " of " << header << " is not in the table of sample/parameters";
}

TEST(ParameterTable, PicturesShowValuesThatAreTaken) {
  for (const sample::ParameterGroup& group : sample::parameterTable())
    for (const sample::Parameter& p : group.parameters) {
      EXPECT_EQ(p.owner, group.owner);
      EXPECT_FALSE(p.meaning.empty()) << p.field;
      if (!p.picture) continue;
      EXPECT_GE(p.picture->values.size(), 2u) << p.field;
      for (size_t i = 0; i < p.picture->values.size(); ++i) {
        const auto valid = pelage::validate(p.picture->make(i).hair.settings);
        EXPECT_TRUE(valid) << p.field << ": " << (valid ? "" : valid.error().message);
      }
    }
}

TEST(ParameterPage, IsWhatTheProgramWrites) {
  EXPECT_EQ(textOf(kSource / "docs/parameters.md"), sample::parameterPage())
      << "write it again: pelage-parameters --doc docs/parameters.md";
}

TEST(ParameterPage, HasItsPicturesAndNoOthers) {
  std::set<std::string> wanted, found;
  for (const sample::ParameterGroup& group : sample::parameterTable())
    for (const sample::Parameter& p : group.parameters)
      if (p.picture) wanted.insert(sample::pictureFile(p));
  for (const auto& entry : std::filesystem::directory_iterator(kSource / "docs/images/parameters"))
    found.insert(entry.path().filename().string());
  EXPECT_EQ(found, wanted) << "render them: scripts/parameter_pictures.sh";
}

}  // namespace
