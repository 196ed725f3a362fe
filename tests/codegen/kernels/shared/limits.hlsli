// The fixture's host has these constants, too.
#ifndef FIXTURE_LIMITS_HLSLI
#define FIXTURE_LIMITS_HLSLI

static const uint kMaxParticles = 1u << 20;
static const uint kDeadFlag = 4, kStuckFlag = 2 * kDeadFlag;
static const uint kAnyFlag = 0x80000000u | kDeadFlag | kStuckFlag;
static const int kLowestCell = -32 * 2;
static const float kRestingSpeed = 1.5 / 65535.0;
static const float kNowhere = 1e18;

#endif
