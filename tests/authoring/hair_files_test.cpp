// Readers of hair curves: what goes in comes out, and nothing that a file can hold does harm. Each
// file is made here.
#include "pelage/authoring/hair_files.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "pelage/authoring/hair_curves.h"
#include "pelage/hair_asset.h"
#include "support/errors.h"
#include "support/not_numbers.h"
#include "support/test_folder.h"

namespace pelage {
namespace {

using Bytes = std::vector<std::byte>;
using test::expectError;
using test::expectHas;
using test::kNan;
using test::required;
using test::TestFolder;
using test::valueOf;

Bytes bytesOf(std::string_view text) {
  const auto* data = reinterpret_cast<const std::byte*>(text.data());
  return {data, data + text.size()};
}

template <class T>
void push(Bytes& bytes, const T& value) {
  const auto* data = reinterpret_cast<const std::byte*>(&value);
  bytes.insert(bytes.end(), data, data + sizeof(T));
}

template <class T>
Bytes changed(Bytes bytes, size_t offset, const T& value) {
  EXPECT_LE(offset + sizeof(T), bytes.size());
  std::memcpy(bytes.data() + offset, &value, sizeof(T));
  return bytes;
}

// Three curves of 2, 3 and 5 vertices with all arrays; the numbers survive halving and 1 - x.
HairCurves someCurves() {
  HairCurves curves;
  curves.vertexCounts = {2, 3, 5};
  for (uint32_t i = 0; i < 10; ++i) {
    const auto x = static_cast<float>(i);
    curves.positions.push_back({x * 0.1f, -x, 1e-7f * x * x});
    curves.inverseMasses.push_back(i % 3 == 0 ? 0.0f : 1.25f);
    curves.radii.push_back(0.001f * x);
    curves.colors.push_back({x / 16, 0.3f, 1e3f, 1 - x / 16});
    curves.vertexUv.push_back({x, -0.7f});
  }
  curves.strandUv = {{0.1f, 0.2f}, {0, 1}, {-3, 0.333f}};
  return curves;
}

void expectSame(const HairCurves& a, const HairCurves& b) {
  EXPECT_EQ(a.vertexCounts, b.vertexCounts);
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.inverseMasses, b.inverseMasses);
  EXPECT_EQ(a.radii, b.radii);
  EXPECT_EQ(a.colors, b.colors);
  EXPECT_EQ(a.vertexUv, b.vertexUv);
  EXPECT_EQ(a.strandUv, b.strandUv);
}

// ---- Small good files

Bytes hairFile() { return *saveYukselHair(someCurves()); }
Bytes textFile() { return bytesOf(*saveHairText(someCurves())); }
Bytes usdFile() { return bytesOf(*saveUsdCurves(someCurves())); }

Bytes objFile() {
  return bytesOf(
      "# two curves\n"
      "v 0 0 0 0.25 0.5 0.75\nv 0 1 0\nv 0 2 \\\n 0.5\nvt 0.25 1\nvt 0.5 0\n"
      "g hair\nf 1 2 3\nl 1/1 2/2 3\n"
      "v 1 0 0\nv 1 1 0\nv 1 2 0\nl -3 -2\nl -2 -1\n");
}

std::string base64(const Bytes& bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t bits = 0;
    for (size_t k = 0; k < 3; ++k)
      bits = bits << 8 | (i + k < bytes.size() ? static_cast<uint32_t>(bytes[i + k]) : 0);
    for (size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? kDigits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

// Positions (0 1 2), (1 2 3), ... of four vertices, then byte colours, then indices 0 1 1 2 2 3.
Bytes gltfBuffer() {
  Bytes bytes;
  for (uint32_t i = 0; i < 4; ++i)
    for (uint32_t c = 0; c < 3; ++c) push(bytes, static_cast<float>(i + c));
  for (uint32_t i = 0; i < 4; ++i)
    for (const uint8_t c : {uint8_t{255}, uint8_t{0}, uint8_t{51}, uint8_t{255}}) push(bytes, c);
  for (const int index : {0, 1, 1, 2, 2, 3}) push(bytes, static_cast<uint16_t>(index));
  return bytes;
}

std::string gltfText(const std::string& buffer, const std::string& primitive =
                                                    "{\"mode\":3,\"attributes\":{\"POSITION\":0,"
                                                    "\"COLOR_0\":1}}") {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],)"
         R"("nodes":[{"scale":[2,2,2],"children":[1]},)"
         R"({"translation":[10,0,0],"rotation":[0,0,0.70710678118654752,0.70710678118654752],)"
         R"("mesh":0}],"meshes":[{"primitives":[)" +
         primitive +
         R"(]}],"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},)"
         R"({"bufferView":1,"componentType":5121,"normalized":true,"count":4,"type":"VEC4"},)"
         R"({"bufferView":2,"componentType":5123,"count":6,"type":"SCALAR"}],)"
         R"("bufferViews":[{"buffer":0,"byteLength":48},)"
         R"({"buffer":0,"byteOffset":48,"byteLength":16},)"
         R"({"buffer":0,"byteOffset":64,"byteLength":12}],"buffers":[{"byteLength":76)" +
         buffer + "}]}";
}

Bytes gltfFile() {
  return bytesOf(
      gltfText(",\"uri\":\"data:application/octet-stream;base64," + base64(gltfBuffer()) + "\""));
}

Bytes glbFile() {
  std::string gltf = gltfText("");
  while (gltf.size() % 4 != 0) gltf += ' ';
  const Bytes buffer = gltfBuffer();
  Bytes bytes = bytesOf("glTF");
  push(bytes, uint32_t{2});
  push(bytes, static_cast<uint32_t>(28 + gltf.size() + buffer.size()));
  push(bytes, static_cast<uint32_t>(gltf.size()));
  for (const char c : std::string_view("JSON")) push(bytes, c);
  for (const char c : gltf) push(bytes, c);
  push(bytes, static_cast<uint32_t>(buffer.size()));
  for (const char c : std::string_view("BIN\0", 4)) push(bytes, c);
  bytes.insert(bytes.end(), buffer.begin(), buffer.end());
  return bytes;
}

Bytes tfx2File() {
  return bytesOf(
      "version 2.0\nscale 2.0\nrotation 0 0 0\ntranslation 1 0 0\nbothEndsImmovable 1\n"
      "maxNumVerticesInStrand 5\nnumFollowHairsPerGuideHair 4\nmaxRadiusAroundGuideHair 1.5\n"
      "numStrands 2\nis sorted 1\n"
      "strand 0 numVerts 2 texcoord 0.500000 000000\n0.5, 1.0, 2.0\n0.5, 2.0, 2.0\n"
      "strand 1 numVerts 5 texcoord 0.25 0.75\n0 0 0\n1 0 0\n2 0 0\n3 0 0\n4 0 0\n");
}

Bytes tfx3File() {
  Bytes bytes;
  push(bytes, 3.0f);
  for (const uint32_t count : {2u, 3u, 0u, 1u}) push(bytes, count);
  for (int i = 0; i < 31; ++i) push(bytes, 0u);
  for (const uint32_t offset : {296u, 368u, 376u, 0u, 0u, 0u}) push(bytes, offset);
  for (int i = 0; i < 32; ++i) push(bytes, 0u);
  EXPECT_EQ(bytes.size(), 296u);
  for (int i = 0; i < 18; ++i) push(bytes, static_cast<float>(i));
  for (const float thickness : {1.0f, 0.5f}) push(bytes, thickness);
  for (const float uv : {0.1f, 0.2f, 0.3f, 0.4f}) push(bytes, uv);
  return bytes;
}

Bytes tfx4File() {
  HairAsset asset;
  asset.strandCount = 2;
  asset.verticesPerStrand = 3;
  for (int i = 0; i < 6; ++i)
    asset.positions.push_back({static_cast<float>(i), 0, 1, i % 3 < 2 ? 0.0f : 1.0f});
  asset.strandUv = {{0.5f, 0.25f}, {1, 0}};
  asset.strandThickness = {1, 0.5f};
  return *saveTfx(asset);
}

struct Sample {
  const char* name;
  Bytes bytes;
};

std::vector<Sample> allSamples() {
  return {{"a.hair", hairFile()}, {"a.hairtxt", textFile()}, {"a.obj", objFile()},
          {"a.gltf", gltfFile()}, {"a.glb", glbFile()},      {"text.tfx", tfx2File()},
          {"3.tfx", tfx3File()},  {"4.tfx", tfx4File()},     {"a.usda", usdFile()}};
}

// ---- Every format

TEST(HairFiles, EachFormatIsRecognisedAndItsCurvesAreUsable) {
  for (const Sample& sample : allSamples()) {
    SCOPED_TRACE(sample.name);
    HairFileReport report;
    auto curves = required(loadHairCurves(sample.bytes, sample.name, &report));
    EXPECT_TRUE(validate(*curves));
    EXPECT_GE(curves->curveCount(), 1u);
    EXPECT_EQ(report.fileSize, sample.bytes.size());
    EXPECT_FALSE(report.format.empty());
  }
}

TEST(HairFiles, EveryTruncationIsAnErrorOrTheCurvesThatAreWhole) {
  for (const Sample& sample : allSamples()) {
    SCOPED_TRACE(sample.name);
    const std::string_view name = sample.name;
    // Text has no length of its own: the end of a line is a good end.
    const bool openEnd = name == "a.hairtxt" || name == "a.obj";
    const size_t whole = loadHairCurves(sample.bytes, name)->positions.size();
    size_t refused = 0;
    for (size_t size = 0; size < sample.bytes.size(); ++size) {
      const auto curves = loadHairCurves(std::span(sample.bytes).first(size), name);
      refused += curves ? 0 : 1;
      if (curves && openEnd) {
        EXPECT_LE(curves->positions.size(), whole);
      }
      if (curves && !openEnd && sample.bytes.size() - size > 16)
        ADD_FAILURE() << "accepted with " << size << " bytes";
      if (!curves) expectHas(curves.error().message, name);
    }
    EXPECT_GT(refused, sample.bytes.size() / 4);
  }
}

TEST(HairFiles, AByteOrderMarkIsNoPartOfTheText) {
  for (const auto& [text, name] :
       {std::pair("v 0 0 0\nv 1 0 0\nl 1 2\n", "a.obj"), std::pair("hairtxt 1\n0 0 0\n1 0 0\n", ""),
        std::pair("numStrands 1\nstrand 0 numVerts 2\n0 0 0\n1 0 0\n", "a.tfx")}) {
    auto curves = loadHairCurves(bytesOf("\xef\xbb\xbf" + std::string(text)), name);
    ASSERT_TRUE(curves) << name << curves.error().message;
    EXPECT_EQ(curves->positions, (std::vector<Float3>{{0, 0, 0}, {1, 0, 0}}));
    EXPECT_TRUE(curves->strandUv.empty());
  }
}

TEST(HairFiles, AFileOfNoKindIsRefusedByName) {
  expectError(loadHairCurves(bytesOf("hello"), "a.png"), "a.png");
  expectError(loadHairCurves(bytesOf(""), "nothing"), "nothing");
  expectError(loadHairCurves(std::filesystem::path("missing.hair")), "missing.hair");
  // The magic number counts more than the name.
  HairFileReport report;
  EXPECT_TRUE(loadHairCurves(hairFile(), "a.obj", &report));
  EXPECT_EQ(report.kind, HairFileKind::kHair);
}

// ---- .hair

TEST(YukselHair, KeepsEveryBitOfWhatItHasAPlaceFor) {
  HairCurves curves = someCurves();
  auto loaded = required(loadYukselHair(*saveYukselHair(curves), "a.hair"));
  curves.inverseMasses.clear();
  curves.strandUv.clear();
  expectSame(*loaded, curves);
}

TEST(YukselHair, ReadsTheHeaderAndTheArraysWhereTheSpecificationPutsThem) {
  Bytes bytes = bytesOf("HAIR");
  for (const uint32_t word : {1u, 2u, 2u | 4u | 8u, 1u}) push(bytes, word);
  for (const float value : {9.0f, 0.5f, 0.25f, 0.5f, 0.75f}) push(bytes, value);
  bytes.resize(128);
  for (const float value : {1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f}) push(bytes, value);
  for (const float thickness : {0.5f, 0.25f}) push(bytes, thickness);
  for (const float transparency : {0.0f, 0.75f}) push(bytes, transparency);
  auto curves = required(loadYukselHair(bytes, "a.hair"));
  EXPECT_EQ(curves->vertexCounts, std::vector<uint32_t>{2});
  EXPECT_EQ(curves->positions[1], (Float3{4, 5, 6}));
  EXPECT_EQ(curves->radii, (std::vector<float>{0.25f, 0.125f}));
  EXPECT_EQ(curves->colors[1], (Float4{0.25f, 0.5f, 0.75f, 0.25f}));
}

// A color and a thickness in the header are those of all strands; the format's own library writes
// 1, opaque and white for "none".
TEST(YukselHair, KeepsColorAndThicknessOfTheHeader) {
  HairCurves curves = someCurves();
  curves.radii.clear();
  curves.colors.clear();
  const Bytes plain = *saveYukselHair(curves);
  const auto none = required(loadYukselHair(plain, "a.hair"));
  EXPECT_TRUE(none->radii.empty() && none->colors.empty());

  Bytes bytes = changed(plain, 20, 0.25f);  // thickness
  bytes = changed(bytes, 24, 0.5f);         // transparency
  bytes = changed(bytes, 28, Float3{0.1f, 0.2f, 0.3f});
  HairFileReport report;
  const auto all = required(loadYukselHair(bytes, "a.hair", &report));
  EXPECT_EQ(all->radii, std::vector<float>(10, 0.125f));
  ASSERT_EQ(all->colors.size(), 10u);
  EXPECT_TRUE(all->colors[9].x == 0.1f && all->colors[9].z == 0.3f && all->colors[9].w == 0.5f);
  EXPECT_TRUE(report.notes.empty());

  // Values out of range are left out, and named.
  bytes = changed(changed(plain, 20, -1.0f), 28, Float3{kNan, 0, 0});
  const auto wrong = required(loadYukselHair(bytes, "a.hair", &report));
  EXPECT_TRUE(wrong->radii.empty() && wrong->colors.empty());
  ASSERT_EQ(report.notes.size(), 2u);
  expectHas(report.notes[0], "thickness");
  expectHas(report.notes[1], "color");
}

TEST(YukselHair, CountsThatLieAreRefusedAtTheirByte) {
  const Bytes good = hairFile();
  for (const uint32_t lie : {0u, 4u, 0x7FFFFFFFu, 0xFFFFFFFFu}) {
    expectError(loadYukselHair(changed(good, 4, lie), "a.hair"), "a.hair: byte ");
    expectError(loadYukselHair(changed(good, 8, lie), "a.hair"), "a.hair: byte ");
  }
  expectError(loadYukselHair(changed(good, 12, 0u), "a.hair"), "byte 12: the file has no points");
  expectError(loadYukselHair(changed(good, 12, 0x1003u), "a.hair"), "0x1000");
  expectError(loadYukselHair(changed(good, 128, uint16_t{7}), "a.hair"), "need 16");
  expectError(loadYukselHair(changed(good, 0, 'h'), "a.hair"), "byte 0");
  // Without the array, the default number of segments must fit.
  expectError(loadYukselHair(changed(changed(good, 12, 2u), 16, 0xFFFFFFFFu), "a.hair"), "byte 8");
}

// ---- .obj

TEST(ObjCurves, ReadsPolylinesJoinedPairsNegativeIndicesAndContinuedLines) {
  HairFileReport report;
  auto curves = required(loadObjCurves(objFile(), "a.obj", &report));
  EXPECT_EQ(curves->vertexCounts, (std::vector<uint32_t>{3, 3}));
  EXPECT_EQ(curves->positions[2], (Float3{0, 2, 0.5f}));
  EXPECT_EQ(curves->positions[5], (Float3{1, 2, 0}));
  EXPECT_EQ(curves->colors[0], (Float4{0.25f, 0.5f, 0.75f, 1}));
  EXPECT_EQ(curves->colors[5], (Float4{1, 1, 1, 1}));
  EXPECT_EQ(curves->vertexUv[1], (Float2{0.5f, 0}));
  ASSERT_EQ(report.notes.size(), 2u);
  EXPECT_EQ(report.notes[1], "1 faces are ignored");
}

TEST(ObjCurves, JoinsPairsInAnyOrderTheWayMostOfThemRunAndEndsAtForks) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\nv 4 0 0\n";
  const auto xs = [&](const std::string& lines) {
    auto curves = loadObjCurves(bytesOf(vertices + lines), "a.obj");
    EXPECT_TRUE(curves);
    std::vector<std::vector<float>> out;
    size_t at = 0;
    for (const uint32_t count : curves->vertexCounts) {
      out.emplace_back();
      for (uint32_t i = 0; i < count; ++i) out.back().push_back(curves->positions[at++].x);
    }
    return out;
  };
  using Chains = std::vector<std::vector<float>>;
  EXPECT_EQ(xs("l 3 4\nl 1 2\nl 4 5\nl 2 3\n"), (Chains{{0, 1, 2, 3, 4}}));
  EXPECT_EQ(xs("l 2 3\nl 3 2\n").size(), 1u);
  EXPECT_EQ(xs("l 3 2\nl 2 1\nl 3 4\n"), (Chains{{3, 2, 1, 0}}));
  EXPECT_EQ(xs("l 2 1\nl 2 3\nl 3 4\n"), (Chains{{0, 1, 2, 3}}));
  EXPECT_EQ(xs("l 1 2\nl 2 3\nl 3 1\n"), (Chains{{0, 1, 2, 0}}));
  EXPECT_EQ(xs("l 1 3\nl 2 3\nl 3 4\nl 4 5\n"), (Chains{{0, 2}, {1, 2}, {2, 3, 4}}));
}

TEST(ObjCurves, ErrorsNameTheLine) {
  const auto load = [](std::string_view text) { return loadObjCurves(bytesOf(text), "a.obj"); };
  expectError(load("v 0 0 0\nl 1 2\n"), "a.obj:2: ");
  expectError(load("v 0 0 0\nl -2 1\n"), "a.obj:2: ");
  expectError(load("v 0 0 0\nl 0 1\n"), "a.obj:2: ");
  expectError(load("v 0 0 0\nl 1 -9223372036854775808\n"), "a.obj:2: ");
  expectError(load("v 0 0 0\nl 1 99999999999999999999\n"), "a.obj:2: ");
  expectError(load("v 0 0 0\nl 1/1 1\n"), "texture coordinate");
  expectError(load("v 0 0\n"), "a.obj:1: ");
  expectError(load("v 0 0 zero\n"), "'zero' is not a number");
  expectError(load("v 0 0 0\nf 1 1 1\n"), "no lines");
}

// ---- glTF

TEST(GltfCurves, StripsAreWhereTheNodesPutThem) {
  for (const Bytes& bytes : {gltfFile(), glbFile()}) {
    auto curves = required(loadGltfCurves(bytes, "a.gltf"));
    ASSERT_EQ(curves->vertexCounts, std::vector<uint32_t>{4});
    // A quarter turn about z, moved by 10, then doubled: (x y z) -> 2 (10 - y, x, z).
    for (uint32_t i = 0; i < 4; ++i) {
      const auto k = static_cast<float>(i);
      EXPECT_NEAR(curves->positions[i].x, 2 * (10 - (k + 1)), 1e-5);
      EXPECT_NEAR(curves->positions[i].y, 2 * k, 1e-5);
      EXPECT_NEAR(curves->positions[i].z, 2 * (k + 2), 1e-5);
      EXPECT_EQ(curves->colors[i], (Float4{1, 0, 0.2f, 1}));
    }
  }
}

TEST(GltfCurves, LinesAreJoinedAndLoopsClosed) {
  const std::string uri =
      ",\"uri\":\"data:application/octet-stream;base64," + base64(gltfBuffer()) + "\"";
  const auto counts = [&](const std::string& primitive) {
    return valueOf(loadGltfCurves(bytesOf(gltfText(uri, primitive)), "a.gltf")).vertexCounts;
  };
  EXPECT_EQ(counts(R"({"mode":1,"indices":2,"attributes":{"POSITION":0}})"),
            std::vector<uint32_t>{4});
  EXPECT_EQ(counts(R"({"mode":1,"attributes":{"POSITION":0}})"), (std::vector<uint32_t>{2, 2}));
  EXPECT_EQ(counts(R"({"mode":2,"attributes":{"POSITION":0}})"), std::vector<uint32_t>{5});
}

TEST(GltfCurves, ManyStrandsMayShareOneArray) {
  // 3,000 primitives of one array of 48,000 vertices: what the indices of all ask for is little.
  constexpr uint32_t kStrands = 3000, kVertices = 16;
  for (const int mode : {3, 1}) {
    Bytes data;
    for (uint32_t i = 0; i < kStrands * kVertices; ++i)
      push(data, Float3{static_cast<float>(i / kVertices), static_cast<float>(i % kVertices), 0});
    const size_t positionSize = data.size();
    // A strip, or segments that make one.
    const uint32_t count = mode == 3 ? kVertices : 2 * (kVertices - 1);
    for (uint32_t s = 0; s < kStrands; ++s)
      for (uint32_t i = 0; i < count; ++i)
        push(data, s * kVertices + (mode == 3 ? i : (i + 1) / 2));
    std::string accessors = R"({"bufferView":0,"componentType":5126,"count":48000,"type":"VEC3"})";
    std::string primitives;
    for (uint32_t s = 0; s < kStrands; ++s) {
      accessors += R"(,{"bufferView":1,"componentType":5125,"type":"SCALAR","count":)" +
                   std::to_string(count) + R"(,"byteOffset":)" + std::to_string(s * count * 4) +
                   "}";
      primitives += std::string(s == 0 ? "" : ",") + R"({"attributes":{"POSITION":0},"mode":)" +
                    std::to_string(mode) + R"(,"indices":)" + std::to_string(s + 1) + "}";
    }
    const std::string text =
        R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
        R"("meshes":[{"primitives":[)" +
        primitives + R"(]}],"accessors":[)" + accessors +
        R"(],"bufferViews":[{"buffer":0,"byteLength":)" + std::to_string(positionSize) +
        R"(},{"buffer":0,"byteOffset":)" + std::to_string(positionSize) + R"(,"byteLength":)" +
        std::to_string(data.size() - positionSize) + R"(}],"buffers":[{"byteLength":)" +
        std::to_string(data.size()) + R"(,"uri":"data:application/octet-stream;base64,)" +
        base64(data) + R"("}]})";
    auto curves = required(loadGltfCurves(bytesOf(text), "a.gltf"));
    EXPECT_EQ(curves->vertexCounts, std::vector<uint32_t>(kStrands, kVertices));
    const size_t last = curves->positions.size() - 1;
    EXPECT_EQ(curves->positions[last], (Float3{kStrands - 1, kVertices - 1, 0}));
  }
}

TEST(GltfCurves, WhatDoesNotFitTogetherIsRefusedByItsPlace) {
  const std::string good(reinterpret_cast<const char*>(gltfFile().data()), gltfFile().size());
  const auto with = [&](std::string_view from, std::string_view to) {
    std::string text = good;
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return loadGltfCurves(bytesOf(text.replace(at, from.size(), to)), "a.gltf");
  };
  expectError(with("\"count\":4", "\"count\":5"), "accessors[0]");
  expectError(with("\"count\":4", "\"count\":18446744073709551615"), "accessors[0]");
  expectError(with("\"count\":4", "\"count\":-1"), "accessors[0].count");
  expectError(with("\"count\":4", "\"count\":0"), "accessors[0].count");
  expectError(with("\"count\":4", "\"byteOffset\":18446744073709551615,\"count\":4"),
              "accessors[0]");
  expectError(with("\"count\":4", "\"sparse\":{},\"count\":4"), "sparse");
  expectError(with("{\"bufferView\":0,", "{"), "no bufferView");
  expectError(with("\"byteLength\":48", "\"byteLength\":77"), "bufferViews[0]");
  expectError(with("\"byteLength\":48", "\"byteStride\":4,\"byteLength\":48"), "byteStride");
  expectError(with("\"byteLength\":76", "\"byteLength\":77"), "buffers[0]");
  expectError(with("\"children\":[1]", "\"children\":[1,1]"), "nodes[1]");
  expectError(with("\"children\":[1]", "\"children\":[0]"), "nodes[0]");
  expectError(with("\"children\":[1]", "\"children\":[7]"), "nodes[7]");
  expectError(with("\"POSITION\":0", "\"POSITION\":2"), "accessors[2].type");
  expectError(with("\"mode\":3", "\"indices\":0,\"mode\":3"), "accessors[0]");
  expectError(with("\"mode\":3", "\"mode\":4"), "no lines");
  expectError(with("data:application/octet-stream;base64,", "../secret.bin?"), "folder");
  expectError(with("\"version\":\"2.0\"", "\"version\":\"1.0\""), "asset.version");
  expectError(with("{\"asset\"", "[{\"asset\""), "byte ");
  expectError(with("[2,2,2]", "[2,1e999,2]"), "out of range");
}

TEST(GltfCurves, InstancesCannotGrowWithoutBound) {
  // 2000 nodes of one mesh with 500 primitives: 4 million vertices of 40 kB.
  std::string primitives, nodes, list;
  for (int i = 0; i < 500; ++i)
    primitives += std::string(i == 0 ? "" : ",") + R"({"mode":3,"attributes":{"POSITION":0}})";
  for (int i = 0; i < 2000; ++i) {
    nodes += std::string(i == 0 ? "" : ",") + R"({"mesh":0})";
    list += (i == 0 ? "" : ",") + std::to_string(i);
  }
  std::string text = gltfText(
      ",\"uri\":\"data:application/octet-stream;base64," + base64(gltfBuffer()) + "\"", primitives);
  const size_t from = text.find("\"scenes\""), to = text.find("\"meshes\"");
  text.replace(from, to - from,
               "\"scenes\":[{\"nodes\":[" + list + "]}],\"nodes\":[" + nodes + "],");
  expectError(loadGltfCurves(bytesOf(text), "a.gltf"), "instances");
}

TEST(GltfCurves, BuffersBesideTheFileAreFound) {
  const TestFolder folder;
  const std::string text = gltfText(R"(,"uri":"the%20hair.bin")");
  const Bytes buffer = gltfBuffer();
  (void)folder.write("the hair.bin", {reinterpret_cast<const char*>(buffer.data()), buffer.size()});
  (void)folder.write("a.gltf", text);
  EXPECT_TRUE(loadHairCurves(folder / "a.gltf"));
  expectError(loadHairCurves(bytesOf(text), "a.gltf"), "load by path");
}

// ---- .tfx

TEST(TfxCurves, TextOfVersion2IsScaledMovedAndFixedAtBothEnds) {
  HairFileReport report;
  auto curves = required(loadTfxCurves(tfx2File(), "a.tfx", &report));
  EXPECT_EQ(report.format, "TressFX 2.0 text");
  EXPECT_EQ(curves->vertexCounts, (std::vector<uint32_t>{2, 5}));
  EXPECT_EQ(curves->positions[0], (Float3{2, 2, 4}));
  EXPECT_EQ(curves->strandUv[1], (Float2{0.25f, 0.75f}));
  EXPECT_EQ(curves->inverseMasses, (std::vector<float>{0, 0, 0, 0, 1, 0, 0}));
}

TEST(TfxCurves, TextOfVersion1HasNoHeaderButTheCount) {
  HairFileReport report;
  auto curves = required(loadTfxCurves(
      bytesOf("numStrands 1\nis sorted 1\nstrand 0 numVerts 3 texcoord 0 0\n1 2 3\n-1.#INF 0 0\n"
              "4 5 6"),
      "a.tfx", &report));
  EXPECT_EQ(report.format, "TressFX 1 text");
  CurveImportReport imported;
  ASSERT_TRUE(prepareCurves(*curves, {}, &imported));
  EXPECT_EQ(imported.removedVertices, 1u);
  EXPECT_EQ(curves->positions, (std::vector<Float3>{{1, 2, 3}, {4, 5, 6}}));
}

TEST(TfxCurves, RotationOfVersion2IsRollThenPitchThenYaw) {
  const auto turned = [](const std::string& rotation) {
    return loadTfxCurves(
               bytesOf("version 2.0\nrotation " + rotation +
                       "\nnumStrands 1\nstrand 0 numVerts 2 texcoord 0 0\n1 2 3\n0 0 0\n"),
               "a.tfx")
        ->positions[0];
  };
  const auto near = [](const Float3& a, const Float3& b) {
    return std::abs(a.x - b.x) + std::abs(a.y - b.y) + std::abs(a.z - b.z) < 1e-5;
  };
  EXPECT_TRUE(near(turned("0 0 1.57079633"), {-2, 1, 3}));
  EXPECT_TRUE(near(turned("1.57079633 0 1.57079633"), {-2, -3, 1}));
  EXPECT_TRUE(near(turned("1.57079633 1.57079633 1.57079633"), {1, -3, 2}));
}

TEST(TfxCurves, Version3HasItsArraysAtItsOffsets) {
  HairFileReport report;
  auto curves = required(loadTfxCurves(tfx3File(), "a.tfx", &report));
  EXPECT_EQ(report.format, "TressFX 3.0");
  EXPECT_EQ(curves->vertexCounts, (std::vector<uint32_t>{3, 3}));
  EXPECT_EQ(curves->positions[5], (Float3{15, 16, 17}));
  EXPECT_EQ(curves->strandUv[1], (Float2{0.3f, 0.4f}));
  EXPECT_EQ(curves->radii[3], 0.5f * kUnitFiberRadius);
  EXPECT_EQ(curves->inverseMasses.size(), 6u);
}

TEST(TfxCurves, AStrandOfVersion4WithoutAnyPositionIsDroppedAndTheOthersAreKept) {
  HairAsset asset;
  asset.strandCount = 3;
  asset.verticesPerStrand = 2;
  for (const float x : {0.0f, 1.0f, 2.0f}) {
    asset.positions.push_back({x, 0, 0, 0});
    asset.positions.push_back({x, 1, 0, 0});
  }
  Bytes bytes = *saveTfx(asset);
  for (const size_t vertex : {2, 3, 5}) {  // all of strand 1, one of strand 2
    std::memcpy(bytes.data() + 160 + vertex * sizeof(Float4), &kNan, sizeof(kNan));
  }
  auto curves = required(loadTfxCurves(bytes, "a.tfx"));
  CurveImportReport report;
  ASSERT_TRUE(prepareCurves(*curves, {}, &report));
  EXPECT_EQ(report.droppedUnusable, 1u);
  EXPECT_EQ(report.droppedNoLength, 1u);  // repaired: the vertex is on the one before
  EXPECT_EQ(curves->positions, (std::vector<Float3>{{0, 0, 0}, {0, 1, 0}}));
}

TEST(TfxCurves, OtherVersionsAndLyingCountsAreNamed) {
  expectError(loadTfxCurves(changed(tfx3File(), 0, 3.5f), "a.tfx"), "version is 3.5");
  expectError(loadTfxCurves(bytesOf("version 2.5\n"), "a.tfx"), "version 2.5");
  expectError(loadTfxCurves(tfx3File(), "a.tfxb"), ".tfxb");
  for (const uint32_t lie : {0u, 7u, 0xFFFFFFFFu}) {
    expectError(loadTfxCurves(changed(tfx3File(), 4, lie), "a.tfx"), "byte ");
    expectError(loadTfxCurves(changed(tfx3File(), 8, lie), "a.tfx"), "byte ");
  }
  expectError(loadTfxCurves(changed(tfx3File(), 144, 4u), "a.tfx"), "byte 144");
  expectError(
      loadTfxCurves(bytesOf("numStrands 9\nstrand 0 numVerts 4000000000 texcoord 0 0\n"), "a.tfx"),
      "a.tfx:2: ");
  expectError(loadTfxCurves(bytesOf("numStrands 4000000000\n"), "a.tfx"), "after 0 strands");
}

// ---- .hairtxt

TEST(HairText, KeepsEveryBit) {
  const HairCurves curves = someCurves();
  auto loaded = required(loadHairText(bytesOf(*saveHairText(curves)), "a.hairtxt"));
  expectSame(*loaded, curves);
}

TEST(HairText, HasColumnsCommentsAndRoots) {
  auto curves = required(loadHairText(bytesOf("# mine\n\nhairtxt 1 z x y radius # columns\n"
                                              "1 2 3 .5\n# not the end\r\n+1 2e1 3 1e-50\n\n\n"
                                              "root 0.5 1\n0 0 0 1\n0 1 0 1"),
                                      "a.hairtxt"));
  EXPECT_EQ(curves->vertexCounts, (std::vector<uint32_t>{2, 2}));
  EXPECT_EQ(curves->positions[1], (Float3{20, 3, 1}));
  EXPECT_EQ(curves->radii, (std::vector<float>{0.5f, 0, 1, 1}));
  EXPECT_EQ(curves->strandUv, (std::vector<Float2>{{0, 0}, {0.5f, 1}}));
}

TEST(HairText, ErrorsNameTheLine) {
  const auto load = [](std::string_view text) { return loadHairText(bytesOf(text), "a.hairtxt"); };
  expectError(load(""), "hairtxt 1");
  expectError(load("hairtxt 2\n"), "version 2");
  expectError(load("hairtxt 1 x y w\n"), "a.hairtxt:1: no column is called 'w'");
  expectError(load("hairtxt 1 x y z x\n"), "twice");
  expectError(load("hairtxt 1 x y z r g\n"), "r, g and b");
  expectError(load("hairtxt 1 x y z u\n"), "u and v");
  expectError(load("hairtxt 1\n1 2\n"), "a.hairtxt:2: 'z' is missing");
  expectError(load("hairtxt 1\n1 2 3 4\n"), "a.hairtxt:2: ");
  expectError(load("hairtxt 1\n1 2 x\n"), "'x' is not a number");
  expectError(load("hairtxt 1\n1 2 3\nroot 0 0\n"), "a.hairtxt:3: 'root'");
  expectError(load("hairtxt 1\nroot 0 0\n"), "needs a curve");
  expectError(load("hairtxt 1\n"), "no curves");
}

}  // namespace
}  // namespace pelage
