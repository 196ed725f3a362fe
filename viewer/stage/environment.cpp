#include "stage/environment.h"

#include <cstring>
#include <vector>

namespace viewer {

using pelage::EnvironmentLight;

namespace {

constexpr NamedEnvironment kEnvironments[] = {
    {"none", {}},
    {"overcast", {.l00 = {0.80f, 0.85f, 0.95f}, .l1m1 = {0.30f, 0.32f, 0.36f}}},
    {"sunset",
     {.l00 = {0.90f, 0.55f, 0.42f},
      .l1m1 = {0.05f, 0.10f, 0.22f},
      .l11 = {-0.48f, -0.25f, -0.08f}}},
    {"night", {.l00 = {0.07f, 0.09f, 0.16f}, .l1m1 = {0.03f, 0.04f, 0.07f}}},
};

}  // namespace

std::span<const NamedEnvironment> environments() { return kEnvironments; }

const char* environmentName(const Stage& stage) {
  const EnvironmentLight now = stage.lights()[0].environment;
  for (const NamedEnvironment& one : kEnvironments)
    if (std::memcmp(&one.light, &now, sizeof now) == 0) return one.name;
  return kOwnEnvironment;
}

void setEnvironment(const EnvironmentLight& environment, Stage& stage) {
  std::vector<pelage::Light> lights = stage.lights();
  lights[0].environment = environment;
  stage.setLights(lights);
}

}  // namespace viewer
