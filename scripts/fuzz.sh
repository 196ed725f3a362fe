#!/usr/bin/env bash
# Runs the fuzzers of the loaders for a fixed count: scripts/fuzz.sh [RUNS] (20000 a target).
# They are built with clang first, or taken from where PELAGE_FUZZ_BINARIES says: to run them on
# another machine, copy that folder, tests/fuzz/corpus and this script, and call, say,
#   PELAGE_FUZZ_BINARIES=bin PELAGE_FUZZ_JOBS=16 bash fuzz.sh 10000000
# PELAGE_FUZZ_JOBS   programs at a time; each target is split into as many parts with seeds of their
#                    own when RUNS is above a million
# PELAGE_FUZZ_CORPUS the corpus, tests/fuzz/corpus
# PELAGE_FUZZ_OUT    logs and findings, build/fuzz-out
set -euo pipefail
runs=${1:-20000}
root=$(cd "$(dirname "$0")/.." && pwd)
jobs=${PELAGE_FUZZ_JOBS:-$(nproc)}
corpus=${PELAGE_FUZZ_CORPUS:-$root/tests/fuzz/corpus}
out=${PELAGE_FUZZ_OUT:-$root/build/fuzz-out}

if [ -z "${PELAGE_FUZZ_BINARIES:-}" ]; then
  launcher=()
  if command -v ccache > /dev/null; then launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
  # The kernels are the same as in a release build: what that has made is taken.
  codegen=()
  if [ -x "$root/build/release/codegen/pelage-codegen" ]; then
    codegen=(-DPELAGE_CODEGEN_EXECUTABLE="$root/build/release/codegen/pelage-codegen")
  fi
  cmake -S "$root" -B "$root/build/fuzz" -G Ninja -DCMAKE_CXX_COMPILER=clang++-14 "${launcher[@]}" \
    -DPELAGE_BUILD_FUZZERS=ON -DPELAGE_BUILD_TESTS=OFF -DPELAGE_BUILD_SAMPLES=OFF \
    -DPELAGE_BUILD_BENCHMARKS=OFF -DPELAGE_BUILD_VIEWER=OFF -DPELAGE_VULKAN=OFF -DPELAGE_GL=OFF \
    -DPELAGE_CODEGEN_CACHE="$root/build/codegen_cache" "${codegen[@]}" > /dev/null
  cmake --build "$root/build/fuzz" --target fuzzers --parallel "$jobs"
  PELAGE_FUZZ_BINARIES=$root/build/fuzz/tests/fuzz
fi
mkdir -p "$out"

# Fuzzes a target with a seed, `count` times. New inputs go into a folder of their own, not into the corpus.
run_part() {
  local target=$1 seed=$2 count=$3 length=4096
  local work=$out/$target.$seed
  case $target in tfxbone | tfxfollow | hair | hairtxt | obj) length=1024 ;; esac
  mkdir -p "$work"
  if "$PELAGE_FUZZ_BINARIES/pelage_fuzz_$target" "$work" "$corpus/$target" -runs="$count" \
      -seed="$seed" -max_len=$length -timeout=10 -rss_limit_mb=1024 -malloc_limit_mb=64 \
      -artifact_prefix="$out/finding-$target-" -verbosity=0 -print_final_stats=1 \
      > "$out/$target.$seed.log" 2>&1; then
    echo "$target, seed $seed: $(awk '/number_of_executed_units|average_exec_per_sec/ \
      {printf "%s %s  ", $1, $2}' "$out/$target.$seed.log")"
  else
    tail -n 40 "$out/$target.$seed.log"
    echo "$target: a finding, see $out/finding-$target-*"
    return 1
  fi
}
export -f run_part
export PELAGE_FUZZ_BINARIES corpus out

parts=1
if [ "$runs" -gt 1000000 ]; then parts=$jobs; fi
start=$SECONDS
for program in "$PELAGE_FUZZ_BINARIES"/pelage_fuzz_*; do
  [ -x "$program" ] && [ -f "$program" ] || continue
  for seed in $(seq 1 "$parts"); do
    echo "${program##*/pelage_fuzz_} $seed $(((runs + parts - 1) / parts))"
  done
done | xargs -P "$jobs" -L 1 bash -c 'run_part "$@"' fuzz
echo "no finding in $runs executions a target, $((SECONDS - start)) s"
