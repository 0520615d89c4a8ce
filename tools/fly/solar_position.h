// Where the sun stands, from date, hour and place.
//
// The Astronomical Almanac's low-precision formulas for the sun, as in Michalsky, The Astronomical Almanac's algorithm
// for approximate solar position (1950-2050), Solar Energy 40 (3), 1988: within 0.01 degrees of the sun's true
// direction in the years 1950 to 2050. UTC stands for UT1, from which it is never farther than 0.9 s, 0.004 degrees.
//
// Seen from the planet's centre and without its air. From the ground the sun stands up to 0.0024 degrees lower, by
// parallax, and near the horizon half a degree higher, by refraction.
#pragma once

#include "engine/result.h"

namespace nephele::tools {

// Gregorian calendar.
struct UtcTime {
  int year = 2000;  // 1950 .. 2050
  int month = 1;    // 1 .. 12
  int day = 1;      // 1 .. as many as the month has
  double hour = 0;  // of the day in UTC, 0 .. 24
};

struct SunPosition {
  double azimuth_rad;    // clockwise from north, 0 .. 2 pi; at a pole, where all ways lead from it, as next to it
  double elevation_rad;  // from the horizon, -pi/2 .. pi/2
};

// latitude_deg: north, -90 .. 90; longitude_deg: east, -180 .. 180. Whatever is out of its range is an error that names
// it, its value and the range.
Result<SunPosition> solar_position(const UtcTime& time, double latitude_deg, double longitude_deg);

}  // namespace nephele::tools
