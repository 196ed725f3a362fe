// The parts of a scene.
#pragma once

#include "scene/frame_journal.h"
#include "scene/hair_simulation.h"
#include "scene/hair_store.h"
#include "scene/view_drawing.h"

namespace pelage::detail {

struct SceneParts {
  HairStore store;
  FrameJournal journal{store};
  HairSimulation simulation{store, journal};
  ViewDrawing drawing{store, journal, simulation};
};

}  // namespace pelage::detail
