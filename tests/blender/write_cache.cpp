// Writes caches of simulated hair, and beside each the positions that the library reads from it as
// floats, for import_test.py: write_cache FOLDER.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <span>
#include <vector>

#include "pelage/hair_cache.h"

namespace {

using namespace pelage;

// Strands that swing, and stand still after a while.
std::vector<Float3> frameOf(const HairCacheDef& def, int frame) {
  std::vector<Float3> positions;
  const float time = 0.2f * static_cast<float>(std::min(frame, 5));
  for (uint32_t s = 0; s < def.strandCount; ++s) {
    const auto phase = 0.01f * static_cast<float>(s);
    const uint32_t vertices =
        def.vertexCounts.empty() ? def.verticesPerStrand : def.vertexCounts[s];
    for (uint32_t v = 0; v < vertices; ++v) {
      const float along = 0.01f * static_cast<float>(v);
      positions.push_back({phase + along * std::sin(time + phase), 1.7f - along,
                           0.1f * std::sin(40 * phase) + along * along * std::cos(3 * time)});
    }
  }
  return positions;
}

Result<void> write(const std::filesystem::path& path, const HairCacheDef& def) {
  auto writer = HairCacheWriter::create(path, def);
  if (!writer) return writer.error();
  for (int f = 0; f < 9; ++f)
    if (auto r = writer->append(frameOf(def, f)); !r) return r;
  if (auto r = writer->close(); !r) return r;
  auto reader = HairCacheReader::open(path);
  if (!reader) return reader.error();
  std::ofstream floats(path.string() + ".f32", std::ios::binary);
  std::vector<Float3> positions(reader->vertexCount());
  for (uint64_t f = 0; f < reader->frameCount(); ++f) {
    if (auto r = reader->read(f, positions); !r) return r;
    const auto bytes = std::as_bytes(std::span(positions));
    floats.write(reinterpret_cast<const char*>(bytes.data()),
                 static_cast<std::streamsize>(bytes.size()));
  }
  return {};
}

Result<void> writeAll(const std::filesystem::path& folder) {
  // Two chunks, all predictions; one chunk of many lengths; exact floats.
  HairCacheDef def = {.name = "even", .strandCount = 700, .verticesPerStrand = 16};
  def.firstFrame = 101;
  def.keyInterval = 4;
  if (auto r = write(folder / "even.pelagecache", def); !r) return r;
  def.name = "odd";
  def.strandCount = 90;
  for (uint32_t s = 0; s < def.strandCount; ++s) {
    def.vertexCounts.push_back(2 + s * 7 % 13);
    def.strandIds.push_back(1000 - s);
  }
  if (auto r = write(folder / "odd.pelagecache", def); !r) return r;
  def.name = "exact";
  def.errorBound = 0;
  return write(folder / "exact.pelagecache", def);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: write_cache FOLDER\n");
    return 1;
  }
  const auto done = writeAll(argv[1]);
  if (!done) std::fprintf(stderr, "%s\n", done.error().message.c_str());
  return done ? 0 : 1;
}
