// Colors the needle of a contact record.
//
// Reads:   ContactVaryings
// Writes:  SV_Target0 linear color, opaque
//
// Invariant (tests/contact): the color is that of the record's depth, without light.
#include "layouts/draw_contacts.hlsli"

float4 contact_pixel(ContactVaryings input) : SV_Target0 { return float4(input.color, 1.0); }
