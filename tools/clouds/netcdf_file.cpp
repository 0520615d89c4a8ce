#include "tools/clouds/netcdf_file.h"

#ifdef NEPHELE_NETCDF

#include <netcdf.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/check.h"

namespace nephele::clouds {
namespace {

constexpr std::array kWaterNames = {"extinction",
                                    "ql",
                                    "qc",
                                    "QCLOUD",
                                    "clw",
                                    "qn",
                                    "cloud_water",
                                    "QC",
                                    "QN",
                                    "clwc",
                                    "qcloud",
                                    "lwc",
                                    "LWC",
                                    "cloud_liquid_water",
                                    "cloud_liquid_water_mixing_ratio"};
constexpr std::array kDensityNames = {"rho", "RHO", "dn0", "DN0", "rhobf", "air_density", "density"};
constexpr std::array kPressureNames = {"p", "P", "pres", "PRES", "pressure", "pfull"};
constexpr std::array kTemperatureNames = {"tabs", "TABS", "temp", "temperature", "ta", "T", "t"};
constexpr double kWaterDensity = 1000.0;       // kg/m3
constexpr double kDryAirGasConstant = 287.05;  // J/(kg K)
constexpr float kUnwritten = 9.9e36f;          // NetCDF fills with 9.97e36 what nobody wrote
constexpr double kFarM = 1e5;
constexpr std::size_t kMostValues = std::size_t{1} << 36;

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

bool is_one_of(const std::string& text, std::initializer_list<std::string_view> names) {
  return std::find(names.begin(), names.end(), text) != names.end();
}

// The standard atmosphere of 1976 below 11 km: kg/m3.
double standard_density(double altitude_m) {
  return 1.225 * std::pow(std::max(1.0 - 2.25577e-5 * std::max(altitude_m, -1000.0), 0.1), 4.2559);
}

enum class Role { x, y, z, time, single };  // single: an axis of one value that is none of these

struct Axis {
  Role role = Role::single;
  std::size_t length = 1;
};

class NetcdfFile {
 public:
  NetcdfFile() = default;
  ~NetcdfFile() {
    if (id_ >= 0) ::nc_close(id_);
  }
  NetcdfFile(const NetcdfFile&) = delete;
  NetcdfFile& operator=(const NetcdfFile&) = delete;

  Result<void> open(const std::string& path) {
    if (const int code = ::nc_open(path.c_str(), NC_NOWRITE, &id_); code != NC_NOERR) {
      id_ = -1;
      return Error{std::string("not a NetCDF file that can be read: ") + ::nc_strerror(code)};
    }
    return {};
  }
  int id() const { return id_; }

  std::optional<int> variable(const std::string& name) const {
    int id = -1;
    if (::nc_inq_varid(id_, name.c_str(), &id) != NC_NOERR) return std::nullopt;
    return id;
  }
  std::vector<int> dimensions(int variable) const {
    int count = 0;
    if (::nc_inq_varndims(id_, variable, &count) != NC_NOERR || count < 0 || count > NC_MAX_VAR_DIMS) return {};
    std::vector<int> ids(static_cast<std::size_t>(count));
    if (count > 0) ::nc_inq_vardimid(id_, variable, ids.data());
    return ids;
  }
  std::string dimension_name(int dimension) const {
    std::array<char, NC_MAX_NAME + 1> name{};
    return ::nc_inq_dimname(id_, dimension, name.data()) == NC_NOERR ? name.data() : "";
  }
  std::size_t length(int dimension) const {
    std::size_t length = 0;
    return ::nc_inq_dimlen(id_, dimension, &length) == NC_NOERR ? length : 0;
  }
  std::string text(int variable, const char* attribute) const {
    nc_type type = NC_NAT;
    std::size_t length = 0;
    if (::nc_inq_att(id_, variable, attribute, &type, &length) != NC_NOERR || type != NC_CHAR || length > 4096)
      return "";
    std::string value(length, '\0');
    if (length > 0 && ::nc_get_att_text(id_, variable, attribute, value.data()) != NC_NOERR) return "";
    while (!value.empty() && (value.back() == '\0' || value.back() == ' ')) value.pop_back();
    return value;
  }
  std::optional<double> number(int variable, const char* attribute) const {
    nc_type type = NC_NAT;
    std::size_t length = 0;
    double value = 0.0;
    if (::nc_inq_att(id_, variable, attribute, &type, &length) != NC_NOERR || type == NC_CHAR || length != 1) return {};
    if (::nc_get_att_double(id_, variable, attribute, &value) != NC_NOERR) return {};
    return value;
  }
  std::string variable_names() const {
    int count = 0;
    ::nc_inq_nvars(id_, &count);
    std::string all;
    for (int i = 0; i < std::min(count, 40); ++i) {
      std::array<char, NC_MAX_NAME + 1> name{};
      if (::nc_inq_varname(id_, i, name.data()) == NC_NOERR) all.append(all.empty() ? "" : ", ").append(name.data());
    }
    return all;
  }

  // A variable of one axis as long as `length`.
  Result<std::vector<double>> coordinates(int variable, std::size_t length) const {
    const std::vector<int> own = dimensions(variable);
    if (own.size() != 1 || this->length(own[0]) != length || length > (std::size_t{1} << 20))
      return Error{"has not one value for each step of its axis"};
    std::vector<double> values(length);
    if (const int code = ::nc_get_var_double(id_, variable, values.data()); code != NC_NOERR)
      return Error{::nc_strerror(code)};
    return values;
  }

 private:
  int id_ = -1;
};

// Which axis a dimension is: by attributes of its coordinate, by units, by name.
Role role_of(const NetcdfFile& file, int dimension) {
  const std::string name = file.dimension_name(dimension), lower = lower_case(name);
  if (const auto coordinate = file.variable(name)) {
    const std::string axis = lower_case(file.text(*coordinate, "axis"));
    if (axis == "x") return Role::x;
    if (axis == "y") return Role::y;
    if (axis == "z") return Role::z;
    if (axis == "t") return Role::time;
    const std::string units = lower_case(file.text(*coordinate, "units"));
    if (units.find("since") != std::string::npos ||
        is_one_of(units, {"s", "sec", "second", "seconds", "min", "minutes", "h", "hour", "hours", "d", "day", "days"}))
      return Role::time;
    if (!file.text(*coordinate, "positive").empty()) return Role::z;
  }
  if (lower.starts_with("x") || is_one_of(lower, {"west_east", "ni", "nx", "lon", "longitude", "i", "east"}))
    return Role::x;
  if (lower.starts_with("y") || is_one_of(lower, {"south_north", "nj", "ny", "lat", "latitude", "j", "north"}))
    return Role::y;
  if (lower.starts_with("z") || lower.starts_with("lev") || lower.starts_with("height") ||
      is_one_of(lower, {"bottom_top", "nk", "nz", "altitude", "alt", "k", "up"}))
    return Role::z;
  if (lower.starts_with("time") || is_one_of(lower, {"t", "nt", "record"})) return Role::time;
  return Role::single;
}

// A variable's values with their axes, read as the file has them: scale, offset and what was never written seen to.
class Field {
 public:
  static Result<Field> open(const NetcdfFile& file, int variable, const std::string& name) {
    Field field;
    field.file_ = &file;
    field.variable_ = variable;
    field.name_ = name;
    std::array<bool, 4> seen{};
    std::size_t values = 1;
    for (const int dimension : file.dimensions(variable)) {
      Axis axis{role_of(file, dimension), file.length(dimension)};
      if (axis.length == 0 || axis.length > kMostValues / values)
        return Error{concat("variable \"", name, "\": ", axis.length, " steps along \"", file.dimension_name(dimension),
                            "\"; accepted: 1 or more, ", kMostValues, " values in all")};
      values *= axis.length;
      if (axis.role == Role::single && axis.length > 1)
        return Error{concat("variable \"", name, "\": its axis \"", file.dimension_name(dimension),
                            "\" is not known as x, y, z or time, by name, units or attribute \"axis\"")};
      if (axis.role != Role::single) {
        bool& twice = seen[static_cast<std::size_t>(axis.role)];
        if (twice) return Error{concat("variable \"", name, "\": two of its axes are the same of x, y, z and time")};
        twice = true;
      }
      field.axes_.push_back(axis);
      field.dimensions_.push_back(dimension);
    }
    nc_type type = NC_NAT;
    ::nc_inq_vartype(file.id(), variable, &type);
    if (type == NC_CHAR || type == NC_STRING || type > NC_MAX_ATOMIC_TYPE)
      return Error{"variable \"" + name + "\" is not of numbers"};
    field.scale_ = file.number(variable, "scale_factor").value_or(1.0);
    field.offset_ = file.number(variable, "add_offset").value_or(0.0);
    for (const char* attribute : {"_FillValue", "missing_value"})
      if (const auto fill = file.number(variable, attribute)) field.fills_.push_back(static_cast<float>(*fill));
    return field;
  }

  const std::vector<Axis>& axes() const { return axes_; }
  int dimension(std::size_t i) const { return dimensions_[i]; }
  std::optional<std::size_t> axis(Role role) const {
    for (std::size_t i = 0; i < axes_.size(); ++i)
      if (axes_[i].role == role) return i;
    return std::nullopt;
  }
  std::string units() const { return lower_case(file_->text(variable_, "units")); }

  // From `first` on; counts of 1 along axes that are not spatial. Missing values become `missing`.
  Result<void> read(const std::vector<std::size_t>& first, const std::vector<std::size_t>& count, float missing,
                    std::span<float> values) const {
    std::vector<std::size_t> begin = first, size = count;
    if (begin.empty()) begin = size = {1};
    const int code = ::nc_get_vara_float(file_->id(), variable_, begin.data(), size.data(), values.data());
    if (code != NC_NOERR && code != NC_ERANGE) return Error{concat("variable \"", name_, "\": ", ::nc_strerror(code))};
    for (float& value : values) {
      const bool filled =
          std::abs(value) >= kUnwritten || std::find(fills_.begin(), fills_.end(), value) != fills_.end();
      value = filled ? missing : static_cast<float>(static_cast<double>(value) * scale_ + offset_);
    }
    return {};
  }

 private:
  const NetcdfFile* file_ = nullptr;
  int variable_ = -1;
  std::string name_;
  std::vector<Axis> axes_;
  std::vector<int> dimensions_;
  double scale_ = 1.0, offset_ = 0.0;
  std::vector<float> fills_;
};

// Something that the air has at every height, or at every voxel.
struct AirField {
  Field field;
  bool whole = false;          // has the volume's own axes
  std::vector<double> levels;  // by height, where it is not
  double unit = 1.0;
};

class NetcdfVolume : public VolumeReader {
 public:
  Result<void> open(const std::string& path, const NetcdfOptions& options) {
    if (auto ok = file_.open(path); !ok) return ok;
    if (auto ok = choose(options.variable); !ok) return ok;
    for (const auto& [role, name] : {std::pair(Role::x, "x"), std::pair(Role::y, "y"), std::pair(Role::z, "z")})
      if (!water_->axis(role))
        return Error{
            concat("variable \"", name_, "\" has no axis ", name, "; accepted: x, y and z, with or without time")};
    if (auto ok = read_times(options.time); !ok) return ok;
    int fastest = 0;
    for (std::size_t i = water_->axes().size(); i-- > 0;)
      if (const int axis = space(water_->axes()[i].role); axis >= 0) order_[static_cast<std::size_t>(fastest++)] = axis;
    for (int axis = 0; axis < 3; ++axis)
      if (auto ok = read_bounds(axis, options); !ok) return ok;
    if (auto ok = check_grid(grid_); !ok) return ok;
    // Floats of some millions of metres are too coarse for particles.
    for (const int axis : {0, 1}) {
      std::vector<double>& bounds = grid_.bounds_m[static_cast<std::size_t>(axis)];
      const double corner = bounds.front();
      if (std::max(std::abs(corner), std::abs(bounds.back())) <= kFarM) continue;
      grid_.anchor_m[axis] = corner;
      for (double& bound : bounds) bound -= corner;
      assumptions_.push_back(concat("Places along ", "xy"[axis], " are measured from the volume's corner, at ", corner,
                                    " m in the file."));
    }
    return choose_unit(options);
  }

  const VolumeGrid& grid() const override { return grid_; }
  std::array<int, 3> axes() const override { return order_; }
  std::vector<std::string> assumptions() const override { return assumptions_; }
  std::vector<double> times_s() const override { return times_s_; }

  Result<void> read_planes(std::size_t first, std::size_t count, std::span<float> values) override {
    if (auto ok = read(*water_, first, count, 0.0f, values); !ok) return ok;
    const auto scale = static_cast<float>(scale_);
    if (!by_density_) {
      for (float& value : values) value *= scale;
      return {};
    }
    std::vector<float> density(values.size()), warmth;
    if (density_ || pressure_) {
      if (auto ok = read_air(density_ ? *density_ : *pressure_, first, count, density); !ok) return ok;
    } else {
      fill_by_level([&](std::size_t z) { return standard_density(middle_m(z)); }, first, count, density);
    }
    if (pressure_ && !density_) {
      warmth.resize(values.size());
      if (auto ok = read_air(*temperature_, first, count, warmth); !ok) return ok;
      for (std::size_t i = 0; i < density.size(); ++i)
        density[i] = warmth[i] > 1.0f ? density[i] / (static_cast<float>(kDryAirGasConstant) * warmth[i]) : 0.0f;
    }
    for (std::size_t i = 0; i < values.size(); ++i) values[i] *= scale * density[i];
    return {};
  }

 private:
  static int space(Role role) { return role == Role::x ? 0 : role == Role::y ? 1 : role == Role::z ? 2 : -1; }
  static Role role(int axis) { return axis == 0 ? Role::x : axis == 1 ? Role::y : Role::z; }
  double middle_m(std::size_t z) const { return 0.5 * (grid_.bounds_m[2][z] + grid_.bounds_m[2][z + 1]); }

  Result<void> choose(const std::string& wanted) {
    std::optional<int> id;
    name_ = wanted;
    if (!wanted.empty()) {
      id = file_.variable(wanted);
    } else {
      for (const char* name : kWaterNames) {
        id = file_.variable(name);
        name_ = name;
        if (id && file_.dimensions(*id).size() >= 3) break;
        id.reset();
      }
    }
    if (!id)
      return Error{concat("--variable is ",
                          wanted.empty() ? "missing, and no variable has a usual name of cloud water"
                                         : concat("\"", wanted, "\", which it does not have"),
                          "; it has ", file_.variable_names())};
    Result<Field> field = Field::open(file_, *id, name_);
    if (!field) return field.error();
    water_.emplace(std::move(*field));
    return {};
  }

  Result<void> read_times(std::size_t time) {
    const auto axis = water_->axis(Role::time);
    time_ = time;
    const std::size_t steps = axis ? water_->axes()[*axis].length : 1;
    if (time >= steps) return Error{concat("--time is ", time, "; accepted: a whole number from 0 to ", steps - 1)};
    if (!axis) return {};
    const std::string name = file_.dimension_name(water_->dimension(*axis));
    const auto coordinate = file_.variable(name);
    const Result<std::vector<double>> values =
        coordinate ? file_.coordinates(*coordinate, steps) : Result<std::vector<double>>(Error{"it has none"});
    if (!values) {
      for (std::size_t i = 0; i < steps; ++i) times_s_.push_back(static_cast<double>(i));
      assumptions_.push_back("Steps of time are one second apart, because the file does not say when they are.");
      return {};
    }
    const std::string units = lower_case(file_.text(*coordinate, "units"));
    const double unit_s = units.starts_with("d")     ? 86400.0
                          : units.starts_with("h")   ? 3600.0
                          : units.starts_with("min") ? 60.0
                                                     : 1.0;
    for (const double value : *values) times_s_.push_back((value - values->front()) * unit_s);
    return {};
  }

  Result<void> read_bounds(int axis, const NetcdfOptions& options) {
    const std::size_t at = *water_->axis(role(axis));
    const std::size_t length = water_->axes()[at].length;
    const std::string name = file_.dimension_name(water_->dimension(at));
    std::vector<double>& bounds = grid_.bounds_m[static_cast<std::size_t>(axis)];
    if (length > kMaxVoxelsAlongAxis)
      return Error{concat("\"", name, "\" has ", length, " steps; accepted: at most ", kMaxVoxelsAlongAxis)};
    const auto coordinate = file_.variable(name);
    if (!coordinate || length == 1) {
      if (!options.voxel_m)
        return Error{concat("\"", name, "\" has ", coordinate ? "a single step" : "no coordinates",
                            "; --voxel-m must say how large a voxel is")};
      bounds = even_bounds(length, 0.0, (*options.voxel_m)[axis]);
      return {};
    }
    const Result<std::vector<double>> read = file_.coordinates(*coordinate, length);
    if (!read) return Error{concat("coordinate \"", name, "\": ", read.error().message)};
    const std::string units = lower_case(file_.text(*coordinate, "units"));
    double unit_m = 1.0;
    if (is_one_of(units, {"km", "kilometer", "kilometers", "kilometre", "kilometres"}))
      unit_m = 1000.0;
    else if (units.empty())
      assumptions_.push_back(concat("\"", name, "\" is in metres, because it has no units."));
    else if (!is_one_of(units, {"m", "meter", "meters", "metre", "metres"}))
      return Error{concat("coordinate \"", name, "\" is in \"", units, "\"; accepted: m or km")};
    std::vector<double> middles = *read;
    for (double& middle : middles) middle *= unit_m;
    const bool falls = middles.front() > middles.back();
    if (falls) std::reverse(middles.begin(), middles.end());
    flipped_[static_cast<std::size_t>(axis)] = falls;
    bounds.resize(length + 1);
    for (std::size_t i = 1; i < length; ++i) {
      if (!(middles[i] > middles[i - 1] && std::isfinite(middles[i]) && std::isfinite(middles[i - 1])))
        return Error{concat("coordinate \"", name, "\" neither rises nor falls all along: ", middles[i - 1],
                            " m, then ", middles[i], " m")};
      bounds[i] = 0.5 * (middles[i - 1] + middles[i]);
    }
    bounds.front() = middles.front() - (bounds[1] - middles.front());
    bounds.back() = middles.back() + (middles.back() - bounds[length - 1]);
    return {};
  }

  Result<void> choose_unit(const NetcdfOptions& options) {
    const std::string units = water_->units();
    if (options.scale_per_m) {
      scale_ = *options.scale_per_m;
      return {};
    }
    if (is_one_of(units, {"m-1", "1/m", "m^-1", "m**-1"})) return {};
    if (is_one_of(units, {"km-1", "1/km", "km^-1"})) {
      scale_ = 1e-3;
      return {};
    }
    const double per_water = 1.5 / (kWaterDensity * options.effective_radius_m);  // [Stephens 1978]: 3 W / (2 rho_w r)
    if (is_one_of(units, {"kg m-3", "kg/m3", "kg m^-3", "kg/m^3", "kg m**-3"})) {
      scale_ = per_water;
      return {};
    }
    if (is_one_of(units, {"g m-3", "g/m3", "g m^-3", "g/m^3"})) {
      scale_ = 1e-3 * per_water;
      return {};
    }
    by_density_ = true;
    scale_ = per_water;
    if (is_one_of(units, {"g/kg", "g kg-1", "g kg^-1", "g kg**-1"}))
      scale_ *= 1e-3;
    else if (units.empty())
      assumptions_.push_back(concat("\"", name_, "\" is in kg/kg, because it has no units."));
    else if (!is_one_of(units, {"kg/kg", "kg kg-1", "kg kg^-1", "kg kg**-1", "1"}))
      return Error{concat("variable \"", name_, "\" is in \"", units,
                          "\"; accepted: kg/kg, g/kg, kg m-3, g m-3, m-1, or any with --extinction-per-m-per-unit")};
    return find_air();
  }

  Result<void> find_air() {
    density_ = air(kDensityNames);
    if (density_) {
      if (is_one_of(density_->field.units(), {"g m-3", "g/m3"})) density_->unit = 1e-3;
      return load_levels(*density_);
    }
    pressure_ = air(kPressureNames);
    temperature_ = air(kTemperatureNames);
    if (pressure_ && temperature_) {
      const std::string units = pressure_->field.units();
      if (is_one_of(units, {"hpa", "mb", "mbar", "millibar"})) pressure_->unit = 100.0;
      if (!units.empty() && pressure_->unit == 1.0 && !is_one_of(units, {"pa", "pascal"}))
        return Error{concat("pressure is in \"", units, "\"; accepted: Pa or hPa")};
      if (auto ok = load_levels(*pressure_); !ok) return ok;
      return load_levels(*temperature_);
    }
    pressure_.reset();
    temperature_.reset();
    assumptions_.push_back(
        "The air has the density of the standard atmosphere, because the file has neither that nor pressure and "
        "temperature.");
    return {};
  }

  // The first variable of such a name that has the water's axes, or heights alone.
  template <std::size_t N>
  std::optional<AirField> air(const std::array<const char*, N>& names) const {
    for (const char* name : names) {
      const auto id = file_.variable(name);
      if (!id) continue;
      Result<Field> field = Field::open(file_, *id, name);
      if (!field) continue;
      bool same = field->axes().size() == water_->axes().size(), heights = true;
      for (std::size_t i = 0; i < field->axes().size(); ++i) {
        const Axis axis = field->axes()[i];
        const auto own = water_->axis(axis.role);
        const bool fits = own && water_->axes()[*own].length == axis.length;
        same = same && fits && own == i;
        heights = heights && (axis.length == 1 || (fits && (axis.role == Role::z || axis.role == Role::time)));
      }
      if (!same && !(heights && field->axis(Role::z))) continue;
      return AirField{std::move(*field), same, {}, 1.0};
    }
    return std::nullopt;
  }

  Result<void> load_levels(AirField& air) const {
    if (air.whole) return {};
    std::vector<std::size_t> first, count;
    for (const Axis& axis : air.field.axes()) {
      first.push_back(axis.role == Role::time && axis.length > 1 ? time_ : 0);
      count.push_back(axis.role == Role::z ? axis.length : 1);
    }
    std::vector<float> values(grid_.count(2));
    if (auto ok = air.field.read(first, count, 0.0f, values); !ok) return ok;
    if (flipped_[2]) std::reverse(values.begin(), values.end());
    air.levels.assign(values.begin(), values.end());
    return {};
  }

  Result<void> read_air(const AirField& air, std::size_t first, std::size_t count, std::vector<float>& values) const {
    if (!air.whole) {
      fill_by_level([&](std::size_t z) { return air.unit * air.levels[z]; }, first, count, values);
      return {};
    }
    if (auto ok = read(air.field, first, count, 0.0f, values); !ok) return ok;
    for (float& value : values) value *= static_cast<float>(air.unit);
    return {};
  }

  template <class Value>
  void fill_by_level(Value&& value, std::size_t first, std::size_t count, std::vector<float>& values) const {
    const std::size_t a = grid_.count(order_[0]), b = grid_.count(order_[1]);
    std::vector<float> by_level(grid_.count(2));
    for (std::size_t z = 0; z < by_level.size(); ++z) by_level[z] = static_cast<float>(value(z));
    for (std::size_t p = 0, at = 0; p < count; ++p)
      for (std::size_t j = 0; j < b; ++j)
        for (std::size_t i = 0; i < a; ++i, ++at)
          values[at] = by_level[order_[2] == 2 ? first + p : order_[1] == 2 ? j : i];
  }

  // Planes of the volume; axes that fall in the file are turned round.
  Result<void> read(const Field& field, std::size_t first, std::size_t count, float missing,
                    std::span<float> values) const {
    std::vector<std::size_t> begin, size;
    for (const Axis& axis : field.axes()) {
      const int own = space(axis.role);
      if (own < 0) {
        begin.push_back(axis.role == Role::time ? time_ : 0);
        size.push_back(1);
      } else if (own == order_[2]) {
        begin.push_back(flipped_[static_cast<std::size_t>(own)] ? axis.length - first - count : first);
        size.push_back(count);
      } else {
        begin.push_back(0);
        size.push_back(axis.length);
      }
    }
    if (auto ok = field.read(begin, size, missing, values); !ok) return ok;
    const std::size_t a = grid_.count(order_[0]), b = grid_.count(order_[1]);
    const auto flipped = [&](std::size_t i) { return flipped_[static_cast<std::size_t>(order_[i])]; };
    if (flipped(2))
      for (std::size_t p = 0; p < count / 2; ++p)
        std::swap_ranges(values.begin() + static_cast<std::ptrdiff_t>(p * a * b),
                         values.begin() + static_cast<std::ptrdiff_t>((p + 1) * a * b),
                         values.begin() + static_cast<std::ptrdiff_t>((count - 1 - p) * a * b));
    for (std::size_t p = 0; p < count && flipped(1); ++p)
      for (std::size_t j = 0; j < b / 2; ++j)
        std::swap_ranges(values.begin() + static_cast<std::ptrdiff_t>((p * b + j) * a),
                         values.begin() + static_cast<std::ptrdiff_t>((p * b + j + 1) * a),
                         values.begin() + static_cast<std::ptrdiff_t>((p * b + b - 1 - j) * a));
    for (std::size_t row = 0; row < count * b && flipped(0); ++row)
      std::reverse(values.begin() + static_cast<std::ptrdiff_t>(row * a),
                   values.begin() + static_cast<std::ptrdiff_t>((row + 1) * a));
    return {};
  }

  NetcdfFile file_;
  std::string name_;
  std::optional<Field> water_;
  std::optional<AirField> density_, pressure_, temperature_;
  std::size_t time_ = 0;
  VolumeGrid grid_;
  std::array<int, 3> order_{0, 1, 2};
  std::array<bool, 3> flipped_{};
  bool by_density_ = false;
  double scale_ = 1.0;
  std::vector<double> times_s_;
  std::vector<std::string> assumptions_;
};

}  // namespace

Result<std::unique_ptr<VolumeReader>> open_netcdf_volume(const std::string& path, const NetcdfOptions& options) {
  auto volume = std::make_unique<NetcdfVolume>();
  if (auto ok = volume->open(path, options); !ok) return ok.error();
  return std::unique_ptr<VolumeReader>(std::move(volume));
}

Result<void> write_netcdf_volume(const std::string& path, VolumeReader& volume) {
  NEPHELE_CHECK((volume.axes() == std::array{0, 1, 2}), "planes across z");
  const std::string temporary = concat(path, ".tmp-", static_cast<long>(::getpid()));
  int file = -1;
  int code = ::nc_create(temporary.c_str(), NC_NETCDF4 | NC_CLOBBER, &file);
  const auto then = [&](auto&& step) {
    if (code == NC_NOERR) code = step();
  };
  std::array<int, 3> dimensions{}, coordinates{};  // x, y, z
  int extinction = -1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string name(1, "xyz"[axis]), letter(1, "XYZ"[axis]);
    then([&] {
      return ::nc_def_dim(file, name.c_str(), volume.grid().count(static_cast<int>(axis)), &dimensions[axis]);
    });
    then([&] { return ::nc_def_var(file, name.c_str(), NC_DOUBLE, 1, &dimensions[axis], &coordinates[axis]); });
    then([&] { return ::nc_put_att_text(file, coordinates[axis], "units", 1, "m"); });
    then([&] { return ::nc_put_att_text(file, coordinates[axis], "axis", 1, letter.c_str()); });
  }
  const std::array<int, 3> slowest_first{dimensions[2], dimensions[1], dimensions[0]};
  then([&] { return ::nc_def_var(file, "extinction", NC_FLOAT, 3, slowest_first.data(), &extinction); });
  then([&] { return ::nc_put_att_text(file, extinction, "units", 3, "m-1"); });
  then([&] { return ::nc_def_var_deflate(file, extinction, 1, 1, 2); });
  then([&] { return ::nc_enddef(file); });
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::vector<double>& bounds = volume.grid().bounds_m[axis];
    std::vector<double> middles;
    for (std::size_t i = 0; i + 1 < bounds.size(); ++i) middles.push_back(0.5 * (bounds[i] + bounds[i + 1]));
    then([&] { return ::nc_put_var_double(file, coordinates[axis], middles.data()); });
  }
  Result<void> read;
  std::vector<float> values;
  const std::size_t at_once = std::clamp<std::size_t>((std::size_t{1} << 22) / volume.plane_voxels(), 1, 16);
  for (std::size_t z = 0; z < volume.planes() && code == NC_NOERR && read; z += at_once) {
    const std::size_t count = std::min(at_once, volume.planes() - z);
    values.resize(count * volume.plane_voxels());
    read = volume.read_planes(z, count, values);
    const std::array<std::size_t, 3> first{z, 0, 0};
    const std::array<std::size_t, 3> size{count, volume.grid().count(1), volume.grid().count(0)};
    then([&] { return ::nc_put_vara_float(file, extinction, first.data(), size.data(), values.data()); });
  }
  if (file >= 0) {
    const int closed = ::nc_close(file);
    then([&] { return closed; });
  }
  std::error_code ignored;
  if (!read || code != NC_NOERR || std::rename(temporary.c_str(), path.c_str()) != 0) {
    std::filesystem::remove(temporary, ignored);
    if (!read) return read;
    return Error{path +
                 ": cannot be written: " + (code != NC_NOERR ? ::nc_strerror(code) : "its name cannot be taken")};
  }
  return {};
}

}  // namespace nephele::clouds

#else

namespace nephele::clouds {
namespace {
constexpr const char* kMissing =
    ": this program was built without NetCDF; install libnetcdf-dev and build with -DNEPHELE_IMPORT=ON";
}

Result<std::unique_ptr<VolumeReader>> open_netcdf_volume(const std::string& path, const NetcdfOptions&) {
  return Error{path + kMissing};
}
Result<void> write_netcdf_volume(const std::string& path, VolumeReader&) { return Error{path + kMissing}; }

}  // namespace nephele::clouds

#endif
