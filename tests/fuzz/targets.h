// The fuzzers load a file and check the loader's promises. The same functions replay the corpus in
// a test of every build.
#pragma once

#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "pelage/result.h"

namespace pelage::fuzz {

struct Outcome {
  bool loaded = false;  ///< false: the loader refused the file
  std::string fault;    ///< the promise that was broken; empty when none was
};

Outcome tfx(std::span<const std::byte> bytes);
Outcome tfxbone(std::span<const std::byte> bytes);
Outcome tfxmesh(std::span<const std::byte> bytes);
Outcome tfxskin(std::span<const std::byte> bytes);
Outcome tfxfollow(std::span<const std::byte> bytes);
Outcome psdf(std::span<const std::byte> bytes);
/// .pelage; also with all checksums made right.
Outcome cache(std::span<const std::byte> bytes);
/// .pelagecache; also with all checksums made right.
Outcome haircache(std::span<const std::byte> bytes);
/// JSON of settings (tools/settings).
Outcome settings(std::span<const std::byte> bytes);
// Hair curves (tools/authoring).
Outcome hair(std::span<const std::byte> bytes);
Outcome hairtxt(std::span<const std::byte> bytes);
Outcome obj(std::span<const std::byte> bytes);
Outcome gltf(std::span<const std::byte> bytes);
/// .tfx of any version.
Outcome tfxcurves(std::span<const std::byte> bytes);
Outcome usda(std::span<const std::byte> bytes);
/// Clips of .gltf and .glb files (tools/authoring).
Outcome animation(std::span<const std::byte> bytes);
/// The motion of a bake's skin (tools/bake).
Outcome pc2(std::span<const std::byte> bytes);
Outcome skinobj(std::span<const std::byte> bytes);

/// The name that loaders get; errors must start with it.
inline constexpr const char* kName = "fuzz";

inline Outcome broken(std::string fault) { return {true, std::move(fault)}; }

/// A file that was refused: the error must say where and why.
inline Outcome refused(const Error& error) {
  const bool placed = error.message.rfind(std::string(kName) + ":", 0) == 0;
  if (error.code == ErrorCode::kInvalidFile && placed) return {};
  return {false, "an error without a place: " + error.message};
}

/// A file as it is. One that is refused is checked again with its checksums made right, so that
/// what is behind them is fuzzed, too.
template <class Check, class Seal>
Outcome checkAlsoSealed(std::span<const std::byte> bytes, Check check, Seal sealed) {
  const Outcome plain = check(bytes);
  if (plain.loaded || !plain.fault.empty()) return plain;
  Outcome outcome = check(sealed(bytes));
  outcome.loaded = false;
  return outcome;
}

/// Bit by bit, so that -0 and 0 differ.
template <class T>
bool sameBits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}
/// Whether `part` is what `whole` starts with.
template <class T>
bool isStart(const std::vector<T>& part, const std::vector<T>& whole) {
  return part.size() <= whole.size() &&
         (part.empty() || std::memcmp(part.data(), whole.data(), part.size() * sizeof(T)) == 0);
}

}  // namespace pelage::fuzz
