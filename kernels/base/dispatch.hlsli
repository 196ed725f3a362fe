// Rows of dispatches that are too long for one axis.
#ifndef PELAGE_BASE_DISPATCH_HLSLI
#define PELAGE_BASE_DISPATCH_HLSLI

// One thread an item: rows have this many threads.
static const int kRowBits = 20;
static const uint kRowThreads = 1u << kRowBits;
uint indexOfThread(uint3 thread) { return (thread.y << kRowBits) | thread.x; }

// One group an item: rows have this many groups.
static const uint kRowGroups = 32768;
uint indexOfGroup(uint3 group) { return group.y * kRowGroups + group.x; }

#endif
