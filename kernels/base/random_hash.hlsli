// Integer hash: the same numbers on every device.
#ifndef PELAGE_BASE_RANDOM_HASH_HLSLI
#define PELAGE_BASE_RANDOM_HASH_HLSLI

// Permuted congruential output function on a linear step (Jarzynski and Olano, "Hash Functions for
// GPU Rendering", JCGT 9(3), 2020, section 4.1: the pcg hash).
uint hashUint(uint value) {
  uint state = value * 747796405u + 2891336453u;
  uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
  return (word >> 22) ^ word;
}

uint hashUints(uint a, uint b) { return hashUint(a ^ hashUint(b)); }

// Uniform in [0, 1), a multiple of 2^-24.
float unitFloat(uint hash) { return float(hash >> 8) * (1.0 / 16777216.0); }

#endif
