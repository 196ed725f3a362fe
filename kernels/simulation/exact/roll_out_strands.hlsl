// Last part of a sub-step of the exact solver with contacts: the forces that solve_contacts has found
// go into the control laws, and the roll-out from root to tip (step 5 of simulate_exact) keeps
// vertices out of the planes of their contacts.
//
// Threads: as eliminate_strands.
// Reads:   g_rest, g_state (now, gains), g_contacts, g_contactWords, g_sleep
// Writes:  g_state (next; k of the gains; the displacement of the tip), g_positions, g_tangents,
//          g_sleep, g_contactWords (the list and its arguments, totals)
//
// The first round lists the strands that need a second one: an edge rotated by more than
// g_passTolerance; with contacts that press, where that is no more than kContactRotation and in the
// step of a reset, by more than kContactRotation, or by more than kForceRotation and the forces
// changed much; or a vertex ended far from where its contact was found, and contacts are found again.
//
// Invariant (tests/simulation): as simulate_exact. No strand is listed twice in a sub-step.
#define CONTACTS 1
#define VELOCITY_SHOCK_PROPAGATION 1
#if BLOCKS
#include "exact_blocks.hlsli"
#else
#include "exact_step.hlsli"
#endif
#include "exact_compliance.hlsli"

// Strands that a group of find_contacts takes.
static const uint kFindStrands = 4;

// Lists a strand for the second round.
void solveAgain(uint index, bool far) {
  uint entry;
  InterlockedAdd(g_contactWords[g_contactHead + kContactListed], 1u, entry);
  g_contactWords[g_contactList + entry] = far ? index | kListedFar : index;
  if (far) listGroup(kContactFindArguments, entry / kFindStrands);
  listGroup(kContactStrandArguments, entry / kAgainStrands);
  listGroup(kContactSolveArguments, entry);
  InterlockedAdd(g_contactWords[kContactAgain], 1u);
  if ((g_flags & kSleepFlag) != 0u) InterlockedAdd(g_sleep[kSleepSecondPasses], 1u);
}

bool isEnough(RodStep rod, RollOut rolled) {
  if (rolled.far) return false;
  float4 sums = float4(0.0, 0.0, 0.0, 0.0);  // of the sizes of the forces, and of their changes
  if (rod.overlaps) sums = loadScratch(kScratchFound, 0u, rod.strand);
  if (!(sums.x > 0.0)) {
    precise float most = g_passTolerance * g_passTolerance;
    return rolled.largest <= most;
  }
  if (g_passTolerance > kContactRotation && (g_flags & kResetFlag) == 0u) return true;
  precise float load = lengthOf(rod.drift) * g_weight * rod.strand.strandLength;
  precise float most = max(sums.x, load) * kForceChange;
  if (rolled.largest > kContactRotation * kContactRotation) return false;
  return sums.y <= most || rolled.largest <= kForceRotation * kForceRotation;
}

// Takes the forces that solve_contacts has found into the control laws.
void takeForces(RodStep rod) {
  if (rod.overlaps) addForces(rod.strand, lastContact(rod.index, rod.strand.count));
}

void endRound(RodStep rod, RollOut rolled) {
  bool again = (g_flags & kAgainFlag) != 0u;
  if (rod.strand.count > 2u) {
    g_state[gainIndex(0, rod.strand)] = float4(rolled.tip.displacement, 0.0);
    if (!again) {
      if (!isEnough(rod, rolled)) solveAgain(rod.index, rolled.far);
    }
  }
  endStep(rod, rolled, again ? 0.0 : g_frameTime);
}

[numthreads(32, 1, 1)]
void roll_out_strands(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
  uint pass = (g_flags & kAgainFlag) != 0u ? 1u : 0u;
#if BLOCKS
  BlockLane own = blockLane(lane);
  uint index = strandOfLane(group, own.number);
  bool has = isSimulated(index);
  RodStep rod = (RodStep)0;
  if (has) rod = beginStep(index);
  bool first = has && own.part == 0u;
  bool rolls = has && rod.strand.count > 2u;
  if (first && rolls) takeForces(rod);
  RollOut rolled = rollOutInBlocks(own, rod, rolls, pass);
  if (!first) return;
  if (!rolls) rolled = rootAlone(rod);
  endRound(rod, rolled);
#else
  uint index = strandOfLane(group, lane);
  if (!isSimulated(index)) return;
  RodStep rod = beginStep(index);
  RollOut rolled;
  if (rod.strand.count > 2u) {
    takeForces(rod);
    rolled = rollOut(rod, pass);
  } else {
    rolled = rootAlone(rod);
  }
  endRound(rod, rolled);
#endif
}
