// Constants of the kernels that measure or draw values of strands' vertices; no resources.
#ifndef VIEWER_STRAND_VALUE_HLSLI
#define VIEWER_STRAND_VALUE_HLSLI

// A vertex without a value: its segments are not drawn.
static const float kNoValue = 1e30;
// Segments have a value below this.
static const float kMostValue = 1e18;

// Words of a summary of values.
static const uint kSummaryLargest = 0;    // bits of the largest magnitude
static const uint kSummaryBeyond = 1;     // vertices beyond the limit
static const uint kSummaryNotFinite = 2;  // vertices that are not finite
static const uint kSummaryMeasured = 3;   // vertices that were measured
static const uint kSummaryWords = 4;

// Threads a row of a dispatch that is too long for one axis.
static const uint kInspectRow = 1048576;

#endif
