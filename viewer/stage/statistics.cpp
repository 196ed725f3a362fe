#include "stage/statistics.h"

#include <fmt/format.h>

#include <cstddef>

namespace viewer {

using pelage::BufferId;
using pelage::Result;

namespace {

// Reads the counters of a buffer; they get no value if it does not exist.
template <class Counters>
Result<void> count(BufferId buffer, const pelage::BufferReader& read,
                   Counters (*parse)(std::span<const std::byte>),
                   std::optional<Counters>& counters) {
  if (buffer == BufferId::kInvalid) return {};
  const auto bytes = read(buffer);
  if (!bytes) return bytes.error();
  counters = parse(*bytes);
  return {};
}

}  // namespace

Result<std::vector<HairStatistics>> hairStatistics(const pelage::Scene& scene,
                                                   std::span<const pelage::HairId> hairs,
                                                   const pelage::BufferReader& read) {
  std::vector<HairStatistics> all;
  for (const pelage::HairId id : hairs) {
    const pelage::HairObject& hair = scene.hair(id);
    const pelage::HairBuffers& buffers = hair.buffers();
    HairStatistics of;
    of.name = hair.name();
    of.guides = hair.guideCount();
    of.followHairs = hair.followCount();
    of.bytes = scene.bytesOf(id);
    Result<void> done = count(buffers.sleep, read, &pelage::readCounters, of.simulation);
    if (done) done = count(buffers.contactWords, read, &pelage::readContactCounters, of.contacts);
    if (done)
      done = count(buffers.followContactWords, read, &pelage::readFollowContactCounters,
                   of.followContacts);
    if (!done) return done.error();
    all.push_back(std::move(of));
  }
  return all;
}

std::vector<ColliderStatistics> colliderStatistics(const pelage::Scene& scene,
                                                   std::span<const pelage::ColliderId> colliders) {
  std::vector<ColliderStatistics> all;
  for (const pelage::ColliderId id : colliders) {
    const pelage::SdfCollider& collider = scene.collider(id);
    const pelage::SdfGrid& grid = collider.grid();
    all.push_back({collider.name(),
                   {grid.nodes[0], grid.nodes[1], grid.nodes[2]},
                   grid.cellSize,
                   scene.bytesOf(id)});
  }
  return all;
}

std::vector<std::string> linesOf(const HairStatistics& hair) {
  std::vector<std::string> lines = {
      fmt::format("{} guides, {} follow hairs", hair.guides, hair.followHairs),
      fmt::format("{:.1f} MiB, {:.1f} MiB of them shared",
                  mebibytes(hair.bytes.own + hair.bytes.shared), mebibytes(hair.bytes.shared))};
  if (hair.simulation)
    lines.push_back(fmt::format("{} guides awake, {} second passes", hair.simulation->awakeStrands,
                                hair.simulation->secondPasses));
  if (hair.contacts)
    lines.push_back(fmt::format("{} contacts, {} strands again", hair.contacts->records,
                                hair.contacts->strandsSolvedAgain));
  if (hair.followContacts)
    lines.push_back(fmt::format("{} contacts of follow hairs, {} strands again",
                                hair.followContacts->records,
                                hair.followContacts->strandsWalkedAgain));
  return lines;
}

std::string lineOf(const ColliderStatistics& collider) {
  return fmt::format("{}: {} x {} x {} nodes of {:.2g} mm, {:.1f} MiB", collider.name,
                     collider.nodes[0], collider.nodes[1], collider.nodes[2],
                     1000 * collider.cellSize,
                     mebibytes(collider.bytes.own + collider.bytes.shared));
}

std::vector<std::string> linesOf(const pelage::TransparencyCounters& counters) {
  return {fmt::format("{} fragments, {} without room", counters.fragments, counters.spilled),
          fmt::format("{} tiles with hair", counters.tiles)};
}

}  // namespace viewer
