#include "scenes/scene_rows.h"

namespace bench {

namespace {

// Guides of each scene.
struct Counts {
  uint32_t free, freeLarge, head, character;
};
constexpr Counts kFullCounts = {2176, 32640, 2000, 900};
constexpr Counts kSmallCounts = {544, 2176, 500, 90};
constexpr Counts kQuickCounts = {32, 96, 60, 9};

const Counts& countsOf(SceneSize size) {
  if (size == SceneSize::kSmall) return kSmallCounts;
  return size == SceneSize::kQuick ? kQuickCounts : kFullCounts;
}

// The baseline has no capsules, and no strands of 24, 16 and 8 vertices side by side.
bool hasBaseline(SceneKind kind) { return kind == SceneKind::kFree || kind == SceneKind::kHeadSdf; }

}  // namespace

const char* rowSolverName(RowSolver solver) {
  switch (solver) {
    case RowSolver::kExact:
      return "exact";
    case RowSolver::kClassic:
      return "classic";
    case RowSolver::kBaseline:
      return "baseline";
  }
  return "unknown";
}

std::string SceneRow::name() const {
  return scene + "/" + rowSolverName(solver) + (followsCollide ? "/follow" : "/guides");
}

std::vector<SceneRow> sceneRows(SceneSize size) {
  const Counts& counts = countsOf(size);
  const SceneRow scenes[] = {
      {"free_" + std::to_string(counts.free), SceneKind::kFree, counts.free},
      {"free_" + std::to_string(counts.freeLarge), SceneKind::kFree, counts.freeLarge},
      {"head_capsules", SceneKind::kHeadCapsules, counts.head},
      {"head_sdf", SceneKind::kHeadSdf, counts.head},
      {"character", SceneKind::kCharacter, counts.character},
      {"character_10x", SceneKind::kCharacter, 10 * counts.character},
      {.scene = "characters_4",
       .kind = SceneKind::kCharacter,
       .guides = counts.character,
       .characters = 4},
      {.scene = "characters_12",
       .kind = SceneKind::kCharacter,
       .guides = counts.character,
       .characters = 12}};
  std::vector<SceneRow> rows;
  for (SceneRow row : scenes) {
    row.solver = RowSolver::kBaseline;
    if (hasBaseline(row.kind)) rows.push_back(row);
    for (const RowSolver solver : {RowSolver::kExact, RowSolver::kClassic}) {
      row.solver = solver;
      for (const bool followsCollide : {false, true}) {
        row.followsCollide = followsCollide;
        // Free hair has no follow hairs, and a smoke test of many characters finds nothing more.
        const bool few = row.kind == SceneKind::kFree || row.characters > 1;
        const bool quick = size == SceneSize::kQuick && row.characters > 1;
        if (!quick && (!few || !followsCollide)) rows.push_back(row);
      }
      row.followsCollide = false;
    }
  }
  return rows;
}

}  // namespace bench
