// The implicit body of the character, and what depends on the place on it.
#pragma once

#include "growth.h"
#include "pelage/bone_weights.h"
#include "pelage/skeleton.h"
#include "surface_net.h"

namespace pelage::detail {

/// All of the body.
double characterSurface(const Vector& p);
Vector characterNormal(const Vector& p);
/// With the ears smoothed over: what falling hair glides on.
double combedCharacter(const Vector& p);
Vector combedCharacterNormal(const Vector& p);
/// Without the ears.
Vector characterSkullNormal(const Vector& p);

/// Head, neck and torso, with the ears smoothed over.
double trunkSurface(const Vector& p);
/// The left arm (x > 0), from inside the shoulder.
double leftArmSurface(const Vector& p);

/// Bones of a point on the skin.
BoneInfluences characterBones(const Vector& p);

/// How much fur grows at a point of the skin, 0..1.
double furShare(const Vector& p);
/// Whether a point of the scalp is in the strip of the mohawk.
bool isMohawkStrip(const Vector& p);

/// Where the arm lies, bind pose, left.
struct ArmJoints {
  Vector clavicle, shoulder, elbow, wrist, fingertips;
};
ArmJoints leftArmJoints();

}  // namespace pelage::detail
