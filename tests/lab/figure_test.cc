#include "lab/experiments/figure.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <limits>
#include <string>

#include "core/file_bytes.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

Figure SmallFigure() {
  Figure figure;
  figure.name = "09_neighbors";
  figure.title = "Neighbors of a \"keypoint\"";
  figure.x_label = "k";
  figure.y_label = "average precision";
  figure.log_x = true;
  figure.series = {{"range", {{1.0, {0.5, 0.4, 0.6}}, {4.0, {0.75, 0.7, 0.8}}}},
                   {"kNN", {{1.0, {0.25, 0.125, 0.375}}}}};
  return figure;
}

TEST(GnuplotScript, HoldsDataAndDrawsBothPictures) {
  EXPECT_EQ(
      GnuplotScript(SmallFigure()),
      R"(# Draws 09_neighbors.svg and 09_neighbors.png. Bars are 95 % bootstrap intervals. Series stand side by side.
set encoding utf8
set termoption noenhanced
set title "Neighbors of a \"keypoint\""
set xlabel "k"
set ylabel "average precision"
set grid
set key tmargin center horizontal
set logscale x
$series0 << EOD
0.993092 0.5 0.4 0.6
3.97237 0.75 0.7 0.8
EOD
$series1 << EOD
1.00696 0.25 0.125 0.375
EOD
set terminal svg noenhanced size 720,480 font "sans,12" background "white"
set output "09_neighbors.svg"
plot $series0 using 1:2:3:4 with yerrorlines linewidth 2 pointtype 4 title "range", $series1 using 1:2:3:4 with yerrorlines linewidth 2 pointtype 5 title "kNN"
set terminal pngcairo noenhanced size 720,480 font "sans,11"
set output "09_neighbors.png"
plot $series0 using 1:2:3:4 with yerrorlines linewidth 2 pointtype 4 title "range", $series1 using 1:2:3:4 with yerrorlines linewidth 2 pointtype 5 title "kNN"
)");
}

TEST(GnuplotScript, NamesCategories) {
  Figure figure = SmallFigure();
  figure.x_names = {"none", "both"};
  const std::string script = GnuplotScript(figure);
  EXPECT_NE(script.find("set xtics rotate by -25 (\"none\" 0, \"both\" 1)\nset xrange [-0.5:1.5]"),
            std::string::npos);
  EXPECT_NE(script.find("with yerrorbars"), std::string::npos);
}

TEST(GnuplotScript, LeavesOutWhatIsNotANumber) {
  Figure figure = SmallFigure();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  figure.series[1].points[0].y = {nan, nan, nan};
  EXPECT_NE(GnuplotScript(figure).find("$series1 << EOD\nEOD\n"), std::string::npos);
}

TEST(WriteFigure, WritesTheScriptWithoutGnuplotToo) {
  const testing::TempDir folder;
  const std::string path = std::getenv("PATH");
  setenv("PATH", folder.path().c_str(), 1);  // Where there is no gnuplot.
  const bool drawn = WriteFigure(SmallFigure(), folder.path().string());
  setenv("PATH", path.c_str(), 1);
  EXPECT_FALSE(drawn);
  EXPECT_EQ(ReadTextFile(folder.File("09_neighbors.gp"), 1 << 20), GnuplotScript(SmallFigure()));
}

TEST(WriteFigure, DrawsSvgAndPng) {
  if (std::system("gnuplot --version > /dev/null 2>&1") != 0) {
    GTEST_SKIP() << "gnuplot is not installed";
  }
  const testing::TempDir folder;
  EXPECT_TRUE(WriteFigure(SmallFigure(), folder.path().string()));
  EXPECT_NE(ReadTextFile(folder.File("09_neighbors.svg"), 1 << 20).find("average precision"),
            std::string::npos);
  EXPECT_GT(std::filesystem::file_size(folder.File("09_neighbors.png")), 1000u);
}

}  // namespace
}  // namespace cairn
