// The rows of the generated groom.
#include <string>
#include <utility>

#include "groups.h"

namespace sample {

using pelage::GroomDef;
using pelage::HairStyle;

namespace {

template <class T>
auto groom(T GroomDef::*field) {
  return [field](Setup& setup, const T& value) { setup.groom.*field = value; };
}

template <class T>
Picture head(T GroomDef::*field, std::vector<T> values, std::string caption) {
  return show(headSetup(), std::move(values), groom(field), std::move(caption));
}

// Few locks without follow hairs.
Setup guides() {
  Setup setup = headSetup();
  setup.follow.countPerGuide = 0;
  setup.hair.material.fiberRadius = 250e-6f;
  return setup;
}

// Few locks that are gathered.
Setup pointed() {
  Setup setup = headSetup();
  setup.groom.clumpCount = 80;
  setup.groom.clumpStrength = 0.7f;
  return setup;
}

std::vector<Parameter> sizeRows() {
  return {
      {PELAGE_FIELD(GroomDef, seed), "", "", "Another seed gives different hair of the same kind.",
       head(&GroomDef::seed, std::vector<uint64_t>{1, 2, 3}, "Three seeds.")},
      {PELAGE_FIELD(GroomDef, strandCount), "guides", "1..1,000,000",
       "Number of roots on the scalp.",
       show(guides(), std::vector{200u, 2000u, 12000u}, groom(&GroomDef::strandCount),
            "Without follow hairs.")},
      {PELAGE_FIELD(GroomDef, verticesPerStrand), "", "2..256", "Vertices of each guide.",
       show(with(guides(),
                 [](Setup& s) {
                   s.groom.strandCount = 400;
                   s.groom.curlRadius = 0.008f;
                   s.center = {0.085f, 0.18f, 0};
                   s.extent = 0.13f;
                 }),
            std::vector{5u, 24u, 64u}, groom(&GroomDef::verticesPerStrand),
            "400 curly guides: corners disappear, and curls appear.")},
      {PELAGE_FIELD(GroomDef, style), "", "kSideParting, kSweptBack",
       "To both sides of a parting, then down; or from the forehead to the back.",
       head(&GroomDef::style, std::vector{HairStyle::kSideParting, HairStyle::kSweptBack},
            "The two styles.")},
      {PELAGE_FIELD(GroomDef, length), "m", "0.002..2", "Length of the hair.",
       head(&GroomDef::length, std::vector{0.03f, 0.18f, 0.3f}, "Short to long.")},
      {PELAGE_FIELD(GroomDef, lengthVariation), "share", "0..0.95",
       "Strands are shorter by up to this fraction.",
       head(&GroomDef::lengthVariation, std::vector{0.0f, 0.15f, 0.8f}, "See the lower edge.")},
  };
}

std::vector<Parameter> shapeRows() {
  return {
      {PELAGE_FIELD(GroomDef, lift), "rad", "0..1.5",
       "Angle between scalp and hair at the roots on top of the head; less below.",
       show(with(headSetup(), [](Setup& s) { s.groom.length = 0.05f; }),
            std::vector{0.1f, 0.65f, 1.5f}, groom(&GroomDef::lift), "Hair of 5 cm.")},
      {PELAGE_FIELD(GroomDef, volume), "m", "0..0.1", "Thickness of the layer of hair.",
       head(&GroomDef::volume, std::vector{0.0f, 0.008f, 0.03f}, "Flat to full.")},
      {PELAGE_FIELD(GroomDef, comb), "1/m", "0..1000",
       "How sharply hair bends to the combed direction.",
       head(&GroomDef::comb, std::vector{0.0f, 25.0f, 200.0f},
            "As it grows, and combed to the sides.")},
      {PELAGE_FIELD(GroomDef, droop), "1/m", "0..1000", "How sharply hair bends downwards.",
       head(&GroomDef::droop, std::vector{0.0f, 22.0f, 100.0f}, "Out, and down.")},
      {PELAGE_FIELD(GroomDef, curlRadius), "m", "0..0.1", "Radius of the curls.",
       show(with(headSetup(), [](Setup& s) { s.groom.verticesPerStrand = 48; }),
            std::vector{0.0f, 0.003f, 0.015f}, groom(&GroomDef::curlRadius), "Straight to curly.")},
      {PELAGE_FIELD(GroomDef, curlFrequency), "turns per meter", "0..500",
       "Frequency of the curls.",
       show(with(headSetup(),
                 [](Setup& s) {
                   s.groom.verticesPerStrand = 96;
                   s.groom.curlRadius = 0.008f;
                   s.follow.maxRadius = 0.002f;
                 }),
            std::vector{5.0f, 14.0f, 50.0f}, groom(&GroomDef::curlFrequency),
            "Curls with a radius of 8 mm.")},
      {PELAGE_FIELD(GroomDef, clumpCount), "", "0..4096", "Number of locks; 0 for none.",
       show(with(headSetup(), [](Setup& s) { s.groom.clumpStrength = 0.9f; }),
            std::vector{0u, 40u, 240u}, groom(&GroomDef::clumpCount), "With a strength of 0.9.")},
      {PELAGE_FIELD(GroomDef, clumpStrength), "", "0..1",
       "0 for none; at 1 all tips of a lock meet.",
       show(with(headSetup(), [](Setup& s) { s.groom.clumpCount = 80; }),
            std::vector{0.0f, 0.4f, 1.0f}, groom(&GroomDef::clumpStrength), "80 locks.")},
      {PELAGE_FIELD(GroomDef, clumpLengthVariation), "share", "0..0.95",
       "Locks are shorter by up to this fraction.",
       show(pointed(), std::vector{0.0f, 0.3f, 0.9f}, groom(&GroomDef::clumpLengthVariation),
            "80 locks; see the lower edge.")},
      {PELAGE_FIELD(GroomDef, clumpTaper), "share", "0..0.95",
       "Strands are shorter by up to this fraction at a lock's edge.",
       show(pointed(), std::vector{0.0f, 0.4f, 0.9f}, groom(&GroomDef::clumpTaper),
            "80 locks: level to pointed.")},
      {PELAGE_FIELD(GroomDef, noise), "m", "0..0.1", "Random displacement of tips.",
       head(&GroomDef::noise, std::vector{0.0f, 0.004f, 0.03f}, "Neat to wild.")},
  };
}

std::vector<Parameter> regionRows() {
  return {
      {PELAGE_FIELD(GroomDef, hairline), "m", "-0.03..0.05",
       "Moves the edge of the hair up: a larger value gives less hair.",
       show(with(headSetup(),
                 [](Setup& s) {
                   s.groom.length = 0.012f;
                   s.groom.strandCount = 4000;
                 }),
            std::vector{-0.02f, 0.0f, 0.04f}, groom(&GroomDef::hairline), "Hair of 12 mm.")},
      {PELAGE_FIELD(GroomDef, hairlineFade), "m", "0..0.05",
       "Width of shorter and thinner hair around the face.",
       show(with(headSetup(),
                 [](Setup& s) {
                   s.groom.style = HairStyle::kSweptBack;
                   s.center = {0, 0.28f, 0.07f};
                   s.extent = 0.16f;
                 }),
            std::vector{0.0f, 0.01f, 0.04f}, groom(&GroomDef::hairlineFade),
            "Hair that is swept back.")},
      {PELAGE_FIELD(GroomDef, stripWidth), "m", "0..0.3",
       "Width of a strip along the middle with hair; 0 for all.",
       show(with(headSetup(),
                 [](Setup& s) {
                   s.groom.length = 0.05f;
                   s.groom.lift = 1.5f;
                   s.groom.comb = 3;
                   s.groom.droop = 1;
                   s.toEye = {0.5f, 0.35f, 1};
                 }),
            std::vector{0.0f, 0.03f, 0.09f}, groom(&GroomDef::stripWidth),
            "Hair of 5 cm that stands up.")},
      {PELAGE_FIELD(GroomDef, thicknessVariation), "share", "0..1",
       "Strands are thinner by up to this fraction.",
       show(with(guides(),
                 [](Setup& s) {
                   s.groom.strandCount = 900;
                   s.hair.material.fiberRadius = 500e-6f;
                   s.hair.material.tipRadiusRatio = 1;
                   s.center = {-0.02f, 0.28f, 0.07f};
                   s.extent = 0.10f;
                 }),
            std::vector{0.0f, 0.2f, 1.0f}, groom(&GroomDef::thicknessVariation),
            "Thick fibers at the parting.")},
      {PELAGE_FIELD(GroomDef, headCellSize), "m", "0.002..0.007", "Cell size of the head mesh.",
       show(with(guides(),
                 [](Setup& s) {
                   s.groom.strandCount = 300;
                   s.center = {0, 0.17f, 0.08f};
                   s.extent = 0.12f;
                 }),
            std::vector{0.007f, 0.005f, 0.002f}, groom(&GroomDef::headCellSize),
            "The face: its corners get finer.")},
  };
}

}  // namespace

std::vector<ParameterGroup> groomGroups() {
  return {{"GroomDef", "pelage/demo/groom.h",
           "generateGroom(): the head in many of these pictures. [gallery.md](gallery.md)",
           joined(sizeRows(), shapeRows(), regionRows())}};
}

}  // namespace sample
