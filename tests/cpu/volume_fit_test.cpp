// Volumes as particles: what must hold exactly (mass, moments, the lattice's place), what must be smooth, and how far
// the particles may be from the volume. The profile's constants are checked by quadrature, rays by closed forms.
#include "tools/clouds/volume_fit.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "shared/volume_moments.h"
#include "tools/clouds/particle_chords.h"
#include "tools/clouds/particle_grid.h"
#include "tools/clouds/volume_verify.h"
#include "tools/sample_volume/cumulus_volume.h"

using namespace nephele;
using namespace nephele::clouds;

namespace {

VolumeGrid cube(std::size_t n, double voxel_m, const glm::dvec3& corner_m = glm::dvec3(0.0)) {
  VolumeGrid grid;
  for (int axis = 0; axis < 3; ++axis)
    grid.bounds_m[static_cast<std::size_t>(axis)] = even_bounds(n, corner_m[axis], voxel_m);
  return grid;
}

template <class Value>
MemoryVolume volume_of(const VolumeGrid& grid, Value&& value) {
  std::vector<float> values;
  const auto middle = [&](std::size_t axis, std::size_t i) {
    return 0.5 * (grid.bounds_m[axis][i] + grid.bounds_m[axis][i + 1]);
  };
  for (std::size_t z = 0; z < grid.count(2); ++z)
    for (std::size_t y = 0; y < grid.count(1); ++y)
      for (std::size_t x = 0; x < grid.count(0); ++x)
        values.push_back(static_cast<float>(value(glm::dvec3(middle(0, x), middle(1, y), middle(2, z)))));
  return MemoryVolume(grid, std::move(values));
}

MemoryVolume cumulus(std::size_t n, const std::array<double, 3>& shift_m = {}) {
  std::vector<float> values(n * n * n);
  sample::for_cumulus_voxels(n, shift_m, [&](std::size_t x, std::size_t y, std::size_t z, float value) {
    values[(z * n + y) * n + x] = value;
  });
  return MemoryVolume(cube(n, sample::kCumulusSideM / static_cast<double>(n)), std::move(values));
}

double mass_of(const MemoryVolume& volume) {
  double mass = 0.0;
  for (std::size_t z = 0; z < volume.grid().count(2); ++z)
    for (std::size_t y = 0; y < volume.grid().count(1); ++y)
      for (std::size_t x = 0; x < volume.grid().count(0); ++x) {
        double m3 = 1.0;
        const std::array<std::size_t, 3> at{x, y, z};
        for (std::size_t axis = 0; axis < 3; ++axis)
          m3 *= volume.grid().bounds_m[axis][at[axis] + 1] - volume.grid().bounds_m[axis][at[axis]];
        mass += m3 * static_cast<double>(volume.at(x, y, z));
      }
  return mass;
}

VolumeFit fitted(VolumeReader& reader, const FitOptions& options) {
  Result<VolumeFit> fit = fit_volume(reader, options);
  if (!fit) FAIL(fit.error().message);
  return std::move(*fit);
}

glm::dvec3 centroid(const ParticleSet& set) {
  glm::dvec3 sum(0.0);
  double mass = 0.0;
  for (const SetParticle& p : set.particles) {
    const ParticleSet one{.particles = {p}};
    const double m = particle_mass_m2(one);
    sum += m * glm::dvec3(p.center_m);
    mass += m;
  }
  return sum / mass;
}

// The same volume with another order of axes.
class Turned : public VolumeReader {
 public:
  explicit Turned(const MemoryVolume& inner) : inner_(inner) {}
  const VolumeGrid& grid() const override { return inner_.grid(); }
  std::array<int, 3> axes() const override { return {2, 0, 1}; }
  Result<void> read_planes(std::size_t first, std::size_t count, std::span<float> values) override {
    std::size_t at = 0;
    for (std::size_t y = first; y < first + count; ++y)
      for (std::size_t x = 0; x < grid().count(0); ++x)
        for (std::size_t z = 0; z < grid().count(2); ++z) values[at++] = inner_.at(x, y, z);
    return {};
  }

 private:
  const MemoryVolume& inner_;
};

}  // namespace

TEST_CASE("volume fit: fill and variance of the profile are what quadrature gives") {
  double mass = 0.0, square = 0.0;
  constexpr int kSteps = 100000;
  for (int i = 0; i < kSteps; ++i) {
    const double r = (i + 0.5) / kSteps, q = 1.0 - r * r;
    const double p = static_cast<double>(shared::particle_profile(static_cast<float>(q), 0u));
    mass += 3.0 * p * r * r / kSteps;
    square += p * r * r * r * r / kSteps;
  }
  // The profile is a float: seven digits, of a few times its value.
  CHECK(std::abs(mass - static_cast<double>(shared::kProfileFill)) < 1e-6);
  CHECK(std::abs(square / (mass / 3.0) / 3.0 - static_cast<double>(shared::kProfileVariance)) < 1e-6);
}

TEST_CASE("volume fit: windows sum to one everywhere, for any edge") {
  for (const float edge : {0.0f, 0.3f, 0.7f, 1.0f})
    for (int i = 0; i <= 100; ++i) {
      const float t = static_cast<float>(i) / 100.0f;
      const float upper = shared::window_share(t, edge);
      CHECK(upper >= 0.0f);
      CHECK(upper <= 1.0f);
      if (edge > 0.0f) CHECK(std::abs(upper + shared::window_share(1.0f - t, edge) - 1.0f) < 1e-6f);
    }
}

TEST_CASE("volume fit: a node's moments become a particle that has them") {
  // Principal variances along a known turned frame: the shape must be the symmetric root, not any other.
  const double angle = 0.6, c = std::cos(angle), s = std::sin(angle);
  const glm::dmat3 turn(c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0);
  const glm::dvec3 radius(90.0, 40.0, 25.0), place(3.0, -7.0, 11.0);
  glm::dmat3 spread(0.0);
  for (int i = 0; i < 3; ++i) spread[i][i] = radius[i] * radius[i] * 0.12500266871624077;  // in closed form
  const glm::dmat3 covariance = turn * spread * glm::transpose(turn);
  const double mass = 5000.0;
  const shared::MomentParticle p = shared::particle_of_moments(
      {static_cast<float>(mass), glm::vec3(mass * place),
       glm::vec3(mass * (glm::dvec3(covariance[0][0], covariance[1][1], covariance[2][2]) + place * place)),
       glm::vec3(mass * (covariance[1][0] + place.x * place.y), mass * (covariance[2][0] + place.x * place.z),
                 mass * (covariance[2][1] + place.y * place.z))},
      1.0f);
  glm::dmat3 sizes(0.0);
  for (int i = 0; i < 3; ++i) sizes[i][i] = radius[i];
  const glm::dmat3 shape = turn * sizes * glm::transpose(turn);
  const double slack = 90.0 * 1e-5;  // floats, after a difference of squares
  CHECK(std::abs(static_cast<double>(p.diagonal_m.x) - shape[0][0]) < slack);
  CHECK(std::abs(static_cast<double>(p.diagonal_m.y) - shape[1][1]) < slack);
  CHECK(std::abs(static_cast<double>(p.diagonal_m.z) - shape[2][2]) < slack);
  CHECK(std::abs(static_cast<double>(p.off_diagonal_m.x) - shape[1][0]) < slack);
  CHECK(std::abs(static_cast<double>(p.off_diagonal_m.y)) < slack);
  const double own = static_cast<double>(p.extinction_per_m) * 0.41593073593073593 * 4.0 / 3.0 * 3.141592653589793 *
                     radius.x * radius.y * radius.z;
  CHECK(std::abs(own / mass - 1.0) < 1e-5);
}

TEST_CASE("volume fit: mass is exact whatever is dropped, on every level; centroids too where nothing is") {
  MemoryVolume volume = cumulus(64);
  const double mass = mass_of(volume);
  for (const double drop : {0.0, 0.004, 0.2})
    for (const double edge : {0.0, 0.5, 1.0}) {
      const VolumeFit fit = fitted(volume, {.spacing_voxels = 3.0, .soft_edge = edge, .drop = drop});
      CHECK(std::abs(fit.stats.mass_m2 / mass - 1.0) < 1e-9);  // sums of doubles
      std::vector<ParticleSet> levels{fit.set};
      levels.insert(levels.end(), fit.set.coarser.begin(), fit.set.coarser.end());
      CHECK(levels.size() >= 4);
      for (const ParticleSet& level : levels) {
        CHECK(check_particle_set(level));
        CHECK(level.shape == ParticleShape::soft);
        CHECK(std::abs(particle_mass_m2(level) / mass - 1.0) < 1e-5);
        if (drop == 0.0) CHECK(glm::length(centroid(level) - centroid(fit.set)) < 0.01);
      }
      for (std::size_t i = 1; i < levels.size(); ++i)
        CHECK(levels[i].particles.size() < levels[i - 1].particles.size() / 2 + 8);
    }
}

TEST_CASE("volume fit: coarser windows sum to one too, so uniform matter gives every inner node the same") {
  MemoryVolume volume = volume_of(cube(48, 10.0), [](const glm::dvec3&) { return 0.01; });
  FitOptions options{.spacing_voxels = 2.0, .vertical_spacing_voxels = 2.0};
  const Result<NodeLattice> fine = gather_nodes(volume, options);
  REQUIRE(fine);
  const NodeLattice coarse = coarser_nodes(*fine);
  CHECK(coarse.spacing_m.x == 40.0);
  std::size_t inner = 0;
  for (const Node& node : coarse.nodes) {
    bool inside = true;
    for (int axis = 0; axis < 3; ++axis) inside = inside && node.index[axis] > 1 && node.index[axis] < 10;
    if (!inside) continue;
    ++inner;
    CHECK(std::abs(node.mass_m2 / (0.01 * 40.0 * 40.0 * 40.0) - 1.0) < 1e-6);
    CHECK(glm::length(node.first) / node.mass_m2 < 1e-6);
  }
  CHECK(inner == 8u * 8u * 8u);
}

TEST_CASE("volume fit: one small blob in one window keeps its moments") {
  // Uniform in a box of 2 x 2 x 2 voxels around a node, where the window is 1: variance side^2 / 12.
  const double voxel_m = 10.0;
  VolumeGrid grid = cube(24, voxel_m);
  MemoryVolume volume = volume_of(grid, [](const glm::dvec3& p) {
    return glm::all(glm::lessThan(glm::abs(p - glm::dvec3(120.0)), glm::dvec3(10.0))) ? 0.05 : 0.0;
  });
  const VolumeFit fit = fitted(volume, {.spacing_voxels = 4.0, .vertical_spacing_voxels = 4.0, .soft_edge = 0.5});
  REQUIRE(fit.set.particles.size() == 1);
  const SetParticle& p = fit.set.particles[0];
  CHECK(glm::length(glm::dvec3(p.center_m) - glm::dvec3(120.0)) < 1e-4);
  const double radius = 20.0 / std::sqrt(12.0 * 0.12500266871624077);
  CHECK(glm::length(glm::dvec3(p.diagonal_m) - glm::dvec3(radius)) < 1e-3);
  CHECK(glm::length(p.off_diagonal_m) < 1e-3f);
  CHECK(p.base_m == 110.0f);
  CHECK(p.top_m == 130.0f);
}

TEST_CASE("volume fit: moved by whole spacings the particles move along, seeds as the world's lattice has them") {
  MemoryVolume volume = cumulus(32);
  VolumeGrid moved = volume.grid();
  const FitOptions options{.spacing_m = glm::dvec3(192.0, 192.0, 128.0)};
  const glm::dvec3 shift(3 * 192.0, -5 * 192.0, 2 * 128.0);
  for (int axis = 0; axis < 3; ++axis)
    for (double& bound : moved.bounds_m[static_cast<std::size_t>(axis)]) bound += shift[axis];
  MemoryVolume there(moved, volume.values());
  const VolumeFit a = fitted(volume, options), b = fitted(there, options);
  REQUIRE(a.set.particles.size() == b.set.particles.size());
  for (std::size_t i = 0; i < a.set.particles.size(); ++i) {
    const SetParticle &p = a.set.particles[i], &q = b.set.particles[i];
    CHECK(glm::length(glm::dvec3(q.center_m) - glm::dvec3(p.center_m) - shift) < 1e-3);
    CHECK(glm::length(p.diagonal_m - q.diagonal_m) < 1e-3f);
    CHECK(b.lattice.nodes.front().index == a.lattice.nodes.front().index + glm::ivec3(3, -5, 2));
  }
  // The same place in the world, told by the anchor: the very same nodes.
  VolumeGrid anchored = volume.grid();
  anchored.anchor_m = shift;
  MemoryVolume told(anchored, volume.values());
  const VolumeFit c = fitted(told, options);
  REQUIRE(c.set.particles.size() == b.set.particles.size());
  for (std::size_t i = 0; i < c.set.particles.size(); ++i) {
    CHECK(c.set.particles[i].seed == b.set.particles[i].seed);
    CHECK(glm::length(c.set.particles[i].center_m - a.set.particles[i].center_m) < 1e-3f);
  }
}

TEST_CASE("volume fit: any number of threads and any order of axes give the same set") {
  MemoryVolume volume = cumulus(48);
  const VolumeFit one = fitted(volume, {.spacing_voxels = 3.0, .threads = 1});
  for (const int threads : {2, 3, 7}) {
    const VolumeFit many = fitted(volume, {.spacing_voxels = 3.0, .threads = threads});
    REQUIRE(many.set.particles.size() == one.set.particles.size());
    CHECK(std::memcmp(many.set.particles.data(), one.set.particles.data(),
                      one.set.particles.size() * sizeof(SetParticle)) == 0);
  }
  Turned turned(volume);
  const VolumeFit other = fitted(turned, {.spacing_voxels = 3.0});
  REQUIRE(other.set.particles.size() == one.set.particles.size());
  for (std::size_t i = 0; i < one.set.particles.size(); ++i) {
    const SetParticle &p = one.set.particles[i], &q = other.set.particles[i];
    CHECK(glm::length(p.center_m - q.center_m) < 1e-3f);
    CHECK(glm::length(p.diagonal_m - q.diagonal_m) < 1e-2f);
    CHECK(glm::length(p.off_diagonal_m - q.off_diagonal_m) < 1e-2f);
    CHECK(p.base_m == q.base_m);
    CHECK(p.top_m == q.top_m);
    CHECK(p.seed == q.seed);
  }
}

TEST_CASE("volume fit: matter that moves a little changes the picture a little") {
  // Second differences in time of the transmittance, of particles over the volume's own. Fits that jump have 2 or more
  // (k-means, fitted afresh: 2.9); 1.6 leaves room for the noise of 400 rays around the 1.1 that windows have.
  constexpr std::size_t kN = 48;
  constexpr double kStepM = 4.3;  // a tenth of a voxel
  std::vector<std::vector<double>> fit(3), own(3);
  for (int frame = 0; frame < 3; ++frame) {
    MemoryVolume volume = cumulus(kN, {frame * kStepM, 0.6 * frame * kStepM, 0.3 * frame * kStepM});
    const VolumeFit made = fitted(volume, {.spacing_voxels = 3.0});
    const ParticleGrid grid(bodies_of(made.set), cube(kN, sample::kCumulusSideM / kN), {0, 1, 2});
    ParticleGrid reader = grid;
    std::vector<float> values(volume.grid().voxels());
    REQUIRE(reader.read_planes(0, kN, values));
    const MemoryVolume as_voxels(volume.grid(), values);
    for (int i = 0; i < 400; ++i) {
      const glm::dvec3 from(500.0 + 50.0 * (i % 20), 0.0, 350.0 + 50.0 * (i / 20)), along(0.0, 1.0, 0.0);
      fit[static_cast<std::size_t>(frame)].push_back(std::exp(-volume_depth(as_voxels, from, along)));
      own[static_cast<std::size_t>(frame)].push_back(std::exp(-volume_depth(volume, from, along)));
    }
  }
  const auto jerk = [](const std::vector<std::vector<double>>& t) {
    double sum = 0.0;
    for (std::size_t i = 0; i < t[0].size(); ++i) {
      const double second = t[0][i] - 2.0 * t[1][i] + t[2][i];
      sum += second * second;
    }
    return std::sqrt(sum / static_cast<double>(t[0].size()));
  };
  CHECK(jerk(own) > 0.0);
  CHECK(jerk(fit) < 1.6 * jerk(own));
}

// For docs/sources.md: tools/sources.sh runs it.
TEST_CASE("volume fit: forty frames of a volume that moves by a tenth of a voxel" * doctest::skip()) {
  constexpr std::size_t kN = 128;
  constexpr double kStepM = 0.1 * sample::kCumulusSideM / kN;
  constexpr int kFrames = 40, kRays = 1600;
  std::vector<std::vector<double>> fit(kFrames), own(kFrames);
  for (int frame = 0; frame < kFrames; ++frame) {
    MemoryVolume volume = cumulus(kN, {frame * kStepM, 0.6 * frame * kStepM, 0.3 * frame * kStepM});
    const VolumeFit made = fitted(volume, {});
    const ParticleChords chords(made.set, true);
    for (int i = 0; i < kRays; ++i) {
      const glm::dvec3 from(400.0 + 31.0 * (i % 40), 0.0, 320.0 + 29.0 * (i / 40)), along(0.0, 1.0, 0.0);
      fit[static_cast<std::size_t>(frame)].push_back(std::exp(-chords.depth(from, along)));
      own[static_cast<std::size_t>(frame)].push_back(std::exp(-volume_depth(volume, from, along)));
    }
  }
  const auto jerk = [](const std::vector<std::vector<double>>& t) {
    double sum = 0.0;
    for (std::size_t frame = 2; frame < t.size(); ++frame)
      for (std::size_t i = 0; i < t[0].size(); ++i)
        sum += std::pow(t[frame - 2][i] - 2.0 * t[frame - 1][i] + t[frame][i], 2);
    return std::sqrt(sum / static_cast<double>((t.size() - 2) * t[0].size()));
  };
  MESSAGE("jerk " << jerk(fit) << " of the set, " << jerk(own) << " of the volume, ratio " << jerk(fit) / jerk(own));
  CHECK(jerk(fit) < 1.15 * jerk(own));
}

TEST_CASE("volume fit: rays through voxels and through particles are exact") {
  // A block: the depth of a straight line is its length inside times the extinction.
  VolumeGrid grid = cube(10, 10.0);
  grid.bounds_m[2] = {0.0, 5.0, 20.0, 50.0, 100.0};
  const MemoryVolume block = volume_of(grid, [](const glm::dvec3&) { return 0.02; });
  CHECK(std::abs(volume_depth(block, {-50.0, 33.0, 40.0}, {1.0, 0.0, 0.0}) - 2.0) < 1e-6);
  CHECK(std::abs(volume_depth(block, {51.0, 33.0, 999.0}, {0.0, 0.0, -1.0}) - 2.0) < 1e-6);
  const glm::dvec3 diagonal = glm::normalize(glm::dvec3(1.0, 1.0, 1.0));
  CHECK(std::abs(volume_depth(block, glm::dvec3(50.0), diagonal) - 2.0 * std::sqrt(3.0)) < 1e-6);
  CHECK(volume_depth(block, {-50.0, 133.0, 40.0}, {1.0, 0.0, 0.0}) == 0.0);
}

TEST_CASE("volume fit: clouds apart have bases and tops of their own") {
  MemoryVolume volume = volume_of(cube(40, 25.0), [](const glm::dvec3& p) {
    const bool low = glm::length(p - glm::dvec3(200.0, 200.0, 300.0)) < 120.0;
    const bool high = glm::length(p - glm::dvec3(800.0, 800.0, 700.0)) < 120.0;
    return low || high ? 0.03 : 0.0;
  });
  const VolumeFit fit = fitted(volume, {.spacing_voxels = 2.0, .vertical_spacing_voxels = 2.0});
  for (const SetParticle& p : fit.set.particles) {
    const bool high = p.center_m.z > 500.0f;
    CHECK(std::abs(p.base_m - (high ? 575.0f : 175.0f)) <= 25.0f);
    CHECK(std::abs(p.top_m - (high ? 825.0f : 425.0f)) <= 25.0f);
  }
}

TEST_CASE("volume fit: what cannot be fitted is told in one line") {
  const auto complaint = [](const MemoryVolume& volume, const FitOptions& options) {
    MemoryVolume copy = volume;
    const Result<VolumeFit> fit = fit_volume(copy, options);
    return fit ? std::string("accepted") : fit.error().message;
  };
  MemoryVolume empty = volume_of(cube(8, 10.0), [](const glm::dvec3&) { return -0.5; });
  CHECK(complaint(empty, {}).find("no voxel is above 0") != std::string::npos);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()}) {
    MemoryVolume damaged =
        volume_of(cube(8, 10.0), [&](const glm::dvec3& p) { return p == glm::dvec3(35.0, 15.0, 65.0) ? bad : 0.01; });
    CHECK(complaint(damaged, {}).find("voxel (3, 1, 6) is") != std::string::npos);
  }
  MemoryVolume tiny = volume_of(cube(8, 10.0), [](const glm::dvec3&) { return 0.01; });
  CHECK(complaint(tiny, {.spacing_m = glm::dvec3(1e-7)}).find("too small") != std::string::npos);
}

TEST_CASE("volume fit: the default is near the volume on every level") {
  MemoryVolume volume = cumulus(128);
  const VolumeFit fit = fitted(volume, {});
  const VolumeTruth truth(volume);
  const SetErrors errors = truth.errors_of(fit.set);
  CHECK(errors.rays == VolumeTruth::kRays);
  // What the importer promises of such a cloud by default.
  CHECK(fit.set.particles.size() <= 4000);
  CHECK(errors.rms_transmittance <= 0.03);
  CHECK(std::abs(errors.mass_ratio - 1.0) < 1e-3);
  double last = errors.rms_transmittance;
  for (const ParticleSet& level : fit.set.coarser) {
    const double error = truth.errors_of(level).rms_transmittance;
    CHECK(error > last);  // coarser is worse, or finer is for nothing
    CHECK(error < 0.15);  // far below what no cloud at all would have, about 0.9
    last = error;
  }
}

TEST_CASE("particle grid: mass is kept, be the particle far smaller than a voxel or far larger") {
  for (const double radius : {0.3, 4.0, 300.0}) {
    PlacedBody body;
    body.center_m = {12.3, -45.6, 78.9};
    body.shape_m = glm::dmat3(radius, 0.2 * radius, 0.0, 0.2 * radius, 0.7 * radius, 0.1 * radius, 0.0, 0.1 * radius,
                              0.5 * radius);
    body.extinction_per_m = 0.04;
    for (const std::array<int, 3> axes : {std::array{0, 1, 2}, std::array{2, 1, 0}})
      for (const bool homogeneous : {false, true}) {
        body.homogeneous = homogeneous;
        ParticleGrid grid({body}, grid_around({body}, 20.0), axes);
        std::vector<float> values(grid.grid().voxels());
        REQUIRE(grid.read_planes(0, grid.planes(), values));
        double sum = 0.0;
        for (const float value : values) sum += 8000.0 * static_cast<double>(value);
        const double fill = homogeneous ? 1.0 : 0.41593073593073593;
        const double mass = 0.04 * fill * 4.0 / 3.0 * 3.141592653589793 * glm::determinant(body.shape_m);
        CHECK(std::abs(sum / mass - 1.0) < 1e-5);  // made so; floats
      }
  }
}
