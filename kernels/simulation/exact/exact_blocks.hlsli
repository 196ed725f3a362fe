// The two halves of a sub-step for grooms that do not fill a device: several lanes a strand. The first
// one of them goes along the strand. In blocks of as many vertices, each of them computes before that
// what a vertex needs that does not depend on the others, and in the roll-out after it what no other
// vertex needs. Bits are those of one lane a strand.
#ifndef PELAGE_SIMULATION_EXACT_EXACT_BLOCKS_HLSLI
#define PELAGE_SIMULATION_EXACT_EXACT_BLOCKS_HLSLI

#include "exact_step.hlsli"

static const uint kLanes = 32;

// The lanes of a group.
struct BlockLane {
  uint lane;
  uint strands;  // of the group
  uint number;   // of its strand
  uint part;     // of its block
  uint parts;
  uint most;  // edges that a strand has at most
};

BlockLane blockLane(uint lane) {
  BlockLane own;
  own.lane = lane;
  own.strands = (g_flags & kAgainFlag) != 0u ? kAgainStrands : kNarrowStrands;
  own.number = lane % own.strands;
  own.part = lane / own.strands;
  own.parts = kLanes / own.strands;
  // Barriers need a bound that all lanes have in common.
  own.most = g_outputVertices > 0u ? g_outputVertices : kMaxCount;
  return own;
}

// ---- tip to root

static const uint kJointVectors = 10;
groupshared float4 s_joints[kJointVectors * kLanes];
groupshared float2 s_jointRests[kLanes];

void shareJoint(uint lane, RodJoint joint, JointContact contact) {
  Symmetric3 b = joint.bending.b;
  s_joints[lane] = float4(joint.bending.gradient, joint.twistStiffness);
  s_joints[lane + kLanes] = float4(b.xx, b.xy, b.xz, b.yy);
  s_joints[lane + 2u * kLanes] = float4(b.yz, b.zz, joint.edgeLength, joint.rotated);
  s_joints[lane + 3u * kLanes] = float4(joint.tangent, joint.target.weight);
  s_joints[lane + 4u * kLanes] = float4(joint.moved, joint.halfRotation.x);
  s_joints[lane + 5u * kLanes] = float4(joint.target.displacement, joint.halfRotation.y);
  s_jointRests[lane] = float2(joint.halfRotation.z, contact.inContact ? 1.0 : 0.0);
#if GLOBAL_SHAPE
  s_joints[lane + 6u * kLanes] = float4(joint.target.bindTarget, joint.target.share);
#endif
  if (!contact.inContact) return;
  s_joints[lane + 7u * kLanes] = contact.touch.plane0;
  s_joints[lane + 8u * kLanes] = contact.touch.plane1;
  s_joints[lane + 9u * kLanes] = contact.touch.a;
}

RodJoint sharedJoint(uint lane) {
  float4 a = s_joints[lane];
  float4 b = s_joints[lane + kLanes];
  float4 c = s_joints[lane + 2u * kLanes];
  float4 d = s_joints[lane + 3u * kLanes];
  float4 e = s_joints[lane + 4u * kLanes];
  float4 f = s_joints[lane + 5u * kLanes];
  RodJoint joint;
  joint.bending.gradient = a.xyz;
  joint.bending.b = makeSymmetric(b.x, b.y, b.z, b.w, c.x, c.y);
  joint.twistStiffness = a.w;
  joint.edgeLength = c.z;
  joint.rotated = c.w;
  joint.tangent = d.xyz;
  joint.target = noTarget();
  joint.target.weight = d.w;
  joint.moved = e.xyz;
  joint.target.displacement = f.xyz;
  joint.halfRotation = float3(e.w, f.w, s_jointRests[lane].x);
#if GLOBAL_SHAPE
  float4 g = s_joints[lane + 6u * kLanes];
  joint.target.bindTarget = g.xyz;
  joint.target.share = g.w;
#endif
  return joint;
}

JointContact sharedJointContact(uint lane) {
  JointContact contact;
  contact.inContact = s_jointRests[lane].y > 0.0;
  contact.touch.plane0 = s_joints[lane + 7u * kLanes];
  contact.touch.plane1 = s_joints[lane + 8u * kLanes];
  contact.touch.a = s_joints[lane + 9u * kLanes];
  contact.touch.b = float4(0.0, 0.0, 0.0, 0.0);
  return contact;
}

// \param set  of the vectors that come with the planes
JointContact loadContact(uint vertex, RodStep rod, uint set) {
  JointContact contact;
  contact.inContact = false;
  contact.touch = (StoredTouch)0;
  if (rod.overlaps && vertex > 1u)
    contact.inContact = hasContact(contactMask(rod.index, vertex), vertex);
  if (contact.inContact) contact.touch = loadTouch(vertex, rod.strand, set);
  return contact;
}

// Data of vertex i, edge i and the edge before it.
struct StoredJoint {
  StoredVertex vertex;
  StoredEdge edge;
  StoredEdge parent;
  float rotation;      // predicted one of the edge
  float parentLength;  // [m]
  JointContact contact;
};

StoredJoint loadJoint(uint i, RodStep rod, uint pass) {
  StoredJoint stored;
  stored.vertex = loadVertex(i, rod.strand, rod.slots);
  stored.edge = loadEdge(i, rod.strand, rod.slots, pass);
  stored.parent = loadEdge(i - 1u, rod.strand, rod.slots, pass);
  stored.rotation = g_state[stateIndex(kDisplacementSets + rod.slots.now, i + 1u, rod.strand)].w;
  stored.parentLength = g_rest[stateIndex(0, i - 1u, rod.strand)].z;
  stored.contact = loadContact(i, rod, kScratchForces);
  return stored;
}

RodJoint jointOfStored(RodStep rod, uint i, StoredJoint stored, uint pass) {
  RodEdge edge = freeEdge(stored.edge, stored.rotation, rod.transport, stored.vertex.rest.z, pass);
  RodEdge parent = rootEdge(stored.parent, rod.transport, rod.rootFrame);
  if (i > 1u)
    parent = freeEdge(stored.parent, stored.vertex.displacement.w, rod.transport,
                      stored.parentLength, pass);
  return jointOf(rod, stored.vertex, edge, parent, pass, stored.contact);
}

// \param has  the lane's strand is there
void eliminateInBlocks(BlockLane own, RodStep rod, bool has, uint pass, TipState tip) {
  uint last = max(rod.strand.count, 2u) - 2u;  // edge
  bool first = has && own.part == 0u;
  RodChain chain = (RodChain)0;
  StoredJoint stored = (StoredJoint)0;
  if (has) {
    stored = loadJoint(max(last, own.part + 1u) - own.part, rod, pass);
    StoredVertex end = loadVertex(last + 1u, rod.strand, rod.slots);
    chain = beginChain(rod, tip, end, loadContact(last + 1u, rod, kScratchForces), first);
  }
  [loop] for (uint begin = 0u; begin + 2u < own.most; begin += own.parts) {
    uint before = begin + own.part;
    if (has && before < last) {
      uint i = last - before;
      shareJoint(own.lane, jointOfStored(rod, i, stored, pass), stored.contact);
      // Loads of the next block, before the arithmetic of this one.
      stored = loadJoint(max(i, own.parts + 1u) - own.parts, rod, pass);
    }
    GroupMemoryBarrierWithGroupSync();
    if (first && begin < last) {
      uint most = min(own.parts, last - begin);
      [loop] for (uint k = 0u; k < most; ++k) {
        uint lane = own.number + own.strands * k;
        chain = eliminateJoint(chain, rod, last - begin - k, sharedJoint(lane),
                               sharedJointContact(lane));
      }
    }
    GroupMemoryBarrierWithGroupSync();
  }
}

// ---- root to tip

// [lane] to the first part, and from it.
groupshared float4 s_iterates[kLanes];
groupshared float4 s_oldTangents[kLanes];  // w: in contact
groupshared float4 s_planes[3 * kLanes];
groupshared float4 s_frames[kLanes];
groupshared float4 s_positions[kLanes];
groupshared float4 s_across[kLanes];
groupshared float4 s_displacements[kLanes];
groupshared float4 s_offsets[kLanes];
groupshared float4 s_ends[kLanes];

// Data of edge i, and the records of the vertex at its end.
struct StoredRoll {
  StoredEdge edge;
  float4 gain;  // the last part of its packing
  JointContact contact;
};

StoredRoll loadRoll(uint i, RodStep rod, uint pass) {
  StoredRoll stored;
  stored.edge = loadEdge(i, rod.strand, rod.slots, pass);
  stored.gain = g_state[gainIndex(i, rod.strand) + 5u * g_stateStride];
  stored.contact = loadContact(i + 1u, rod, kScratchFound);
  return stored;
}

void shareRoll(uint lane, RolledEdge edge, JointContact contact) {
  s_iterates[lane] = edge.iterate;
  s_oldTangents[lane] = float4(axisX(edge.old), contact.inContact ? 1.0 : 0.0);
  if (!contact.inContact) return;
  s_planes[lane] = float4(contact.touch.plane0.xyz, contact.touch.b.w);
  s_planes[lane + kLanes] = contact.touch.plane1;
  s_planes[lane + 2u * kLanes] = contact.touch.a;
}

JointContact sharedRollContact(uint lane) {
  JointContact contact;
  contact.inContact = s_oldTangents[lane].w > 0.0;
  contact.touch.plane0 = s_planes[lane];
  contact.touch.plane1 = s_planes[lane + kLanes];
  contact.touch.a = s_planes[lane + 2u * kLanes];
  contact.touch.b = float4(0.0, 0.0, 0.0, contact.touch.plane0.w);
  return contact;
}

// \param has  the lane's strand is there
RollOut rollOutInBlocks(BlockLane own, RodStep rod, bool has, uint pass) {
  uint last = max(rod.strand.count, 2u) - 2u;  // edge
  bool first = has && own.part == 0u;
  RollChain chain = (RollChain)0;
  StoredRoll stored = (StoredRoll)0;
  PackedGain packed = (PackedGain)0;
  if (has) {
    chain = beginRollOut(rod);
    stored = loadRoll(min(own.part + 1u, last), rod, pass);
    packed = loadGain(1u, rod.strand);
  }
  if (first) writeOutput(0, rod.strand, rod.root.position, rod.edge0, axisX(rod.rootFrame));
  precise float3 guessed = float3(0.0, 0.0, 0.0);
  bool far = false;
  [loop] for (uint begin = 1u; begin + 1u < own.most; begin += own.parts) {
    uint i = begin + own.part;
    bool exists = has && i <= last;
    RolledEdge edge = (RolledEdge)0;
    JointContact contact = stored.contact;
    if (exists) {
      edge = rolledEdge(stored.edge, unpackRotation(stored.gain.zw), stored.gain.y, rod.transport,
                        pass);
      shareRoll(own.lane, edge, contact);
      // Loads of the next block, before the arithmetic of this one.
      stored = loadRoll(min(i + own.parts, last), rod, pass);
    }
    GroupMemoryBarrierWithGroupSync();
    uint most = first && begin <= last ? min(own.parts, last + 1u - begin) : 0u;
    [loop] for (uint k = 0u; k < most; ++k) {
      uint lane = own.number + own.strands * k;
      PackedGain packedNext = loadGain(min(begin + k + 1u, last), rod.strand);
      RollChain next = rollEdge(chain, rod, unpackGain(packed), s_iterates[lane],
                                s_oldTangents[lane].xyz, sharedRollContact(lane));
      precise float3 across = chain.edge + next.edge;
      s_frames[lane] = next.frame;
      s_positions[lane] = float4(chain.x, 0.0);
      s_across[lane] = float4(across, 0.0);
      s_displacements[lane] = float4(next.displacement, 0.0);
      s_offsets[lane] = float4(next.offset, 0.0);
      chain = next;
      packed = packedNext;
    }
    GroupMemoryBarrierWithGroupSync();
    if (exists) {
      RollChain rolled = (RollChain)0;
      rolled.frame = s_frames[own.lane];
      rolled.displacement = s_displacements[own.lane].xyz;
      rolled.offset = s_offsets[own.lane].xyz;
      EdgeEnd end =
          endEdge(rod, i, edge, rolled, s_positions[own.lane].xyz, s_across[own.lane].xyz, contact);
      s_ends[own.lane] = float4(end.guessed, end.far ? 1.0 : 0.0);
    }
    GroupMemoryBarrierWithGroupSync();
    for (uint j = 0u; j < most; ++j) {
      float4 end = s_ends[own.number + own.strands * j];
      guessed = guessed + end.xyz;
      far = far || end.w > 0.0;
    }
  }
  RollOut result = (RollOut)0;
  if (first) {
    result = endRollOut(rod, chain, guessed);
    result.far = far;
  }
  return result;
}

#endif
