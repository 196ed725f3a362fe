// BasisCurves of .usda files: those of independent writers (tests/fuzz/corpus/usda), cubic curves
// against de Casteljau's construction, transforms, and that what is written is read.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "pelage/authoring/guides.h"
#include "pelage/authoring/hair_curves.h"
#include "pelage/authoring/hair_files.h"
#include "pelage/authoring/usd_curves.h"
#include "support/errors.h"
#include "support/test_folder.h"

namespace pelage {
namespace {

using test::expectError;
using test::expectHas;
using test::required;
using test::TestFolder;
using test::valueOf;

Result<HairCurves> load(const std::string& text, HairFileReport* report = nullptr) {
  return loadHairCurves(std::as_bytes(std::span(text)), "a.usda", report);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

std::filesystem::path corpus(const char* name) {
  return std::filesystem::path(PELAGE_SOURCE_DIR) / "tests/fuzz/corpus/usda" / name;
}

// A layer in meters, y up, with one prim.
std::string layerOf(const std::string& attributes) {
  return "#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n\ndef Xform \"root\"\n{\n"
         "    def BasisCurves \"hair\"\n    {\n" +
         attributes + "    }\n}\n";
}

void expectAt(const Float3& a, const Float3& b, float tolerance = 1e-6f) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

// ---- Files in the shape of other writers

// Blender's usd_writer_curves.cc: pinned Catmull-Rom curves, z up, an Xform for the object.
TEST(UsdFiles, AFileOfBlenderIsInMetersWithYUp) {
  HairFileReport report;
  auto curves = required(loadHairCurves(corpus("valid_blender.usda"), &report));
  EXPECT_EQ(report.kind, HairFileKind::kUsd);
  expectHas(report.format, "1 m per unit, z up");
  EXPECT_TRUE(report.notes.empty()) << report.notes.front();
  ASSERT_EQ(curves->vertexCounts, (std::vector<uint32_t>{3, 2}));
  // Scaled by 2, turned by 90 degrees about z, moved by (1, 2, 3); then (x, y, z) -> (x, z, -y).
  expectAt(curves->positions[0], {1, 3, -4});
  expectAt(curves->positions[1], {1, 5, -4});
  expectAt(curves->positions[2], {1, 7, -4});
  expectAt(curves->positions[4], {-1, 4, -2});
  ASSERT_EQ(curves->radii.size(), 5u);
  EXPECT_NEAR(curves->radii[0], 0.002f, 1e-9f) << "half of the width, times the scale";
  EXPECT_NEAR(curves->radii[1], 0.001f, 1e-9f);
  EXPECT_EQ(curves->strandUv, (std::vector<Float2>{{0.25f, 0.75f}, {0.5f, 1}}));
  EXPECT_TRUE(curves->labels.empty());
}

// Houdini's SOP import: centimeters, samples, indexed primvars, Unreal's names.
TEST(UsdFiles, AFileOfHoudiniHasItsLabels) {
  HairFileReport report;
  auto curves = required(loadHairCurves(corpus("valid_houdini.usda"), &report));
  ASSERT_EQ(curves->vertexCounts, (std::vector<uint32_t>{2, 2}));
  expectAt(curves->positions[1], {0, 1.01f, 0});
  expectAt(curves->positions[3], {0.01f, 1.02f, 0});
  EXPECT_NEAR(curves->radii[0], 1e-4f, 1e-9f);
  EXPECT_EQ(curves->colors[0], (Float4{0, 1, 0, 1}));
  EXPECT_EQ(curves->colors[2], (Float4{1, 0, 0, 1}));
  EXPECT_EQ(curves->labels, (std::vector<CurveLabel>{{7, 2, true}, {9000000000, 2, false}}));
  EXPECT_EQ(curves->strandUv[0], (Float2{0.5f, 0.25f}));
  std::string notes;
  for (const std::string& note : report.notes) notes += note + "\n";
  expectHas(notes, "the first ones, at 1,");
  expectHas(notes, "1 BasisCurves are invisible");
  expectHas(notes, "groom_group_name");
}

// usdcat: classes and overs are no curves; fallbacks; numbers that are not finite.
TEST(UsdFiles, AFlattenedFileHasDefinedPrimsAlone) {
  HairFileReport report;
  auto curves = required(loadHairCurves(corpus("valid_usdcat.usda"), &report));
  expectHas(report.format, "2 prims");
  ASSERT_EQ(curves->vertexCounts.size(), 2u);
  EXPECT_GT(curves->vertexCounts[0], 4u) << "a cubic segment in pieces";
  EXPECT_EQ(curves->vertexCounts[1], 4u) << "closed";
  expectAt(curves->positions[curves->vertexCounts[0] - 1], {1, 0, 0});
  EXPECT_EQ(curves->radii[0], 0.05f);
  EXPECT_EQ(curves->radii[curves->vertexCounts[0] - 1], 0.1f) << "two values are varying";
  EXPECT_EQ(curves->radii.back(), kUnitFiberRadius) << "of the prim without widths";
  EXPECT_EQ(curves->colors[0].w, 0.5f);
  CurveImportReport imported;
  ASSERT_TRUE(prepareCurves(*curves, {}, &imported));
  EXPECT_EQ(imported.removedVertices, 2u);
}

TEST(UsdFiles, AShotIsReadAtItsFirstFrame) {
  const TestFolder folder;
  UsdCurvesDef def;
  def.vertexCounts = {2, 3};
  def.widths = {1e-4f};
  def.strandIds = {3, 1};
  def.firstFrame = 1001;
  auto writer = required(UsdCurvesWriter::create(folder / "a.usda", def));
  std::vector<Float3> frame(5);
  for (int f = 0; f < 3; ++f) {
    for (size_t i = 0; i < 5; ++i) frame[i] = {static_cast<float>(f), 0.1f, static_cast<float>(i)};
    ASSERT_TRUE(writer->append(frame));
  }
  ASSERT_TRUE(writer->close());
  HairFileReport report;
  auto curves = required(loadHairCurves(folder / "a.usda", &report));
  EXPECT_EQ(curves->vertexCounts, def.vertexCounts);
  EXPECT_EQ(curves->positions[4], (Float3{0, 0.1f, 4}));
  EXPECT_EQ(curves->radii[0], 5e-5f);
  EXPECT_EQ(curves->labels[0].id, 3u);
  ASSERT_EQ(report.notes.size(), 1u);
  expectHas(report.notes[0], "at 1001");
}

// ---- Cubic curves

using Point = std::array<double, 3>;

Point mix(const Point& a, const Point& b, double t) {
  Point r;
  for (size_t k = 0; k < 3; ++k) r[k] = a[k] + (b[k] - a[k]) * t;
  return r;
}

Point casteljau(std::array<Point, 4> p, double t) {
  for (size_t n = 3; n > 0; --n)
    for (size_t i = 0; i < n; ++i) p[i] = mix(p[i], p[i + 1], t);
  return p[0];
}

// The Bezier points of a segment.
std::array<Point, 4> bezierOf(const std::string& basis, const std::array<Point, 4>& p) {
  const auto sum = [&](double a, double b, double c, double d) {
    Point r;
    for (size_t k = 0; k < 3; ++k) r[k] = a * p[0][k] + b * p[1][k] + c * p[2][k] + d * p[3][k];
    return r;
  };
  if (basis == "bezier") return p;
  if (basis == "bspline")
    return {sum(1.0 / 6, 4.0 / 6, 1.0 / 6, 0), sum(0, 2.0 / 3, 1.0 / 3, 0),
            sum(0, 1.0 / 3, 2.0 / 3, 0), sum(0, 1.0 / 6, 4.0 / 6, 1.0 / 6)};
  return {sum(0, 1, 0, 0), sum(-1.0 / 6, 1, 1.0 / 6, 0), sum(0, 1.0 / 6, 1, -1.0 / 6),
          sum(0, 0, 1, 0)};
}

double distanceToSegment(const Point& p, const Float3& a, const Float3& b) {
  const Point from = {a.x, a.y, a.z}, to = {b.x, b.y, b.z};
  double dot = 0, square = 0;
  for (size_t k = 0; k < 3; ++k) {
    dot += (p[k] - from[k]) * (to[k] - from[k]);
    square += (to[k] - from[k]) * (to[k] - from[k]);
  }
  const Point near = mix(from, to, square > 0 ? std::clamp(dot / square, 0.0, 1.0) : 0);
  return std::hypot(p[0] - near[0], p[1] - near[1], p[2] - near[2]);
}

TEST(UsdFiles, CubicCurvesAreWithinAThousandthOfTheirLength) {
  const std::vector<Point> vertices = {{0, 0, 0},   {0.2, 1, 0},   {1, 1.5, 0.3}, {1.5, 0.2, 1},
                                       {2, 0.1, 0}, {2.5, 1, 0.5}, {1, 2, 0}};
  const auto n = static_cast<int>(vertices.size());
  std::string points;
  for (const Point& p : vertices)
    points += "(" + std::to_string(p[0]) + ", " + std::to_string(p[1]) + ", " +
              std::to_string(p[2]) + "), ";
  for (const std::string basis : {"bezier", "bspline", "catmullRom"}) {
    for (const std::string wrap : {"nonperiodic", "pinned", "periodic"}) {
      SCOPED_TRACE(basis + " " + wrap);
      const bool bezier = basis == "bezier", closed = wrap == "periodic";
      const bool pinned = wrap == "pinned" && !bezier;
      const int count = bezier && closed ? 6 : n;
      std::string given = points;
      if (count < n) given = given.substr(0, given.rfind('('));
      auto curves = required(load(layerOf(
          "        uniform token basis = \"" + basis + "\"\n        uniform token wrap = \"" +
          wrap + "\"\n        int[] curveVertexCounts = [" + std::to_string(count) +
          "]\n        point3f[] points = [" + given + "]\n")));
      double length = 0;
      for (int i = 1; i < count; ++i) {
        const Point &a = vertices[static_cast<size_t>(i - 1)],
                    &b = vertices[static_cast<size_t>(i)];
        length += std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
      }
      const auto control = [&](int i) {
        if (closed) return vertices[static_cast<size_t>((i + count) % count)];
        if (i < 0) return mix(vertices[1], vertices[0], 2);
        if (i >= count)
          return mix(vertices[static_cast<size_t>(count - 2)],
                     vertices[static_cast<size_t>(count - 1)], 2);
        return vertices[static_cast<size_t>(i)];
      };
      const int step = bezier ? 3 : 1;
      const int segments = closed ? count / step : pinned ? count - 1 : (count - 4) / step + 1;
      const int first = pinned || (closed && !bezier) ? -1 : 0;
      double largest = 0;
      for (int s = 0; s < segments; ++s)
        for (int i = 0; i <= 50; ++i) {
          const int at = s * step + first;
          const Point p = casteljau(
              bezierOf(basis, {control(at), control(at + 1), control(at + 2), control(at + 3)}),
              i / 50.0);
          double least = 1e9;
          for (size_t v = 1; v < curves->positions.size(); ++v)
            least = std::min(least,
                             distanceToSegment(p, curves->positions[v - 1], curves->positions[v]));
          largest = std::max(largest, least);
        }
      EXPECT_LE(largest, 1e-3 * length);
      EXPECT_GT(largest, 1e-6 * length) << "is it the curve that was evaluated?";
      if (wrap != "nonperiodic" || bezier)
        if (basis != "bspline" || pinned) expectAt(curves->positions.front(), {0, 0, 0});
      if (closed) expectAt(curves->positions.back(), curves->positions.front());
      if (!closed && (bezier || pinned)) expectAt(curves->positions.back(), {1, 2, 0});
    }
  }
}

TEST(UsdFiles, ValuesOfACubicCurveFollowItsSegments) {
  const std::string curve =
      "        uniform token basis = \"bspline\"\n        uniform token wrap = \"pinned\"\n"
      "        int[] curveVertexCounts = [3]\n"
      "        point3f[] points = [(0, 0, 0), (1, 1, 0), (2, 0, 0)]\n";
  const auto radii = [&](const std::string& values) {
    return valueOf(load(layerOf(curve + "        float[] widths = " + values))).radii;
  };
  const std::vector<float> varying = radii("[0, 2, 8] (interpolation = \"varying\")\n");
  const std::vector<float> vertex = radii("[0, 2, 4] (interpolation = \"vertex\")\n");
  ASSERT_EQ(varying.size(), vertex.size());
  ASSERT_GT(varying.size(), 4u);
  const size_t last = varying.size() - 1, middle = last / 2;
  EXPECT_EQ(varying[0], 0);
  EXPECT_EQ(varying[middle], 1);
  EXPECT_EQ(varying[last], 4);
  for (size_t i = 1; i < middle; ++i)
    EXPECT_NEAR(varying[i], static_cast<float>(i) / static_cast<float>(middle), 1e-6f);
  // A B-spline of numbers in line is that line.
  for (size_t i = 0; i <= last; ++i)
    EXPECT_NEAR(vertex[i], 2.0f * static_cast<float>(i) / static_cast<float>(last), 1e-6f);
  EXPECT_EQ(radii("[3] (interpolation = \"constant\")\n"), std::vector<float>(last + 1, 1.5f));
  EXPECT_EQ(radii("[3] (interpolation = \"uniform\")\n"), std::vector<float>(last + 1, 1.5f));
}

// ---- Transforms

TEST(UsdFiles, OperationsOfPrimsAreInTheirOrder) {
  const auto tipOf = [](const std::string& ops, const std::string& order) {
    auto curves =
        load(layerOf("        int[] curveVertexCounts = [2]\n"
                     "        point3f[] points = [(0, 0, 0), (1, 2, 3)]\n"
                     "        uniform token type = \"linear\"\n" +
                     ops + "        uniform token[] xformOpOrder = [" + order + "]\n"));
    EXPECT_TRUE(curves) << curves.error().message;
    return curves ? curves->positions[1] : Float3{};
  };
  const std::string move = "        double3 xformOp:translate = (10, 0, 0)\n";
  expectAt(tipOf(move, "\"xformOp:translate\""), {11, 2, 3});
  expectAt(tipOf(move + "        float3 xformOp:scale = (2, 3, 4)\n",
                 "\"xformOp:translate\", \"xformOp:scale\""),
           {12, 6, 12});
  expectAt(tipOf(move + "        float3 xformOp:scale = (2, 3, 4)\n",
                 "\"xformOp:scale\", \"xformOp:translate\""),
           {22, 6, 12});
  // About x first: (1, 2, 3) -> (1, -3, 2) -> (3, 1, 2).
  expectAt(tipOf("        float3 xformOp:rotateXYZ = (90, 0, 90)\n", "\"xformOp:rotateXYZ\""),
           {3, 1, 2});
  // About z first: (1, 2, 3) -> (-2, 1, 3) -> (-2, -3, 1).
  expectAt(tipOf("        float3 xformOp:rotateZYX = (90, 0, 90)\n", "\"xformOp:rotateZYX\""),
           {-2, -3, 1});
  expectAt(tipOf("        float xformOp:rotateY = 90\n", "\"xformOp:rotateY\""), {3, 2, -1});
  expectAt(tipOf("        quath xformOp:orient = (0, 0, 1, 0)\n", "\"xformOp:orient\""),
           {-1, 2, -3});
  expectAt(tipOf("        matrix4d xformOp:transform = ( (0, 1, 0, 0), (-1, 0, 0, 0), (0, 0, 1, "
                 "0), (5, 6, 7, 1) )\n",
                 "\"xformOp:transform\""),
           {3, 7, 10});
  const std::string pivot =
      "        float3 xformOp:translate:pivot = (1, 0, 0)\n"
      "        float xformOp:rotateZ = 90\n";
  expectAt(tipOf(pivot,
                 "\"xformOp:translate:pivot\", \"xformOp:rotateZ\", "
                 "\"!invert!xformOp:translate:pivot\""),
           {-1, 0, 3});
}

// ---- What is written

HairCurves writtenCurves() {
  HairCurves curves;
  curves.vertexCounts = {2, 3};
  curves.positions = {
      {0.1f, -1.0f / 3, 1e-30f}, {-0.0f, 1e-45f, 999999.9f}, {0, 0, 0}, {1, 2, 3}, {4, 5, 7}};
  curves.inverseMasses = {0, 0, 0, 0.5f, 1};
  curves.radii = {1e-45f, 4e-5f, 0.1f, 0, 1e30f};
  curves.colors = {
      {0.1f, 0.2f, 0.3f, 0.4f}, {1, 1, 1, 1}, {0, 0, 0, 0}, {5, 6, 7, 8}, {1, 2, 3, 4}};
  curves.vertexUv = {{0, 1}, {0.1f, 0.9f}, {2, 3}, {4, 5}, {6, 7}};
  curves.strandUv = {{0.3f, 0.7f}, {1, 0}};
  curves.labels = {{(uint64_t{1} << 63) - 1, 0, true}, {0, (1u << 24) - 1, false}};
  return curves;
}

TEST(UsdFiles, WhatIsWrittenReadsBackToTheSameBits) {
  const HairCurves curves = writtenCurves();
  auto again = required(load(*saveUsdCurves(curves)));
  EXPECT_EQ(again->vertexCounts, curves.vertexCounts);
  EXPECT_EQ(again->positions, curves.positions);
  EXPECT_TRUE(std::signbit(again->positions[1].x));
  EXPECT_EQ(again->inverseMasses, curves.inverseMasses);
  EXPECT_EQ(again->radii, curves.radii);
  EXPECT_EQ(again->colors, curves.colors);
  EXPECT_EQ(again->vertexUv, curves.vertexUv);
  EXPECT_EQ(again->strandUv, curves.strandUv);
  EXPECT_EQ(again->labels, curves.labels);
  EXPECT_EQ(*saveUsdCurves(*again), *saveUsdCurves(curves));
  HairCurves bare;
  bare.vertexCounts = {2};
  bare.positions = {{0, 0, 0}, {0, 1, 0}};
  const TestFolder folder;
  ASSERT_TRUE(saveUsdCurves(bare, folder / "a.usda", "guide_1"));
  expectHas(test::textOf(folder / "a.usda"), "def BasisCurves \"guide_1\"");
  auto plain = required(loadHairCurves(folder / "a.usda"));
  EXPECT_TRUE(plain->radii.empty() && plain->colors.empty() && plain->labels.empty());
}

TEST(UsdFiles, RefusesToWriteWhatCannotBeRead) {
  const auto refused = [](auto change) {
    HairCurves curves = writtenCurves();
    change(curves);
    return !saveUsdCurves(curves);
  };
  EXPECT_FALSE(saveUsdCurves(writtenCurves(), TestFolder() / "a.usda", "a b"));
  EXPECT_FALSE(saveUsdCurves({}));
  EXPECT_TRUE(refused([](HairCurves& c) { c.labels[0].id = uint64_t{1} << 63; }));
  EXPECT_TRUE(refused([](HairCurves& c) { c.labels[0].group = 1u << 24; }));
  EXPECT_TRUE(refused([](HairCurves& c) { c.labels.resize(1); }));
  EXPECT_TRUE(refused([](HairCurves& c) { c.radii[0] = 2e30f; }));
  EXPECT_TRUE(refused([](HairCurves& c) { c.vertexCounts[0] = 9; }));
}

// ---- Labels

TEST(UsdFiles, LabelsStayWithTheirCurves) {
  HairCurves curves;
  for (uint32_t i = 0; i < 20; ++i) {
    const auto x = static_cast<float>(i);
    curves.vertexCounts.push_back(i == 4 ? 1 : 2);
    curves.positions.push_back({x, 0, 0});
    if (i != 4) curves.positions.push_back({x, 1, 0});
    curves.labels.push_back({i, 0, i % 5 == 0});
  }
  ASSERT_TRUE(prepareCurves(curves, {.randomizeStrands = true}));
  ASSERT_EQ(curves.labels.size(), 19u);
  std::vector<uint32_t> guides;
  for (uint32_t i = 0; i < 19; ++i) {
    EXPECT_EQ(static_cast<float>(curves.labels[i].id), curves.positions[size_t{i} * 2].x);
    if (curves.labels[i].isGuide) guides.push_back(i);
  }
  auto strands = required(resampleCurves(curves, {.verticesPerStrand = 4}));
  auto selection = required(selectGuides(strands->asset, {.guides = guides}));
  EXPECT_EQ(selection->source, guides);
  EXPECT_EQ(selection->guides.strandCount, 4u);
  EXPECT_EQ(selection->followHairs.size(), 15u);
  EXPECT_LT(selection->report.maxError, 1e-5f) << "parallel hairs";
  EXPECT_FALSE(selectGuides(strands->asset, {.guides = {3, 3}}));
  EXPECT_FALSE(selectGuides(strands->asset, {.guides = {19}}));
  EXPECT_FALSE(selectGuides(strands->asset, {.guideCount = 1, .guides = {0}}));
}

// ---- Errors

TEST(UsdFiles, ErrorsNameTheLineAndThePrim) {
  const std::string good = layerOf(
      "        int[] curveVertexCounts = [2, 3]\n"
      "        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 2, 0), (0, 3, 0)]\n"
      "        float[] widths = [1, 2] (\n            interpolation = \"uniform\"\n        )\n"
      "        uniform token type = \"linear\"\n"
      "        double3 xformOp:translate = (1, 2, 3)\n"
      "        uniform token[] xformOpOrder = [\"xformOp:translate\"]\n");
  ASSERT_TRUE(load(good));
  const struct {
    const char *from, *to, *message;
  } cases[] = {
      {"[2, 3]", "[2, 4]", "a.usda:11: /root/hair: curve 1 has 4 vertices, but 3 of 5"},
      {"[2, 3]", "[2, -1]", "a.usda:11: /root/hair: curve 1 has -1 vertices"},
      {"[2, 3]", "[2, 2]", "a.usda:11: /root/hair: there are 5 points for the 4 vertices"},
      {"[2, 3]", "[2, 99999999999999999999]", "'99999999999999999999' is not a whole number"},
      {"[2, 3]", "[2, 9223372036854775807]", "curve 1 has 9223372036854775807 vertices"},
      {"[2, 3]", "[2, x]", "a.usda:11: /root/hair: curveVertexCounts: 'x'"},
      {"int[] curveVertexCounts", "float[] curveVertexCounts", "not an array of integers"},
      {"int[] curveVertexCounts", "int[] other", "/root/hair: curveVertexCounts has no value"},
      {"(1, 0, 0)", "(1, 0)", "a.usda:12: /root/hair: points: an element has 2 numbers"},
      {"(1, 0, 0)", "(1, 0, 0, 0)", "points: an element has 4 numbers or more"},
      {"(1, 0, 0)", "1", "'1' where a point3f of points"},
      {"(1, 0, 0)", "(1, 0, 0x)", "points: '0x' is not a number"},
      {"point3f[] points", "int3[] points", "points is not an array of points"},
      {"point3f[] points", "point3f[] p", "/root/hair: points has no value"},
      {"[1, 2] (", "[1, 2, 3] (",
       "a.usda:13: /root/hair: widths has 3 values; with the "
       "interpolation 'uniform' it needs 2"},
      {"\"uniform\"", "\"faceVarying\"", "the interpolation 'faceVarying' is none of curves"},
      {"\"linear\"", "\"cubic\"", ""},
      {"\"linear\"", "\"quadratic\"", "/root/hair: type is 'quadratic'"},
      {"[\"xformOp:translate\"]", "[\"xformOp:gone\"]", "names 'xformOp:gone', which has no value"},
      {"double3 xformOp", "double2 xformOp", "xformOp:translate: an element has 3 numbers"},
      {"double3 xformOp:translate = (1, 2, 3)", "token xformOp:translate = \"x\"",
       "'xformOp:translate' with the type token is no operation"},
      {"metersPerUnit = 1", "metersPerUnit = 0", "metersPerUnit is 0"},
      {"metersPerUnit = 1", "metersPerUnit = nan", "metersPerUnit"},
      {"\"Y\"", "\"X\"", "upAxis is 'X'"},
      {"#usda 1.0", "#usda 2.0", "a.usda:1: the file does not begin with"},
      {"def Xform \"root\"\n{", "def Xform \"root\n{", "a.usda:7: \" is not closed"},
      {"def Xform \"root\"", "define Xform \"root\"", "'define' where 'def', 'over' or 'class'"},
      {"BasisCurves", "Mesh", "no BasisCurves that are defined and visible"},
      {"BasisCurves", "NurbsCurves", "1 prims are curves of another kind"},
      {"def BasisCurves", "over BasisCurves", "no BasisCurves"},
      {"    }\n}\n", "    }\n", "a.usda:20: /root: the file ends before the prim does"},
      {"(0, 3, 0)]", "(0, 3, 0)", "/root/hair: 'float' where ',' or ']' of points"},
  };
  for (const auto& one : cases) {
    SCOPED_TRACE(std::string(one.from) + " -> " + one.to);
    const auto curves = load(replaced(good, one.from, one.to));
    // Cubic curves of too few vertices are polylines.
    if (*one.message == '\0') {
      EXPECT_TRUE(curves);
    } else {
      expectError(curves, one.message);
    }
  }
  const std::string cubic = replaced(replaced(good, "\"linear\"", "\"cubic\""), "[2, 3]", "[0, 5]");
  expectError(load(cubic), "curve 1 has 5 vertices, which is no whole number of segments");
}

TEST(UsdFiles, ReferencesBinaryFilesAndUnknownUnitsSaySo) {
  expectError(
      load("#usda 1.0\ndef \"hair\" (\n    prepend references = @hair.usd@</hair> (offset = "
           "1)\n)\n{\n}\n"),
      "usdcat --flatten");
  const std::string crate = "PXR-USDC and more", package = "PK\x03\x04";
  for (const auto& [bytes, name] :
       {std::pair(crate, "a.usdc"), std::pair(crate, "a.usd"), std::pair(package, "a.usdz")})
    expectError(loadHairCurves(std::as_bytes(std::span(bytes)), name),
                (std::string("usdcat --flatten -o hair.usda ") + name).c_str());
  HairFileReport report;
  auto curves = required(
      load(replaced(layerOf("        int[] curveVertexCounts = [2]\n        uniform token type = "
                            "\"linear\"\n        point3f[] points = [(0, 0, 0), (0, 100, 0)]\n"),
                    "    metersPerUnit = 1\n", ""),
           &report));
  EXPECT_EQ(curves->positions[1].y, 1);
  ASSERT_EQ(report.notes.size(), 1u);
  expectHas(report.notes[0], "centimeters");
}

TEST(UsdFiles, DeepNestingIsAnError) {
  std::string prims = "#usda 1.0\n", brackets = "#usda 1.0\ndef \"a\"\n{\n    int x = ";
  for (int i = 0; i < 200000; ++i) prims += "def \"a\" {";
  brackets += std::string(200000, '[');
  expectError(load(prims), "nested deeper than 128");
  expectError(load(brackets), "nested deeper than 64");
}

}  // namespace
}  // namespace pelage
