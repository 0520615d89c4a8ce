// The sun's place against published values: none of them comes from the formulas under test.
#include "tools/fly/solar_position.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

using namespace nephele;
using namespace nephele::tools;

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
// What the formulas' authors claim for the sun's direction.
constexpr double kErrorDeg = 0.01;

struct InDegrees {
  double azimuth, elevation;
};

InDegrees sun(const UtcTime& time, double latitude_deg, double longitude_deg) {
  const Result<SunPosition> position = solar_position(time, latitude_deg, longitude_deg);
  if (!position) FAIL(position.error().message);
  return {position->azimuth_rad / kDegree, position->elevation_rad / kDegree};
}

// From the pole the sun stands as high as it is north of the equator.
double declination_deg(const UtcTime& time) { return sun(time, 90, 0).elevation; }

// The hour at which the sun crosses the meridian, seen from where it does so in the south.
double noon_hour(const UtcTime& day, double longitude_deg) {
  double before = 6, after = 18;
  while (after - before > 1e-9) {
    const double middle = 0.5 * (before + after);
    const double azimuth = sun({day.year, day.month, day.day, middle}, 60, longitude_deg).azimuth;
    (azimuth < 180 ? before : after) = middle;
  }
  return before;
}

std::string complaint(const UtcTime& time, double latitude_deg, double longitude_deg) {
  const Result<SunPosition> position = solar_position(time, latitude_deg, longitude_deg);
  return position ? "accepted" : position.error().message;
}

}  // namespace

// Reda and Andreas, Solar Position Algorithm for Solar Radiation Applications, NREL/TP-560-34302, table A5.1. Their
// elevation is seen from the ground, lower by the sun's parallax of 8.8" times the cosine of the elevation.
TEST_CASE("solar position: the example of NREL's SPA") {
  const InDegrees position = sun({2003, 10, 17, 19.0 + 30.0 / 60 + 30.0 / 3600}, 39.742476, -105.1786);
  const double parallax_deg = 8.794 / 3600 * std::cos(39.87 * kDegree);
  CHECK(std::abs(position.elevation - parallax_deg - 39.872046) < kErrorDeg);
  // Sideways an error is larger by one over the cosine of the elevation.
  CHECK(std::abs(position.azimuth - 194.340241) < kErrorDeg / std::cos(39.87 * kDegree));
}

// Instants of the seasons to the minute, U.S. Naval Observatory, Earth's Seasons. At an equinox the declination changes
// by 0.016 degrees in an hour, so half a minute adds 0.0001 to the formulas' error, at a solstice nothing.
TEST_CASE("solar position: declination at equinoxes and solstices") {
  // The obliquity of the ecliptic of date, IAU 2006, less than 0.003 from the true one by nutation.
  const auto obliquity_deg = [](double year) { return 23.4392911 - 0.0130042 * (year - 2000) / 100; };
  CHECK(std::abs(declination_deg({2020, 3, 20, 3 + 50.0 / 60})) < kErrorDeg);
  CHECK(std::abs(declination_deg({2020, 9, 22, 13 + 31.0 / 60})) < kErrorDeg);
  CHECK(std::abs(declination_deg({2020, 6, 20, 21 + 44.0 / 60}) - obliquity_deg(2020.5)) < kErrorDeg);
  CHECK(std::abs(declination_deg({2020, 12, 21, 10 + 2.0 / 60}) + obliquity_deg(2021)) < kErrorDeg);
  CHECK(std::abs(declination_deg({2000, 3, 20, 7 + 35.0 / 60})) < kErrorDeg);
  CHECK(std::abs(declination_deg({2000, 9, 22, 17 + 28.0 / 60})) < kErrorDeg);
  CHECK(std::abs(declination_deg({2000, 6, 21, 1 + 48.0 / 60}) - obliquity_deg(2000.5)) < kErrorDeg);
  // The sun goes north in March and south in September.
  CHECK(declination_deg({2020, 3, 20, 4.9}) > 0.01);
  CHECK(declination_deg({2020, 9, 22, 14.6}) < -0.01);
}

// The equation of time, by which a sundial is ahead of mean time: The Astronomical Almanac, rounded to a second in
// textbooks. 0.01 degrees are 2.4 s of it, and its value on a day differs by up to 8 s between the years of a leap
// cycle.
TEST_CASE("solar position: noon by the equation of time, the same to both sides of it") {
  struct Day {
    UtcTime day;
    double equation_s;
  };
  for (const auto& [day, equation_s] : {Day{{2001, 2, 11}, -(14 * 60 + 14)}, Day{{2001, 11, 3}, 16 * 60 + 26},
                                        Day{{2001, 7, 26}, -(6 * 60 + 31)}, Day{{2001, 5, 14}, 3 * 60 + 40}}) {
    CAPTURE(equation_s);
    const double noon = noon_hour(day, 0);
    CHECK(std::abs((12.0 - noon) * 3600 - equation_s) < 11.0);
    // 15 degrees are an hour, and noon comes earlier in the east; in that hour the equation of time changes by 1.3 s.
    CHECK(std::abs(noon_hour(day, 15) - (noon - 1.0)) * 3600 < 1.3);
    UtcTime before = day, after = day;
    before.hour = noon - 3;
    after.hour = noon + 3;
    const InDegrees morning = sun(before, 40, 0), evening = sun(after, 40, 0);
    // In six hours the sun goes north or south by up to 0.1 degrees; sideways that is more by one over the cosine of
    // its elevation, which is less than 50 degrees here.
    CHECK(std::abs(morning.elevation - evening.elevation) < 0.1);
    CHECK(std::abs(morning.azimuth + evening.azimuth - 360) < 0.1 / std::cos(50 * kDegree));
    CHECK(morning.azimuth < 180);
  }
}

TEST_CASE("solar position: noon stands in the south of the north, in the north of the south") {
  const UtcTime june{2020, 6, 21, 12.03};  // noon over Greenwich: the equation of time is two minutes
  CHECK(std::abs(sun(june, 50, 0).azimuth - 180) < 0.5);
  CHECK(std::abs(sun(june, 50, 0).elevation - (90 - 50 + 23.436)) < 0.02);
  const InDegrees south = sun(june, -50, 0);
  CHECK(std::min(south.azimuth, 360 - south.azimuth) < 0.5);
  CHECK(std::abs(south.elevation - (90 - 50 - 23.436)) < 0.02);
  // Between the tropics it is in the north in June too.
  CHECK(std::cos(sun(june, 10, 0).azimuth * kDegree) > 0.99);
  // Sydney, its summer: in the east in the morning, in the north at noon, in the west in the evening.
  CHECK(std::abs(sun({2020, 12, 20, 20}, -33.87, 151.21).azimuth - 110) < 15);
  CHECK(std::abs(sun({2020, 12, 21, 1.9}, -33.87, 151.21).elevation - (90 - 33.87 + 23.436)) < 0.05);
  CHECK(std::abs(sun({2020, 12, 21, 8}, -33.87, 151.21).azimuth - 250) < 15);
}

TEST_CASE("solar position: at the poles the sun goes round at one height, clockwise in the north") {
  for (double hour = 0; hour < 24; hour += 3) {
    const double declination = declination_deg({2020, 5, 1, hour});
    CHECK(std::abs(sun({2020, 5, 1, hour}, 90, 77).elevation - declination) < 1e-9);
    CHECK(std::abs(sun({2020, 5, 1, hour}, -90, -13).elevation + declination) < 1e-9);
    // As a step beside the pole sees it, where the pole's azimuth is counted from its meridian.
    CHECK(std::abs(sun({2020, 5, 1, hour}, 90, 0).azimuth - sun({2020, 5, 1, hour}, 89.999, 0).azimuth) < 0.01);
  }
  const double turned = sun({2020, 5, 1, 11}, 90, 0).azimuth - sun({2020, 5, 1, 10}, 90, 0).azimuth;
  CHECK(std::abs(turned - 15) < 0.01);
  CHECK(std::abs(sun({2020, 5, 1, 11}, -90, 0).azimuth - sun({2020, 5, 1, 10}, -90, 0).azimuth + 15) < 0.01);
}

TEST_CASE("solar position: the same at both names of the date line, of midnight and of a turn") {
  const auto same = [](const InDegrees& a, const InDegrees& b) {
    return std::abs(a.elevation - b.elevation) < 1e-9 && std::abs(std::remainder(a.azimuth - b.azimuth, 360)) < 1e-9;
  };
  CHECK(same(sun({2021, 3, 4, 5.5}, 20, 180), sun({2021, 3, 4, 5.5}, 20, -180)));
  CHECK(same(sun({2020, 2, 28, 24}, 20, 10), sun({2020, 2, 29, 0}, 20, 10)));
  CHECK(same(sun({2020, 2, 29, 24}, 20, 10), sun({2020, 3, 1, 0}, 20, 10)));
  CHECK(same(sun({2021, 2, 28, 24}, 20, 10), sun({2021, 3, 1, 0}, 20, 10)));
  CHECK(same(sun({1999, 12, 31, 24}, 20, 10), sun({2000, 1, 1, 0}, 20, 10)));
  // Nowhere a jump: in a minute the sun goes a quarter of a degree.
  for (int minute = 1; minute <= 1440; ++minute) {
    const InDegrees a = sun({2020, 8, 1, (minute - 1) / 60.0}, 35, 179.9),
                    b = sun({2020, 8, 1, minute / 60.0}, 35, 179.9);
    CHECK(std::abs(a.elevation - b.elevation) < 0.26);
    CHECK(std::abs(std::remainder(a.azimuth - b.azimuth, 360)) < 1.5);
    CHECK(b.azimuth >= 0);
    CHECK(b.azimuth <= 360);
  }
}

TEST_CASE("solar position: towards both ends of its years the seasons are where they are") {
  // Meeus, Astronomical Algorithms, example 27.a: the solstice of June 1962, when the obliquity was 23.444 degrees. A
  // solstice's declination hardly depends on its hour, an equinox's does.
  CHECK(std::abs(declination_deg({1962, 6, 21, 21 + 24.0 / 60}) - 23.444) < kErrorDeg);
  // The March equinox of 2044 as tables of seasons predict it; by then the length of the day is a guess of a minute.
  CHECK(std::abs(declination_deg({2044, 3, 19, 23 + 20.0 / 60})) < 2 * kErrorDeg);
}

TEST_CASE("solar position: whatever is out of range is named") {
  const UtcTime good{2020, 2, 29, 12};
  CHECK(complaint(good, 0, 0) == "accepted");
  CHECK(complaint({1949, 12, 31, 0}, 0, 0) == "year is 1949; accepted: a whole number from 1950 to 2050");
  CHECK(complaint({2051, 1, 1, 0}, 0, 0).starts_with("year is 2051"));
  CHECK(complaint({-5, 1, 1, 0}, 0, 0).starts_with("year is -5"));
  CHECK(complaint({2020, 0, 1, 0}, 0, 0) == "month is 0; accepted: a whole number from 1 to 12");
  CHECK(complaint({2020, 13, 1, 0}, 0, 0).starts_with("month is 13"));
  CHECK(complaint({2020, 2, 30, 0}, 0, 0) == "day is 30; accepted: a whole number from 1 to 29");
  CHECK(complaint({2021, 2, 29, 0}, 0, 0) == "day is 29; accepted: a whole number from 1 to 28");
  CHECK(complaint({2000, 2, 29, 0}, 0, 0) == "accepted");
  CHECK(complaint({2020, 4, 31, 0}, 0, 0).starts_with("day is 31"));
  CHECK(complaint({2020, 4, 0, 0}, 0, 0).starts_with("day is 0"));
  CHECK(complaint({2020, 4, -1, 0}, 0, 0).starts_with("day is -1"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double hour : {-0.001, 24.001, nan})
    CHECK(complaint({2020, 4, 1, hour}, 0, 0).find("; accepted: a number from 0 to 24") != std::string::npos);
  CHECK(complaint(good, 90.0000001, 0) == "latitude_deg is 90.0000001; accepted: a number from -90 to 90");
  CHECK(complaint(good, nan, 0).starts_with("latitude_deg is nan"));
  CHECK(complaint(good, 0, -181) == "longitude_deg is -181; accepted: a number from -180 to 180");
}
