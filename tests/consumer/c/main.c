// A scene in C on an installed pelage. It exits with 0 when the strand fell and was drawn, or when
// there is no Vulkan device.
#include <pelage/pelage_c.h>
#include <stdio.h>

#define VERTICES 16

static float pixels[32 * 32 * 4];

static int fail(void) {
  fprintf(stderr, "c_scene: %s\n", pelage_last_error());
  return 1;
}

int main(void) {
  // A horizontal strand, 30 cm long.
  float positions[VERTICES][4] = {{0}};
  for (int i = 0; i < VERTICES; ++i) {
    positions[i][0] = 0.02f * (float)i;
    positions[i][3] = i < 2 ? 0 : 1;
  }
  pelage_asset_def def;
  pelage_asset* asset;
  pelage_scene* scene;
  pelage_settings* settings;
  pelage_id hair;
  const double radius = 0.01;
  if (pelage_asset_def_init(&def, sizeof def)) return fail();
  def.strand_count = 1;
  def.vertices_per_strand = VERTICES;
  def.positions = positions[0];
  if (pelage_asset_create(&def, &asset) || pelage_scene_create(&scene) ||
      pelage_scene_add_hair(scene, asset, NULL, &hair) || pelage_settings_create(&settings) ||
      pelage_settings_set(settings, "material.fiberRadius", &radius, 1) ||
      pelage_scene_set_settings(scene, hair, settings))
    return fail();

  pelage_headless* device;
  if (pelage_headless_create(NULL, &device))
    return printf("c_scene: skipped: %s\n", pelage_last_error()), 0;
  const float eye[3] = {0.1f, 0, 1}, at[3] = {0.1f, 0, 0}, up[3] = {0, 1, 0};
  pelage_headless_target target;
  pelage_view view;
  if (pelage_headless_target_init(&target, sizeof target) || pelage_view_init(&view, sizeof view))
    return fail();
  view.width = view.height = target.width = target.height = 32;
  target.pixels = pixels;
  if (pelage_view_look_at(&view, eye, at, up, 0.8f, 0.1f, 10)) return fail();
  for (int i = 0; i < 30; ++i) {
    pelage_frame* frame;
    if (pelage_scene_simulate(scene, 1.0f / 60, &frame) ||
        (i == 29 && pelage_frame_draw(frame, &view, settings, NULL)) ||
        pelage_headless_run(device, frame, &target, i == 29) || pelage_destroy(frame))
      return fail();
  }

  pelage_hair_info info;
  float tip[4];
  if (pelage_hair_info_init(&info, sizeof info) || pelage_scene_get_hair_info(scene, hair, &info) ||
      pelage_read(device, info.positions, (VERTICES - 1) * sizeof tip, tip, sizeof tip))
    return fail();
  int covered = 0;
  for (int i = 0; i < 32 * 32; ++i) covered += pixels[4 * i + 3] > 0;
  printf("c_scene: the tip is at (%.4f, %.4f, %.4f) m, hair in %d pixels\n", tip[0], tip[1], tip[2],
         covered);
  if (pelage_destroy(device) || pelage_destroy(scene) || pelage_destroy(asset) ||
      pelage_destroy(settings))
    return fail();
  return tip[1] < -0.01f && covered > 10 ? 0 : 1;
}
