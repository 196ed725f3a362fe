load system("dirname '".ARG0."'")."/style.gp"
set linetype 1 lc rgb "#d55e00" pt 8 lw 1.6 ps 1.2
set linetype 2 lc rgb "#0072b2" pt 7 lw 2.4 ps 1.2
set linetype 3 lc rgb "#009e73" pt 4 lw 1.6 ps 1.2
set linetype 4 lc rgb "#009e73" pt 6 lw 1.6 ps 1.2
set linetype 5 lc rgb "#009e73" pt 12 lw 1.6 ps 1.2
set linetype 6 lc rgb "#e69f00" pt 10 lw 1.6 ps 1.2
set linetype 7 lc rgb "#56b4e9" pt 5 lw 1.6 ps 1.2
set linetype 8 lc rgb "#cc79a7" pt 1 lw 1.6 ps 1.2
set linetype 9 lc rgb "#999999" pt 2 lw 1.6 ps 1.2
set linetype 10 lc rgb "#666666" pt 3 lw 1.6 ps 1.2
files = "classic8 windowed hybrid4 hybrid8 hybrid16 shortcut tiles alpha-test stochastic stochastic_x4"
names = "'TressFX 4.0 like, k = 8' 'pelage, windowed' 'pelage, hybrid 4' 'hybrid 8' 'hybrid 16' 'pelage, ShortCut' 'pelage, tiles' 'alpha test' 'stochastic' 'stochastic, 4 samples'"
data(k) = dir."/".word(files, k)
unset logscale y
set format y "%g"
set ylabel "PSNR over the pixels with hair [dB]"
set multiplot layout 1,2 margins 0.07,0.98,0.33,0.84 spacing 0.09 title "Transparency, ".what.": ".device font ",13"
set key at screen 0.5,0.2 center top maxrows 4 samplen 2 width 2 font ",9"
set xlabel "build and resolve [ms]"
set title "time; numbers: opacity"
plot for [k = 1:10] data(k) using 1:3 with linespoints lt k title word(names, k), \
  for [k = 1:2] data(k) using 1:3:4 with labels offset 1.2,0.7 font ",8" notitle
unset key
set xlabel "bytes a pixel of the view (0.5: none)"
set title "memory"
plot for [k = 1:10] data(k) using 2:3 with linespoints lt k notitle, \
  for [k = 1:2] data(k) using 2:3:4 with labels offset 1.2,0.7 font ",8" notitle
unset multiplot
