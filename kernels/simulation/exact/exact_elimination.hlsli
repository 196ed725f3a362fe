// Tip to root: one vertex of the Riccati elimination. It computes the value function over the state
// (dx_i, dphi_i-1) of the rest of the strand,
//   V = 1/2 dx.M dx + dx.N dphi + 1/2 dphi.D dphi + px.dx + pf.dphi,
// from that of (dx_i+1, dphi_i), by minimizing over the rotation dphi_i of edge i, with dx_i+1 =
// dx_i + dphi_i x e_i (Bertsekas, Dynamic Programming and Optimal Control, volume I, section 3.1).
// tests/reference/rod/exact_rod.h has it in readable form.
#ifndef PELAGE_SIMULATION_EXACT_EXACT_ELIMINATION_HLSLI
#define PELAGE_SIMULATION_EXACT_EXACT_ELIMINATION_HLSLI

#include "exact_contact.hlsli"
#include "exact_gains.hlsli"

struct Value {
  Symmetric3 m;
  Symmetric3 d;
  float3 n0;  // rows of N
  float3 n1;
  float3 n2;
  float3 px;
  float3 pf;
#if CONTACTS
  float load;  // bound of the pulling force of the rest of the strand
#endif
};

Value emptyValue() {
  Value value;
  value.m = zeroSymmetric();
  value.d = zeroSymmetric();
  value.n0 = float3(0.0, 0.0, 0.0);
  value.n1 = float3(0.0, 0.0, 0.0);
  value.n2 = float3(0.0, 0.0, 0.0);
  value.px = float3(0.0, 0.0, 0.0);
  value.pf = float3(0.0, 0.0, 0.0);
#if CONTACTS
  value.load = 0.0;
#endif
  return value;
}

// A free vertex in this step.
struct RodVertex {
  float3 displacement;  // since the start of the step, in the iterate [m]
  float3 x;             // position in the iterate [m]
  float3 target;        // the displacement that it would have alone
  float weight;         // am
};

// Where a free vertex goes in this step.
struct RodTarget {
  float3 displacement;  // that it would have alone, without the bind pose
  float weight;         // am
#if GLOBAL_SHAPE
  float3 bindTarget;  // where the bind pose has it [m]
  float share;        // of the bind pose
#endif
};

RodTarget noTarget() {
  RodTarget target;
  target.displacement = float3(0.0, 0.0, 0.0);
  target.weight = 0.0;
#if GLOBAL_SHAPE
  target.bindTarget = float3(0.0, 0.0, 0.0);
  target.share = 0.0;
#endif
  return target;
}

// \param x position in the iterate, \param displacement since the start of the step
RodVertex vertexAt(RodTarget target, float3 x, float3 displacement) {
  precise float3 alone = target.displacement;
#if GLOBAL_SHAPE
  if (target.share > 0.0) {
    precise float3 targetDisplacement = target.bindTarget - x + displacement;
    alone = alone + (targetDisplacement - alone) * target.share;
  }
#endif
  RodVertex vertex;
  vertex.displacement = displacement;
  vertex.x = x;
  vertex.target = alone;
  vertex.weight = target.weight;
  return vertex;
}

// An edge and the joint at its root's end.
struct RodEdge {
  float4 frame;         // before the step, transported
  float3 halfRotation;  // half of the rotation from there to the guess, in the frame's axes
  float4 guess;
  float4 iterate;
  float edgeLength;
};

// Gradient and Gauss-Newton matrix of the bending energy.
struct Bending {
  float3 gradient;
  Symmetric3 b;
};

// Energy 8 (kb |s|^2 + (kt - kb) (s.a)^2) of the joint's rotation r against its rest, with s the
// vector of r over 1 + |w|, which is tan(angle / 4) along the axis; a the twist axis, half-way
// between the two rest tangents. (Discrete elastic rods: Bergou et al., ACM Trans. Graph. 27(3),
// 2008, section 4.2, with 4 tan(angle / 4) for the angle.)
Bending bendingOf(RodEdge edge, RodEdge parent, float3 rest, float inverseVoronoiLength) {
  precise float kb = g_bendStiffness * inverseVoronoiLength;
  precise float dk = g_twistStiffness * inverseVoronoiLength - kb;
  float4 relative = multiplyQuaternions(conjugate(parent.iterate), edge.iterate);
  float4 r = withoutRest(relative, rest);
  precise float factor = (r.w < 0.0 ? -1.0 : 1.0) / (1.0 + abs(r.w));
  precise float3 s = r.xyz * factor;
  precise float s2 = dot3(s, s);
  precise float o = 1.0 + s2;
  precise float scale = 4.0 * kb * o;
  precise float diagonal = kb * o * o;
  // Half-way between e_x and rest e_x, for a rest rotation without a component along e_x.
  float3 axis = float3(rest.z, rest.y, -rest.x);
  precise float sa = dot3(s, axis);
  precise float twice = 2.0 * sa;
  precise float3 ra = axis * (1.0 - s2) + cross3(s, axis) * 2.0 + s * twice;
  precise float share = 4.0 * dk * sa;
  precise float3 moment = s * scale + ra * share;
  float3 w = rotate(parent.iterate, ra);
  precise float3 dw = w * dk;
  Bending bending;
  bending.b = addOuter(addDiagonal(zeroSymmetric(), diagonal), dw, w);
  precise float3 gradient = rotate(parent.iterate, moment);
  if (g_damping != 0.0) {
    // Kelvin-Voigt: the same energy about the joint before the step, times tau / h.
    float4 last = multiplyQuaternions(conjugate(parent.frame), edge.frame);
    float4 change = multiplyQuaternions(relative, conjugate(last));
    precise float rotationScale = (change.w < 0.0 ? -4.0 : 4.0) / (1.0 + abs(change.w));
    precise float3 rotation = change.xyz * rotationScale;
    precise float3 friction = rotation * kb;
    precise float along = dk * dot3(rotation, axis);
    friction = friction + axis * along;
    gradient = gradient + rotate(parent.iterate, friction) * g_damping;
    precise float stiffer = 1.0 + g_damping;
    bending.b = scaleSymmetric(bending.b, stiffer);
  }
  bending.gradient = gradient;
  return bending;
}

// An edge and the vertex at its root's end, as far as they do not depend on the vertices behind.
struct RodJoint {
  Bending bending;
  float twistStiffness;
  float3 tangent;  // of the iterate
  float edgeLength;
  float3 halfRotation;  // as in RodEdge
  float rotated;        // rotation about the tangent from the guess to the iterate
  float3 moved;         // change of the edge's vector in this step [m]
  RodTarget target;
};

#if CONTACTS
Value addPenalty(Value value, float3 normal, float across, float along) {
  precise float3 more = normal * (along - across);
  value.m = addOuter(addDiagonal(value.m, across), more, normal);
  return value;
}

// Adds the contacts of a vertex: the forces of the last step and the penalties.
Value addContacts(Value value, ExactStrand strand, StoredTouch touch, RodVertex vertex) {
  precise float weight = max(vertex.weight, leastWeight(strand));
  precise float across = weight * kFrictionPenalty;
  precise float along = weight * kContactPenalty;
  value = addPenalty(value, touch.plane0.xyz, across, along);
  // Without a second record its normal is 0.
  bool second = dot3(touch.plane1.xyz, touch.plane1.xyz) > 0.0;
  value = addPenalty(value, touch.plane1.xyz, second ? across : 0.0, second ? along : 0.0);
  precise float3 px = value.px - touch.a.xyz;
  precise float load = value.load + touch.a.w;
  value.px = px;
  value.load = load;
  return value;
}
#endif

// Adds am/2 |x - y|^2 of a vertex, y being where it would be alone.
Value addVertex(Value value, RodVertex vertex) {
  value.m = addDiagonal(value.m, vertex.weight);
  precise float3 force = (vertex.displacement - vertex.target) * vertex.weight;
  precise float3 px = value.px + force;
  value.px = px;
#if CONTACTS
  precise float load = value.load + lengthOf(force);
  value.load = load;
#endif
  return value;
}

struct Elimination {
  Value value;
  Gain gain;
  Response response;
};

// \param endWeight am of vertex i + 1, whose rotary inertia about the tangent is a share of am l^2
Elimination eliminateEdge(Value v, RodJoint joint, float endWeight) {
  float3 t = joint.tangent;
  precise float3 e = t * joint.edgeLength;
  Symmetric3 m = v.m;
  // S M with S = [e], by columns; S M S^T; S N.
  float3 c0 = cross3(e, float3(m.xx, m.xy, m.xz));
  float3 c1 = cross3(e, float3(m.xy, m.yy, m.yz));
  float3 c2 = cross3(e, float3(m.xz, m.yz, m.zz));
  float3 r0 = cross3(e, float3(c0.x, c1.x, c2.x));
  precise float s11 = e.z * c0.y - e.x * c2.y;
  precise float s12 = e.x * c1.y - e.y * c0.y;
  precise float s22 = e.x * c1.z - e.y * c0.z;
  float3 n0 = cross3(e, float3(v.n0.x, v.n1.x, v.n2.x));
  float3 n1 = cross3(e, float3(v.n0.y, v.n1.y, v.n2.y));
  float3 n2 = cross3(e, float3(v.n0.z, v.n1.z, v.n2.z));
  // The second derivative of x_i+1 in dphi_i under the tension e.px, made positive.
  precise float tension = abs(dot3(v.px, e));
#if CONTACTS
  // Far from the solution the gradient of a contact is far from its force.
  tension = min(tension, v.load * joint.edgeLength);
#endif
  precise float3 tt = t * tension;
  precise float axx = r0.x + n0.x + n0.x + v.d.xx + tension - tt.x * t.x;
  precise float axy = r0.y + n1.x + n0.y + v.d.xy - tt.x * t.y;
  precise float axz = r0.z + n2.x + n0.z + v.d.xz - tt.x * t.z;
  precise float ayy = s11 + n1.y + n1.y + v.d.yy + tension - tt.y * t.y;
  precise float ayz = s12 + n2.y + n1.z + v.d.yz - tt.y * t.z;
  precise float azz = s22 + n2.z + n2.z + v.d.zz + tension - tt.z * t.z;
  Symmetric3 a = makeSymmetric(axx, axy, axz, ayy, ayz, azz);
  // Along t all but D vanishes in exact arithmetic: its rounding is replaced.
  precise float own = max(dot3(t, multiplySymmetric(v.d, t)), 0.0);
  precise float missing = max(traceOf(a) * kTwistFloor - joint.twistStiffness - own, 0.0);
  precise float inertia = endWeight * joint.edgeLength * joint.edgeLength * g_twistInertia;
  precise float correction = own - dot3(t, multiplySymmetric(a, t)) + missing + inertia;
  precise float3 ct = t * correction;
  a = addOuter(a, ct, t);
  a = addDiagonal(a, kTiny);
  precise float resist = inertia * joint.rotated;
  precise float3 pf = v.pf + t * resist;

  Symmetric3 b = joint.bending.b;
  float3 g = joint.bending.gradient;
  Symmetric3 sum = addSymmetric(a, b);
  precise float least = traceOf(sum) * kPivotFloor + kTiny;
  Symmetric3 w = inverseOf(sum, least);
  precise float3 q0 = cross3(e, v.px) + pf;
  precise float3 q = q0 + g;
  precise float3 x0 = c0 + v.n0;
  precise float3 x1 = c1 + v.n1;
  precise float3 x2 = c2 + v.n2;
  Elimination result;
  Gain gain;
  gain.k = multiplySymmetric(w, q);
  gain.kx0 = multiplySymmetric(w, x0);
  gain.kx1 = multiplySymmetric(w, x1);
  gain.kx2 = multiplySymmetric(w, x2);
  gain.kw0 = multiplySymmetric(w, float3(b.xx, b.xy, b.xz));
  gain.kw1 = multiplySymmetric(w, float3(b.xy, b.yy, b.yz));
  gain.kw2 = multiplySymmetric(w, float3(b.xz, b.yz, b.zz));
  gain.edgeLength = joint.edgeLength;
  gain.halfRotation = joint.halfRotation;
  result.gain = gain;
  result.response.w = w;
  result.response.e = e;

  precise float mxx = m.xx - dot3(x0, gain.kx0);
  precise float mxy = m.xy - dot3(x0, gain.kx1);
  precise float mxz = m.xz - dot3(x0, gain.kx2);
  precise float myy = m.yy - dot3(x1, gain.kx1);
  precise float myz = m.yz - dot3(x1, gain.kx2);
  precise float mzz = m.zz - dot3(x2, gain.kx2);
  // B W A, which is B - B W B without the cancellation.
  float3 a0 = multiplySymmetric(a, gain.kw0);
  float3 a1 = multiplySymmetric(a, gain.kw1);
  float3 a2 = multiplySymmetric(a, gain.kw2);
  precise float dxy = (a0.y + a1.x) * 0.5;
  precise float dxz = (a0.z + a2.x) * 0.5;
  precise float dyz = (a1.z + a2.y) * 0.5;
  precise float3 lessPx = v.px - float3(dot3(x0, gain.k), dot3(x1, gain.k), dot3(x2, gain.k));
  float3 back = multiplySymmetric(a, multiplySymmetric(w, g));
  precise float3 nextPf = float3(dot3(gain.kw0, q0), dot3(gain.kw1, q0), dot3(gain.kw2, q0)) - back;
  Value next;
  next.m = makeSymmetric(mxx, mxy, mxz, myy, myz, mzz);
  next.d = makeSymmetric(a0.x, dxy, dxz, a1.y, dyz, a2.z);
  next.n0 = float3(dot3(x0, gain.kw0), dot3(x0, gain.kw1), dot3(x0, gain.kw2));
  next.n1 = float3(dot3(x1, gain.kw0), dot3(x1, gain.kw1), dot3(x1, gain.kw2));
  next.n2 = float3(dot3(x2, gain.kw0), dot3(x2, gain.kw1), dot3(x2, gain.kw2));
  next.px = lessPx;
  next.pf = nextPf;
#if CONTACTS
  next.load = v.load;
#endif
  result.value = next;
  return result;
}

#endif
