#include "codegen/front_end.h"

#include <glslang/MachineIndependent/localintermediate.h>
#include <glslang/Public/ResourceLimits.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <memory>
#include <optional>
#include <sstream>

#include "codegen/file_io.h"

namespace pelage::codegen {
namespace {

namespace fs = std::filesystem;

// glslang keeps process-wide tables.
void initializeOnce() {
  struct Process {
    Process() { glslang::InitializeProcess(); }
    ~Process() { glslang::FinalizeProcess(); }
  };
  static const Process process;
}

EShLanguage language(Stage stage) {
  switch (stage) {
    case Stage::kVertex:
      return EShLangVertex;
    case Stage::kPixel:
      return EShLangFragment;
    case Stage::kCompute:
      break;
  }
  return EShLangCompute;
}

class FileIncluder final : public glslang::TShader::Includer {
 public:
  explicit FileIncluder(const FrontEndInput& input) : input_(input) {}

  IncludeResult* includeLocal(const char* header, const char* includer, size_t depth) override {
    return open(resolve(includer).parent_path() / header, depth);
  }
  IncludeResult* includeSystem(const char* header, const char*, size_t depth) override {
    if (IncludeResult* result = open(input_.baseDir / header, depth)) return result;
    for (const fs::path& dir : input_.includeDirs) {
      if (IncludeResult* result = open(dir / header, depth)) return result;
    }
    return nullptr;
  }
  void releaseInclude(IncludeResult* result) override { delete result; }

  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& [name, text] : texts_) names.push_back(name);
    return names;
  }
  const std::vector<std::string>& missing() const { return missing_; }

 private:
  // glslang has no guard of its own against a file that includes itself.
  static constexpr size_t kMaximumDepth = 64;

  fs::path resolve(const std::string& name) const {
    const fs::path path(name);
    return path.is_absolute() ? path : input_.baseDir / path;
  }

  IncludeResult* open(const fs::path& path, size_t depth) {
    if (depth > kMaximumDepth) return nullptr;
    const std::string name = displayName(path, input_.baseDir);
    auto found = texts_.find(name);
    if (found == texts_.end()) {
      std::optional<std::string> text = readWholeFile(path);
      if (!text) {
        if (std::find(missing_.begin(), missing_.end(), name) == missing_.end()) {
          missing_.push_back(name);
        }
        return nullptr;
      }
      found = texts_.emplace(name, std::move(*text)).first;
    }
    return new IncludeResult(name, found->second.data(), found->second.size(), nullptr);
  }

  const FrontEndInput& input_;
  std::map<std::string, std::string> texts_;
  std::vector<std::string> missing_;
};

// "ERROR: kernels/a.hlsl:12: 'x' : undeclared" or "WARNING: ..." or anything else.
std::vector<FrontEndMessage> parseLog(const std::string& log, const std::string& defaultFile) {
  std::vector<FrontEndMessage> messages;
  std::istringstream stream(log);
  for (std::string line; std::getline(stream, line);) {
    FrontEndMessage message{defaultFile, 1, {}, true};
    std::string_view rest = line;
    if (rest.starts_with("ERROR: ")) {
      rest.remove_prefix(7);
    } else if (rest.starts_with("WARNING: ")) {
      rest.remove_prefix(9);
      message.isError = false;
    } else {
      continue;
    }
    // The count of errors at the end says nothing new.
    if (rest.find("compilation errors.  No code generated") != std::string_view::npos) continue;
    for (size_t colon = rest.find(':'); colon != std::string_view::npos;
         colon = rest.find(':', colon + 1)) {
      uint32_t number = 0;
      const char* begin = rest.data() + colon + 1;
      const char* end = rest.data() + rest.size();
      const auto [next, error] = std::from_chars(begin, end, number);
      if (error == std::errc() && next != end && *next == ':') {
        message.file = std::string(rest.substr(0, colon));
        message.line = std::max(number, 1u);
        rest.remove_prefix(static_cast<size_t>(next - rest.data()) + 1);
        break;
      }
    }
    while (!rest.empty() && rest.front() == ' ') rest.remove_prefix(1);
    while (!rest.empty() && (rest.back() == ' ' || rest.back() == '\r')) rest.remove_suffix(1);
    if (rest.empty()) continue;
    if (message.file.empty()) message.file = defaultFile;
    message.text = std::string(rest);
    messages.push_back(std::move(message));
  }
  return messages;
}

std::string preamble(const FrontEndInput& input) {
  std::string text;
  for (const auto& [name, value] : input.macros) text += "#define " + name + " " + value + "\n";
  return text;
}

// Preprocessing and compiling share the source text and the set-up of the shader object.
struct Job {
  explicit Job(const FrontEndInput& input)
      : includer(input), shader(language(input.stage)), defines(preamble(input)), name(input.file) {
    std::optional<std::string> text =
        input.text ? input.text : readWholeFile(input.baseDir / input.file);
    found = text.has_value();
    if (found) source = std::move(*text);
    strings[0] = source.c_str();
    lengths[0] = static_cast<int>(source.size());
    names[0] = name.c_str();
    shader.setStringsWithLengthsAndNames(strings, lengths, names, 1);
    shader.setPreamble(defines.c_str());
    shader.setEntryPoint(input.entry.c_str());
    shader.setSourceEntryPoint(input.entry.c_str());
    shader.setEnvInput(glslang::EShSourceHlsl, language(input.stage), glslang::EShClientVulkan,
                       100);
    shader.setEnvClient(glslang::EShClientVulkan, glslang::EShTargetVulkan_1_1);
    shader.setEnvTarget(glslang::EShTargetSpv, glslang::EShTargetSpv_1_3);
    shader.setHlslIoMapping(true);
    shader.setShiftBinding(glslang::EResUbo, RegisterBase::kUniform);
    shader.setShiftBinding(glslang::EResTexture, RegisterBase::kTexture);
    shader.setShiftBinding(glslang::EResUav, RegisterBase::kUav);
    shader.setShiftBinding(glslang::EResSampler, RegisterBase::kSampler);
    // Resources that the HLSL mapping does not call a UAV keep the class of their register.
    shader.setShiftBinding(glslang::EResImage, RegisterBase::kUav);
    shader.setShiftBinding(glslang::EResSsbo, RegisterBase::kUav);
  }

  std::vector<std::string> files() const {
    std::vector<std::string> result{name};
    for (std::string& file : includer.files()) {
      if (file != name) result.push_back(std::move(file));
    }
    return result;
  }

  FileIncluder includer;
  glslang::TShader shader;
  std::string source, defines, name;
  const char* strings[1];
  int lengths[1];
  const char* names[1];
  bool found = false;
};

FrontEndMessage fileNotFound(const FrontEndInput& input) {
  return {input.file, 1, "cannot open the file", true};
}

constexpr auto kHlslMessages =
    static_cast<EShMessages>(EShMsgReadHlsl | EShMsgSpvRules | EShMsgVulkanRules | EShMsgDebugInfo);
constexpr int kDefaultVersion = 500;

}  // namespace

std::string displayName(const fs::path& file, const fs::path& baseDir) {
  const fs::path relative = file.lexically_normal().lexically_relative(baseDir.lexically_normal());
  if (!relative.empty() && *relative.begin() != "..") return relative.generic_string();
  std::error_code error;
  const fs::path absolute = fs::absolute(file, error);
  return (error ? file : absolute).lexically_normal().generic_string();
}

PreprocessOutput preprocessHlsl(const FrontEndInput& input) {
  initializeOnce();
  PreprocessOutput output;
  Job job(input);
  if (!job.found) {
    output.messages.push_back(fileNotFound(input));
    return output;
  }
  output.ok = job.shader.preprocess(GetDefaultResources(), kDefaultVersion, ENoProfile, false,
                                    false, kHlslMessages, &output.text, job.includer);
  output.messages = parseLog(job.shader.getInfoLog(), input.file);
  output.files = job.files();
  output.missingFiles = job.includer.missing();
  return output;
}

FrontEndOutput compileHlsl(const FrontEndInput& input) {
  initializeOnce();
  FrontEndOutput output;
  Job job(input);
  if (!job.found) {
    output.messages.push_back(fileNotFound(input));
    return output;
  }
  bool ok =
      job.shader.parse(GetDefaultResources(), kDefaultVersion, false, kHlslMessages, job.includer);
  output.log = job.shader.getInfoLog();
  output.files = job.files();
  output.missingFiles = job.includer.missing();

  glslang::TProgram program;
  if (ok) {
    program.addShader(&job.shader);
    ok = program.link(kHlslMessages) && program.mapIO();
    output.log += program.getInfoLog();
  }
  if (ok) {
    glslang::TIntermediate* intermediate = program.getIntermediate(language(input.stage));
    // Else storage buffers become uniform "BufferBlock"s, which newer targets refuse.
    intermediate->setUseStorageBuffer();
    glslang::SpvOptions options;
    options.generateDebugInfo = true;
    options.disableOptimizer = true;
    spv::SpvBuildLogger logger;
    glslang::GlslangToSpv(*intermediate, output.spirv, &logger, &options);
    output.log += logger.getAllMessages();
  }
  output.messages = parseLog(output.log, input.file);
  if (!ok && std::none_of(output.messages.begin(), output.messages.end(),
                          [](const FrontEndMessage& m) { return m.isError; })) {
    output.messages.push_back({input.file, 1, "the front end gave up without a message", true});
  }
  output.ok = ok;
  return output;
}

std::string parseGlsl(std::string_view text, Stage stage) {
  initializeOnce();
  glslang::TShader shader(language(stage));
  const char* strings[1] = {text.data()};
  const int lengths[1] = {static_cast<int>(text.size())};
  shader.setStringsWithLengths(strings, lengths, 1);
  shader.setEnvInput(glslang::EShSourceGlsl, language(stage), glslang::EShClientOpenGL, 100);
  shader.setEnvClient(glslang::EShClientOpenGL, glslang::EShTargetOpenGL_450);
  if (shader.parse(GetDefaultResources(), 100, false, EShMsgDefault)) return {};
  const std::string log = shader.getInfoLog();
  return log.empty() ? "the parser gave no reason" : log;
}

std::string frontEndVersion() {
  const glslang::Version version = glslang::GetVersion();
  return "glslang " + std::to_string(version.major) + "." + std::to_string(version.minor) + "." +
         std::to_string(version.patch);
}

}  // namespace pelage::codegen
