// Light that passes from fiber to fiber in a volume of hair; no resources.
//
// After dual scattering (Zinke, Yuksel, Weber and Keyser, "Dual scattering approximation for fast
// multiple scattering in hair", SIGGRAPH 2008), with optical depths for numbers of fibers. Light
// that fibers scatter forward stays in its beam, which so takes on the color of the hair. What they
// scatter elsewhere is diffuse; where dual scattering adds up the first backward orders, this solves
// the diffusion equation between both ends of the hair on the light's ray (Ishimaru, "Wave
// propagation and scattering in random media", 1978, chapter 9), which has all orders.
//
// Invariant (tests/shading/strand_volume_test): a slab and a ball of fibers reflect and transmit as
// much as a path tracer says; finite and not negative.
#ifndef PELAGE_SHADING_STRAND_VOLUME_HLSLI
#define PELAGE_SHADING_STRAND_VOLUME_HLSLI

#include "fiber_bsdf.hlsli"
#include "strand_light_path.hlsli"

// Diffuse light of a light falls by exp(-sqrt(kDiffusion (1 - albedo)) depth), and leaves at an end
// by Marshak's condition, with kEscape; light from all sides has kSkyDiffusion and kSkyEscape.
// Theory has 3 and 2 for fibers in all directions, and 2 and pi / 2 in a plane. kEscape, kTowardsEye
// and kSkyEscape have the minimum error against a path tracer for parallel fibers (docs/shading.md).
static const float kDiffusion = 3.0;
static const float kEscape = 2.3;
static const float kTowardsEye = 1.12;
static const float kSkyDiffusion = 2.0;
static const float kSkyEscape = 1.4;

struct StrandVolume {
  float3 albedo;   // share of the light that a fiber sends on
  float3 forward;  // part of it that stays in the beam
  float3 lost;     // share of the light that leaves the beam which fibers absorb
};

StrandVolume strandVolume(FiberModel fiber) {
  // Means over the width of a fiber with an index of refraction of 1.55 that is seen from its side:
  // reflectance, chord, and cosines of the angles by which R, TT and TRT turn light.
  float reflected = fresnelReflectance(0.59, fiber.ior);
  float3 through = exp(-1.9 * fiber.absorption);
  float3 tt = (1.0 - reflected) * (1.0 - reflected) * through;
  float3 trt = tt * through * reflected;
  StrandVolume volume;
  volume.albedo = reflected + tt + trt / (1.0 - through * reflected);
  // The mean cosine of a logistic distribution is nearly that of a normal one.
  float kept = exp(-1.645 * fiber.logisticScale * fiber.logisticScale);
  float3 forward = kept * (0.066 * reflected + 0.87 * tt - 0.9 * trt);
  volume.forward = max(forward, float3(0.0, 0.0, 0.0));
  volume.lost = (1.0 - volume.albedo) / (1.0 - volume.forward);
  return volume;
}

// Returns the decay of diffuse light per optical depth of the beam, along a light's ray. What leaves
// through the sides of the hair adds to it: 2.5 (pi / a)^2, between 2 of a cube of edge a and 8/3
// of a ball as large. a ends kEscape / kDiffusion outside of the hair.
float3 diffuseDecay(StrandVolume volume, StrandLightPath path) {
  float3 edge = (1.0 - volume.forward) * path.across + 2.0 * kEscape / kDiffusion;
  float3 decay2 = kDiffusion * volume.lost + 2.5 * kShadingPi * kShadingPi / (edge * edge);
  return sqrt(max(decay2, float3(1e-4, 1e-4, 1e-4)));
}

// Returns the share of a light that reaches a point in its beam.
float3 volumeBeam(StrandVolume volume, StrandLightPath path) {
  return exp((volume.forward - 1.0) * path.front);
}

// Returns the diffuse light from a fiber to the eye, for a light of 1.
float3 volumeDiffuse(StrandVolume volume, StrandLightPath path) {
  float3 thin = 1.0 - volume.forward;
  float3 k = diffuseDecay(volume, path);
  // Where diffuse light falls as the beam does, the solution is 0 / 0.
  k += 0.02 * step(abs(k - 1.0), float3(0.01, 0.01, 0.01));
  float3 beamFront = exp(-thin * path.front);
  float3 beamAll = beamFront * exp(-thin * path.behind);
  float3 front = exp(-k * thin * path.front);
  float3 behind = exp(-k * thin * path.behind);
  float3 scattered = (volume.albedo - volume.forward) / thin;
  float ratio = kEscape / kDiffusion;
  float3 beam = kDiffusion * scattered / (1.0 - k * k);
  float3 a = 1.0 + ratio * k;
  float3 b = front * behind * (1.0 - ratio * k);
  float3 top = beam * (1.0 + ratio);
  float3 bottom = beam * beamAll * (1.0 - ratio);
  float3 fluence =
      ((a * top - b * bottom) * front + (a * bottom - b * top) * behind) / (a * a - b * b) -
      beam * beamFront;
  return max(fluence, float3(0.0, 0.0, 0.0)) * volume.albedo * (0.25 * kTowardsEye);
}

// Returns the light from a fiber to the eye for light from all sides, of radiance `mean` + `slope`
// times the cosine to the light's ray.
// \param facing cosine between that ray and the direction of the eye
float3 volumeAmbient(StrandVolume volume, StrandLightPath path, float facing, float3 mean,
                     float3 slope) {
  float3 decay = sqrt(max(kSkyDiffusion * volume.lost, float3(1e-4, 1e-4, 1e-4)));
  float3 front = exp(-decay * (1.0 - volume.forward) * path.front);
  float3 behind = exp(-decay * (1.0 - volume.forward) * path.behind);
  float3 c = decay * (kSkyEscape / kSkyDiffusion);
  float3 both = (1.0 - c) * front * behind;
  float3 even = (front + behind) / (1.0 + c + both);
  float3 along = c * (front - behind) / (1.0 + c + both);
  float3 odd = (front - behind) / (1.0 + c - both);
  // Light that goes straight on comes from behind the fiber, from one of two halves of the sphere
  // with a soft border. What comes from outside of the hair is left out: it belongs to the picture
  // behind the hair, where a dark strand before a bright sky is dark.
  float side = clamp(1.25 * facing, -1.0, 1.0);
  float outside = lerp(exp(-path.front), exp(-path.behind), 0.5 + 0.5 * side);
  float3 passing = volume.forward * max(even - side * along - outside, float3(0.0, 0.0, 0.0));
  float3 sum = mean * ((volume.albedo - volume.forward) * even + passing) +
               slope * (2.0 / 3.0) * volume.albedo * odd;
  return max(sum, float3(0.0, 0.0, 0.0));
}

#endif
