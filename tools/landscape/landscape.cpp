// Makes the heights of a landscape: uplift against rivers, until valleys have grown into branches. Writes a PGM of 16
// bits to standard output; the same numbers on every machine with IEEE doubles.
//
// Based on: Braun and Willett, A very efficient O(n), implicit and parallel method to solve the stream power equation
// governing fluvial incision and landscape evolution, 2013; Cordonnier et al., Large Scale Terrain Generation from
// Tectonic Uplift and Fluvial Erosion, 2016. Departs from both: pits are left alone (they fill by what is lifted around
// them), and slopes are cut to an angle of repose that varies from place to place.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

namespace {

constexpr int kSide = 512;
constexpr double kSpacingM = 40000.0 / kSide, kHighestM = 3300.0;
constexpr std::size_t kCells = std::size_t{kSide} * kSide;

std::uint32_t mixed(std::uint32_t x) {
  x = (x ^ (x >> 16)) * 0x7feb352du;
  x = (x ^ (x >> 15)) * 0x846ca68bu;
  return x ^ (x >> 16);
}

double smooth(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

// In [-1, 1], between lattice points smooth.
double value_noise(double x, double y, std::uint32_t seed) {
  const double cell_x = std::floor(x), cell_y = std::floor(y);
  const double u = smooth(0, 1, x - cell_x), v = smooth(0, 1, y - cell_y);
  const auto corner = [&](int i, int j) {
    const auto column = static_cast<std::uint32_t>(static_cast<int>(cell_x) + i + 4096);
    const auto row = static_cast<std::uint32_t>(static_cast<int>(cell_y) + j + 4096);
    return mixed(column * 0x9e3779b9u ^ mixed(row * 0x85ebca6bu + seed)) / 2147483647.5 - 1.0;
  };
  const double south = corner(0, 0) + u * (corner(1, 0) - corner(0, 0));
  const double north = corner(0, 1) + u * (corner(1, 1) - corner(0, 1));
  return south + v * (north - south);
}

double octaves(double x_km, double y_km, double first_km, int count, std::uint32_t seed) {
  double sum = 0.0, gain = 1.0;
  for (int i = 0; i < count; ++i) {
    sum += gain * value_noise(x_km / first_km, y_km / first_km, seed + static_cast<std::uint32_t>(i));
    gain *= 0.5;
    first_km *= 0.5;
  }
  return sum;
}

struct Place {
  double x_km, y_km;  // from the map's middle
};
Place place_of(std::size_t cell) {
  const double spacing_km = kSpacingM / 1000.0;
  return {(static_cast<double>(cell % kSide) - 0.5 * (kSide - 1)) * spacing_km,
          (static_cast<double>(cell / kSide) - 0.5 * (kSide - 1)) * spacing_km};
}

// The great valley winds from south to north.
double from_valley_km(const Place& p) {
  return std::abs(p.x_km + 1.5 - 2.6 * std::sin(p.y_km / 5.5) - 1.2 * std::sin(p.y_km / 2.3 + 1.0) -
                  0.8 * octaves(p.x_km, p.y_km, 5.0, 2, 40));
}

// 1 in the map's middle, 0 near its edges.
double inland(const Place& p) {
  const double from_edge_km = 20.0 - std::max(std::abs(p.x_km), std::abs(p.y_km));
  return smooth(1.0, 9.0, from_edge_km + 2.5 * octaves(p.x_km, p.y_km, 9.0, 3, 7));
}

double uplift(const Place& p) {
  const double ranges = 0.75 + 0.5 * octaves(p.x_km, p.y_km, 11.0, 3, 3);
  return inland(p) * (0.04 + 0.96 * smooth(0.6, 6.0, from_valley_km(p))) * std::max(0.12, ranges);
}

class Rivers {
 public:
  Rivers() : height_m_(kCells), receiver_(kCells), slope_run_m_(kCells), area_m2_(kCells), order_(kCells) {
    for (std::size_t i = 0; i < kCells; ++i) {
      const Place p = place_of(i);
      edge_.push_back(inland(p) <= 0.0);
      uplift_.push_back(uplift(p));
      repose_.push_back(0.66 + 0.2 * octaves(p.x_km, p.y_km, 2.5, 3, 21));
      height_m_[i] = edge_[i] ? 0.0 : 30.0 + 60.0 * uplift_[i] + 25.0 * octaves(p.x_km, p.y_km, 3.0, 6, 11);
    }
  }

  void age(double years) {
    constexpr double kUpliftM = 1.1e-3, kErosion = 2.6e-6;  // metres a year; of the stream power law, a year
    for (std::size_t i = 0; i < kCells; ++i)
      if (!edge_[i]) height_m_[i] += kUpliftM * uplift_[i] * years;
    find_receivers();
    // Downstream first; then area flows down, and heights follow from the mouth upwards.
    std::fill(area_m2_.begin(), area_m2_.end(), kSpacingM * kSpacingM);
    for (std::size_t k = kCells; k-- > 0;)
      if (receiver_[order_[k]] != order_[k]) area_m2_[receiver_[order_[k]]] += area_m2_[order_[k]];
    for (const std::size_t i : order_) {
      const std::size_t to = receiver_[i];
      if (to == i || edge_[i]) continue;
      const double cut = kErosion * std::sqrt(area_m2_[i]) * years / slope_run_m_[i];
      height_m_[i] = (height_m_[i] + cut * height_m_[to]) / (1.0 + cut);
      height_m_[i] = std::min(height_m_[i], height_m_[to] + repose_[i] * slope_run_m_[i]);
    }
  }

  // Soil creeps from ridges into hollows.
  void creep(double share) {
    std::vector<double> smoothed = height_m_;
    for (std::size_t i = 0; i < kCells; ++i)
      if (!edge_[i])
        smoothed[i] +=
            share *
            (0.25 * (height_m_[i - 1] + height_m_[i + 1] + height_m_[i - kSide] + height_m_[i + kSide]) - height_m_[i]);
    height_m_ = smoothed;
  }

  std::vector<double>& height_m() { return height_m_; }

 private:
  void find_receivers() {
    for (std::size_t i = 0; i < kCells; ++i) {
      receiver_[i] = i;
      if (edge_[i]) continue;
      double steepest = 0.0;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          if (dx == 0 && dy == 0) continue;
          const std::size_t to = i + static_cast<std::size_t>(dy * kSide + dx);  // an inland cell is off the border
          const double run_m = kSpacingM * (dx != 0 && dy != 0 ? std::sqrt(2.0) : 1.0);
          const double slope = (height_m_[i] - height_m_[to]) / run_m;
          if (slope <= steepest) continue;
          steepest = slope;
          receiver_[i] = to;
          slope_run_m_[i] = run_m;
        }
    }
    for (std::size_t i = 0; i < kCells; ++i) order_[i] = i;
    std::stable_sort(order_.begin(), order_.end(),
                     [&](std::size_t a, std::size_t b) { return height_m_[a] < height_m_[b]; });
  }

  std::vector<double> height_m_;
  std::vector<std::size_t> receiver_;
  std::vector<double> slope_run_m_, area_m2_;
  std::vector<std::size_t> order_;  // from low to high
  std::vector<char> edge_;
  std::vector<double> uplift_, repose_;
};

}  // namespace

int main() {
  Rivers rivers;
  for (int i = 0; i < 240; ++i) {
    rivers.age(i < 180 ? 25000.0 : 6000.0);
    rivers.creep(0.12);
  }
  std::vector<double> height_m = rivers.height_m();
  double highest_m = 0.0;
  for (const double h : height_m) highest_m = std::max(highest_m, h);
  std::printf("P5\n%d %d\n65535\n", kSide, kSide);
  for (int row = kSide - 1; row >= 0; --row)
    for (int column = 0; column < kSide; ++column) {
      const std::size_t i = static_cast<std::size_t>(row) * kSide + static_cast<std::size_t>(column);
      const Place p = place_of(i);
      double h = height_m[i] * (kHighestM / highest_m);
      // What the rivers brought lies level on the floor of the great valley; a round join where it meets the slopes.
      const double floor_m =
          (260.0 + 6.0 * p.y_km) * smooth(0.0, 1.0, inland(p)) * (1.0 - smooth(2.2, 4.5, from_valley_km(p)));
      const double over = h - floor_m;
      h = floor_m > 0.0
              ? floor_m + 0.5 * (over + std::sqrt(over * over + 40.0 * 40.0)) - 20.0 * smooth(40.0, -40.0, over)
              : h;
      const auto value = static_cast<std::uint32_t>(std::lround(std::clamp(h / kHighestM, 0.0, 1.0) * 65535.0));
      std::putchar(static_cast<int>(value >> 8));
      std::putchar(static_cast<int>(value & 255u));
    }
}
