# Colours that stay apart for colour-blind readers (Okabe and Ito), and a mark for each solver.
solvers = "tressfx_like xpbd_cosserat classic exact"
titles = "'TressFX 4.0 like' 'XPBD Cosserat' 'pelage classic' 'pelage exact'"
set linetype 1 lc rgb "#d55e00" pt 8 lw 1.6 ps 1.1
set linetype 2 lc rgb "#e69f00" pt 4 lw 1.6 ps 1.1
set linetype 3 lc rgb "#009e73" pt 6 lw 1.6 ps 1.1
set linetype 4 lc rgb "#0072b2" pt 7 lw 2.4 ps 1.1
set datafile missing NaN
set logscale xy
set format y "10^{%T}"
set grid back lc rgb "#dddddd"
set border lc rgb "#666666"
set key font ",9" spacing 1.1
