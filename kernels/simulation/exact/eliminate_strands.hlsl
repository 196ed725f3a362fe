// First part of a sub-step of the exact solver with contacts: the state, and the elimination from
// tip to root (steps 1 to 4 of simulate_exact). The contacts that find_contacts has found have a
// constant penalty in it (exact_contact.hlsli).
//
// Threads: one per strand, in groups of 32 of which the first 8 (kNarrowFlag) or all have one; in a
//          second round the first 4, each with a strand of the list.
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
#include "exact_step.hlsli"

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

[numthreads(32, 1, 1)]
void eliminate_strands(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint index = strandOfLane(group, lane);
  bool again = (g_flags & kAgainFlag) != 0u;
  if (!isSimulated(index)) return;
  if (!again) {
    if (!prepareState(index)) return;
  }
  RodStep rod = beginStep(index);
  if (rod.strand.count <= 2u) return;
  TipState tip;
  if (again) {
    tip.displacement = g_state[gainIndex(0, rod.strand)].xyz;
    tip.x = g_state[strandIndex(kTipPosition, rod.slots.next, index)].xyz;
  } else {
    tip = guessedTip(rod);
  }
  eliminate(rod, again ? 1u : 0u, tip);
  if (!rod.overlaps) return;
  storeScratch(kScratchStates, 0u, rod.strand, rod.transport.now.rotation);
  storeScratch(kScratchStates, 1u, rod.strand, float4(rod.transport.now.shift, 0.0));
  if (!again) listForSolve(index, rod.strand.count);
}
