// Capsules, and contacts of hair with colliders as find_contacts writes them and solvers read them.
//
// Each object has two buffers. g_contacts has kMaxContacts records per vertex, in the order of
// g_positions, and behind them what find_contacts alone reads and writes; a record is
// kContactElements of its elements. g_contactWords has, in words:
//   totals  of the frame: kContactCount, kContactPasses, kContactTiles
//   heads   kContactHeadWords for each sub-step of the frame, see below
//   list    [tile] tiles of 32 strands with strands whose contacts must be found again
//   marks   [tile] bit i for strand i of a tile in the list
//   masks   [strand][mask word] bit i % 32 of word i / 32: vertex i has a record
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
  uint pad0;
};

static const uint kMaxContacts = 2;
static const uint kContactElements = 4;
static const uint kContactAlignment = 64;
// The collider: the index of a capsule, or kContactSdf | the index of an SDF.
static const uint kContactCollider = 0xffffu;
static const uint kContactSdf = 0x8000u;
// Friction holds the vertex, or the vertex slides; neither: not known yet.
static const uint kContactSticks = 0x10000u;
static const uint kContactSlides = 0x20000u;
// The normal force was active in the last solve.
static const uint kContactActive = 0x40000u;
// One more record follows.
static const uint kContactMore = 0x80000u;

// Totals, at the beginning.
static const uint kContactCount = 0;  // records written
// Solver passes beyond the first one of strands with a record.
static const uint kContactPasses = 1;
static const uint kContactTiles = 2;  // tiles found and solved again
static const uint kContactTotalWords = 4;
// Words of a head.
static const uint kContactHeadWords = 8;
static const uint kContactFindArguments = 0;   // 3 words: groups of find_contacts over the list
static const uint kContactSolveArguments = 3;  // 3 words: groups of the solver over the list

#endif
