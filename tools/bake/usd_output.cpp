#include "usd_output.h"

#include <cctype>
#include <cstdint>
#include <numeric>
#include <string>
#include <vector>

#include "pelage/authoring/usd_curves.h"
#include "pelage/hair_cache.h"

namespace pelage::bake {
namespace {

// A name that a prim can have.
std::string primName(std::string name) {
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  if (name.empty() || std::isdigit(static_cast<unsigned char>(name.front())) != 0)
    name.insert(0, "_");
  return name.substr(0, 255);
}

}  // namespace

Result<void> writeUsd(const std::filesystem::path& cache, float width,
                      const std::filesystem::path& path, uint32_t threads) {
  auto reader = HairCacheReader::open(cache);
  if (!reader) return reader.error();
  const HairCacheDef& from = reader->def();
  UsdCurvesDef def;
  def.name = primName(from.name);
  def.vertexCounts = from.vertexCounts;
  if (def.vertexCounts.empty()) def.vertexCounts.assign(from.strandCount, from.verticesPerStrand);
  def.widths = {width};
  def.strandIds.resize(from.strandCount);
  std::iota(def.strandIds.begin(), def.strandIds.end(), uint64_t{0});
  def.framesPerSecond = from.framesPerSecond;
  def.firstFrame = from.firstFrame;
  auto writer = UsdCurvesWriter::create(path, std::move(def), threads);
  if (!writer) return writer.error();
  std::vector<Float3> positions(reader->vertexCount());
  for (uint64_t frame = 0; frame < reader->frameCount(); ++frame) {
    if (auto done = reader->read(frame, positions); !done) return done;
    if (auto done = writer->append(positions); !done) return done;
  }
  return writer->close();
}

}  // namespace pelage::bake
