#include "codegen/unit.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <nlohmann/json.hpp>

#include "codegen/checks/checks.h"
#include "codegen/checks/source_model.h"
#include "codegen/checks/token_stream.h"
#include "codegen/error_recovery.h"
#include "codegen/file_io.h"

namespace pelage::codegen {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json::binary_t packWords(const std::vector<uint32_t>& words) {
  json::binary_t::container_type bytes;
  bytes.reserve(words.size() * 4);
  for (const uint32_t word : words) {
    for (int shift = 0; shift < 32; shift += 8)
      bytes.push_back(static_cast<uint8_t>(word >> shift));
  }
  return json::binary_t(std::move(bytes));
}

std::vector<uint32_t> unpackWords(const json& value) {
  const json::binary_t& bytes = value.get_binary();
  std::vector<uint32_t> words(bytes.size() / 4);
  for (size_t i = 0; i < words.size() * 4; ++i) {
    words[i / 4] |= uint32_t{bytes[i]} << (8 * (i % 4));
  }
  return words;
}

json pack(const Diagnostics& diagnostics) {
  json list = json::array();
  for (const Diagnostic& d : diagnostics.items()) {
    list.push_back({d.file, d.line, d.code, d.message, d.isError});
  }
  return list;
}

Diagnostics unpackDiagnostics(const json& list) {
  Diagnostics diagnostics;
  for (const json& d : list) {
    diagnostics.add({d.at(0).get<std::string>(), d.at(1).get<uint32_t>(),
                     d.at(2).get<std::string>(), d.at(3).get<std::string>(), d.at(4).get<bool>()});
  }
  return diagnostics;
}

std::string toText(const json& value) {
  const std::vector<uint8_t> bytes = json::to_cbor(value);
  return {bytes.begin(), bytes.end()};
}

template <class Result, class Fill>
std::optional<Result> decode(const std::string& text, const Fill& fill) {
  try {
    const json value = json::from_cbor(text);
    Result result;
    result.complete = value.at("complete").get<bool>();
    result.diagnostics = unpackDiagnostics(value.at("diagnostics"));
    fill(value, result);
    return result;
  } catch (const json::exception&) {
    return std::nullopt;
  }
}

void addMessages(const std::vector<FrontEndMessage>& messages, Diagnostics& diagnostics) {
  for (const FrontEndMessage& message : messages) {
    if (message.isError) diagnostics.error(message.file, message.line, "PK400", message.text);
  }
}

std::map<std::string, SourceLocation> findDeclarations(const std::string& text,
                                                       const std::string& file) {
  std::map<std::string, SourceLocation> declarations;
  const checks::TokenStream stream = checks::tokenize(text, file);
  const checks::SourceModel model = checks::parseSource(stream);
  const auto add = [&](size_t token) {
    const checks::Token& t = stream.at(token);
    declarations.emplace(std::string(t.text), SourceLocation{stream.fileOf(t), t.line});
  };
  for (const checks::Declaration& global : model.globals) add(global.name);
  for (const checks::ConstantBlock& block : model.blocks) add(block.nameToken);
  for (const checks::Struct& type : model.structs) add(type.nameToken);
  for (const checks::Function& function : model.functions) add(function.name);
  return declarations;
}

// Saves the results so far to disk: glslang may crash the process in any of its calls.
// \return the exit status
template <class Result>
int write(const fs::path& file, const Result& result) {
  return writeWholeFile(file, encode(result)) ? 0 : 1;
}

json pack(const FrontEndInput& source) {
  json macros = json::array(), includeDirs = json::array();
  for (const auto& [name, value] : source.macros) macros.push_back({name, value});
  for (const fs::path& dir : source.includeDirs) includeDirs.push_back(dir.string());
  return {{"baseDir", source.baseDir.string()},
          {"file", source.file},
          {"entry", source.entry},
          {"stage", static_cast<int>(source.stage)},
          {"macros", std::move(macros)},
          {"includeDirs", std::move(includeDirs)}};
}

FrontEndInput unpackSource(const json& value) {
  FrontEndInput source;
  source.baseDir = value.at("baseDir").get<std::string>();
  source.file = value.at("file").get<std::string>();
  source.entry = value.at("entry").get<std::string>();
  source.stage = static_cast<Stage>(value.at("stage").get<int>());
  for (const json& macro : value.at("macros"))
    source.macros.emplace_back(macro.at(0).get<std::string>(), macro.at(1).get<std::string>());
  for (const json& dir : value.at("includeDirs"))
    source.includeDirs.emplace_back(dir.get<std::string>());
  return source;
}

template <class Result>
PreprocessOutput preprocess(const FrontEndInput& input, Result& result) {
  PreprocessOutput source = preprocessHlsl(input);
  result.files = source.files;
  addMessages(source.messages, result.diagnostics);
  if (!source.ok && !result.diagnostics.hasErrors())
    result.diagnostics.error(input.file, 1, "PK400", "the preprocessor gave up without a message");
  return source;
}

int runFrontEnd(const json& job, const fs::path& file) {
  const FrontEndInput input = unpackSource(job.at("source"));
  FrontEndResult result;
  const PreprocessOutput source = preprocess(input, result);
  if (!source.ok) {
    result.complete = true;
    return write(file, result);
  }

  CheckInput check;
  check.stage = input.stage;
  check.entry = input.entry;
  check.file = input.file;
  check.preprocessed = source.text;
  check.precise = job.at("precise").get<bool>();
  runSourceChecks(check, result.diagnostics);
  result.declarations = findDeclarations(source.text, input.file);
  if (write(file, result) != 0) return 1;

  FrontEndOutput output = compileHlsl(input);
  if (!output.ok) {
    // The first message is the cause; later ones at the same location are consequences.
    FrontEndResult early = result;
    addMessages({*std::find_if(output.messages.begin(), output.messages.end(),
                               [](const FrontEndMessage& m) { return m.isError; })},
                early.diagnostics);
    if (write(file, early) != 0) return 1;
    addMessages(findAllErrors(input, source.text, output.messages), result.diagnostics);
    result.complete = true;
    return write(file, result);
  }
  result.spirv = std::move(output.spirv);
  result.log = std::move(output.log);
  check.rawSpirv = result.spirv;
  check.frontEndLog = result.log;
  runModuleChecks(check, result.diagnostics);
  result.complete = true;
  return write(file, result);
}

int runConstants(const json& job, const fs::path& file) {
  const FrontEndInput input = unpackSource(job.at("source"));
  ConstantsResult result;
  result.complete = true;
  const PreprocessOutput source = preprocess(input, result);
  if (!result.diagnostics.hasErrors())
    result.constants = findConstants(source.text, input.file, result.diagnostics);
  if (!result.diagnostics.hasErrors()) {
    const FrontEndInput probe = constantsProbe(input, source.text, result.constants);
    const FrontEndOutput output = compileHlsl(probe);
    if (output.ok) {
      readConstants(output.spirv, input.file, result.constants, result.diagnostics);
    } else {
      addMessages(findAllErrors(probe, *probe.text, output.messages), result.diagnostics);
    }
  }
  return write(file, result);
}

int runBackEnd(const json& job, const fs::path& file) {
  BackEndInput input;
  const std::vector<uint32_t> raw = unpackWords(job.at("spirv"));
  input.rawSpirv = raw;
  input.entry = job.at("entry").get<std::string>();
  input.stage = static_cast<Stage>(job.at("stage").get<int>());
  input.tier = static_cast<Tier>(job.at("tier").get<int>());
  input.firstStorageBinding = job.at("firstStorageBinding").get<uint32_t>();
  input.precise = job.at("precise").get<bool>();
  for (const json& p : job.at("patches")) {
    input.patches.push_back({p.at(0).get<uint32_t>(), p.at(1).get<uint32_t>(),
                             p.at(2).get<uint32_t>(), p.at(3).get<uint32_t>(),
                             static_cast<ResourceKind>(p.at(4).get<int>())});
  }
  const auto entryFile = job.at("entryFile").get<std::string>();
  const auto entryLine = job.at("entryLine").get<uint32_t>();

  BackEndOutput output = runBackEnd(input);
  BackEndResult result;
  CheckInput check;
  check.stage = input.stage;
  check.entry = input.entry;
  check.file = job.at("file").get<std::string>();
  check.rawSpirv = raw;
  check.optimisedSpirv = output.optimised;
  check.frontEndLog = job.at("log").get<std::string>();
  check.glsl = output.glsl;
  check.essl = output.essl;
  check.tier = input.tier;
  check.precise = input.precise;
  runModuleChecks(check, result.diagnostics);
  for (const BackEndError& error : output.errors) {
    result.diagnostics.add({entryFile, entryLine, error.code, error.message, error.isError});
  }
  result.optimised = std::move(output.optimised);
  result.spirv = std::move(output.spirv);
  result.glsl = std::move(output.glsl);
  result.essl = std::move(output.essl);
  result.complete = true;
  return write(file, result);
}

}  // namespace

std::string Unit::text() const {
  return "'" + kernel->name + "'" + (key.empty() ? "" : " with " + key);
}

SourceLocation Unit::locate(const std::string& name) const {
  const auto found = front.declarations.find(name);
  return found != front.declarations.end() ? found->second : SourceLocation{kernel->file, 1};
}

std::string encode(const FrontEndJob& job) {
  return toText({{"step", "front end"}, {"source", pack(job.source)}, {"precise", job.precise}});
}

std::string encode(const BackEndJob& job) {
  json patches = json::array();
  for (const BindingPatch& p : job.patches) {
    patches.push_back({p.set, p.rawBinding, p.binding, p.glBinding, static_cast<int>(p.kind)});
  }
  return toText({{"step", "back end"},
                 {"file", job.file},
                 {"entry", job.entry},
                 {"entryFile", job.entryLocation.file},
                 {"entryLine", job.entryLocation.line},
                 {"stage", static_cast<int>(job.stage)},
                 {"tier", static_cast<int>(job.tier)},
                 {"firstStorageBinding", job.firstStorageBinding},
                 {"precise", job.precise},
                 {"spirv", packWords(job.spirv)},
                 {"log", job.log},
                 {"patches", std::move(patches)}});
}

std::string encode(const ConstantsJob& job) {
  return toText({{"step", "constants"}, {"source", pack(job.source)}});
}

std::string encode(const FrontEndResult& result) {
  json declarations = json::object();
  for (const auto& [name, where] : result.declarations)
    declarations[name] = {where.file, where.line};
  return toText({{"complete", result.complete},
                 {"diagnostics", pack(result.diagnostics)},
                 {"spirv", packWords(result.spirv)},
                 {"log", result.log},
                 {"files", result.files},
                 {"declarations", std::move(declarations)}});
}

std::string encode(const BackEndResult& result) {
  return toText({{"complete", result.complete},
                 {"diagnostics", pack(result.diagnostics)},
                 {"optimised", packWords(result.optimised)},
                 {"spirv", packWords(result.spirv)},
                 {"glsl", result.glsl},
                 {"essl", result.essl}});
}

std::string encode(const ConstantsResult& result) {
  json constants = json::array();
  for (const SharedConstant& c : result.constants)
    constants.push_back({c.name, static_cast<int>(c.type), c.bits, c.line});
  return toText({{"complete", result.complete},
                 {"diagnostics", pack(result.diagnostics)},
                 {"files", result.files},
                 {"constants", std::move(constants)}});
}

std::optional<FrontEndResult> decodeFrontEndResult(const std::string& text) {
  return decode<FrontEndResult>(text, [](const json& value, FrontEndResult& result) {
    result.spirv = unpackWords(value.at("spirv"));
    result.log = value.at("log").get<std::string>();
    result.files = value.at("files").get<std::vector<std::string>>();
    for (const auto& [name, where] : value.at("declarations").items())
      result.declarations[name] = {where.at(0).get<std::string>(), where.at(1).get<uint32_t>()};
  });
}

std::optional<BackEndResult> decodeBackEndResult(const std::string& text) {
  return decode<BackEndResult>(text, [](const json& value, BackEndResult& result) {
    result.optimised = unpackWords(value.at("optimised"));
    result.spirv = unpackWords(value.at("spirv"));
    result.glsl = value.at("glsl").get<std::string>();
    result.essl = value.at("essl").get<std::string>();
  });
}

std::optional<ConstantsResult> decodeConstantsResult(const std::string& text) {
  return decode<ConstantsResult>(text, [](const json& value, ConstantsResult& result) {
    result.files = value.at("files").get<std::vector<std::string>>();
    for (const json& c : value.at("constants"))
      result.constants.push_back({c.at(0).get<std::string>(),
                                  static_cast<ScalarType>(c.at(1).get<int>()),
                                  c.at(2).get<uint32_t>(), c.at(3).get<uint32_t>()});
  });
}

int runUnit(const fs::path& stem) {
  const std::string jobFile = stem.string() + ".job";
  try {
    const std::optional<std::string> text = readWholeFile(jobFile);
    if (!text) {
      std::fprintf(stderr, "cannot read %s\n", jobFile.c_str());
      return 1;
    }
    const json job = json::from_cbor(*text);
    const fs::path file = stem.string() + ".result";
    if (job.at("step") == "constants") return runConstants(job, file);
    return job.at("step") == "front end" ? runFrontEnd(job, file) : runBackEnd(job, file);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
}

}  // namespace pelage::codegen
