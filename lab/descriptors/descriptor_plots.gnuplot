# Draws the tables of cairn_fit_descriptor_model:
#   gnuplot -e "tables='DIR'; images='docs/images'" descriptor_plots.gnuplot
set datafile separator ","
set datafile missing ""
set terminal svg size 720,440 font "Helvetica,13" background "white"
set grid lc rgb "#dddddd"
set key bottom right

set output images."/descriptor_spectrum.svg"
set logscale y
set key top right
set xlabel "principal axis"
set ylabel "standard deviation of RootSIFT"
plot tables."/spectrum.csv" using 1:2 skip 1 with points pt 7 ps 0.4 lc rgb "#1b6ca8" title "drive", \
     "" using 1:4 skip 1 with points pt 7 ps 0.4 lc rgb "#c0392b" title "walk", \
     "" using 1:3 skip 1 with lines lw 2 lc rgb "#1b6ca8" title "model, drive", \
     "" using 1:5 skip 1 with lines lw 2 lc rgb "#c0392b" title "model, walk"
unset logscale y

set output images."/descriptor_angle.svg"
set key bottom right
set xlabel "difference of viewing angle, rad (difference of scale below 2^{0.3})"
set ylabel "median distance of two looks at one landmark"
set yrange [0:0.5]
plot tables."/angle.csv" using 1:2 skip 1 with points pt 7 lc rgb "#1b6ca8" title "drive", \
     "" using 1:3 skip 1 with lines lw 2 lc rgb "#1b6ca8" title "model", \
     "" using 1:6 skip 1 with points pt 5 lc rgb "#27ae60" title "rendered street", \
     "" using 1:7 skip 1 with lines lw 2 lc rgb "#27ae60" title "model", \
     "" using 1:8 skip 1 with points pt 9 lc rgb "#8e44ad" title "facade, other days", \
     "" using 1:9 skip 1 with lines lw 2 lc rgb "#8e44ad" title "model"

set output images."/descriptor_scale.svg"
set xlabel "difference of log_2 scale (difference of angle below 0.1 rad)"
plot tables."/scale.csv" using 1:2 skip 1 with points pt 7 lc rgb "#1b6ca8" title "drive", \
     "" using 1:3 skip 1 with lines lw 2 lc rgb "#1b6ca8" title "model", \
     "" using 1:4 skip 1 with points pt 5 lc rgb "#c0392b" title "walk", \
     "" using 1:5 skip 1 with lines lw 2 lc rgb "#c0392b" title "model", \
     "" using 1:6 skip 1 with points pt 9 lc rgb "#27ae60" title "rendered street (not fitted)"
unset yrange

set output images."/descriptor_nearest.svg"
set xlabel "distance to the nearest of so many others"
set ylabel "share of descriptors"
set key top left
plot tables."/nearest.csv" using 2:1 skip 1 with points pt 7 ps 0.4 lc rgb "#1b6ca8" title "drive, 100", \
     "" using 3:1 skip 1 with lines lw 2 lc rgb "#1b6ca8" title "model, 100", \
     "" using 4:1 skip 1 with points pt 7 ps 0.4 lc rgb "#c0392b" title "drive, 1,000", \
     "" using 5:1 skip 1 with lines lw 2 lc rgb "#c0392b" title "model, 1,000", \
     "" using 6:1 skip 1 with points pt 7 ps 0.4 lc rgb "#27ae60" title "drive, 2,500", \
     "" using 7:1 skip 1 with lines lw 2 lc rgb "#27ae60" title "model, 2,500"

set output images."/descriptor_same_and_other.svg"
set xlabel "distance: own landmark (left), nearest of 1,000 others (right)"
set key bottom right
plot tables."/same_and_other.csv" using 2:1 skip 1 with points pt 7 ps 0.4 lc rgb "#1b6ca8" title "drive", \
     "" using 3:1 skip 1 with points pt 7 ps 0.4 lc rgb "#1b6ca8" notitle, \
     "" using 4:1 skip 1 with lines lw 2 lc rgb "#1b6ca8" title "model, drive", \
     "" using 5:1 skip 1 with lines lw 2 lc rgb "#1b6ca8" notitle, \
     "" using 6:1 skip 1 with points pt 7 ps 0.4 lc rgb "#c0392b" title "walk", \
     "" using 7:1 skip 1 with points pt 7 ps 0.4 lc rgb "#c0392b" notitle, \
     "" using 8:1 skip 1 with lines lw 2 lc rgb "#c0392b" title "model, walk", \
     "" using 9:1 skip 1 with lines lw 2 lc rgb "#c0392b" notitle

set output images."/descriptor_crowd.svg"
set logscale x
set key top right
set xlabel "number of others"
set ylabel "median distance to the nearest"
plot tables."/crowd.csv" using 1:2 skip 1 with points pt 7 lc rgb "#1b6ca8" title "10,000 descriptors of web images", \
     "" using 1:3 skip 1 with lines lw 2 lc rgb "#c0392b" title "model"
