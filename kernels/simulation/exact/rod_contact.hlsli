// Contacts of a strand in the solve: each is a plane that a vertex stays in front of, with Coulomb's
// friction in it.
//
// The normal force f_n and the friction f_t are the multipliers of an augmented Lagrangian (Nocedal
// and Wright, Numerical Optimization, section 17.4), with the penalty k = 30 weight L: 30 times the
// inertia of the whole strand, so that a pass leaves a thirtieth of a gap at most. At 10 strands over
// an edge take 15 s to come to rest, at 100 some gain energy. A pass adds
//   normal      f_n - k g at the gap g, where that is above 0
//   friction    sticks: f_t - k s at the slip s; slides: mu f_n against the slip
// to the gradient, and to the matrix what that changes with the vertex; then the forces become what
// the solve has used. A vertex changes between sticking and sliding where the solve leaves the cone,
// or turns round. The forces of the last step are where the next one starts from, so that hair at
// rest takes one pass, does not creep and does not tremble.
//
// What the passes leave of a penetration is taken from the positions alone: the edge to the vertex is
// turned, the next edges go back to where the solve led, and the history of the displacements does
// not learn of it.
//
// Rounding: between the elimination and the roll-out a record has its forces at the iterate, and the
// roll-out adds the penalty of what the solve has moved the vertex by. Taken from the new position
// they would have its rounding, 1e-9 m and more, times k: at 4 sub-steps as much as the weight of a
// vertex.
#ifndef PELAGE_SIMULATION_EXACT_ROD_CONTACT_HLSLI
#define PELAGE_SIMULATION_EXACT_ROD_CONTACT_HLSLI

#include "../../layouts/contact_records.hlsli"
#include "rod_state.hlsli"

#if CONTACTS
static const float kContactStiffness = 30.0;
// A vertex that rests on a surface is on either side by rounding [m].
static const float kContactTouch = 2e-5;
// Gaps that a further pass is for [m].
static const float kContactTolerance = 1e-4;
// Rotation of an edge in a pass [rad] above which strands with contacts take another one; they do also
// where a force or a state has changed. Where moving strands do not, the forces of limp ones swing by a
// factor of four from step to step, and nothing that friction holds stays in its place.
static const float kContactTurn = 0.2;
// Slips below this have no direction to trust [m].
static const float kLeastSlip = 1e-5;
// How far from where a contact was found its plane is good for [m].
static const float kContactRange = 0.03;

struct RodContact {
  float3 normal;
  float gap;  // [m]
  float3 slip;
  float friction;
  float3 tangential;  // friction
  float normalForce;
  uint bits;
  float3 off;  // from where it was found
};

// A record as it is in memory. Loads take long: they are asked for before what there is to do besides.
struct StoredContact {
  float4 plane;
  float4 surface;
  float4 force;
  float3 foundAt;
  uint bits;
};

StoredContact noContact() {
  StoredContact stored;
  stored.plane = float4(0.0, 0.0, 0.0, 0.0);
  stored.surface = float4(0.0, 0.0, 0.0, 0.0);
  stored.force = float4(0.0, 0.0, 0.0, 0.0);
  stored.foundAt = float3(0.0, 0.0, 0.0);
  stored.bits = 0u;
  return stored;
}

StoredContact loadContact(uint record) {
  StoredContact stored;
  stored.plane = g_contacts[record].plane;
  stored.surface = g_contacts[record].surface;
  stored.force = g_contacts[record].force;
  stored.foundAt =
      float3(g_contacts[record].foundX, g_contacts[record].foundY, g_contacts[record].foundZ);
  stored.bits = g_contacts[record].bits;
  return stored;
}

// \param x     position of the vertex
// \param moved its displacement in the world
RodContact contactAt(StoredContact stored, float3 x, float3 moved) {
  RodContact contact;
  contact.normal = stored.plane.xyz;
  precise float3 off = x - stored.foundAt;
  precise float gap = stored.plane.w + dot3(stored.plane.xyz, off);
  precise float3 relative = moved - stored.surface.xyz;
  precise float outward = dot3(relative, stored.plane.xyz);
  precise float3 slip = relative - stored.plane.xyz * outward;
  contact.gap = gap;
  contact.slip = slip;
  contact.friction = stored.surface.w;
  contact.tangential = stored.force.xyz;
  contact.normalForce = stored.force.w;
  contact.bits = stored.bits;
  contact.off = off;
  return contact;
}

float contactStiffness(ExactStrand strand) {
  precise float k = g_weight * strand.strandLength * kContactStiffness;
  return k;
}

float lengthOf(float3 v) { return squareRoot(max(dot3(v, v), 1e-30)); }

uint recordOf(ExactStrand strand, uint vertex) { return (strand.target + vertex) * kMaxContacts; }

// The word of the mask that has the vertex.
uint contactMask(uint index, uint vertex) {
  return g_contactWords[g_contactMasks + index * g_contactMaskWords + vertex / 32u];
}

bool hasContact(uint mask, uint vertex) { return ((mask >> (vertex & 31u)) & 1u) != 0u; }

bool touchesAnything(uint index, uint count) {
  uint any = 0u;
  for (uint word = 0; word * 32u < count; ++word) any = any | contactMask(index, word * 32u);
  return any != 0u;
}

// The displacement in the world of a vertex at x that the iterate moves by `way` against where it
// was transported to.
float3 worldDisplacement(Carry carry, float3 x, float3 way) {
#if VELOCITY_SHOCK_PROPAGATION
  precise float3 transported = x - way;
  precise float3 before = rotate(conjugate(carry.now.rotation), transported - carry.now.shift);
  precise float3 moved = x - before;
  return moved;
#else
  return way;
#endif
}

// The frame, turned so that its tangent is `direction`.
float4 turnFrame(float4 frame, float3 tangent, float3 direction) {
  precise float scalar = max(1.0 + dot3(tangent, direction), 1e-4);
  float4 turn = normalizeProduct(float4(cross3(tangent, direction), scalar));
  return normalizeProduct(multiplyQuaternions(turn, frame));
}

// ---- what the roll-out does

// Turns an edge that starts `offset` from where the solve led, so that it ends where the solve leads.
float4 leadBack(float4 frame, float edgeLength, inout float3 offset) {
  float3 tangent = axisX(frame);
  precise float3 arm = tangent * edgeLength - offset;
  precise float squared = dot3(arm, arm);
  if (!(squared > 1e-6 * edgeLength * edgeLength)) return frame;
  float4 turned = turnFrame(frame, tangent, directionOr(arm, tangent));
  precise float3 left = offset + (axisX(turned) - tangent) * edgeLength;
  offset = left;
  return turned;
}

// Turns an edge from `start` so that its end is in front of the planes of its records.
//
// \param stored  the first record
// \param offset  how far the end is from where the solve leads, in and out
float4 keepOut(uint record, StoredContact stored, float3 start, float4 frame, float edgeLength,
               inout float3 offset) {
  [loop] for (uint k = 0; k < kMaxContacts; ++k) {
    if (k > 0u) stored = loadContact(record + k);
    float3 tangent = axisX(frame);
    precise float3 end = start + tangent * edgeLength;
    RodContact contact = contactAt(stored, end, float3(0.0, 0.0, 0.0));
    precise float along = dot3(tangent, contact.normal);
    precise float3 flat = tangent - contact.normal * along;
    precise float size = dot3(flat, flat);
    if (contact.gap < -kContactTouch && size > 1e-10) {
      precise float off = min(max(along * edgeLength - contact.gap, -edgeLength), edgeLength);
      precise float rest = squareRoot(max(edgeLength * edgeLength - off * off, 0.0));
      precise float3 arm = contact.normal * off + flat * (rest * inverseRoot(size));
      float4 turned = turnFrame(frame, tangent, directionOr(arm, tangent));
      precise float3 moved = offset + (axisX(turned) - tangent) * edgeLength;
      offset = moved;
      frame = turned;
    }
    if ((contact.bits & kContactMore) == 0u) break;
  }
  return frame;
}

// How a rotation by u changes an edge: as turnedBy() does, without the rounding of a difference of
// tangents.
float3 turnedEdge(float3 u, float3 edge) {
  precise float3 halfTurn = u * 0.5;
  float3 turned = cross3(halfTurn, edge);
  precise float scale = 2.0 / (1.0 + dot3(halfTurn, halfTurn));
  precise float3 r = (turned + cross3(halfTurn, turned)) * scale;
  return r;
}

struct ContactResult {
  bool changed;  // another pass would be other
  bool far;      // from where it was found
  float3 taken;  // what the history is not to know of
};

// Takes the forces that the solve has used as those of the contacts of vertex `vertex`, which is now
// at x.
//
// \param stored  the first record
// \param dx      from the iterate, as the solve has it
ContactResult updateContacts(ExactStrand strand, uint vertex, StoredContact stored, float3 x,
                             float3 moved, float3 dx) {
  ContactResult result;
  result.changed = false;
  result.far = false;
  result.taken = float3(0.0, 0.0, 0.0);
  uint record = recordOf(strand, vertex);
  float k = contactStiffness(strand);
  [loop] for (uint c = 0; c < kMaxContacts; ++c) {
    if (c > 0u) stored = loadContact(record + c);
    RodContact contact = contactAt(stored, x, moved);
    precise float flat2 = dot3(contact.off, contact.off);
    result.far = result.far || flat2 > kContactRange * kContactRange;
    precise float normalForce = 0.0;
    precise float3 tangential = float3(0.0, 0.0, 0.0);
    uint bits = contact.bits;
    if ((bits & kContactActive) == 0u) {
      bits = bits & ~(kContactSticks | kContactSlides);
      if (contact.gap < -kContactTolerance) result.changed = true;
    } else {
      precise float outwardStep = dot3(contact.normal, dx);
      precise float raw = contact.normalForce - k * outwardStep;
      normalForce = max(raw, 0.0);
      if (abs(contact.gap) > kContactTolerance) result.changed = true;
      precise float most = contact.friction * normalForce;
      if ((bits & kContactSticks) != 0u) {
        precise float3 along = dx - contact.normal * outwardStep;
        precise float3 pull = contact.tangential - along * k;
        float size = lengthOf(pull);
        tangential = pull;
        if (size > most) {
          precise float3 limited = pull * (most / size);
          tangential = limited;
          bits = (bits & ~kContactSticks) | kContactSlides;
          result.changed = true;
        }
      } else if ((bits & kContactSlides) != 0u) {
        float3 direction = directionOr(contact.tangential, float3(0.0, 0.0, 0.0));
        precise float along = dot3(contact.slip, direction);
        if (along > 0.0) {
          // It came to a stop and turned round.
          bits = (bits & ~kContactSlides) | kContactSticks;
          result.changed = true;
        } else {
          precise float3 against = contact.slip * -1.0;
          precise float3 pull = directionOr(against, direction) * most;
          tangential = pull;
        }
      }
      // The part of the displacement that led out of the collider.
      precise float outward = dot3(moved - stored.surface.xyz, contact.normal);
      precise float begun = contact.gap - outward;
      if (begun < 0.0 && outward > 0.0) {
        precise float3 taken = result.taken + contact.normal * min(outward, -begun);
        result.taken = taken;
      }
    }
    if (!isUsable(tangential) || !(normalForce < 1e18)) {
      normalForce = 0.0;
      tangential = float3(0.0, 0.0, 0.0);
    }
    g_contacts[record + c].force = float4(tangential, normalForce);
    g_contacts[record + c].bits = bits;
    if ((contact.bits & kContactMore) == 0u) break;
  }
  return result;
}
#endif

#endif
