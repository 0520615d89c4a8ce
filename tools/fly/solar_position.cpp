#include "tools/fly/solar_position.h"

#include <chrono>
#include <cmath>
#include <numbers>

#include "engine/accepted.h"
#include "engine/check.h"

namespace nephele::tools {
namespace {

constexpr int kFirstYear = 1950, kLastYear = 2050;
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kHourAngle = std::numbers::pi / 12.0;  // by which the planet turns in an hour of sidereal time

Result<void> check_number(const char* name, double value, double minimum, double maximum) {
  const RealNumber accepted{minimum, maximum};
  if (accepts(accepted, value)) return {};
  return not_accepted(name, number_text(value), accepted);
}

Result<void> check_whole(const char* name, int value, unsigned minimum, unsigned maximum) {
  if (value >= static_cast<int>(minimum) && value <= static_cast<int>(maximum)) return {};
  return not_accepted(name, concat(value), WholeNumber{minimum, maximum});
}

std::chrono::year_month_day date_of(const UtcTime& time) {
  return {std::chrono::year(time.year), std::chrono::month(static_cast<unsigned>(time.month)),
          std::chrono::day(static_cast<unsigned>(time.day))};
}

Result<void> check_inputs(const UtcTime& time, double latitude_deg, double longitude_deg) {
  if (auto ok = check_whole("year", time.year, kFirstYear, kLastYear); !ok) return ok;
  if (auto ok = check_whole("month", time.month, 1, 12); !ok) return ok;
  const std::chrono::year_month_day date = date_of(time);
  const auto last = static_cast<unsigned>((date.year() / date.month() / std::chrono::last).day());
  if (auto ok = check_whole("day", time.day, 1, last); !ok) return ok;
  if (auto ok = check_number("hour", time.hour, 0, 24); !ok) return ok;
  if (auto ok = check_number("latitude_deg", latitude_deg, -90, 90); !ok) return ok;
  return check_number("longitude_deg", longitude_deg, -180, 180);
}

// From noon of the first of January 2000.
double days_from_2000(const UtcTime& time) {
  using namespace std::chrono;
  const sys_days start = year(2000) / January / 1;
  return static_cast<double>((sys_days(date_of(time)) - start).count()) - 0.5 + time.hour / 24.0;
}

}  // namespace

Result<SunPosition> solar_position(const UtcTime& time, double latitude_deg, double longitude_deg) {
  if (auto ok = check_inputs(time, latitude_deg, longitude_deg); !ok) return ok.error();
  const double days = days_from_2000(time);

  // On the ecliptic: the mean longitude, and by how much the orbit's eccentricity has the sun ahead of it.
  const double mean_longitude = (280.460 + 0.9856474 * days) * kDegree;
  const double mean_anomaly = (357.528 + 0.9856003 * days) * kDegree;
  const double longitude =
      mean_longitude + (1.915 * std::sin(mean_anomaly) + 0.020 * std::sin(2.0 * mean_anomaly)) * kDegree;
  const double obliquity = (23.439 - 4e-7 * days) * kDegree;

  // On the sky over the equator.
  const double right_ascension = std::atan2(std::cos(obliquity) * std::sin(longitude), std::cos(longitude));
  const double sine_declination = std::sin(obliquity) * std::sin(longitude);
  const double cosine_declination = std::sqrt(1.0 - sine_declination * sine_declination);

  // Over the place, whose meridian the sun has passed by the hour angle.
  const double greenwich_sidereal_h = 6.697375 + 0.0657098242 * days + time.hour;
  const double hour_angle = greenwich_sidereal_h * kHourAngle + longitude_deg * kDegree - right_ascension;
  const double sine_latitude = std::sin(latitude_deg * kDegree), cosine_latitude = std::cos(latitude_deg * kDegree);
  const double towards_equator = cosine_declination * std::cos(hour_angle);
  const double east = -cosine_declination * std::sin(hour_angle);
  const double north = sine_declination * cosine_latitude - towards_equator * sine_latitude;
  const double up = sine_declination * sine_latitude + towards_equator * cosine_latitude;

  const double azimuth_rad = std::atan2(east, north);
  return SunPosition{.azimuth_rad = azimuth_rad < 0.0 ? azimuth_rad + 2.0 * std::numbers::pi : azimuth_rad,
                     .elevation_rad = std::atan2(up, std::hypot(east, north))};
}

}  // namespace nephele::tools
