#include "choices.h"

namespace viewer {

const std::vector<Choice<sample::GroomPreset>>& grooms() {
  using sample::GroomPreset;
  static const std::vector<Choice<GroomPreset>> kChoices = {{"parted", GroomPreset::kParted},
                                                            {"straight", GroomPreset::kStraight},
                                                            {"curly", GroomPreset::kCurly},
                                                            {"fur", GroomPreset::kFur},
                                                            {"mohawk", GroomPreset::kMohawk}};
  return kChoices;
}

const std::vector<Choice<pelage::CharacterMotion>>& motions() {
  using pelage::CharacterMotion;
  static const std::vector<Choice<CharacterMotion>> kChoices = {
      {"all", CharacterMotion::kAll},         {"walk", CharacterMotion::kWalk},
      {"shake", CharacterMotion::kHeadShake}, {"jump", CharacterMotion::kJump},
      {"idle", CharacterMotion::kIdle},       {"bind", CharacterMotion::kBind}};
  return kChoices;
}

const std::vector<Choice<pelage::Solver>>& solvers() {
  static const std::vector<Choice<pelage::Solver>> kChoices = {
      {"exact", pelage::Solver::kExact}, {"classic", pelage::Solver::kClassic}};
  return kChoices;
}

const std::vector<Choice<pelage::Transparency>>& transparencies() {
  using pelage::Transparency;
  static const std::vector<Choice<Transparency>> kChoices = {
      {"windowed", Transparency::kWindowed},     {"tiles", Transparency::kTiles},
      {"hybrid4", Transparency::kHybrid4},       {"hybrid8", Transparency::kHybrid8},
      {"hybrid16", Transparency::kHybrid16},     {"shortcut", Transparency::kShortCut},
      {"stochastic", Transparency::kStochastic}, {"alpha-test", Transparency::kAlphaTest}};
  return kChoices;
}

const std::vector<Choice<sample::HeadCollider>>& headColliders() {
  using sample::HeadCollider;
  static const std::vector<Choice<HeadCollider>> kChoices = {{"capsules", HeadCollider::kCapsules},
                                                             {"mesh", HeadCollider::kMesh}};
  return kChoices;
}

const std::vector<Choice<pelage::HairShadow>>& shadows() {
  using pelage::HairShadow;
  static const std::vector<Choice<HairShadow>> kChoices = {
      {"deep", HairShadow::kDeep}, {"depth", HairShadow::kDepth}, {"none", HairShadow::kNone}};
  return kChoices;
}

}  // namespace viewer
