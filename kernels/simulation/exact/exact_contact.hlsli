// Contacts of a strand in the solve: each is a plane that a vertex stays in front of, with Coulomb
// friction in the plane.
//
// The normal force f_n and the friction f_t are the multipliers of an augmented Lagrangian (Nocedal
// and Wright, Numerical Optimization, section 17.4), with the penalty k = 30 weight L: 30 times the
// inertia of the whole strand, so that a pass leaves a thirtieth of a gap at most. At 10 strands
// over an edge take 15 s to come to rest, at 100 some gain energy. A pass adds
//   normal      f_n - k g at the gap g, where that is above 0
//   friction    sticks: f_t - k s at the slip s; slides: mu f_n against the slip
// to the gradient, and the corresponding derivative to the matrix; then the forces become those
// that the solve has used. A vertex changes between sticking and sliding if the solve leaves the
// cone, or if its slip reverses. The forces of the last step are the start of the next one, so hair
// at rest takes one pass, does not creep and does not tremble.
//
// The penetration that remains after the passes is removed from the positions only: the edge to the
// vertex is rotated, the next edges lead back to the solution, and the history of the displacements
// does not change.
//
// Rounding: between the elimination and the roll-out a record has its forces at the iterate, and
// the roll-out adds the penalty of the solve's displacement. If it were computed from the new
// position, it would have the rounding of positions, 1e-9 m and more, times k: at 4 sub-steps as
// much as the weight of a vertex.
#ifndef PELAGE_SIMULATION_EXACT_EXACT_CONTACT_HLSLI
#define PELAGE_SIMULATION_EXACT_EXACT_CONTACT_HLSLI

#include "../../contact/layouts/contact_records.hlsli"
#include "exact_state.hlsli"

#if CONTACTS
static const float kContactStiffness = 30.0;
// A vertex at rest on a surface is on either side of it by rounding [m].
static const float kContactDistance = 2e-5;
// Gap that needs a further pass [m].
static const float kContactTolerance = 1e-4;
// Rotation of an edge in a pass [rad] above which strands with contacts take another one; they also
// do if a force or a state has changed. Without further passes of moving strands, the forces of
// limp ones swing by a factor of four from step to step, and friction holds nothing.
static const float kContactRotation = 0.2;
// Slips below this have no reliable direction [m].
static const float kMinSlip = 1e-5;
// Distance from where a contact was found within which its plane is valid [m].
static const float kContactRange = 0.03;

struct RodContact {
  float3 normal;
  float gap;  // [m]
  float3 slip;
  float friction;
  float3 tangential;  // friction
  float normalForce;
  uint bits;
  float3 off;  // offset from where it was found
};

// A record as in memory. Loads take long, so they are issued before other work.
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
  uint element = kContactElements * record;
  uint4 found = g_contacts[element + 3u];
  stored.plane = asfloat(g_contacts[element]);
  stored.surface = asfloat(g_contacts[element + 1u]);
  stored.force = asfloat(g_contacts[element + 2u]);
  stored.foundAt = asfloat(found.xyz);
  stored.bits = found.w;
  return stored;
}

// Force and state of a record.
void storeContact(uint record, float3 tangential, float normalForce, uint bits) {
  uint element = kContactElements * record;
  g_contacts[element + 2u] = asuint(float4(tangential, normalForce));
  g_contacts[element + 3u].w = bits;
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

// Returns the word of the mask that has the vertex.
uint contactMask(uint index, uint vertex) {
  return g_contactWords[g_contactMasks + index * g_contactMaskWords + vertex / 32u];
}

bool hasContact(uint mask, uint vertex) { return ((mask >> (vertex & 31u)) & 1u) != 0u; }

bool touchesAnything(uint index, uint count) {
  uint any = 0u;
  for (uint word = 0; word * 32u < count; ++word) any = any | contactMask(index, word * 32u);
  return any != 0u;
}

// Returns the displacement in world space of a vertex at x that the iterate moves by `displacement`
// from its transported position.
float3 worldDisplacement(Transport transport, float3 x, float3 displacement) {
#if VELOCITY_SHOCK_PROPAGATION
  precise float3 transported = x - displacement;
  precise float3 before =
      rotate(conjugate(transport.now.rotation), transported - transport.now.shift);
  precise float3 moved = x - before;
  return moved;
#else
  return displacement;
#endif
}

// Returns the frame, rotated so that its tangent is `direction`.
float4 rotateFrame(float4 frame, float3 tangent, float3 direction) {
  precise float scalar = max(1.0 + dot3(tangent, direction), 1e-4);
  float4 relativeRotation = normalizeProduct(float4(cross3(tangent, direction), scalar));
  return normalizeProduct(multiplyQuaternions(relativeRotation, frame));
}

// ---- roll-out

// Rotates an edge that starts `offset` from the solution, so that its end is at the solution.
float4 leadBack(float4 frame, float edgeLength, inout float3 offset) {
  float3 tangent = axisX(frame);
  precise float3 arm = tangent * edgeLength - offset;
  precise float squared = dot3(arm, arm);
  if (!(squared > 1e-6 * edgeLength * edgeLength)) return frame;
  float4 rotated = rotateFrame(frame, tangent, directionOr(arm, tangent));
  precise float3 left = offset + (axisX(rotated) - tangent) * edgeLength;
  offset = left;
  return rotated;
}

// Rotates an edge from `start` so that its end is in front of the planes of its records.
//
// \param stored  the first record
// \param offset  distance of the end from the solution, in and out
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
    if (contact.gap < -kContactDistance && size > 1e-10) {
      precise float off = min(max(along * edgeLength - contact.gap, -edgeLength), edgeLength);
      precise float rest = squareRoot(max(edgeLength * edgeLength - off * off, 0.0));
      precise float3 arm = contact.normal * off + flat * (rest * inverseRoot(size));
      float4 rotated = rotateFrame(frame, tangent, directionOr(arm, tangent));
      precise float3 moved = offset + (axisX(rotated) - tangent) * edgeLength;
      offset = moved;
      frame = rotated;
    }
    if ((contact.bits & kContactMore) == 0u) break;
  }
  return frame;
}

// Returns the change of an edge by a rotation u: as rotatedBy(), without the rounding of a
// difference of tangents.
float3 rotatedEdge(float3 u, float3 edge) {
  precise float3 halfRotation = u * 0.5;
  float3 rotated = cross3(halfRotation, edge);
  precise float scale = 2.0 / (1.0 + dot3(halfRotation, halfRotation));
  precise float3 r = (rotated + cross3(halfRotation, rotated)) * scale;
  return r;
}

struct ContactResult {
  bool changed;  // another pass would differ
  bool far;      // far from where the contact was found
  float3 taken;  // displacement that the history leaves out
};

// Stores the forces that the solve has used as those of the contacts of vertex `vertex`, which is
// now at x.
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
          // It came to a stop and reversed.
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
    storeContact(record + c, tangential, normalForce, bits);
    if ((contact.bits & kContactMore) == 0u) break;
  }
  return result;
}
#endif

#endif
