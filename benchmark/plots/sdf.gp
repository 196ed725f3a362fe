load system("dirname '".ARG0."'")."/style.gp"
# 1 classic, 2 classic on pelage's grid, 3 and 4 pelage.
set linetype 2 lc rgb "#e69f00" pt 4 lw 1.6 ps 1.1
set linetype 3 lc rgb "#009e73" pt 6 lw 1.6 ps 1.1
set linetype 4 lc rgb "#0072b2" pt 7 lw 2.4 ps 1.1
set linetype 5 lc rgb "#cc79a7" pt 12 lw 1.6 ps 1.1
methods = "classic tight one_axis three_axes band_4"
names = "'TressFX 4.0 like' 'the same, tight grid' 'pelage, one axis' 'pelage, three axes' 'pelage, band of 4'"
responses = "classic tight trilinear closest"
labels = "'TressFX 4.0 like' 'the same, tight grid' 'pelage, trilinear' 'pelage, closest feature'"
set multiplot layout 2,2 title "Distance field of ".shape." at ".cells." cells: ".device font ",13"
build(k) = dir."/build.".word(methods, k)
collide(k) = dir."/collide_near.".word(responses, k)
set xlabel "build, all passes [µs]"
set ylabel "distance error of written nodes, rms [cell]"
set title "build: error"
set key outside bottom center maxrows 3 samplen 2
plot for [k = 1:5] build(k) using 1:2 with linespoints lt k title word(names, k), \
  for [k = 1:5] build(k) using 1:2:4 with labels offset 0.9,0.7 font ",8" notitle
unset key
set ylabel "inside nodes without a depth, % (0.01: none)"
set title "build: unset interior"
plot for [k = 1:5] build(k) using 1:($5 > 0 ? $5 : 0.01) with linespoints lt k notitle, \
  for [k = 1:5] build(k) using 1:($5 > 0 ? $5 : 0.01):4 with labels offset 0.9,0.7 font ",8" notitle
set ylabel "keys and crossings [MiB]"
set title "build: memory"
plot for [k = 1:5] build(k) using 1:3 with linespoints lt k notitle, \
  for [k = 1:5] build(k) using 1:3:4 with labels offset 0.9,0.7 font ",8" notitle
set xlabel "collision of ".vertices." vertices [µs]"
set ylabel "vertices left inside, % (0.001: none)"
set title "collision: what stays inside, all within 3 cells"
set key outside bottom center maxrows 3 samplen 2
plot for [k = 1:words(responses)] collide(k) using 1:($2 > 0.001 ? $2 : 0.001) with linespoints lt k \
    title word(labels, k), \
  for [k = 1:words(responses)] collide(k) using 1:($2 > 0.001 ? $2 : 0.001):4 with labels offset 0.9,0.7 \
    font ",8" notitle
unset multiplot
