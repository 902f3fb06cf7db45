#include "lab/experiments/figure.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

#include "core/file_bytes.h"

extern char** environ;

namespace cairn {
namespace {

// Returns a gnuplot string in double quotes.
std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char letter : text) {
    if (letter == '"' || letter == '\\') {
      quoted += '\\';
    }
    quoted += letter == '\n' ? ' ' : letter;
  }
  return quoted + "\"";
}

std::string XTics(const Figure& figure) {
  if (figure.x_names.empty()) {
    return "";
  }
  std::string tics;
  for (size_t i = 0; i < figure.x_names.size(); ++i) {
    tics += fmt::format("{}{} {}", i == 0 ? "" : ", ", Quoted(figure.x_names[i]), i);
  }
  return fmt::format("set xtics rotate by -25 ({})\nset xrange [-0.5:{}]\n", tics,
                     static_cast<double>(figure.x_names.size()) - 0.5);
}

// The smallest and the largest x of a figure.
std::pair<double, double> RangeOfX(const Figure& figure) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const FigureSeries& series : figure.series) {
    for (const FigurePoint& point : series.points) {
      if (std::isfinite(point.x) && (point.x > 0.0 || !figure.log_x)) {
        low = std::min(low, point.x);
        high = std::max(high, point.x);
      }
    }
  }
  return {low, high};
}

// Where a point is drawn: the intervals of several series at one x would hide each other, so each
// series stands a little beside the next, by a hundredth of the axis or a twelfth of a name's
// place.
double DrawnX(const Figure& figure, size_t series_idx, double x) {
  const double steps =
      static_cast<double>(series_idx) - 0.5 * (static_cast<double>(figure.series.size()) - 1.0);
  const auto [low, high] = RangeOfX(figure);
  if (!figure.x_names.empty()) {
    return x + steps / 12.0;
  }
  if (!(high > low)) {
    return x;
  }
  return figure.log_x ? x * std::pow(high / low, 0.01 * steps) : x + 0.01 * steps * (high - low);
}

std::string DataBlock(const Figure& figure, size_t series_idx) {
  std::string block = fmt::format("$series{} << EOD\n", series_idx);
  for (const FigurePoint& point : figure.series[series_idx].points) {
    if (std::isfinite(point.x) && std::isfinite(point.y.value)) {
      block += fmt::format("{:.6g} {:.6g} {:.6g} {:.6g}\n", DrawnX(figure, series_idx, point.x),
                           point.y.value, point.y.low, point.y.high);
    }
  }
  return block + "EOD\n";
}

std::string PlotCommand(const Figure& figure) {
  std::string command = "plot";
  for (size_t i = 0; i < figure.series.size(); ++i) {
    command +=
        fmt::format("{} $series{} using 1:2:3:4 with {} linewidth 2 pointtype {} title {}",
                    i == 0 ? "" : ",", i, figure.x_names.empty() ? "yerrorlines" : "yerrorbars",
                    4 + i, Quoted(figure.series[i].label));
  }
  return command + "\n";
}

// Runs `gnuplot <script>` in `folder`. Returns true if it succeeded.
bool RunGnuplot(const std::string& script, const std::string& folder) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  std::string program = "gnuplot";
  std::string argument = script;
  char* arguments[] = {program.data(), argument.data(), nullptr};
  pid_t child = 0;
  const int failure = posix_spawnp(&child, "gnuplot", &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failure != 0) {
    return false;
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace

std::string GnuplotScript(const Figure& figure) {
  std::string script = fmt::format(
      "# Draws {0}.svg and {0}.png. Bars are 95 % bootstrap intervals. Series stand side by side.\n"
      "set encoding utf8\n"
      "set termoption noenhanced\n"
      "set title {1}\n"
      "set xlabel {2}\n"
      "set ylabel {3}\n"
      "set grid\n"
      "set key tmargin center horizontal\n",  // Below, it would cover the names of the axis.
      figure.name, Quoted(figure.title), Quoted(figure.x_label), Quoted(figure.y_label));
  script += figure.log_x ? "set logscale x\n" : "";
  script += figure.log_y ? "set logscale y\n" : "";
  script += XTics(figure);
  for (size_t i = 0; i < figure.series.size(); ++i) {
    script += DataBlock(figure, i);
  }
  const std::string plot = PlotCommand(figure);
  script += fmt::format(
      "set terminal svg noenhanced size 720,480 font \"sans,12\" background \"white\"\n"
      "set output {}\n{}",
      Quoted(figure.name + ".svg"), plot);
  script += fmt::format(
      "set terminal pngcairo noenhanced size 720,480 font \"sans,11\"\n"
      "set output {}\n{}",
      Quoted(figure.name + ".png"), plot);
  return script;
}

bool WriteFigure(const Figure& figure, const std::string& folder) {
  const std::string script_name = figure.name + ".gp";
  const std::filesystem::path path(folder);
  WriteTextFile((path / script_name).string(), GnuplotScript(figure));
  return RunGnuplot(script_name, folder) &&
         std::filesystem::exists(path / (figure.name + ".svg")) &&
         std::filesystem::exists(path / (figure.name + ".png"));
}

}  // namespace cairn
