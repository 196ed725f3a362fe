// Advances the guide strands by one sub-step: the classic solver, in one pass over each strand.
//
// Threads: one per guide strand; dispatch g_guideCount x 1. The group writes the outputs together.
//          The result does not depend on its size.
// Reads:   g_rest, g_state (with the roots), g_contacts, g_contactWords
// Writes:  g_state, g_positions and g_tangents of the guides
//
// The steps, in this order (h is the sub-step, H = max(h, 1/60 s) the step of 3. to 7.;
// simulation/layouts/simulation.hlsli has the maps of the constants):
//   1. The root's pose at the start and the end of the sub-step. Held vertices (0, 1, and those of
//      inverse mass 0) go to their bind position in the end pose. A new origin of the object moves
//      the state first.
//   2. With g_vspCoefficient or a finite g_vspThreshold: current and previous positions are
//      transported by a fraction of the root's rigid motion.
//   3. Free motion: u = (x - x_-1) (H / h_-1) keep + gravityStep g.
//   4. With air drag c: u += k P (H w - u), P = I - t t^T, k = c H / (1 + c H): implicit Euler for
//      dv/dt = c P (w - v), the drag of a thin fiber on the flow across it. Stable for every c h,
//      along the wind for every sign of it, at the tip too, and the same for short and long
//      segments. t is from the positions before the step.
//   5. |u| <= H maxSpeed; z = x + u.
//   6. With g_globalStiffness: a fraction of the displacement to the bind-pose target, the bind
//      position in the end pose.
//   7. g_localIterations times: from root to tip, each segment moves towards its rest vector in the
//      frame that is transported along the strand without twist; each end moves half of the
//      distance.
//   8. The fraction for h of the change of displacement by 3. to 7.:
//      x <- x + v h + forceShare (z - x - v H), v H = (x - x_-1) (H / h_-1). See takeForceShare().
//   9. Length: the tensions of all segments at once (tridiagonal, and implicit in the segments'
//      directions), Newton steps on the lengths where they are asked for, then follow the leader
//      from the root: exact lengths. Between two held vertices there is no leader: see fitSpan().
//  10. CONTACTS: each vertex that follows its leader moves in front of the planes of find_contacts,
//      with friction, and back to its length, before the next one follows it. Not between held
//      vertices.
//  11. State, positions and tangents are written.
// Wind comes before the shapes, so that the drag acts on velocities and not on their corrections.
// The fraction in 2. transports the strand with the root; it is not a stiffness. Gravity, wind and
// forces come reduced from the host where g_vspCoefficient is above 0.75.
//
// Invariant (tests/simulation): free strands have their rest lengths to rounding after every step,
// in contact too; the rest pose without gravity is a fixed point to rounding; a strand at rest
// under gravity and wind is at rest for every step of at most 1/60 s, in the same shape; finite
// input gives no NaN; a vertex whose state is not a number, or above 1e18, goes to its bind-pose
// target.
#define GROUP_LANES 64

// Guard of the loops against constants that are out of their range.
static const uint kMaxIterations = 64;
static const uint kContactRounds = 2;

#define ROOTS_IN_STATE
#include "free_motion.hlsli"
#include "length_solve.hlsli"
#include "local_shape.hlsli"
#include "strand_finish.hlsli"

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
  bool free = (g_flags & kResetFlag) == 0u;
  if (free) {
    keepLocalShape(s, rootFrame, rootDirection);
    takeForceShare(s);
    solveLengths(s);
    if (s.held > 1) fitSpans(s, rootDirection);
  }
  followLeaders(s, motion, free, rootDirection);
}

[numthreads(GROUP_LANES, 1, 1)] void simulate_classic(uint3 thread
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
