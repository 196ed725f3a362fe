// The choice between lists and tiles, against the times that the benchmark has measured.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "pelage/scene.h"
#include "support/errors.h"
#include "support/plain_asset.h"
#include "support/views.h"

namespace pelage::test {
namespace {

struct Row {
  std::string api, scene, view;
  double opacity = 0;
  double fragments = 0;
  double windowed = 0, tiles = 0;  // build and resolve [ms]
};

// Rows of the two methods, side by side.
std::vector<Row> measuredRows(const std::string& device) {
  std::ifstream file(std::string(PELAGE_SOURCE_DIR) + "/benchmark/results/transparency_" + device +
                     ".csv");
  std::map<std::string, size_t> columns;
  std::map<std::tuple<std::string, std::string, std::string, std::string>, Row> rows;
  for (std::string line; std::getline(file, line);) {
    std::vector<std::string> cells;
    std::istringstream cut(line);
    for (std::string cell; std::getline(cut, cell, ',');) cells.push_back(cell);
    if (columns.empty()) {
      for (size_t i = 0; i < cells.size(); ++i) columns[cells[i]] = i;
      continue;
    }
    const auto at = [&](const char* name) { return cells.at(columns.at(name)); };
    const double time = std::stod(at("build_ms")) + std::stod(at("resolve_ms"));
    if (at("method") != "windowed" && at("method") != "tiles") continue;
    Row& row = rows[{at("api"), at("scene"), at("view"), at("opacity")}];
    row.api = at("api");
    row.scene = at("scene");
    row.view = at("view");
    row.opacity = std::stod(at("opacity"));
    row.fragments = std::stod(at("fragments"));
    (at("method") == "tiles" ? row.tiles : row.windowed) = time;
  }
  std::vector<Row> both;
  for (const auto& [key, row] : rows)
    if (row.windowed > 0 && row.tiles > 0) both.push_back(row);
  return both;
}

// Counts that the rows do not have, from the same views at 1920 x 1080. `width` is that of the
// fibers in the middle of the hair [pixels].
struct Counted {
  const char *scene, *view;
  double vertices, tiles, width;
};
constexpr Counted kCounted[] = {{"mohawk", "whole", 1212032, 673, 1.16},
                                {"mohawk", "close", 1212032, 3957, 3.06},
                                {"groom", "whole", 528000, 7243, 0.40},
                                {"groom", "close", 528000, 26412, 1.0}};

TransparencyWork workOf(const Row& row) {
  for (const Counted& counted : kCounted) {
    if (row.scene != counted.scene || row.view != counted.view) continue;
    return {counted.vertices, row.fragments, counted.tiles,
            row.opacity * counted.width / (counted.width + 1)};
  }
  ADD_FAILURE() << row.scene << ' ' << row.view << ": no counts";
  return {};
}

TEST(TransparencyChoice, IsTheFasterOneInEveryMeasuredRow) {
  const std::vector<Row> rows = measuredRows("h100");
  ASSERT_GE(rows.size(), 13u);
  for (const Row& row : rows) {
    const TransparencyCost cost = predictCost(workOf(row));
    std::cout << row.api << ' ' << row.scene << ' ' << row.view << ' ' << row.opacity << ": lists "
              << row.windowed << " ms, predicted " << cost.windowed << "; tiles " << row.tiles
              << " ms, predicted " << cost.tiles << "\n";
    const Transparency faster =
        row.tiles < row.windowed ? Transparency::kTiles : Transparency::kWindowed;
    // Whatever the last frame was drawn with.
    for (const Transparency current :
         {Transparency::kWindowed, Transparency::kTiles, Transparency::kShortCut})
      EXPECT_EQ(chooseTransparency(workOf(row), false, current), faster);
    if (row.api != "vulkan") continue;
    EXPECT_NEAR(std::log(cost.windowed / row.windowed), 0, std::log(1.25));
    EXPECT_NEAR(std::log(cost.tiles / row.tiles), 0, std::log(1.25));
  }
  for (const Row& row : measuredRows("lavapipe")) {
    EXPECT_LT(row.windowed, row.tiles) << row.scene << ' ' << row.view << ' ' << row.opacity;
    EXPECT_EQ(chooseTransparency({1e6, 1e7, 1e4, 0.5}, true, Transparency::kTiles),
              Transparency::kWindowed);
  }
}

TEST(TransparencyChoice, StaysWhereTheGainIsLittle) {
  // From a tuft far away, whose lists are faster, to a fur: the border is crossed in one direction.
  uint32_t changes = 0, kept = 0;
  Transparency up = Transparency::kWindowed;
  EXPECT_EQ(chooseTransparency({1e3, 500, 20, 0.3}, false, Transparency::kTiles), up);
  for (double vertices = 1e3; vertices < 1e6; vertices *= 1.02) {
    const TransparencyWork work = {vertices, vertices / 2, vertices / 50, 0.3};
    const Transparency next = chooseTransparency(work, false, up);
    changes += next != up ? 1 : 0;
    up = next;
    kept += up != chooseTransparency(work, false, Transparency::kTiles) ? 1 : 0;
  }
  EXPECT_EQ(changes, 1u);
  EXPECT_GE(kept, 5u) << "both stay what they are around the border";
}

TEST(TransparencyChoice, TakesWhatWasCountedForWhatWasPredicted) {
  const TransparencyWork predicted = {1000, 500, 40, 0.5};
  TransparencyWork work = refineWork(predicted, Transparency::kWindowed,
                                     {.fragments = 1500, .spilled = 0, .tiles = 30});
  EXPECT_EQ(work.fragments, 1500);
  EXPECT_EQ(work.tiles, 30);
  work = refineWork(predicted, Transparency::kTiles, {.fragments = 100, .spilled = 0, .tiles = 30});
  EXPECT_EQ(work.fragments, 100);
  EXPECT_EQ(work.vertices, predicted.vertices);
  for (const Transparency method : {Transparency::kShortCut, Transparency::kWindowed}) {
    work = refineWork(predicted, method, {});
    EXPECT_EQ(work.fragments, predicted.fragments);
  }
}

TEST(TransparencyChoice, IsKnownForEveryWork) {
  const double odd[] = {0, -1, 1e300, std::numeric_limits<double>::infinity(),
                        std::numeric_limits<double>::quiet_NaN()};
  for (const double value : odd) {
    for (double TransparencyWork::*const member :
         {&TransparencyWork::vertices, &TransparencyWork::fragments, &TransparencyWork::tiles,
          &TransparencyWork::alpha}) {
      TransparencyWork work = {1000, 500, 40, 0.5};
      work.*member = value;
      const Transparency chosen = chooseTransparency(work, false, Transparency::kStochastic);
      EXPECT_TRUE(chosen == Transparency::kWindowed || chosen == Transparency::kTiles);
    }
  }
}

class PredictedWork : public testing::Test {
 protected:
  static View viewFrom(float distance, float targetZ = 0) {
    // The strands stand from 0 to 0.4 m along x.
    return cameraView({.eye = {0.2f, 0.04f, distance},
                       .target = {0.2f, 0.04f, targetZ},
                       .fov = 0.6f,
                       .width = 400,
                       .nearPlane = 0.001f,
                       .farPlane = 100});
  }
};

TEST_F(PredictedWork, GrowsWithTheHairOnTheScreenAndIsNothingOutsideOfIt) {
  Scene scene;
  EXPECT_EQ(scene.predictWork(viewFrom(2)).fragments, 0);
  const Result<HairId> added = required(scene.addHair(makeAsset(40), {}));
  HairObject& hair = scene.hair(*added);
  const TransparencyWork far = scene.predictWork(viewFrom(8));
  const TransparencyWork near = scene.predictWork(viewFrom(2));
  EXPECT_GT(far.fragments, 0);
  // Four times as many pixels long, and a little wider.
  EXPECT_GT(near.fragments, 3.9 * far.fragments);
  EXPECT_GT(near.tiles, far.tiles);
  EXPECT_GT(near.alpha, far.alpha);
  EXPECT_EQ(near.vertices, hair.strandCount() * hair.verticesPerStrand());
  // Into the hair: most of it is outside the picture.
  for (const float distance : {0.05f, 0.01f, 1e-3f, 0.0f}) {
    const TransparencyWork inside = scene.predictWork(viewFrom(distance));
    EXPECT_TRUE(std::isfinite(inside.fragments) && std::isfinite(inside.tiles)) << distance;
    EXPECT_LE(inside.tiles, 400.0 * 400 / 64 + 1);
  }

  hair.material.opacity = 0.5f;
  EXPECT_NEAR(scene.predictWork(viewFrom(2)).alpha, 0.5 * near.alpha, 1e-6);
  hair.drawnShare = 0.25f;
  EXPECT_LT(scene.predictWork(viewFrom(2)).fragments, 0.6 * near.fragments);
  hair.visible = false;
  EXPECT_EQ(scene.predictWork(viewFrom(2)).fragments, 0);
  hair.visible = true;
  View away = viewFrom(2, 9);
  EXPECT_EQ(scene.predictWork(away).fragments, 0);
  away.width = 0;
  EXPECT_EQ(scene.predictWork(away).fragments, 0);
}

// Sampling every so many vertices would find the same one of each strand: here the roots.
TEST_F(PredictedWork, SeesAllOfAStrandWhateverTheNumberOfItsVertices) {
  for (const uint32_t vertices : {4u, 16u, 24u, 64u}) {
    HairAsset asset;
    asset.strandCount = 8192 / vertices;
    asset.verticesPerStrand = vertices;
    for (uint32_t s = 0; s < asset.strandCount; ++s) {
      for (uint32_t v = 0; v < vertices; ++v) {
        const float along = static_cast<float>(v) / static_cast<float>(vertices - 1);
        asset.positions.push_back({0.4f * along, 0.04f, 0, v == 0 ? 0.0f : 1.0f});
      }
    }
    ASSERT_TRUE(asset.process());
    Scene scene;
    ASSERT_TRUE(scene.addHair(asset, {}));
    View view = viewFrom(2);
    view.width = view.height = 4000;
    const double all = scene.predictWork(view).fragments;
    ASSERT_GT(all, 0);
    constexpr float kAngle = 0.05f;
    const float half = 2 * std::tan(kAngle / 2);  // of what is in view [m]
    for (const float x : {0.06f, 0.2f, 0.32f}) {
      view = cameraView({.eye = {x, 0.04f, 2},
                         .target = {x, 0.04f, 0},
                         .fov = kAngle,
                         .width = 324,  // as many pixels a metre
                         .nearPlane = 0.001f,
                         .farPlane = 100});
      uint32_t seen = 0;
      for (uint32_t v = 0; v < vertices; ++v)
        if (std::abs(asset.positions[v].x - x) < half) ++seen;
      const double share = static_cast<double>(seen) / vertices;
      EXPECT_NEAR(scene.predictWork(view).fragments / all, share, 0.01 + 0.02 * share)
          << vertices << " vertices, at " << x;
    }
  }
}

}  // namespace
}  // namespace pelage::test
