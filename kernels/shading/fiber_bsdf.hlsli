// Light scattered by a fiber of hair: a rough dielectric cylinder with scales, colored inside. The
// model sums light that is reflected (R), passes through (TT), is reflected inside once (TRT), and
// the rest.
//
// f cos(theta) = sum over lobes p of M_p(theta) A_p N_p(phi), [1/sr]: longitudinal M_p of d'Eon et
// al., "An energy-conserving hair reflectance model", EGSR 2011; azimuthal N_p, roughnesses and
// absorption of Chiang et al., "A practical and controllable hair and fur model for production path
// tracing", Eurographics 2016. Angles as there: theta from the plane at right angles to the fiber,
// here > 0 towards the tip; phi around it.
//
// Invariant (tests/shading/fiber_shading_test): without absorption the integral over all directions
// of light is 1; with it less; finite for every argument.
#ifndef PELAGE_SHADING_FIBER_BSDF_HLSLI
#define PELAGE_SHADING_FIBER_BSDF_HLSLI

#include "shading_math.hlsli"

// Minimum roughness: smoother fibers have highlights that no pixel resolves and that exceed floats.
static const float kMinRoughness = 0.05;
// Absorption of a fiber that is black for the eye.
static const float kMinAlbedo = 1e-5;

// Values that depend on material and color only.
struct FiberModel {
  float4 variance;      // longitudinal, of R, TT, TRT and the rest
  float logisticScale;  // azimuthal
  float3 absorption;    // along one radius
  float ior;
  float3 tiltSine;  // of the angle by which the scales rotate R, TT and TRT
  float3 tiltCosine;
};

struct FiberAngles {
  float sinLight;  // theta
  float cosLight;
  float sinEye;
  float cosEye;
  float azimuth;  // from the eye to the light, > 0 towards tangent x toEye
};

// Shares of the light that leave in each lobe; without absorption their sum is 1.
struct FiberAttenuation {
  float3 r;
  float3 tt;
  float3 trt;
  float3 rest;
};

// \param fiber as StrandShading.fiber; \param base 0..1: albedo of a volume of such fibers.
FiberModel makeFiberModel(float4 fiber, float3 base) {
  FiberModel model;
  float m = bounded(fiber.x, kMinRoughness, 1.0);
  float n = bounded(fiber.y, kMinRoughness, 1.0);
  float tilt = bounded(fiber.z, -0.5, 0.5);
  model.ior = bounded(fiber.w, 1.0, 3.0);

  // Chiang et al. 2016, equation 7; the lobes' factors are those of Marschner et al. 2003, squared.
  float m2 = m * m;
  float m4 = m2 * m2;
  float m16 = m4 * m4 * m4 * m4;
  float deviation = 0.726 * m + 0.812 * m2 + 3.7 * m16 * m4;
  model.variance = deviation * deviation * float4(1.0, 0.25, 4.0, 4.0);

  // Chiang et al. 2016, equation 8, and 12 for the factor sqrt(pi / 8).
  float n2 = n * n;
  float n4 = n2 * n2;
  float n5 = n4 * n;
  float n22 = n5 * n5 * n5 * n5 * n2;
  model.logisticScale = 0.626657069 * (0.265 * n + 1.194 * n2 + 5.372 * n22);

  // Chiang et al. 2016, equation 9.
  float3 albedo = max(base, float3(kMinAlbedo, kMinAlbedo, kMinAlbedo));
  float3 root =
      log(albedo) / (5.969 - 0.215 * n + 2.532 * n2 - 10.73 * n2 * n + 5.574 * n4 + 0.245 * n5);
  model.absorption = root * root;

  // A cone of slope a mirrors light 2 a towards the root. Through two such walls, or three, small
  // angles bend by 2 a (ior - 1) and 2 a (2 ior - 1) towards the tip: about a and 4 a for hair.
  float3 turn = tilt * float3(2.0, -1.0, -4.0);
  model.tiltSine = sin(turn);
  model.tiltCosine = cos(turn);
  return model;
}

// \param tangent, \param toEye, \param toLight unit vectors.
FiberAngles fiberAngles(float3 tangent, float3 toEye, float3 toLight) {
  FiberAngles angles;
  angles.sinLight = clamp(dot(tangent, toLight), -1.0, 1.0);
  angles.sinEye = clamp(dot(tangent, toEye), -1.0, 1.0);
  angles.cosLight = otherLeg(angles.sinLight);
  angles.cosEye = otherLeg(angles.sinEye);
  // Both vectors without their components along the fiber; atan2() needs no unit lengths.
  float x = dot(toEye, toLight) - angles.sinEye * angles.sinLight;
  float y = dot(cross(tangent, toEye), toLight);
  angles.azimuth = 0.0;
  // Neither API says what atan2(0, 0) is.
  if (x * x + y * y > 1e-12) angles.azimuth = atan2(y, x);
  return angles;
}

// I0(x) exp(-x) for x >= 0: Abramowitz and Stegun, "Handbook of mathematical functions", 1964,
// 9.8.1 and 9.8.2; relative error under 3e-7.
float scaledBesselI0(float x) {
  float scaled = 0.0;
  if (x < 3.75) {
    float t = x / 3.75;
    t *= t;
    float i0 =
        1.0 +
        t * (3.5156229 +
             t * (3.0899424 + t * (1.2067492 + t * (0.2659732 + t * (0.0360768 + t * 0.0045813)))));
    scaled = i0 * exp(-x);
  } else {
    float u = 3.75 / x;
    float sum = 0.39894228 +
                u * (0.01328592 +
                     u * (0.00225319 +
                          u * (-0.00157565 +
                               u * (0.00916281 +
                                    u * (-0.02057706 +
                                         u * (0.02635537 + u * (-0.01647633 + u * 0.00392377)))))));
    scaled = sum / sqrt(x);
  }
  return scaled;
}

// d'Eon et al. 2011, equation 7, with the large exponentials of I0 and sinh taken together, which
// holds where they overflow: d'Eon's note on small variances uses logarithms for that.
float longitudinalScattering(float variance, float sinLight, float cosLight, float sinEye,
                             float cosEye) {
  float inverse = 1.0 / variance;
  float product = cosLight * cosEye;
  float exponent = min((product - sinLight * sinEye - 1.0) * inverse, 0.0);
  return scaledBesselI0(product * inverse) * exp(exponent) * inverse / (1.0 - exp(-2.0 * inverse));
}

// M of R, TT, TRT and the rest: the scales rotate the direction of the eye.
float4 longitudinalLobes(FiberModel model, FiberAngles a) {
  float3 sine = a.sinEye * model.tiltCosine + a.cosEye * model.tiltSine;
  // Rotated past the fiber's axis, it leaves on the other side.
  float3 cosine = abs(a.cosEye * model.tiltCosine - a.sinEye * model.tiltSine);
  return float4(
      longitudinalScattering(model.variance.x, a.sinLight, a.cosLight, sine.x, cosine.x),
      longitudinalScattering(model.variance.y, a.sinLight, a.cosLight, sine.y, cosine.y),
      longitudinalScattering(model.variance.z, a.sinLight, a.cosLight, sine.z, cosine.z),
      longitudinalScattering(model.variance.w, a.sinLight, a.cosLight, a.sinEye, a.cosEye));
}

// Reflectance of a smooth dielectric for unpolarized light (Fresnel), under 1.
float fresnelReflectance(float cosine, float ior) {
  float inside = sqrt(max(1.0 - (1.0 - cosine * cosine) / (ior * ior), 0.0));
  float2 sums = max(float2(cosine + ior * inside, ior * cosine + inside), 1e-6);
  float share = 1.0 / (sums.x * sums.y);
  float across = (cosine - ior * inside) * sums.y * share;
  float along = (ior * cosine - inside) * sums.x * share;
  return min(0.5 * (across * across + along * along), 0.9999);
}

// Index of refraction of the cross-section of a fiber that is seen at theta (Marschner et al.,
// "Light scattering from human hair fibers", SIGGRAPH 2003, appendix B).
float crossSectionIor(FiberModel model, FiberAngles a) {
  float leg = sqrt(max(model.ior * model.ior - a.sinEye * a.sinEye, 0.0));
  return max(leg / max(a.cosEye, 1e-4), 1.0);
}

// Values of attenuation that depend on the angle of the eye only.
struct FiberPath {
  float cosEye;
  float inverseCross;  // 1 over the index of refraction of the cross-section
  float twiceLength;   // 2 over the cosine inside the fiber: length along the fiber of a unit chord
};

FiberPath fiberPath(FiberModel model, FiberAngles a) {
  FiberPath path;
  path.cosEye = a.cosEye;
  path.inverseCross = 1.0 / crossSectionIor(model, a);
  path.twiceLength = 2.0 / max(otherLeg(a.sinEye / model.ior), 1e-3);
  return path;
}

// \param h offset of the ray from the fiber's axis, -1..1.
// Chiang et al. 2016, section 4.3 and equations 5 and 6; the rest is the geometric series.
FiberAttenuation fiberAttenuation(FiberModel model, FiberPath path, float h) {
  float reflected = fresnelReflectance(path.cosEye * otherLeg(h), model.ior);
  float chord = path.twiceLength * otherLeg(h * path.inverseCross);
  float3 through = exp(-model.absorption * chord);

  FiberAttenuation result;
  result.r = float3(reflected, reflected, reflected);
  result.tt = (1.0 - reflected) * (1.0 - reflected) * through;
  result.trt = result.tt * through * reflected;
  result.rest = result.trt * through * reflected / (1.0 - through * reflected);
  return result;
}

// The periodic cut logistic (Chiang et al. 2016, equation 11) at the azimuths of R, TT and TRT.
struct AzimuthalLobes {
  float3 density;
  float3 integral;  // from -pi
};

AzimuthalLobes azimuthalLobes(FiberModel model, float3 x) {
  float3 turns = floor(x * (0.5 / kShadingPi) + 0.5);
  float3 rest = x - 2.0 * kShadingPi * turns;
  float3 e = exp(-abs(rest) / model.logisticScale);
  float3 above = 1.0 / (1.0 + e);
  float3 below = e * above;
  float3 share = float3(rest.x < 0.0 ? below.x : above.x, rest.y < 0.0 ? below.y : above.y,
                        rest.z < 0.0 ? below.z : above.z);
  // The integral of the whole logistic beyond pi, and likewise below -pi.
  float cut = exp(-kShadingPi / model.logisticScale);
  cut /= 1.0 + cut;
  float scale = 1.0 / (1.0 - 2.0 * cut);
  AzimuthalLobes lobes;
  lobes.density = above * below * (scale / model.logisticScale);
  lobes.integral = turns + (share - cut) * scale;
  return lobes;
}

// Abramowitz and Stegun 4.4.46: error under 1e-7. Those of drivers may be off by 2e-4, which is
// visible in sharp lobes.
float arcSine(float x) {
  float size = min(abs(x), 1.0);
  float sum =
      1.5707963050 +
      size * (-0.2145988016 +
              size * (0.0889789874 +
                      size * (-0.0501743046 +
                              size * (0.0308918810 +
                                      size * (-0.0170881256 +
                                              size * (0.0066700901 - size * 0.0012624911))))));
  float angle = 0.5 * kShadingPi - sqrt(1.0 - size) * sum;
  return x < 0.0 ? -angle : angle;
}

// Azimuths at which smooth R, TT and TRT leave at offset h (Chiang et al. 2016, section 4.2), h
// positive on the side of positive azimuths. Those of -h are minus these, plus whole turns.
float3 lobeAzimuths(FiberPath path, float h) {
  float entry = 2.0 * arcSine(h);
  float passage = kShadingPi - 2.0 * arcSine(h * path.inverseCross);
  return float3(entry, entry + passage, entry + 2.0 * passage);
}

// Scattering of light that meets the fiber at offset h of the eye's ray: f cos(theta), [1/sr].
// \param lobes longitudinalLobes()
float3 nearFiberScattering(FiberModel model, FiberAngles a, float4 lobes, float h) {
  FiberPath path = fiberPath(model, a);
  FiberAttenuation shares = fiberAttenuation(model, path, h);
  float3 around = lobes.xyz * azimuthalLobes(model, a.azimuth - lobeAzimuths(path, h)).density;
  return around.x * shares.r + around.y * shares.tt + around.z * shares.trt +
         lobes.w / (2.0 * kShadingPi) * shares.rest;
}

// Parts of half the fiber's width. In each, azimuth is linear in h, and attenuation is that halfway
// along the arc. A search found the limits with the minimum error for roughness 0.2 to 0.5: narrow
// at the edge, where both change most.
static const uint kFiberParts = 4u;
static const float kFiberPartEnds[5] = {0.0, 0.514, 0.788, 0.943, 1.0};
static const float kFiberPartMiddles[4] = {0.2667, 0.6623, 0.8770, 0.9856};

// Returns the mean of nearFiberScattering over the fiber's width. In each part the mean of the
// logistic is exact, so no point of the width appears as its own lobe, and energy is conserved.
float3 fiberScattering(FiberModel model, FiberAngles a, float4 lobes) {
  FiberPath path = fiberPath(model, a);
  float3 sum = float3(0.0, 0.0, 0.0);
  // The two halves are mirror images: their parts end at the azimuths -x and x of each lobe.
  float3 innerEnd = float3(0.0, kShadingPi, 2.0 * kShadingPi);
  float3 innerIntegral = float3(0.0, 1.0, 2.0);
  [unroll] for (uint part = 0u; part < kFiberParts; ++part) {
    float to = kFiberPartEnds[part + 1u];
    float3 end = lobeAzimuths(path, to);
    AzimuthalLobes left = azimuthalLobes(model, a.azimuth + end);
    AzimuthalLobes right = azimuthalLobes(model, a.azimuth - end);
    float3 integral = left.integral - right.integral;
    float3 width = end - innerEnd;
    float3 density = max((integral - innerIntegral) / width, float3(0.0, 0.0, 0.0));
    // A part without width has the density at its end.
    float3 narrow = left.density + right.density;
    density = float3(abs(width.x) < 1e-3 ? narrow.x : density.x,
                     abs(width.y) < 1e-3 ? narrow.y : density.y,
                     abs(width.z) < 1e-3 ? narrow.z : density.z);
    float3 scattered = 0.5 * lobes.xyz * density;
    FiberAttenuation shares = fiberAttenuation(model, path, kFiberPartMiddles[part]);
    sum += (to - kFiberPartEnds[part]) *
           (scattered.x * shares.r + scattered.y * shares.tt + scattered.z * shares.trt +
            lobes.w / (2.0 * kShadingPi) * shares.rest);
    innerEnd = end;
    innerIntegral = integral;
  }
  return sum;
}

#endif
