// Grows pelage's own groom and moves it on pelage's own OpenGL runtime. Exits with 0 when a pass of
// this program, bound by the generated structs, reached the hair.
#include <pelage/bindings.h>
#include <pelage/demo/groom.h>
#include <pelage/headless.h>
#include <pelage/pelage.h>

#include <cstdio>
#include <cstring>

namespace {

int fail(const std::string& what) {
  std::fprintf(stderr, "consumer_runtime: %s\n", what.c_str());
  return 1;
}

}  // namespace

int main() {
  const auto device = pelage::createHeadlessGl({.api = pelage::Api::kGl});
  if (!device) {
    std::printf("consumer_runtime: skipped: %s\n", device.error().message.c_str());
    return 0;
  }
  auto groom = pelage::generateGroom({.strandCount = 200});
  if (!groom) return fail(groom.error().message);
  if (const auto processed = groom->hair.process(); !processed)
    return fail(processed.error().message);
  pelage::Scene scene;
  const auto hair = scene.addHair(groom->hair, {.name = "groom"});
  if (!hair) return fail(hair.error().message);
  const pelage::BufferId positions = scene.hair(*hair).buffers().positions;

  // The second frame takes no time, so that the shift is all that moves.
  float before = 0;
  for (int i = 0; i < 2; ++i) {
    auto frame = scene.simulate(0);
    if (!frame) return fail(frame.error().message);
    if (i == 1) {
      pelage::ShiftPositionsConstants constants = {};
      constants.shift = {2, 0, 0, 0};
      constants.shiftedCount = 1;
      pelage::ShiftPositionsBindings bindings{.shiftPositionsConstants = constants};
      bindings.shiftedPositions = {positions, sizeof(pelage::Float4)};
      const auto added = pelage::PassBuilder(frame->addList())
                             .dispatch(pelage::shiftPositionsVariant({}), 1)
                             .finish(bindings);
      if (!added) return fail(added.error().message);
    }
    if (const auto done = (*device)->run(*frame); !done) return fail(done.error().message);
    const auto bytes = (*device)->read(positions, 0, sizeof(float));
    if (!bytes) return fail(bytes.error().message);
    float x = 0;
    std::memcpy(&x, bytes->data(), sizeof(x));
    if (i == 1 && x != before + 2) return fail("the pass did not reach the hair");
    before = x;
  }
  std::printf("consumer_runtime: pelage %u on %s\n", pelage::libraryVersion(),
              (*device)->info().name.c_str());
  return 0;
}
