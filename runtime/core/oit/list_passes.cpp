// The exact composite from per-pixel linked lists.
#include "oit/oit_views.h"
#include "pelage/kernels.h"
#include "shading/lit_kernels.h"

namespace pelage::detail {

namespace {

Result<void> addListResolve(const OitDraw& draw, const MaterialBatch& batch, const ListSizes& sizes,
                            uint64_t nodeBytes, PassList& list) {
  const View& view = draw.view.view;
  const TransparencySettings& settings = draw.settings;
  const OitBuffers::Lists& lists = draw.buffers.lists;
  PPLLReadConstants read = {};
  setMaterials(batch.materials, read.readModels, read.readBodies, read.readPrimaries,
               read.readSecondaries, read.readFibers);
  read.readWidth = view.width;
  read.readHeight = view.height;
  read.readNodeCapacity = draw.plan.sizes.nodeCount;
  read.readEpsilon = settings.epsilon;
  const EngineLights* lights = draw.view.engineLights;
  PassBuilder resolve(list);
  resolve
      .drawIndirect(litVariant(lights, oitTileVertexVariant({})),
                    litVariant(lights, ppllReadVariant({.tail = settings.spillTail})), overTarget(),
                    lists.counters)
      .vertices(tileList(lists.tiles, view.width, view.height));
  if (lights != nullptr) resolve.offer(lights->resources);
  return resolve.finish(
      OitTilesBindings{.oitTileConstants = tileConstants(view.width, view.height)},
      PPLLReadBindings{
          .strandViewConstants = draw.view.constants,
          .ppllReadConstants = read,
          .readHeads = {lists.heads, sizes.headBytes},
          .readNodes = {lists.nodes, nodeBytes},
          .readTail = {lists.tail, sizes.tailBytes},
          .readShadowWords = {draw.view.shadowWords, draw.view.shadowBytes},
      });
}

}  // namespace

Result<void> addListPasses(OitDraw& draw, const MaterialBatch& batch, PassList& buildList,
                           PassList& resolveList) {
  const View& view = draw.view.view;
  const TransparencySettings& settings = draw.settings;
  OitBuffers::Lists& lists = draw.buffers.lists;
  const bool tail = settings.spillTail;
  const ListSizes sizes = listSizes(view.width, view.height, tail);
  const uint64_t nodeBytes = draw.plan.sizes.nodeCount * detail::nodeBytes(settings);
  constexpr uint32_t kWord = sizeof(uint32_t);
  draw.ensureCapacity(lists.heads, "transparency/heads", sizes.headBytes, kWord);
  draw.ensureCapacity(lists.nodes, "transparency/nodes", nodeBytes, sizeof(Uint4));
  draw.ensureCapacity(lists.tiles, "transparency/tiles", sizes.tileBytes, kWord,
                      BufferUsage::kStorage | BufferUsage::kVertex);
  draw.ensureCapacity(lists.counters, "transparency/counters", kCounterBytes, kWord,
                      BufferUsage::kStorage | BufferUsage::kIndirect | BufferUsage::kReadback);
  if (tail)
    draw.ensureCapacity(lists.tail, "transparency/tail", sizes.tailBytes, sizeof(Uint4));
  else
    draw.factory.remove(lists.tail);

  PPLLBuildConstants build = {};
  build.listWidth = view.width;
  build.listHeight = view.height;
  build.nodeCapacity = draw.plan.sizes.nodeCount;
  build.listTileColumns = sizes.columns;
  const PPLLBuildBindings fill{
      .ppllBuildConstants = build,
      .listHeads = {lists.heads, sizes.headBytes},
      .listNodes = {lists.nodes, nodeBytes},
      .listCounters = {lists.counters, kCounterBytes},
      .listTiles = {lists.tiles, sizes.tileBytes},
      .listTail = {lists.tail, sizes.tailBytes},
  };
  PassBuilder clear(buildList);
  clear.dispatch(clearPpllVariant({.tail = tail}), view.width, view.height)
      .bytes(sizes.headBytes + sizes.tailBytes);
  if (Result<void> added = clear.finish(fill); !added) return added;

  for (size_t i = 0; i < batch.hairs.size(); ++i) {
    Result<void> added = addStrandDraw(
        draw.view, draw.view.hairs[batch.hairs[i]], batch.materialOf[i],
        litVariant(draw.view.engineLights, ppllBuildVariant({.tail = tail})), fill, buildList);
    if (!added) return added;
  }

  return addListResolve(draw, batch, sizes, nodeBytes, resolveList);
}

}  // namespace pelage::detail
