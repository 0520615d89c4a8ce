#include "lut/study/chord_maps.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "engine/parallel.h"
#include "lut/oracles.h"
#include "shared/table_axes.h"

namespace nephele {

using shared::vec2;
using shared::vec3;

namespace {

constexpr float kPeakOpticalRadius = 8;

struct Chord {
  vec3 entry, exit;
};

using Place = std::array<float, 4>;  // in [0, 1] each

struct ChordMap {
  const char* name;
  std::array<int, 4> size;
  std::array<bool, 4> periodic;  // else the first and the last vertex stand at 0 and 1
  std::function<Place(const Chord&)> encode;
  std::function<Chord(const Place&)> decode;
};

// Entry and exit point on octahedral maps.
ChordMap entry_exit_map() {
  return {"entry and exit, octahedral",
          {32, 32, 32, 32},
          {},
          [](const Chord& chord) {
            const vec2 s = shared::octahedral_encode(chord.entry), e = shared::octahedral_encode(chord.exit);
            return Place{s.x, s.y, e.x, e.y};
          },
          [](const Place& p) {
            return Chord{shared::octahedral_decode({p[0], p[1]}), shared::octahedral_decode({p[2], p[3]})};
          }};
}

// [Yusov14] 5.1: zenith and azimuth of the entry point, then of the view direction around the normal there.
struct LocalFrame {
  vec3 inward, south, east;
};

LocalFrame local_frame(float zenith, float azimuth) {
  const float sz = std::sin(zenith), cz = std::cos(zenith), sa = std::sin(azimuth), ca = std::cos(azimuth);
  return {-vec3(sz * ca, sz * sa, cz), vec3(cz * ca, cz * sa, -sz), vec3(-sa, ca, 0)};
}

float turn_fraction(float y, float x) {
  const float turn = std::atan2(y, x) / (2 * shared::kPi);
  return turn < 0 ? turn + 1 : turn;
}

ChordMap angles_map() {
  return {"zenith and azimuth of entry and direction",
          {23, 45, 23, 45},
          {false, true, false, true},
          [](const Chord& chord) {
            const float zenith = std::acos(std::clamp(chord.entry.z, -1.0f, 1.0f));
            const float turn = turn_fraction(chord.entry.y, chord.entry.x);
            const LocalFrame frame = local_frame(zenith, 2 * shared::kPi * turn);
            const vec3 way = normalize(chord.exit - chord.entry);
            return Place{zenith / shared::kPi, turn,
                         2 / shared::kPi * std::acos(std::clamp(dot(way, frame.inward), 0.0f, 1.0f)),
                         turn_fraction(dot(way, frame.east), dot(way, frame.south))};
          },
          [](const Place& p) {
            const LocalFrame frame = local_frame(shared::kPi * p[0], 2 * shared::kPi * p[1]);
            const float zenith = 0.5f * shared::kPi * p[2], azimuth = 2 * shared::kPi * p[3];
            const vec3 way = std::cos(zenith) * frame.inward +
                             std::sin(zenith) * (std::cos(azimuth) * frame.south + std::sin(azimuth) * frame.east);
            return Chord{-frame.inward, normalize(-frame.inward + 2 * std::cos(zenith) * way)};
          }};
}

// The chord's direction, up to its sign, on an octahedral map of the upper hemisphere; where it crosses the plane
// through the centre, on the square by Shirley and Chiu's concentric map (1997). Frame: Duff et al., Building an
// orthonormal basis, revisited (2017), continuous on the hemisphere.
struct PlaneFrame {
  vec3 x, y;
};

PlaneFrame plane_frame(const vec3& d) {
  const float a = -1 / (1 + d.z), b = d.x * d.y * a;
  return {{1 + d.x * d.x * a, b, -d.x}, {b, 1 + d.y * d.y * a, -d.y}};
}

vec2 square_from_disc(const vec2& p) {
  const float r = length(p);
  if (r == 0) return {0, 0};
  if (std::abs(p.x) >= std::abs(p.y)) {
    const float side = p.x < 0 ? -r : r;
    return {side, side * std::atan(p.y / p.x) * 4 / shared::kPi};
  }
  const float side = p.y < 0 ? -r : r;
  return {side * std::atan(p.x / p.y) * 4 / shared::kPi, side};
}

vec2 disc_from_square(const vec2& s) {
  if (s.x == 0 && s.y == 0) return {0, 0};
  if (std::abs(s.x) >= std::abs(s.y)) {
    const float angle = shared::kPi / 4 * s.y / s.x;
    return s.x * vec2(std::cos(angle), std::sin(angle));
  }
  const float angle = shared::kPi / 4 * s.x / s.y;
  return s.y * vec2(std::sin(angle), std::cos(angle));
}

ChordMap direction_impact_map() {
  return {"direction without sign and impact point",
          {32, 32, 32, 32},
          {},
          [](const Chord& chord) {
            vec3 d = normalize(chord.exit - chord.entry);
            if (d.z < 0) d = -d;
            const float scale = 1 / (std::abs(d.x) + std::abs(d.y) + d.z);
            const PlaneFrame frame = plane_frame(d);
            const vec3 middle = 0.5f * (chord.entry + chord.exit);
            const vec2 s = square_from_disc({dot(middle, frame.x), dot(middle, frame.y)});
            return Place{0.5f + 0.5f * scale * (d.x + d.y), 0.5f + 0.5f * scale * (d.x - d.y), 0.5f + 0.5f * s.x,
                         0.5f + 0.5f * s.y};
          },
          [](const Place& p) {
            const float u = 2 * p[0] - 1, v = 2 * p[1] - 1, x = 0.5f * (u + v), y = 0.5f * (u - v);
            const vec3 d = normalize(vec3(x, y, std::max(0.0f, 1 - std::abs(x) - std::abs(y))));
            const PlaneFrame frame = plane_frame(d);
            const vec2 b = disc_from_square({2 * p[2] - 1, 2 * p[3] - 1});
            const vec3 middle = b.x * frame.x + b.y * frame.y;
            const float half = std::sqrt(std::max(0.0f, 1 - dot(b, b)));
            return Chord{middle - half * d, middle + half * d};
          }};
}

// The mean density that the filtered table gives for the chord.
double filtered(const ChordMap& map, const Chord& chord, std::uint32_t seed) {
  const Place place = map.encode(chord);
  std::array<int, 4> cell{};
  std::array<float, 4> fraction{}, cells{};
  for (int k = 0; k < 4; ++k) {
    cells[k] = static_cast<float>(map.periodic[k] ? map.size[k] : map.size[k] - 1);
    const float at = std::clamp(place[k], 0.0f, 1.0f) * cells[k];
    cell[k] = static_cast<int>(std::min(std::floor(at), cells[k] - 1));
    fraction[k] = at - static_cast<float>(cell[k]);
  }
  double sum = 0;
  for (int corner = 0; corner < 16; ++corner) {
    Place vertex{};
    double weight = 1;
    for (int k = 0; k < 4; ++k) {
      const int up = corner >> k & 1;
      vertex[k] = static_cast<float>(cell[k] + up) / cells[k];
      weight *= up ? fraction[k] : 1 - fraction[k];
    }
    if (weight == 0) continue;
    const Chord at = map.decode(vertex);
    sum += weight * exact_mean_density(at.entry, at.exit, seed);
  }
  return sum;
}

Chord random_chord(UniformNumbers& uniform) {
  const auto direction = [&] {
    const double z = 2 * uniform() - 1, phi = 2 * double{shared::kPi} * uniform(), s = std::sqrt(1 - z * z);
    return vec3(glm::dvec3(s * std::cos(phi), s * std::sin(phi), z));
  };
  const vec3 along = direction(), side = normalize(cross(along, direction()));
  const float impact = static_cast<float>(std::sqrt(uniform())), half = std::sqrt(1 - impact * impact);
  return {impact * side - half * along, impact * side + half * along};
}

}  // namespace

std::vector<ChordMapError> compare_chord_maps(std::uint32_t particle_seed, int chords) {
  std::vector<ChordMapError> errors;
  for (const ChordMap& map : {entry_exit_map(), angles_map(), direction_impact_map()}) {
    std::vector<double> squares(chords);
    parallel_for(chords, [&](int i) {
      UniformNumbers uniform(static_cast<std::uint64_t>(i));
      const Chord chord = random_chord(uniform);
      const double scale = -double{kPeakOpticalRadius} * length(chord.exit - chord.entry);
      const double error = std::exp(scale * filtered(map, chord, particle_seed)) -
                           std::exp(scale * exact_mean_density(chord.entry, chord.exit, particle_seed));
      squares[i] = error * error;
    });
    double sum = 0;
    for (double square : squares) sum += square;
    errors.push_back({map.name, map.size, std::sqrt(sum / chords)});
  }
  return errors;
}

}  // namespace nephele
