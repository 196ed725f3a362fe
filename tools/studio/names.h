// Names of pelage that most sources of this folder use.
#pragma once

#include "pelage/bone_weights.h"
#include "pelage/collision_mesh.h"
#include "pelage/demo/character.h"
#include "pelage/hair_asset.h"
#include "pelage/result.h"
#include "pelage/types.h"

namespace sample {

using pelage::AffineTransform;
using pelage::BoneInfluences;
using pelage::Character;
using pelage::CollisionMesh;
using pelage::Error;
using pelage::ErrorCode;
using pelage::Float3;
using pelage::Float4;
using pelage::HairAsset;
using pelage::Result;

}  // namespace sample
