#include "tools/sweep_plots.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <functional>
#include <map>
#include <optional>
#include <sstream>

#include "engine/atomic_file.h"

namespace nephele::tools {
namespace {

constexpr double kSmallPass = 0.02;  // of the dearest variant's total: what is below is drawn as "other"

// Twelve colours that tell apart on white.
constexpr const char* kLooks =
    "colors = '#1f77b4 #d62728 #2ca02c #ff7f0e #9467bd #8c564b #e377c2 #7f7f7f #bcbd22 #17becf #0b3d62 #8c1c1c'\n"
    "do for [i=1:12] { set linetype i linecolor rgb word(colors, i) }\nset linetype cycle 12\n"
    "set format '%g'\n";

constexpr const char* kTerminal = "\nset terminal svg noenhanced background '#ffffff' font 'Helvetica,12' size 900,";

// Both axes logarithmic; along x, ticks at 1, 2 and 5, since few decades are seen there.
std::string logarithmic_axes() {
  std::string ticks;
  for (const char* decade : {"e-1", "e0", "e1", "e2", "e3", "e4", "e5", "e6", "e7"})
    for (const char* digit : {"1", "2", "5"}) ticks += std::string(ticks.empty() ? "" : ", ") + digit + decade;
  return "set logscale xy\nset xtics (" + ticks + ")\nset key outside right top\n";
}

// A gnuplot string or data field. Quotes would end it, backslashes and braces mean something.
std::string gnuplot_text(const std::string& text) {
  std::string safe = "\"";
  for (const char c : text) safe += c == '"' || c == '\\' || c == '{' || c == '}' || c == '\n' ? ' ' : c;
  return safe + '"';
}

std::string file_stem(const std::string& text) {
  std::string stem;
  for (const char c : text) stem += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return stem;
}

template <class Key>
std::vector<std::string> in_order(const std::vector<SweepRow>& rows, Key&& key) {
  std::vector<std::string> names;
  for (const SweepRow& row : rows)
    if (std::find(names.begin(), names.end(), key(row)) == names.end()) names.push_back(key(row));
  return names;
}

std::vector<const SweepRow*> rows_of_scene(const std::vector<SweepRow>& rows, const std::string& scene) {
  std::vector<const SweepRow*> own;
  for (const SweepRow& row : rows)
    if (row.variant->scene == scene) own.push_back(&row);
  return own;
}

// One curve: a named data block of points with labels, in order of x.
struct Point {
  double x, y;
  std::string label;
};
class Plot {
 public:
  Plot(std::ostream& script, std::string stem, const std::string& title, const std::string& x, const std::string& y)
      : script_(script), stem_(std::move(stem)) {
    script_ << "\nset output '" << stem_ << ".svg'\nset title " << gnuplot_text(title) << "\nset xlabel "
            << gnuplot_text(x) << "\nset ylabel " << gnuplot_text(y) << '\n';
  }
  void curve(const std::string& title, std::vector<Point> points, const std::string& style, bool labels) {
    std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.x < b.x; });
    const std::string block = "$" + stem_ + "_" + std::to_string(count_++);
    script_ << block << " << EOD\n";
    for (const Point& point : points) script_ << point.x << ' ' << point.y << ' ' << gnuplot_text(point.label) << '\n';
    script_ << "EOD\n";
    plots_ +=
        (plots_.empty() ? "plot " : ", \\\n  ") + block + " using 1:2 with " + style + " title " + gnuplot_text(title);
    if (labels)
      plots_ +=
          ", \\\n  " + block + " using 1:2:3 with labels offset 0.6,0.5 left font ',8' textcolor rgb '#666666' notitle";
  }
  ~Plot() { script_ << plots_ << '\n'; }
  Plot(const Plot&) = delete;
  Plot& operator=(const Plot&) = delete;

 private:
  std::ostream& script_;
  std::string stem_, plots_;
  int count_ = 0;
};

std::string marks(std::size_t index) {
  return " linetype " + std::to_string(index + 1) + " pointtype " + std::to_string(index + 4) + " pointsize 0.8";
}

void error_plot(std::ostream& script, const std::string& scene, const std::vector<const SweepRow*>& rows) {
  std::vector<Point> front;
  std::map<std::string, std::vector<Point>> series;
  std::vector<std::string> names;
  for (const SweepRow* row : rows) {
    if (!row->errors || !(row->errors->relmse > 0))
      continue;  // the reference itself has no place on a logarithmic axis
    if (!series.contains(row->variant->series)) names.push_back(row->variant->series);
    series[row->variant->series].push_back({row->ms.median, row->errors->relmse, ""});
    if (row->on_front)
      front.push_back({row->ms.median, row->errors->relmse, row->variant->series + ' ' + row->variant->place});
  }
  if (names.empty()) return;
  script << kTerminal << "620\n" << logarithmic_axes();
  Plot plot(script, "error_" + file_stem(scene), scene + ": error against time", "ms a frame (median)", "relMSE");
  if (!front.empty()) plot.curve("Pareto front", front, "steps linewidth 2 linecolor rgb '#bbbbbb'", true);
  for (std::size_t i = 0; i < names.size(); ++i) plot.curve(names[i], series[names[i]], "points" + marks(i), false);
}

void passes_plot(std::ostream& script, const std::string& scene, const std::vector<const SweepRow*>& rows) {
  double dearest = 0;
  std::map<std::string, double> largest;
  std::vector<std::string> passes;
  for (const SweepRow* row : rows) {
    double total = 0;
    for (const auto& [name, ms] : row->passes_ms) {
      total += ms;
      if (!largest.contains(name)) passes.push_back(name);
      largest[name] = std::max(largest[name], ms);
    }
    dearest = std::max(dearest, total);
  }
  std::erase_if(passes, [&](const std::string& name) { return largest[name] < kSmallPass * dearest; });
  if (passes.empty()) return;

  const std::string stem = "passes_" + file_stem(scene);
  script << kTerminal << 160 + 18 * rows.size() << "\nunset logscale\nset xtics autofreq\n"
         << "set output '" << stem << ".svg'\nset title " << gnuplot_text(scene + ": cost by pass")
         << "\nset xlabel \"ms (medians)\"\nunset ylabel\n"
         << "set key outside bottom center maxrows 3\nset yrange [" << static_cast<double>(rows.size()) - 0.4
         << ":-0.6]\n$" << stem << " << EOD\n";
  for (const SweepRow* row : rows) {
    double rest = 0;
    for (const auto& [name, ms] : row->passes_ms)
      if (std::find(passes.begin(), passes.end(), name) == passes.end()) rest += ms;
    script << gnuplot_text(row->variant->series + ' ' + row->variant->place);
    for (const std::string& pass : passes) {
      const auto found = std::find_if(row->passes_ms.begin(), row->passes_ms.end(),
                                      [&](const auto& own) { return own.first == pass; });
      script << ' ' << (found == row->passes_ms.end() ? 0 : found->second);
    }
    script << ' ' << rest << '\n';
  }
  script << "EOD\n";
  // Horizontal stacked bars: each pass is a box from the sum of those before it to the sum with it.
  passes.emplace_back("other");
  std::string sum = "0", plots;
  for (std::size_t i = 0; i < passes.size(); ++i) {
    const std::string with = sum + "+$" + std::to_string(i + 2);
    plots += (plots.empty() ? "plot $" : ", \\\n  $") + stem + " using (" + sum + "):0:(" + sum + "):(" + with +
             "):($0-0.38):($0+0.38)" + (i == 0 ? ":ytic(1)" : "") + " with boxxyerror fillstyle solid 0.85 linetype " +
             std::to_string(i + 1) + " title " + gnuplot_text(passes[i]);
    sum = with;
  }
  script << plots << "\nunset yrange\nset ytics autofreq\n";
}

// The cost of every series in every scene that varies `along`, against x.
void cost_plot(std::ostream& script, const std::vector<SweepRow>& rows, const std::string& stem,
               const std::string& x_label, const std::function<std::optional<double>(const SweepRow&)>& x_of) {
  std::map<std::string, std::vector<Point>> curves;
  const auto curve_of = [](const SweepRow& row) { return row.variant->scene + ", " + row.variant->series; };
  for (const SweepRow& row : rows)
    if (const auto x = x_of(row)) curves[curve_of(row)].push_back({*x, row.ms.median, row.variant->place});
  std::erase_if(curves, [](const auto& curve) {
    return std::all_of(curve.second.begin(), curve.second.end(),
                       [&](const Point& p) { return p.x == curve.second.front().x; });
  });
  if (curves.empty()) return;
  script << "\nset terminal svg noenhanced size 900,520 background '#ffffff' font 'Helvetica,12'\nset logscale xy\nset "
            "key outside right top\n";
  Plot plot(script, stem, "Cost against " + x_label, x_label, "ms a frame (median)");
  std::size_t index = 0;
  for (const std::string& name : in_order(rows, curve_of))
    if (curves.contains(name)) plot.curve(name, curves[name], "linespoints linewidth 1.5" + marks(index++), true);
}

constexpr const char* kDistance = "scene.clouds.view_distance_m";

bool varies(const SweepRow& row, const char* axis) { return row.variant->axes.contains(axis); }

}  // namespace

std::string sweep_plot_script(const std::vector<SweepRow>& rows) {
  std::ostringstream script;
  script
      << "# Written by nephele sweep; run: gnuplot plots.gp\nset encoding utf8\nset grid back linecolor rgb '#dddddd'\n"
      << kLooks;
  for (const std::string& scene : in_order(rows, [](const SweepRow& row) { return row.variant->scene; })) {
    const std::vector<const SweepRow*> own = rows_of_scene(rows, scene);
    error_plot(script, scene, own);
    passes_plot(script, scene, own);
  }
  cost_plot(script, rows, "cost_particles", "particles", [](const SweepRow& row) -> std::optional<double> {
    if (!varies(row, "quality") && !varies(row, "ring_size_cells") && !varies(row, "layers")) return std::nullopt;
    return static_cast<double>(row.work_of("particles_generated"));
  });
  cost_plot(script, rows, "cost_pixels", "pixels", [](const SweepRow& row) -> std::optional<double> {
    if (!varies(row, "resolution")) return std::nullopt;
    return double(row.variant->picture.render.width) * row.variant->picture.render.height;
  });
  cost_plot(script, rows, "cost_distance", "view distance, m", [](const SweepRow& row) -> std::optional<double> {
    if (!varies(row, kDistance)) return std::nullopt;
    return row.variant->axes.at(kDistance).get<double>();
  });
  return script.str();
}

Result<void> write_sweep_plots(const std::string& directory, const std::vector<SweepRow>& rows) {
  if (auto written = write_file_atomically(directory + "/plots.gp", sweep_plot_script(rows)); !written) return written;

  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addchdir_np(&actions, directory.c_str());
  std::string program = "gnuplot", script = "plots.gp";
  char* const argv[] = {program.data(), script.data(), nullptr};
  pid_t child = 0;
  const int spawned = ::posix_spawnp(&child, program.c_str(), &actions, nullptr, argv, environ);
  ::posix_spawn_file_actions_destroy(&actions);
  int status = 0;
  if (spawned != 0 || ::waitpid(child, &status, 0) != child || status != 0)
    std::fprintf(
        stderr,
        "nephele: no plots were drawn: they need gnuplot (Debian package gnuplot-nox); then run it on %s/plots.gp\n",
        directory.c_str());
  return {};
}

}  // namespace nephele::tools
