#include "scenes/drawing_rows.h"

namespace bench {

namespace {

// Times the distance of the other rows: the character is some 90 pixels high.
constexpr float kFar = 12;
// The same where there are many characters: each is some 200 pixels high.
constexpr float kCrowd = 8;

const char* extraName(DrawingExtra extra) {
  switch (extra) {
    case DrawingExtra::kNone:
      return "alone";
    case DrawingExtra::kDepth:
      return "depth";
    case DrawingExtra::kMotion:
      return "motion";
    case DrawingExtra::kInterpolation:
      return "interpolation";
    case DrawingExtra::kStereo:
      return "stereo";
    case DrawingExtra::kEngineLights:
      return "engine_lights";
    case DrawingExtra::kPlayback:
      return "playback";
    case DrawingExtra::kLevelOfDetail:
      return "level_of_detail";
  }
  return "unknown";
}

}  // namespace

std::string DrawingRow::name() const {
  std::string scene = ratBoy ? "draw_rat_boy" : "draw";
  if (characters > 1)
    scene += "_" + std::to_string(characters);
  else if (distance > 1)
    scene += "_far";
  else if (tenfold)
    scene += "_10x";
  return scene + "/" + extraName(extra);
}

std::vector<DrawingRow> drawingRows(SceneSize size) {
  DrawingRow row = {.guides = 900, .width = 1920, .height = 1080, .shadowSize = 1024};
  if (size == SceneSize::kSmall)
    row = {.guides = 90, .width = 480, .height = 270, .shadowSize = 256};
  if (size == SceneSize::kQuick) row = {.guides = 9, .width = 96, .height = 54, .shadowSize = 64};
  std::vector<DrawingRow> rows;
  for (const DrawingExtra extra :
       {DrawingExtra::kNone, DrawingExtra::kDepth, DrawingExtra::kMotion,
        DrawingExtra::kInterpolation, DrawingExtra::kStereo, DrawingExtra::kEngineLights}) {
    row.extra = extra;
    rows.push_back(row);
  }
  DrawingRow far = row;
  far.distance = kFar;
  row.tenfold = true;
  row.guides *= 10;
  for (const DrawingExtra extra : {DrawingExtra::kNone, DrawingExtra::kPlayback}) {
    row.extra = extra;
    rows.push_back(row);
  }
  const auto addWithDetail = [&rows](DrawingRow some) {
    for (const DrawingExtra extra : {DrawingExtra::kNone, DrawingExtra::kLevelOfDetail}) {
      some.extra = extra;
      rows.push_back(some);
    }
  };
  addWithDetail(far);
  // A smoke test of many characters, or of files, finds nothing more.
  if (size == SceneSize::kQuick) return rows;
  DrawingRow crowd = far;
  crowd.distance = kCrowd;
  for (const uint32_t characters : {4u, 12u}) {
    crowd.characters = characters;
    addWithDetail(crowd);
  }
  for (const float distance : {1.0f, kFar}) {
    DrawingRow boy = far;
    boy.extra = DrawingExtra::kNone;
    boy.distance = distance;
    boy.ratBoy = true;
    rows.push_back(boy);
  }
  return rows;
}

}  // namespace bench
