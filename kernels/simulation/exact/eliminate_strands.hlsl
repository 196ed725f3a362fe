// First part of a sub-step of the exact solver with contacts: the state, and the elimination from
// tip to root (steps 1 to 4 of simulate_exact). The contacts that find_contacts has found have a
// constant penalty in it (exact_contact.hlsli).
//
// Threads: one per strand, in groups of 32. BLOCKS: four per strand (kNarrowFlag); in a second round
//          eight, for each strand of the list.
// Reads:   g_rest, g_state, g_contacts, g_contactWords, g_forces, g_sleep
// Writes:  g_state (gains; at a reset the states that it reads), g_contacts (scratch), g_contactWords
//          (lists for solve_contacts, in no order); with the pose flag g_positions alone
//
// In a second round, which roll_out_strands lists strands for, the strand is linearized about the
// result of the first one.
//
// Invariant (tests/simulation): as simulate_exact.
#define CONTACTS 1
#define VELOCITY_SHOCK_PROPAGATION 1
#if BLOCKS
#include "exact_blocks.hlsli"
#else
#include "exact_step.hlsli"
#endif

// Lists a strand with records for solve_contacts.
void listForSolve(uint index, uint vertices) {
  uint contacts = contactCount(index, vertices);
  uint list = contacts <= kFewLanes ? 0u : (contacts <= 2u * kFewLanes ? 1u : 2u);
  uint entry;
  InterlockedAdd(g_contactWords[g_contactHead + kContactLists + list], 1u, entry);
  uint word = listedWord(list, entry);
  g_contactWords[word] = index;
  g_contactWords[word + 1u] = contacts << 16 | lastContact(index, vertices);
  if (entry % strandsOfGroup(list) != 0u) return;
  uint group;
  InterlockedAdd(g_contactWords[g_contactHead + kContactGroups], 1u, group);
  listGroup(kContactGroupArguments, group);
}

TipState firstTip(RodStep rod) {
  TipState tip;
  if ((g_flags & kAgainFlag) != 0u) {
    tip.displacement = g_state[gainIndex(0, rod.strand)].xyz;
    tip.x = g_state[strandIndex(kTipPosition, rod.slots.next, rod.index)].xyz;
  } else {
    tip = guessedTip(rod);
  }
  return tip;
}

// Stores the transport for solve_contacts, and lists the strand.
void endElimination(RodStep rod) {
  if (!rod.overlaps) return;
  storeScratch(kScratchStates, 0u, rod.strand, rod.transport.now.rotation);
  storeScratch(kScratchStates, 1u, rod.strand, float4(rod.transport.now.shift, 0.0));
  if ((g_flags & kAgainFlag) == 0u) listForSolve(rod.index, rod.strand.count);
}

[numthreads(32, 1, 1)]
void eliminate_strands(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint pass = (g_flags & kAgainFlag) != 0u ? 1u : 0u;
#if BLOCKS
  BlockLane own = blockLane(lane);
  uint index = strandOfLane(group, own.number);
  bool has = isSimulated(index);
  // Other lanes do without what it writes.
  if (has && own.part == 0u && pass == 0u) prepareState(index);
  if ((g_flags & kPoseFlag) != 0u) return;
  RodStep rod = (RodStep)0;
  TipState tip = (TipState)0;
  if (has) rod = beginStep(index);
  has = has && rod.strand.count > 2u;
  if (has) tip = firstTip(rod);
  eliminateInBlocks(own, rod, has, pass, tip);
  if (has && own.part == 0u) endElimination(rod);
#else
  uint index = strandOfLane(group, lane);
  if (!isSimulated(index)) return;
  if (pass == 0u) {
    if (!prepareState(index)) return;
  }
  RodStep rod = beginStep(index);
  if (rod.strand.count <= 2u) return;
  eliminate(rod, pass, firstTip(rod));
  endElimination(rod);
#endif
}
