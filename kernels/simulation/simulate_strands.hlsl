// Advances the guide strands by one sub-step: the classic tier, in one pass over each strand.
//
// Threads: one a guide strand; dispatch g_guideCount x 1. The group writes the outputs together.
//          The result does not depend on its size.
// Reads:   g_rest, g_rootTransforms, g_state, g_contacts, g_contactWords
// Writes:  g_state, g_lengths, g_positions and g_tangents of the guides
//
// In this order (h the sub-step; H = max(h, 1/60 s), which 3. to 7. are for; maps of the constants
// in layouts/simulation.hlsli):
//   1. The root's pose at the sub-step's begin and end. Held vertices (0, 1, and those of inverse
//      mass 0) go to their bind position in the end pose. A new origin of the object moves the
//      state first.
//   2. With g_vspCoefficient or a finite g_vspThreshold: current and previous positions are carried
//      along by a share of the root's rigid motion.
//   3. Free motion: u = (x - x_-1) (H / h_-1) keep + gravityStep g.
//   4. With air drag c: u += k P (H w - u), P = I - t t^T, k = c H / (1 + c H): implicit Euler for
//      dv/dt = c P (w - v), the drag of a thin fibre on the flow across it. Stable for every c h,
//      along the wind for every sign of it, at the tip too, and the same for short and long
//      segments. t is from the positions before the step.
//   5. |u| <= H maxSpeed; z = x + u.
//   6. With g_globalStiffness: a share of the way to the goal, the bind position in the end pose.
//   7. g_localIterations times: from root to tip each segment goes towards its rest vector in the
//      frame that is carried along the strand without twist; each end moves half of the way.
//   8. Of the change of displacement that 3. to 7. make, the share for h:
//      x <- x + v h + forceShare (z - x - v H), v H = (x - x_-1) (H / h_-1). See takeForceShare().
//   9. Length: the tensions of all segments at once (tridiagonal, and implicit in the segments'
//      directions), Newton steps on the lengths where they are asked for, then follow the leader
//      from the root: exact lengths. Between two held vertices there is no leader: see fitSpan().
//  10. CONTACTS: each vertex that follows its leader is put in front of the planes that find_contacts
//      has found, with friction, and back to its length, before the next one follows it. Not between
//      held vertices.
//  11. State, positions and tangents are written.
// Wind comes before the shapes, so that the drag acts on velocities and not on their corrections.
// Gravity acts at every share of 2.: that is part in the root's motion, not stiffness.
//
// Invariant (tests/kernel): free strands have their rest lengths to rounding after every step, in
// contact too; the rest pose without gravity is a fixed point to rounding; a strand that rests under
// gravity and wind rests at every step of at most 1/60 s, in the same shape; nothing finite gives a
// NaN; a vertex whose state is not a number, or above 1e18, takes its goal.
#define GROUP_LANES 64

// Guard of the loops against constants that are out of their range.
static const uint kMaxIterations = 64;
static const uint kContactRounds = 2;

#include "classic/free_motion.hlsli"
#include "classic/length_solve.hlsli"
#include "classic/local_shape.hlsli"
#include "classic/strand_finish.hlsli"

void advance(inout Strand s) {
  uint guide = s.guide;
  float3 bindRoot = restPosition(0, guide);
  RootPose begin = rootPoseAt(guide, bindRoot, g_rootBegin);
  RootPose end = rootPoseAt(guide, bindRoot, g_rootEnd);
  float4 rootFrame = firstFrame(guide, end);
  float3 rootDirection = firstDirection(guide, bindRoot, end, rootFrame);

  s.root = end.position;
  Motion motion = rootMotion(guide, begin, end);
  integrate(s, bindRoot, end, motion);
  s.root = position(s, 0);
  bool free = (g_flags & 1u) == 0u;
  if (free) {
    keepLocalShape(s, rootFrame, rootDirection);
    takeForceShare(s);
    solveLengths(s);
    if (s.held > 1) fitSpans(s, rootDirection);
  }
  followLeaders(s, motion, free, rootDirection);
}

[numthreads(GROUP_LANES, 1, 1)] void simulate_strands(uint3 thread
                                                      : SV_DispatchThreadID, uint lane
                                                      : SV_GroupIndex) {
  Strand s;
  s.guide = thread.x;
  s.lane = lane;
  s.held = 1;
  s.root = float3(0.0, 0.0, 0.0);
  if (g_vertexCount < kMinVertices || g_vertexCount > kMaxVertices) return;
  bool alive = s.guide < g_guideCount;
  if (alive) advance(s);
  writeOutputs(s, alive, thread.x - lane);
}
