load system("dirname '".ARG0."'")."/style.gp"
set multiplot layout 1,2 title "Groom, head moved 0.2 m at 1.9 Hz: ".device font ",13"
groom(k) = dir."/groom.".word(solvers, k)
# The setting of each solver in the left panel.
effort(k) = int(word("2 20 4 1", k))
label(k) = word(titles, k).", ".word("'2 sweeps' '20 sub-steps' '4 Newton steps' '1 sub-step'", k)
set title "time a frame"
set xlabel "strands of 32 vertices"
set ylabel "all passes [µs]"
set key outside bottom center maxrows 3 samplen 2
plot for [k = 1:4] groom(k) using ($3 == effort(k) ? $5 : NaN):1 with linespoints lt k \
    title label(k), \
  groom(4) using ($3 == effort(4) ? $5 : NaN):6 with lines dt 2 lc rgb "#666666" \
    title "copy of as many bytes as exact"
set title sprintf("stretch, %d strands", groomSize)
set xlabel "all passes of a frame [µs]"
set ylabel "stretch, rms of all edges, %"
unset key
plot for [k = 1:4] groom(k) using ($5 == groomSize ? $1 : NaN):4 with linespoints lt k notitle, \
  for [k = 1:4] groom(k) using ($5 == groomSize ? $1 : NaN):4:3 with labels offset 0.9,0.7 \
    font ",8" notitle
unset multiplot
