load system("dirname '".ARG0."'")."/style.gp"
set multiplot layout 2,2 title "Error against time a frame: ".device font ",13"
set ylabel "error, % of length"
set xlabel "all passes of a frame [µs]"
file(scene, k) = dir."/".scene.".".word(solvers, k)
do for [scene in "limp_swing shaken_curl elastica_tip helix_sag"] {
  if (scene eq "limp_swing") { set title "limp swing, rms of 1 s, ".swing." strands" }
  if (scene eq "shaken_curl") { set title "curl on a shaken head, rms of 2 s, ".swing." strands" }
  if (scene eq "elastica_tip") { set title "elastica, tip at rest, ".static." strands" }
  if (scene eq "helix_sag") { set title "sagging helix, rms at rest, ".static." strands" }
  if (scene eq "limp_swing") { set key top right } else { unset key }
  plot for [k = 1:4] file(scene, k) using 1:2 with linespoints lt k title word(titles, k), \
    for [k = 1:4] file(scene, k) using 1:2:3 with labels offset 0.9,0.7 font ",8" notitle
}
unset multiplot
