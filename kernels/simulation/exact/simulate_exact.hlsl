// Advances the guide strands by one sub-step: the exact solver, an inextensible Kirchhoff rod that
// is implicit in time, solved directly along each strand. For objects without colliders;
// eliminate_strands, solve_contacts and roll_out_strands are the same step with contacts.
//
// Threads: one per strand in the order of the state; dispatch min(count, 2^20) x
//          ceil(count / 2^20). No barriers and no shared memory; a strand of any count from 2 to
//          256 is a loop.
// Reads:   g_rest, g_state (now, before, earlier), g_forces, g_sleep
// Writes:  g_state (next; at a reset the states that it reads; gains), g_positions, g_tangents,
//          g_sleep
//
// The steps, in this order (simulation/layouts/exact.hlsli has the numbers of a step):
//   1. Vertices 0, 1 and edge 0 take the pose of the root at the end of the sub-step. A new origin
//      of the object moves the state first.
//   2. VELOCITY_SHOCK_PROPAGATION: displacements and frames are transported by a fraction of the
//      root's rigid motion.
//   3. Every vertex gets a target, to which the last three displacements and the drift lead: BDF2
//      or backward Euler of a free vertex with air drag; GLOBAL_SHAPE: pulled to its bind-pose
//      target. Every edge gets a guess: it keeps rotating as the last step has stored in the w of
//      the displacement of the vertex at its end.
//   4. Tip to root, the elimination (exact_elimination.hlsli).
//   5. Root to tip, the roll-out: rotations of the edges, positions by summing the edges; the
//      displacements of this step; positions and tangents for drawing.
//   6. 4 and 5 once more, about the result, if an edge rotated by more than g_passTolerance.
//      Without it, whipping strands gain energy.
// With g_damping: Kelvin-Voigt damping of the bending and the twist.
// FORCES: accelerations and drags of a buffer, in step 3.
// With the sleep flag the threads are those of the tiles that select_awake_tiles has found awake.
//
// Invariant (tests/simulation): edges have their rest lengths to rounding; the rest pose without
// gravity is a fixed point to rounding; finite input gives no NaN; a NaN in the state (not in
// lengths, Voronoi lengths and the rest shape) is gone after a few steps; a strand whose record
// does not fit its buffers is skipped; the result of a strand depends on no other strand, and
// agrees with tests/reference/rod bit by bit where the device's square root and division are exact.
#include "exact_step.hlsli"

[numthreads(32, 1, 1)]
void simulate_exact(uint3 thread : SV_DispatchThreadID) {
  uint index = indexOfThread(thread);
  bool sleeping = (g_flags & kSleepFlag) != 0u;
  if (sleeping) index = awakeStrand(index);
  if (!isSimulated(index)) return;
  if (!prepareState(index)) return;
  RodStep rod = beginStep(index);
  RollOut rolled;
  if (rod.strand.count > 2) {
    TipState tip = guessedTip(rod);
    precise float tolerance2 = g_passTolerance * g_passTolerance;
    [loop] for (uint pass = 0u; pass < kPassLimit; ++pass) {
      eliminate(rod, pass, tip);
      rolled = rollOut(rod, pass);
      tip = rolled.tip;
      if (rolled.largest <= tolerance2) break;
      if (sleeping && pass + 1u < kPassLimit) InterlockedAdd(g_sleep[kSleepSecondPasses], 1u);
    }
  } else {
    rolled = rootAlone(rod);
  }
  endStep(rod, rolled, g_frameTime);
}
