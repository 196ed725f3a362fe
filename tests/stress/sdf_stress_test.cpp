// Hair and mesh colliders at their limits, on every API with both solvers: nothing is NaN, out of
// bounds or lost, and what goes wrong for a while is forgotten.
#include <functional>

#include "stress/sdf_stress.h"
#include "support/not_numbers.h"

namespace pelage::test {
namespace {

// ---- what goes wrong for a while

/// Something bad that happens to a collider in the bad frames.
struct Trouble {
  std::string name;
  std::function<void(SdfStress&, Location&, int frame)> make;
  TriangleMesh mesh = block();
  bool forgotten = true;  ///< else the hair may end on another side of the block
  float cell = kCell;
};

class SdfTrouble : public SdfStress {
 protected:
  Trouble bone(const std::string& name, int row, int column, float value, bool sometimes = false) {
    return {name, [=, this](SdfStress&, Location& point, int frame) {
              if (sometimes && frame % 2 == 0) return;
              AffineTransform bone = boneAt(plus(point.at, displacementAt(frame)));
              Float4& entry = bone.rows[row];
              float* entries[] = {&entry.x, &entry.y, &entry.z, &entry.w};
              *entries[column] = value;
              setBone(colliderOf(point), bone);
            }};
  }
  Trouble scale(const std::string& name, const Float3& by, bool forgotten = true,
                float cell = kCell) {
    return {name,
            [=, this](SdfStress&, Location& point, int frame) {
              setBones(point, displacementAt(frame), by);
            },
            block(), forgotten, cell};
  }
  std::vector<Trouble> troubles() {
    const auto nothing = [](SdfStress&, Location&, int) {};
    std::vector<Trouble> all = {{"untouched", nothing}};
    all.push_back(bone("translation NaN", 0, 3, kNan));
    all.push_back(bone("rotation inf", 1, 1, kInf));
    all.push_back(bone("translation -inf", 2, 3, -kInf));
    all.push_back(bone("NaN every other frame", 2, 0, kNan, true));
    all.push_back(bone("translation 1e30", 0, 3, 1e30f));
    all.push_back(scale("mirrored", {-1, 1, 1}, false));
    all.push_back(scale("inside out", {-1, -1, -1}, false));
    all.push_back(scale("without scale", {0, 0, 0}));
    all.push_back(scale("flat", {1, 0, 1}));
    all.push_back(scale("a line", {0, 1, 0}));
    all.push_back(scale("tiny", {1e-20f, 1e-20f, 1e-20f}));
    all.push_back(scale("uneven", {5, 1, 0.1f}));
    all.push_back(scale("ten times as large", {10, 10, 10}, false, 0.04f));
    all.push_back({"steps of 16 cells",
                   [this](SdfStress&, Location& point, int frame) {
                     setBones(point, {0, 16 * kCell * static_cast<float>(frame % 2) - 0.1f, 0});
                   },
                   block(), false});
    all.push_back({"teleports with reset", [this](SdfStress&, Location& point, int frame) {
                     const float x = frame == kGoodFrames + kBadFrames - 1 ? 0.0f
                                     : frame % 2 == 0                      ? -50.0f
                                                                           : 40.0f;
                     setBone(hairOf(point), boneAt(plus(point.at, {x, 0, 0})));
                     setBones(point, plus(displacementAt(frame), {x, 0, 0}));
                     hairOf(point).reset();
                     colliderOf(point).reset();
                   }});
    all.push_back(
        {"resets", [this](SdfStress&, Location& point, int) { colliderOf(point).reset(); }});
    all.push_back({"off", [this](SdfStress&, Location& point, int frame) {
                     colliderOf(point).enabled = frame == kGoodFrames + kBadFrames - 1;
                   }});
    all.push_back({"zero area and duplicates", nothing,
                   reference::withZeroArea(reference::withDuplicates(block(), 5), 7)});
    return all;
  }
};

TEST_P(SdfTrouble, OfAColliderIsSurvivedAndForgotten) {
  const HairAsset asset = comb();
  const std::vector<Trouble> all = troubles();
  std::vector<Location> points;
  for (const Trouble& trouble : all) {
    Location point{trouble.name, trouble.mesh};
    point.at.z = kSpacing * static_cast<float>(points.size() + 1);
    addHair(point, asset, settings_);
    point.collider = add(point.mesh, {.name = point.name, .cellSize = all[points.size()].cell});
    colliderOf(point).friction = 0;
    points.push_back(point);
  }
  double deepest = 0;
  const int frames = kGoodFrames + kBadFrames + kRecoveryFrames;
  for (int frame = 0; frame < frames; ++frame) {
    const bool bad = frame >= kGoodFrames && frame < kGoodFrames + kBadFrames;
    for (size_t i = 0; i < all.size(); ++i) {
      setBones(points[i], displacementAt(frame));
      if (bad) all[i].make(*this, points[i], frame);
    }
    run_.step();
    const int since = frame - kGoodFrames;
    if (since >= 0 && since < kBadFrames + 3) {
      for (const Location& point : points)
        expectSane(asset, point, "bad frame " + std::to_string(since));
    }
    if (HasFatalFailure()) return;
    if (since == kBadFrames - 1) {
      // A collider whose bones are no numbers is where it was.
      const TriangleMesh last = posed(block(), boneAt(displacementAt(kGoodFrames - 1)));
      for (size_t i = 1; i < 4; ++i) {
        const TriangleMesh there = reference::moved(last, points[i].at);
        EXPECT_LT(depth(points[i], there), 0.02 * double{kCell}) << points[i].name;
      }
    }
    keepLargest(deepest, depth(points[0],
                               posed(block(), boneAt(plus(points[0].at, displacementAt(frame))))));
  }
  EXPECT_LT(deepest, 0.02 * double{kCell});
  const Float3 displacement = displacementAt(frames);
  const std::vector<Float4> untouched = run_.positions(hairOf(points[0]));
  double worst = 0;
  for (size_t i = 0; i < all.size(); ++i) {
    expectSane(asset, points[i], "at the end");
    const std::vector<Float4> positions = run_.positions(hairOf(points[i]));
    double off = 0;
    for (size_t v = 0; v < positions.size(); ++v)
      keepLargest(off, (toVector(positions[v]) - toVector(untouched[v]) -
                        Vector3d(0, 0, static_cast<double>(points[i].at.z - points[0].at.z)))
                           .norm());
    // Classic hair may pass through a shape that was a line, or long and flat, for a while.
    const bool mayPass = points[i].name == "a line" || points[i].name == "uneven";
    if (all[i].forgotten && (exact() || !mayPass)) {
      // Rods that are drawn into a collider without friction tremble a little on it.
      EXPECT_LT(off, exact() ? 6e-4 : 2e-5) << points[i].name << " [m]";
      keepLargest(worst, off);
    }
    EXPECT_LT(depth(points[i], posed(block(), boneAt(plus(points[i].at, displacement)))),
              0.02 * double{kCell})
        << points[i].name;
  }
  // The fields are right, and another collider makes all of them be built as a whole: no key
  // changes.
  const std::vector<SdfData> sdfs = copySdfs(points);
  (void)add(block(), {.name = "other", .cellSize = kCell});
  run_.step();
  const std::vector<SdfData> whole = copySdfs(points);
  for (size_t i = 0; i < all.size(); ++i) {
    if (api() == Api::kVulkan && exact()) {
      int wrongSigns = 0;
      EXPECT_LT(sdfError(sdfs[i], posed(points[i].mesh, boneAt(plus(points[i].at, displacement))),
                         wrongSigns),
                1e-3)
          << points[i].name;
      EXPECT_EQ(wrongSigns, 0) << points[i].name;
    }
    EXPECT_TRUE(sdfs[i].keys == whole[i].keys) << points[i].name;
    const bool sameGrid = i < 5;
    if (sameGrid) {
      EXPECT_TRUE(sdfs[i].keys == sdfs[0].keys) << points[i].name;
    }
  }
  printFigure("trouble of colliders, " + label() + ": " + std::to_string(all.size()) +
                  " kinds, largest distance to untouched hair after 60 frames [mm]",
              1000 * worst);
  printFigure("  deepest in a block that moves [cell]", deepest / double{kCell});
  printFigure("  largest stretch in the bad frames [%]", 100 * worstStretch_);
}

class SdfPoints : public SdfStress {};

// ---- wherever and however large

TEST_P(SdfPoints, PlaceAndScaleInTheWorldDoNotMatter) {
  // 10 places of the grid's nodes against the mesh, one 10 km away, and a world of another size.
  struct Where {
    Float3 at;
    float scale = 1;
  };
  std::vector<Where> all;
  for (int i = 0; i < 10; ++i) {
    const float shift = 0.1f * kCell * static_cast<float>(i);
    all.push_back({{shift, 0.7f * shift, kSpacing * static_cast<float>(i + 1) - 0.4f * shift}});
  }
  all.push_back({{1e4f, -1e4f, 1e4f}});
  all.push_back({{0, 0, 0}, 1e-3f});
  all.push_back({{0, 0, -3000}, 1e3f});
  std::vector<Location> points;
  std::vector<HairAsset> assets;
  for (const Where& where : all) {
    const float scale = where.scale;
    Location point{"place " + std::to_string(points.size()), reference::scaled(block(), scale)};
    point.at = where.at;
    assets.push_back(comb(scale));
    SimulationSettings settings = settings_;
    settings.gravity.y *= scale;
    settings.wind.velocity.z *= scale;
    // Softer than it should be in the largest world: 10 is the most.
    settings.bendLength = std::min(settings.bendLength * std::pow(scale, 4.0f / 3), 10.0f);
    settings.maxSpeed *= scale;
    settings.sleep.enabled = false;
    addHair(point, assets.back(), settings);
    point.collider = add(point.mesh, {.name = point.name, .cellSize = scale * kCell});
    colliderOf(point).margin = scale * 0.001f;
    points.push_back(point);
  }
  double deepest = 0;
  for (int frame = 0; frame < 40; ++frame) {
    const Float3 displacement = displacementAt(frame);
    for (size_t i = 0; i < all.size(); ++i) {
      const float scale = all[i].scale;
      setBones(points[i], {0, scale * displacement.y, scale * displacement.z});
    }
    run_.step();
    if (frame % 5 != 4) continue;
    for (size_t i = 0; i < all.size(); ++i) {
      expectSane(assets[i], points[i], "frame " + std::to_string(frame));
      const float scale = all[i].scale;
      const TriangleMesh mesh =
          posed(points[i].mesh,
                boneAt(plus(points[i].at, {0, scale * displacement.y, scale * displacement.z})));
      const double cell = static_cast<double>(scale * kCell);
      // Half a millimetre is what floats 10 km away are rounded by. In a world of a thousandth of
      // the size drag is so strong that contacts get no second round (decision 5).
      const double more = i == 10 ? 0.06 : i == 11 ? 0.08 : 0;
      const double deep = depth(points[i], mesh) / cell;
      EXPECT_LT(deep, 0.02 + more) << points[i].name << ", frame " << frame;
      if (i != 10) keepLargest(deepest, deep);
    }
    if (HasFatalFailure()) return;
  }
  const std::vector<Float4> first = run_.positions(hairOf(points[0]));
  double near = 0, far = 0, small = 0;
  for (size_t i = 1; i < all.size(); ++i) {
    const std::vector<Float4> positions = run_.positions(hairOf(points[i]));
    double& off = i < 10 ? near : i == 10 ? far : small;
    if (all[i].scale > 1) continue;
    for (size_t v = 0; v < positions.size(); ++v) {
      const auto at = [&](size_t k) {
        return toVector({all[k].at.x, all[k].at.y, all[k].at.z, 0});
      };
      keepLargest(off, ((toVector(positions[v]) - at(i)) / static_cast<double>(all[i].scale) -
                        (toVector(first[v]) - at(0)))
                               .norm() /
                           double{kCell});
    }
  }
  // The exact solver's contacts go other ways after rounding: measured 0.057, and at most 0.062 at
  // 54 random places between the nodes; classic 1e-4.
  EXPECT_LT(near, exact() ? 0.1 : 1e-3);
  // Positions are rounded by half a millimetre, 0.05 cells, an axis.
  EXPECT_LT(far, 0.15);
  // Contacts of the exact solver know lengths of their own, which do not shrink with the world:
  // what is at rest on a surface within 0.02 mm is so within 2 cells here, and gaps of 0.1 mm,
  // which ask for a further pass, are 10. Measured 0.331, the same bits on every API.
  EXPECT_LT(small, exact() ? 0.4 : 1e-3);
  printFigure("places, " + label() + ": hair differs by [cell]", near);
  printFigure("  10 km away [cell]", far);
  printFigure("  in a world of a thousandth of the size [cell]", small);
  printFigure("  deepest [cell]", deepest);
}

// ---- thin plates

TEST_P(SdfPoints, FastHairAndThinPlates) {
  // Hair that gravity makes longer steps by 1 to 16 cells every frame, on plates of 0.3 and 1.2
  // cells, and plates that come up from below in steps as long.
  const HairAsset asset = comb();
  settings_.globalStiffness = 0;
  settings_.bendLength = 0.02f;
  settings_.damping = 0.06f;
  const double frame = 1.0 / 60;
  struct Run {
    double thickness, step;
    bool rises;
    Location point;
    float top = 0;
  };
  std::vector<Run> runs;
  for (const double thickness : {0.3, 1.2}) {
    for (const double step : {1.0, 4.0, 16.0}) {
      for (const bool rises : {false, true}) {
        Run run{thickness, step, rises, {"plate", {}}};
        const float low = static_cast<float>(-thickness) * kCell;
        run.point.mesh = reference::rotated(
            reference::box({-0.35f, low, -0.35f}, {0.35f, 0, 0.35f}), {0, 0, 1}, 0.1f);
        run.point.at.z = kSpacing * static_cast<float>(runs.size() + 1);
        SimulationSettings settings = settings_;
        if (!rises)
          settings.gravity.y = static_cast<float>(-step * double{kCell} / (frame * frame));
        addHair(run.point, asset, settings);
        run.point.collider = add(run.point.mesh, {.name = "plate", .cellSize = kCell});
        runs.push_back(run);
      }
    }
  }
  double shares[2] = {};
  size_t counts[2] = {}, wrong[2] = {};
  for (int i = 0; i < 30; ++i) {
    for (Run& run : runs) {
      // Well below the roots; tilted, so that it is no plane of nodes.
      run.top = run.rises ? std::min(-0.32f + static_cast<float>(run.step) * kCell *
                                                  static_cast<float>(std::max(i - 12, 0)),
                                     -0.08f)
                          : -0.07f;
      setBones(run.point, {0, run.top, 0});
    }
    run_.step();
    for (const Run& run : runs) {
      expectSane(asset, run.point, "frame " + std::to_string(i));
      if (HasFatalFailure()) return;
      const std::vector<Float4> positions = run_.positions(hairOf(run.point));
      const int kind = run.thickness > 1 ? 1 : 0;
      for (const Float4& p : positions) {
        if (!(p.w > 0)) continue;
        // Along the plate's normal, from the middle between its sides.
        const double x = double{p.x}, y = double{p.y} - double{run.top};
        const double height = std::cos(0.1) * y - std::sin(0.1) * x;
        ++counts[kind];
        if (height < -0.5 * run.thickness * double{kCell}) ++wrong[kind];
      }
    }
  }
  for (int kind = 0; kind < 2; ++kind)
    shares[kind] = static_cast<double>(wrong[kind]) / static_cast<double>(counts[kind]);
  printFigure("plates of 0.3 cells, " + label() + ": on the wrong side [%]", 100 * shares[0]);
  printFigure("plates of 1.2 cells: on the wrong side [%]", 100 * shares[1]);
  // The classic solver leaves where its contacts were expected: it moves vertices after the sweep.
  EXPECT_LE(shares[1], exact() ? 0.01 : 0.015);
  EXPECT_LE(shares[0], exact() ? 0.015 : 0.04);
}

INSTANTIATE_TEST_SUITE_P(All, SdfTrouble, testing::ValuesIn(solversOnApis()), solverTestName);
INSTANTIATE_TEST_SUITE_P(All, SdfPoints, testing::ValuesIn(solversOnApis()), solverTestName);

}  // namespace
}  // namespace pelage::test
