// Finds and counts passes of lists.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "pelage/pass_list.h"

namespace pelage::test {

/// How often a list runs a kernel.
inline size_t countPasses(const PassList& list, std::string_view name) {
  return static_cast<size_t>(std::count_if(list.passes.begin(), list.passes.end(),
                                           [&](const Pass& pass) { return name == pass.name; }));
}

/// The first pass of a kernel; nullptr where there is none.
inline const Pass* findPass(const PassList& list, std::string_view name) {
  for (const Pass& pass : list.passes)
    if (pass.name == name) return &pass;
  return nullptr;
}

/// Each with a space behind it.
inline std::string passNames(const PassList& list) {
  std::string names;
  for (const Pass& pass : list.passes) names += std::string(pass.name) + " ";
  return names;
}

inline size_t uploadsTo(const PassList& list, BufferId buffer) {
  return static_cast<size_t>(
      std::count_if(list.uploads.begin(), list.uploads.end(),
                    [&](const Upload& upload) { return upload.buffer == buffer; }));
}

/// A block of constants that a pass has; zeros where it has none.
template <class T>
T constantsOf(const PassList& list, const Pass& pass, std::string_view block) {
  T constants = {};
  for (const PassBinding& binding : list.bindingsOf(pass))
    if (pass.layouts()[binding.set]->entries[binding.entry].name == block)
      std::memcpy(&constants, list.constants.data() + binding.offset, sizeof(constants));
  return constants;
}

/// The values of the first upload to a buffer; empty without one.
template <class T>
std::vector<T> uploaded(const PassList& list, BufferId buffer) {
  for (const Upload& upload : list.uploads) {
    if (upload.buffer != buffer) continue;
    std::vector<T> values(upload.size / sizeof(T));
    std::memcpy(values.data(), list.uploadData.data() + upload.dataOffset, upload.size);
    return values;
  }
  return {};
}

}  // namespace pelage::test
