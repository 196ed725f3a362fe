#include "screen.h"

#include <utility>

namespace viewer {

using pelage::Error;
using pelage::Result;

Result<void> Screen::open(const ScreenDef& def) {
  def_ = def;
  if (def_.api) return openApi(*def_.api);
  def_.api = pelage::Api::kVulkan;
  const Result<void> vulkan = openApi(*def_.api);
  if (vulkan) return {};
  def_.api = pelage::Api::kGl;
  if (const Result<void> gl = openApi(*def_.api); !gl)
    return Error{vulkan.error().code,
                 vulkan.error().message + "; nor can OpenGL be used: " + gl.error().message};
  interface->say("Drawing with OpenGL", "Vulkan cannot be used: " + vulkan.error().message);
  return {};
}

Result<void> Screen::openApi(pelage::Api api) {
  canvas.reset();
  interface.reset();
  window.reset();
  WindowDef windowDef;
  windowDef.width = def_.width;
  windowDef.height = def_.height;
  windowDef.api = api;
  windowDef.debug = def_.validation;
  windowDef.vsync = def_.vsync;
  auto madeWindow = Window::create(windowDef);
  if (!madeWindow) return madeWindow.error();
  window = *std::move(madeWindow);
  interface = std::make_unique<UserInterface>(window->size().interfaceScale);
  CanvasDef canvasDef;
  canvasDef.api = api;
  canvasDef.validation = def_.validation;
  canvasDef.deviceIndex = def_.device;
  canvasDef.cache = def_.cache;
  canvasDef.vsync = def_.vsync;
  auto madeCanvas = createCanvas(canvasDef, *window);
  if (!madeCanvas) return madeCanvas.error();
  canvas = *std::move(madeCanvas);
  return {};
}

}  // namespace viewer
