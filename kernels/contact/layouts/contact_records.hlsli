// Capsules, and contacts of hair with colliders as find_contacts writes them and solvers read them.
//
// Each object has two buffers. g_contacts has kMaxContacts records per vertex, in the order of
// g_positions, behind them what find_contacts alone reads and writes, and behind that the scratch of
// the exact solver; a record is kContactElements of its elements. g_contactWords has, in words:
//   totals  of the frame: kContactCount, kContactAgain
//   heads   kContactHeadWords for each sub-step of the frame, see below
//   list    [strand] strands that are solved again, and kListedFar for those whose contacts are found
//           again
//   masks   [strand][mask word] bit i % 32 of word i / 32: vertex i has a record
//   lists   kContactListCount for solve_contacts, by the number of vertices in contact; [strand]: its
//           index, and its last vertex in contact | 65,536 times their number
//   strands [strand] ContactStrand, from a multiple of kContactAlignment on
// Strands are counted in the order in which the solver takes them.
#ifndef PELAGE_CONTACT_LAYOUTS_CONTACT_RECORDS_HLSLI
#define PELAGE_CONTACT_LAYOUTS_CONTACT_RECORDS_HLSLI

// A sphere or a tapered capsule in motion: the union of the spheres between two ends, all [m] and
// relative to the origin of the hair's state. One that is not finite has no contacts.
struct Collider {
  float4 head;        // xyz at the frame's end, w radius
  float4 tail;        // xyz at the frame's end, w radius; equal to the head for a sphere
  float4 headBefore;  // xyz at the frame's start, w Coulomb friction
  float4 tailBefore;  // xyz at the frame's start; w unused
  float4 spin;  // xyz rotation vector of the frame about the axis, or a sphere's center [rad]; w
                // unused
};

// A plane that a vertex stays in front of, and the force of the contact, in the space of the
// solver's origin. Forces are for unit linear density. The elements of a record have, with floats
// as their bits: 0 plane, 1 surface, 2 force, 3 foundAt and bits.
struct ContactRecord {
  float4 plane;    // xyz unit normal out of the collider; w signed distance of `foundAt` from the
                   // plane [m]
  float4 surface;  // xyz displacement of the collider's surface in the sub-step [m]; w Coulomb's
                   // friction coefficient
  float4 force;    // xyz friction; w normal force, >= 0 [m2/s2]
  float foundX;    // xyz foundAt: the predicted position [m]
  float foundY;
  float foundZ;
  uint bits;  // kContactCollider and the flags below
};

// A strand whose vertices may collide.
struct ContactStrand {
  uint target;  // element of vertex 0 in the positions
  uint count;   // vertices; 0: none of them collides
  uint root;    // index of its root transform
  uint state;   // as in ExactStrand; without a scratch 0
};

static const uint kMaxContacts = 2;
static const uint kContactElements = 4;
static const uint kContactAlignment = 64;
// The collider: the index of a capsule, or kContactSdf | the index of an SDF.
static const uint kContactCollider = 0xffffu;
static const uint kContactSdf = 0x8000u;
// The contact pressed on the collider when it was found.
static const uint kContactPressed = 0x40000u;
// One more record follows.
static const uint kContactMore = 0x80000u;

// Sets of the exact solver's scratch, in each of which a vertex is an element as in ExactStrand's
// sets; floats as their bits. find_contacts writes kScratchPlanes and kScratchForces for vertices
// with a record, solve_contacts for a second round; eliminate_strands the rest.
//   0..2    of the edge from the vertex on: W (xx xy xz yy yz zz), x and y of the change of the
//           forces at its end; its vector and z of the change
//   planes  of each record: its normal (0: there is none), and the displacement of the surface along
//           it if the contact presses, otherwise kNoLimit; solve_contacts writes the latter anew
//   forces  sum of the records' forces, and of their sizes
// Vertices in contact, for solve_contacts:
//   states  position and weight; displacement; where the vertex alone would be. Of vertices 0 and 1 the
//           rotation and the shift of the transport. Behind that, where strands have more vertices
//           than its matrix, sets of its own
// and for roll_out_strands, in place of states:
//   found   where they were found, and the distance of each record's plane; of vertex 0 the sums of
//           the sizes of the forces and of their changes
static const uint kScratchPlanes = 3;
static const uint kScratchForces = 5;
static const uint kScratchStates = 6;
static const uint kScratchFound = 6;
static const uint kScratchSets = 9;
static const uint kScratchSweepSets = 12;
static const uint kMatrixContacts = 24;
static const float kNoLimit = 1e30;

// Totals, at the beginning.
static const uint kContactCount = 0;  // records written
static const uint kContactAgain = 1;  // strands solved again
static const uint kContactTotalWords = 4;
// Words of a head: groups of indirect dispatches over the lists, 3 words each, with at most
// kListedGroups in x and rows of them in z.
static const uint kContactHeadWords = 20;
static const uint kContactFindArguments = 0;    // of find_contacts: 4 strands a group
static const uint kContactStrandArguments = 3;  // of kernels with a thread a strand, 4 a group
static const uint kContactSolveArguments = 6;   // of solve_contacts: a strand a group
static const uint kContactListed = 9;           // strands in the list
static const uint kContactGroups = 10;          // of solve_contacts over the lists by number
static const uint kContactGroupArguments = 12;
static const uint kContactLists = 16;  // strands in each of them
// Lists of strands with at most kFewLanes vertices in contact, twice as many, and more.
static const uint kContactListCount = 3;
static const uint kContactListWords = 2;
static const uint kFewLanes = 8;
static const uint kListedGroups = 65535;
static const uint kListedFar = 0x80000000u;

#endif
