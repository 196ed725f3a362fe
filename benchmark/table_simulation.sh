#!/usr/bin/env bash
# Prints the results of run_simulation.sh as Markdown tables, or puts them into a document between
# its lines "<!-- RESULTS.csv -->" and "<!-- end of RESULTS.csv -->".
#   benchmark/table_simulation.sh RESULTS.csv [API [DOCUMENT.md]]
set -euo pipefail
csv=$1
api=${2:-vulkan}
document=${3:-}

tables() {
  awk -F, -v api="$api" '
  # Two or three digits that count.
  function brief(x) {
    if (x == "") return "-"
    x += 0
    return x >= 99.95 ? sprintf("%.0f", x) : x >= 9.995 ? sprintf("%.1f", x) : \
           x >= 0.9995 ? sprintf("%.2f", x) : x >= 0.09995 ? sprintf("%.3f", x) : sprintf("%.2g", x)
  }
  function cells(key) {
    return key in time ? error[key] " / " stretch[key] " | " time[key] : "- | -"
  }
  function heading(columns, n, i, line) {
    print "| " (columns ~ /^20/ ? "scene" : "solver, setting") " | " columns " |"
    line = "|---|"
    for (i = 0; i < n; ++i) line = line "---|"
    print line
  }
  NR == 1 || $2 != api { next }
  commit == "" { split($0, quoted, "\""); commit = $1; device = quoted[2]; driver = quoted[4] }
  {
    name = $4 ", " $6
    if ($3 == "limp_whip") fallingCommit = $1
    if (!(name in seen)) { seen[name] = 1; names[++count] = name }
    where = $3 ~ /^(groom|mohawk)/ ? $3 " " $7 : $3
    key = where ";" name
    value[key] = $10; micros[key] = $14
    error[key] = brief($10); stretch[key] = brief($11); rms[key] = brief($12)
    time[key] = brief($14); floor[key] = brief($20); rate[key] = brief($19)
    ratio[key] = brief($21); broken[key] = $13
    if (where ~ / /) { if (!(where in known)) { known[where] = 1; places[++pointCount] = where } }
  }
  END {
    print device ", " driver ", " api ", commit " commit ".\n"
    print "Error in % of the length / largest stretch in %, and µs a frame:\n"
    split("limp_swing shaken_curl elastica_tip helix_sag", scenes, " ")
    heading("limp swing | µs | shaken curl | µs | elastica tip | µs | helix sag | µs", 8)
    for (i = 1; i <= count; ++i) {
      if (!(("limp_swing;" names[i]) in time)) continue
      line = "| " names[i]
      for (s = 1; s <= 4; ++s) line = line " | " cells(scenes[s] ";" names[i])
      print line " |"
    }
    swings = 0
    for (i = 1; i <= count; ++i) swings += ("limp_whip;" names[i]) in time
    if (swings) {
      print "\nReleased from the horizontal, likewise (commit " fallingCommit "):\n"
      split("limp_whip soft_swing stiff_swing", falling, " ")
      heading("limp whip | µs | bend length 0.05 m | µs | bend length 0.15 m | µs", 6)
      for (i = 1; i <= count; ++i) {
        if (!(("limp_whip;" names[i]) in time)) continue
        line = "| " names[i]
        for (s = 1; s <= 3; ++s) line = line " | " cells(falling[s] ";" names[i])
        print line " |"
      }
    }
    print "\nThe cheapest setting with an error of at most so many %, and its µs:\n"
    heading("20 % | 5 % | 1 % | 0.3 % | 0.1 %", 5)
    split("20 5 1 0.3 0.1", limits, " ")
    for (s = 1; s <= 4; ++s) {
      line = "| " scenes[s]
      for (l = 1; l <= 5; ++l) {
        best = ""
        for (i = 1; i <= count; ++i) {
          key = scenes[s] ";" names[i]
          if (!(key in value) || value[key] == "" || value[key] + 0 > limits[l] + 0) continue
          if (best == "" || micros[key] + 0 < micros[best] + 0) { best = key; winner = names[i] }
        }
        line = line " | " (best == "" ? "none" : winner ": " time[best])
      }
      print line " |"
    }
    for (p = 1; p <= pointCount; ++p) {
      split(places[p], place, " ")
      print "\n`" place[1] "`, " place[2] " strands:\n"
      heading("rms stretch, % | largest, % | broken strands | µs a frame | of tressfx_like, 2 sweeps | " \
              "GB/s | copy, µs", 7)
      for (i = 1; i <= count; ++i) {
        key = places[p] ";" names[i]
        if (key in time)
          print "| " names[i] " | " rms[key] " | " stretch[key] " | " broken[key] " | " time[key] \
            " | " ratio[key] " | " rate[key] " | " floor[key] " |"
      }
    }
  }' "$csv"
}

if [ -z "$document" ]; then
  tables
  exit
fi
name=$(basename "$csv")
work=$(mktemp)
trap 'rm -f "$work"' EXIT
tables >"$work"
grep -qxF "<!-- $name -->" "$document" && grep -qxF "<!-- end of $name -->" "$document" || {
  echo "$document has no lines '<!-- $name -->' and '<!-- end of $name -->'" >&2
  exit 1
}
awk -v name="$name" -v work="$work" '
  $0 == "<!-- end of " name " -->" { inside = 0 }
  !inside
  $0 == "<!-- " name " -->" {
    inside = 1
    while ((getline line < work) > 0) print line
  }' "$document" >"$document.new"
mv "$document.new" "$document"
