#include "oit/classic_list.h"

#include <cstring>
#include <span>

#include "baseline/gpu_structs.h"
#include "baseline/kernels.h"
#include "oit/strand_draws.h"
#include "pelage/gpu_structs.h"

namespace bench {

using pelage::BufferId;
using pelage::PassBuilder;
using pelage::PassList;
using pelage::Result;

void ClassicList::makeRoom(BufferId& buffer, const char* name, uint64_t bytes, uint32_t stride) {
  const pelage::BufferDesc* desc = scene_.resources().find(buffer);
  if (desc != nullptr && desc->size == bytes) return;
  if (desc != nullptr) scene_.resources().remove(buffer);
  buffer = scene_.resources().add({.name = name, .size = bytes, .stride = stride});
}

void ClassicList::free() {
  for (const BufferId buffer : {heads_, nodes_, counter_})
    if (buffer != BufferId::kInvalid) scene_.resources().remove(buffer);
}

Result<void> ClassicList::draw(const pelage::View& view, uint32_t nodes,
                               std::vector<PassList>& lists) {
  const auto strands = strandLists(scene_, view);
  if (!strands) return strands.error();
  const PassList& from = (*strands)[0];
  const uint64_t headBytes = uint64_t{view.width} * view.height * sizeof(uint32_t);
  const uint64_t nodeBytes = uint64_t{nodes} * sizeof(pelage::Uint4);
  makeRoom(heads_, "classic/heads", headBytes, sizeof(uint32_t));
  makeRoom(nodes_, "classic/nodes", nodeBytes, sizeof(pelage::Uint4));
  makeRoom(counter_, "classic/counter", 16, sizeof(uint32_t));
  lists.assign(3, {});
  copyOtherPasses(from, lists[0]);

  baseline::ClassicListBuildConstants build = {};
  build.classicWidth = view.width;
  build.classicHeight = view.height;
  build.classicCapacity = nodes;
  const auto offer = [&](PassBuilder& builder) {
    builder.bind("g_classicHeads", heads_, headBytes)
        .bind("g_classicNodes", nodes_, nodeBytes)
        .bind("g_classicCounter", counter_, 16)
        .constants("ClassicListBuildConstants", build);
  };
  PassBuilder clear(lists[1]);
  clear.dispatch(baseline::clearClassicListVariant({}), view.width, view.height);
  offer(clear);
  if (Result<void> done = clear.finish(); !done) return done;
  if (Result<void> done =
          addStrandDraws(from, baseline::classicListBuildVariant({}), offer, lists[1]);
      !done)
    return done;

  const std::vector<std::byte> viewBlock = blockOfStrands(from, "StrandViewConstants");
  const std::vector<std::byte> renderBlock = blockOfStrands(from, "RenderConstants");
  if (renderBlock.size() != sizeof(pelage::RenderConstants))
    return pelage::Error{pelage::ErrorCode::kInvalidArgument, "no hair is in view"};
  pelage::RenderConstants render;
  std::memcpy(&render, renderBlock.data(), sizeof(render));
  baseline::ClassicListReadConstants read = {};
  read.classicBody = render.shadingBody;
  read.classicPrimary = render.shadingPrimary;
  read.classicSecondary = render.shadingSecondary;
  read.classicFiber = render.shadingFiber;
  read.classicModel = render.shadingModel;
  read.classicReadWidth = view.width;
  read.classicReadHeight = view.height;
  read.classicReadCapacity = nodes;
  const BufferId shadows = scene_.shadowWords();
  pelage::DrawState over;
  over.depthCompare = pelage::DepthCompare::kAlways;
  over.depthWrite = false;
  over.blend = pelage::BlendMode::kPremultipliedAlpha;
  PassBuilder resolve(lists[2]);
  return resolve
      .draw(baseline::classicListVertexVariant({}), baseline::classicListReadVariant({}), over, 3,
            1)
      .bind("g_classicReadHeads", heads_, headBytes)
      .bind("g_classicReadNodes", nodes_, nodeBytes)
      .bind("g_classicShadowWords", shadows, scene_.resources().find(shadows)->size)
      .constants("StrandViewConstants", std::span<const std::byte>(viewBlock))
      .constants("ClassicListReadConstants", read)
      .finish();
}

}  // namespace bench
