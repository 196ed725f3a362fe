// The smallest program in C: hair on a head for one second, where the tip of one strand went, and a
// picture of it. Usage: pelage-hello-c [PICTURE.pfm]
#include <pelage/pelage_c.h>
#include <stdio.h>
#include <stdlib.h>

static float pixels[256][256][4];

static void check(pelage_result result) {
  if (result == PELAGE_OK) return;
  fprintf(stderr, "pelage-hello-c: error: %s\n", pelage_last_error());
  exit(1);
}

int main(int argc, char** argv) {
  if (argc > 1 && argv[1][0] == '-') return puts("usage: pelage-hello-c [PICTURE.pfm]") < 0;

  // 1. A scene with guide hairs, and a device. An engine has one already: see docs/c.md.
  pelage_asset* asset;
  pelage_scene* scene;
  pelage_headless* device;
  pelage_id hair;
  check(pelage_asset_generate(7, 500, &asset));
  check(pelage_scene_create(&scene));
  check(pelage_scene_add_hair(scene, asset, NULL, &hair));
  check(pelage_headless_create(NULL, &device));

  // 2. Frames: the scene writes one, the device runs it. The last one has a view.
  const float eye[3] = {0, 0.3f, 0.9f}, head[3] = {0, 0.2f, 0}, up[3] = {0, 1, 0};
  pelage_headless_target target;
  pelage_view view;
  check(pelage_headless_target_init(&target, sizeof target));
  check(pelage_view_init(&view, sizeof view));
  view.width = view.height = target.width = target.height = 256;
  target.pixels = pixels[0][0];
  check(pelage_view_look_at(&view, eye, head, up, 0.6f, 0.1f, 10));
  for (int i = 0; i < 60; ++i) {
    pelage_frame* frame;
    check(pelage_scene_simulate(scene, 1.0f / 60, &frame));
    if (i == 59) check(pelage_frame_draw(frame, &view, NULL, NULL));
    check(pelage_headless_run(device, frame, &target, i == 59));
    check(pelage_destroy(frame));
  }

  // 3. Positions lie in a buffer, [strand][vertex]; a renderer reads it where it is.
  pelage_hair_info info;
  check(pelage_hair_info_init(&info, sizeof info));
  check(pelage_scene_get_hair_info(scene, hair, &info));
  float tip[4];
  check(pelage_read(device, info.positions, (info.vertices_per_strand - 1) * 16, tip, 16));
  printf("tip of strand 0: (%.4f, %.4f, %.4f) m\n", tip[0], tip[1], tip[2]);
  FILE* file = argc > 1 ? fopen(argv[1], "wb") : NULL;
  if (file == NULL) return argc > 1;
  fprintf(file, "PF\n256 256\n-1\n");  // 32-bit floats, the bottom row first
  for (int y = 255; y >= 0; --y)
    for (int x = 0; x < 256; ++x) fwrite(pixels[y][x], sizeof(float), 3, file);
  return fclose(file);
}
