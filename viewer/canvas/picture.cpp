#include "canvas/picture.h"

#include "image.h"
#include "viewer_kernels/gpu_structs.h"
#include "viewer_kernels/kernels.h"

namespace viewer {

using viewer_kernels::PictureConstants;

pelage::Result<pelage::PassList> pictureList(pelage::TextureId scene, uint32_t width,
                                             uint32_t height, bool flipsRows) {
  const sample::Backdrop backdrop;
  PictureConstants constants = {};
  constants.backdropTop = {backdrop.top.x, backdrop.top.y, backdrop.top.z, backdrop.glow};
  constants.backdropBottom = {backdrop.bottom.x, backdrop.bottom.y, backdrop.bottom.z, 0};
  constants.pictureWidth = width;
  constants.pictureHeight = height;
  constants.flipsRows = flipsRows ? 1 : 0;
  pelage::DrawState state;
  state.depthCompare = pelage::DepthCompare::kAlways;
  state.depthWrite = false;
  pelage::PassList list;
  pelage::Result<void> done = pelage::PassBuilder(list)
                                  .draw(viewer_kernels::pictureVertexVariant({}),
                                        viewer_kernels::picturePixelVariant({}), state, 3, 1)
                                  .constants("PictureConstants", constants)
                                  .bind("g_sceneColor", scene)
                                  .finish();
  if (!done) return done.error();
  return list;
}

}  // namespace viewer
