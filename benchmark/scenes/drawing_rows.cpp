#include "scenes/drawing_rows.h"

namespace bench {

std::string DrawingRow::name() const {
  switch (extra) {
    case DrawingExtra::kNone:
      return "draw/alone";
    case DrawingExtra::kDepth:
      return "draw/depth";
    case DrawingExtra::kMotion:
      return "draw/motion";
    case DrawingExtra::kInterpolation:
      return "draw/interpolation";
    case DrawingExtra::kEngineLights:
      return "draw/engine_lights";
  }
  return "unknown";
}

std::vector<DrawingRow> drawingRows(SceneSize size) {
  DrawingRow row = {.guides = 900, .width = 1920, .height = 1080, .shadowSize = 1024};
  if (size == SceneSize::kSmall)
    row = {.guides = 90, .width = 480, .height = 270, .shadowSize = 256};
  if (size == SceneSize::kQuick) row = {.guides = 9, .width = 96, .height = 54, .shadowSize = 64};
  std::vector<DrawingRow> rows;
  for (const DrawingExtra extra : {DrawingExtra::kNone, DrawingExtra::kDepth, DrawingExtra::kMotion,
                                   DrawingExtra::kInterpolation, DrawingExtra::kEngineLights}) {
    row.extra = extra;
    rows.push_back(row);
  }
  return rows;
}

}  // namespace bench
