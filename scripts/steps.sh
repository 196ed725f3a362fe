# Shared by demo.sh, test.sh, test_all.sh and web.sh, which source it from the root of the tree: steps with their
# times, and what builds and tests have in common.

# A driver or validation layer that is missing is a failure here, and no reason to skip.
export PELAGE_REQUIRE_DEVICES=1
# Mesa compiles each kernel once for all programs that are run, under the sanitizers, too.
export MESA_SHADER_CACHE_DIR="$PWD/build/shader_cache"
export CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime
jobs=$(nproc)
codegen_cache="$PWD/build/codegen_cache"

names=() starts=()
step() {
  printf '\n=== %s (%d s)\n' "$1" "$SECONDS"
  names+=("$1")
  starts+=("$SECONDS")
}
# Prints the time of each step, also where one fails.
print_times() {
  local i
  starts+=("$SECONDS")
  echo
  for ((i = 0; i < ${#names[@]}; ++i)); do
    printf '%6d s  %s\n' $((starts[i + 1] - starts[i])) "${names[i]}"
  done
  times > "$times_file"  # of the shell and of what it ran: 1m2.345s each
  printf '%6d s  in all, %d s of CPU\n' "$SECONDS" \
    "$(awk -F '[ms \n]+' '{sum += 60 * ($1 + $3) + $2 + $4} END {print int(sum)}' "$times_file")"
  rm -f "$times_file"
}
times_file=$(mktemp)
trap print_times EXIT
