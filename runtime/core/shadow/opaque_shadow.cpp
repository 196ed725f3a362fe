#include "shadow/opaque_shadow.h"

#include "passes/dispatch_rows.h"
#include "pelage/assert.h"
#include "pelage/bindings.h"
#include "pelage/constants.h"
#include "pelage/kernels.h"

namespace pelage::detail {

Result<void> addOpaqueShadow(PassList& list, const OpaqueShadowPlan& plan, BufferId words,
                             uint64_t wordCount) {
  PELAGE_ASSERT(wordCount >= uint64_t{plan.firstWord} + plan.words,
                "the buffer of the maps ends before the map does");
  const uint64_t bytes = uint64_t{plan.words} * sizeof(uint32_t);
  OpaqueShadowConstants constants = {};
  constants.opaqueTexelCount = plan.words;
  constants.opaqueFirstWord = plan.firstWord;
  PassBuilder builder(list);
  dispatchRows(builder, copyOpaqueShadowVariant({}), plan.words).bytes(2 * bytes);
  return builder.finish(OpaqueShadowBindings{
      .opaqueShadowConstants = constants,
      .opaqueDepth = {plan.depth, bytes},
      .opaqueWords = {words, wordCount * sizeof(uint32_t)},
  });
}

}  // namespace pelage::detail
