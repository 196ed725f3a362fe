// Records in the elements of g_contacts, which the including file has declared.
#ifndef PELAGE_CONTACT_CONTACT_ACCESS_HLSLI
#define PELAGE_CONTACT_CONTACT_ACCESS_HLSLI

#include "layouts/contact_records.hlsli"

uint contactBits(uint record) { return g_contacts[kContactElements * record + 3u].w; }

float4 contactForce(uint record) { return asfloat(g_contacts[kContactElements * record + 2u]); }

ContactRecord loadRecord(uint record) {
  uint element = kContactElements * record;
  uint4 found = g_contacts[element + 3u];
  ContactRecord loaded;
  loaded.plane = asfloat(g_contacts[element]);
  loaded.surface = asfloat(g_contacts[element + 1u]);
  loaded.force = asfloat(g_contacts[element + 2u]);
  loaded.foundX = asfloat(found.x);
  loaded.foundY = asfloat(found.y);
  loaded.foundZ = asfloat(found.z);
  loaded.bits = found.w;
  return loaded;
}

#endif
