#include "simulation/csv_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

namespace bench {

pelage::Result<void> appendLines(const std::string& path, const char* header,
                                 const std::vector<std::string>& lines) {
  const auto error = [&](const char* what) {
    return pelage::Error{pelage::ErrorCode::kFileNotFound,
                         fmt::format("{}: cannot be {}: {}", path, what, std::strerror(errno))};
  };
  std::FILE* file = std::fopen(path.c_str(), "ab");
  if (file == nullptr) return error("opened");
  // The position of a stream opened for appending is not at the end before the first write.
  bool good = std::fseek(file, 0, SEEK_END) == 0;
  if (good && std::ftell(file) == 0) good = std::fputs(header, file) >= 0;
  for (const std::string& line : lines) good = good && std::fputs(line.c_str(), file) >= 0;
  good = std::fclose(file) == 0 && good;
  if (!good) return error("written");
  return {};
}

std::string csvNumber(double value, bool known) {
  return known ? fmt::format("{:.6g}", value) : "";
}

std::string csvEnd(const pelage::DeviceInfo& device) {
  return fmt::format("\"{}\",\"{}\"\n", device.name, device.driver);
}

std::string besidePath(const std::string& path, const char* suffix) {
  std::filesystem::path file(path);
  file.replace_filename(file.stem().string() + suffix + file.extension().string());
  return file.string();
}

}  // namespace bench
