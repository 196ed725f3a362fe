// Shared by the commands of a program: the report, for people or as JSON, and progress.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pelage/result.h"

namespace CLI {
class App;
}

namespace pelage::program {

/// Exit codes of programs.
inline constexpr int kFailure = 1, kBadArguments = 2;

/// One run of the program. A command adds facts to the report in the order in which they are to be
/// read; the session prints them at the end, as lines "label: text" or as one JSON object.
class Session {
 public:
  /// \param program  its name, for warnings
  explicit Session(std::string program) : program_(std::move(program)) {}

  bool json = false;   ///< --json
  bool quiet = false;  ///< --quiet

  /// Begins the report of another file: the program's JSON is then a list of them, "files".
  void beginFile();
  /// Ends the last of several reports; what is added from now on stands beside their list.
  /// \param list  its key, in place of "files"
  void endFiles(std::string_view list);
  /// \param key of the JSON object; empty for something that only people read.
  /// \param label, text what people read instead; an empty label for nothing.
  void add(std::string_view key, nlohmann::json value, std::string_view label, std::string text);
  /// Something that the artist should know: in the list "warnings" of the report, and on stderr.
  void warn(std::string text);
  /// An error in one of several files: in its report, and on stderr after all reports. The program
  /// goes on with the next file, and exits with kFailure in the end.
  void fail(std::string_view file, std::string text);
  /// The same for a report that does not name a file.
  void fail(std::string text);
  const std::vector<std::string>& errors() const { return errors_; }
  /// Prints the report on stdout.
  void print() const;

  /// A bar on stderr while that is a terminal; nothing with --quiet or --json.
  /// \param done, total steps of `what`; done = total removes the bar.
  void progress(std::string_view what, uint64_t done, uint64_t total);

  /// Set by the command that was chosen.
  std::function<Result<void>()> command;

 private:
  struct Line {
    std::string label, text;
  };
  std::string program_;
  nlohmann::ordered_json report_;
  std::vector<nlohmann::ordered_json> earlier_;  // reports of the files before
  std::string list_;                             // of endFiles()
  std::vector<Line> lines_;
  std::vector<std::string> warnings_, errors_;
  uint64_t drawnPermille_ = ~uint64_t{0};
};

/// Runs a program of commands, and returns its exit code. Errors go to stderr.
/// \param addCommands  adds the commands, and may keep `exitCode`: that of a run without an error
int runCommands(const char* program, const char* description, const char* version, int argc,
                char** argv,
                const std::function<void(CLI::App&, Session&, int& exitCode)>& addCommands);

}  // namespace pelage::program
