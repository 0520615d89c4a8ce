#include "tools/clouds/vdb_file.h"

#ifdef NEPHELE_OPENVDB

#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <istream>
#include <utility>
#include <vector>

#include "engine/check.h"

namespace nephele::clouds {
namespace {

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

// OpenVDB takes what it reads beyond a file's end for numbers, and may count by them for hours. So before it sees the
// file: the header's texts lie inside it, and every grid ends inside it.
class HeaderCheck {
 public:
  HeaderCheck(std::istream& file, std::uint64_t bytes) : file_(file), bytes_(bytes) {}

  Result<void> run() {
    std::array<char, 36> id{};
    if (number<std::uint64_t>() != 0x56444220u) return Error{"not an OpenVDB file"};
    const auto version = number<std::uint32_t>();
    if (version < 222) return Error{concat("of format version ", version, "; accepted: 222 or later")};
    skip(8);  // version of the library that wrote it
    const auto offsets = number<std::uint8_t>();
    if (offsets != 1) return Error{"without grid offsets; accepted: files that say where their grids lie"};
    file_.read(id.data(), id.size());
    const auto metadata = number<std::uint32_t>();
    for (std::uint32_t i = 0; i < metadata && good(); ++i)
      for (int part = 0; part < 3; ++part) skip(number<std::uint32_t>());  // name, type, value
    const auto grids = number<std::int32_t>();
    if (!good() || grids < 0 || grids > 10000) return Error{"damaged: its header"};
    for (std::int32_t i = 0; i < grids; ++i) {
      for (int part = 0; part < 3; ++part) skip(number<std::uint32_t>());  // name, type, parent
      const auto grid = number<std::int64_t>(), blocks = number<std::int64_t>(), end = number<std::int64_t>();
      const auto here = static_cast<std::int64_t>(file_.tellg());
      if (!good() || grid < here || blocks < grid || end < blocks || static_cast<std::uint64_t>(end) > bytes_)
        return Error{"damaged, or cut short: a grid does not lie inside the file"};
      file_.seekg(end);
    }
    return {};
  }

 private:
  template <class T>
  T number() {
    T value{};
    file_.read(reinterpret_cast<char*>(&value), sizeof value);
    return good() ? value : T{};
  }
  void skip(std::uint64_t count) {
    if (count > bytes_) file_.setstate(std::ios::failbit);
    file_.seekg(static_cast<std::streamoff>(count), std::ios::cur);
    if (good() && static_cast<std::uint64_t>(file_.tellg()) > bytes_) file_.setstate(std::ios::failbit);
  }
  bool good() const { return !file_.fail(); }

  std::istream& file_;
  std::uint64_t bytes_;
};

template <class Grid>
class VdbVolume : public VolumeReader {
 public:
  VdbVolume(typename Grid::ConstPtr grid, const openvdb::CoordBBox& box, VolumeGrid bounds, double scale)
      : grid_(std::move(grid)), box_(box), bounds_(std::move(bounds)), scale_(static_cast<float>(scale)) {}

  const VolumeGrid& grid() const override { return bounds_; }
  std::array<int, 3> axes() const override { return {2, 1, 0}; }

  Result<void> read_planes(std::size_t first, std::size_t count, std::span<float> values) override {
    NEPHELE_CHECK(values.size() == count * plane_voxels() && first + count <= planes());
    openvdb::CoordBBox box = box_;
    box.min().x() = box_.min().x() + static_cast<int>(first);
    box.max().x() = box.min().x() + static_cast<int>(count) - 1;
    openvdb::tools::Dense<float> dense(box, values.data());  // z fastest
    openvdb::tools::copyToDense(*grid_, dense);
    for (float& value : values) value *= scale_;
    return {};
  }

 private:
  typename Grid::ConstPtr grid_;
  openvdb::CoordBBox box_;
  VolumeGrid bounds_;
  float scale_;
};

// What the transform makes of the box, if it only scales and moves.
Result<VolumeGrid> bounds_of(const openvdb::GridBase& grid, const openvdb::CoordBBox& box) {
  if (!grid.transform().isLinear())
    return Error{"grid \"" + grid.getName() + "\": its transform is a frustum; accepted: scales and moves alone"};
  const openvdb::math::Mat4d m = grid.transform().baseMap()->getAffineMap()->getMat4();
  VolumeGrid bounds;
  for (int axis = 0; axis < 3; ++axis) {
    for (int other = 0; other < 3; ++other)
      if (other != axis && std::abs(m(axis, other)) > 1e-6 * std::abs(m(axis, axis)))
        return Error{"grid \"" + grid.getName() +
                     "\": its transform turns or shears; accepted: scales and moves alone"};
    if (!(m(axis, axis) > 0.0 && std::isfinite(m(axis, axis)) && std::isfinite(m(3, axis))))
      return Error{concat("grid \"", grid.getName(), "\": voxels of ", m(axis, axis), "; accepted: more than 0")};
    const double first = (static_cast<double>(box.min()[axis]) - 0.5) * m(axis, axis) + m(3, axis);
    bounds.bounds_m[static_cast<std::size_t>(axis)] =
        even_bounds(static_cast<std::size_t>(box.max()[axis] - box.min()[axis]) + 1, first, m(axis, axis));
  }
  return bounds;
}

template <class Grid>
Result<std::unique_ptr<VolumeReader>> volume_of(const openvdb::GridBase::Ptr& base, double scale) {
  const typename Grid::ConstPtr grid = openvdb::gridConstPtrCast<Grid>(base);
  const openvdb::CoordBBox box = grid->evalActiveVoxelBoundingBox();
  if (box.empty()) return Error{"grid \"" + base->getName() + "\" has no active voxel"};
  for (int axis = 0; axis < 3; ++axis)
    if (static_cast<std::int64_t>(box.max()[axis]) - box.min()[axis] >= static_cast<std::int64_t>(kMaxVoxelsAlongAxis))
      return Error{concat("grid \"", base->getName(), "\": active voxels from ", box.min()[axis], " to ",
                          box.max()[axis], " along ", "xyz"[axis], "; accepted: at most ", kMaxVoxelsAlongAxis)};
  Result<VolumeGrid> bounds = bounds_of(*base, box);
  if (!bounds) return bounds.error();
  return std::unique_ptr<VolumeReader>(std::make_unique<VdbVolume<Grid>>(grid, box, std::move(*bounds), scale));
}

}  // namespace

Result<std::unique_ptr<VolumeReader>> open_vdb_volume(const std::string& path, const std::string& name, double scale) {
  {
    std::ifstream header(path, std::ios::binary);
    if (auto ok = HeaderCheck(header, std::filesystem::file_size(path)).run(); !ok) return ok.error();
  }
  openvdb::initialize();
  openvdb::io::File file(path);
  file.open();  // leaves are read when they are looked at
  std::vector<std::string> scalar;
  std::string all;
  for (auto at = file.beginName(); at != file.endName(); ++at) {
    const std::string found = at.gridName();
    all.append(all.empty() ? "\"" : ", \"").append(found).append("\"");
    const openvdb::GridBase::Ptr metadata = file.readGridMetadata(found);
    if (metadata->isType<openvdb::FloatGrid>() || metadata->isType<openvdb::DoubleGrid>()) scalar.push_back(found);
  }
  std::string chosen = name;
  if (name.empty()) {
    const auto known = std::find_if(scalar.begin(), scalar.end(), [](const std::string& candidate) {
      const std::string text = lower_case(candidate);
      return text.find("density") != std::string::npos || text.find("extinction") != std::string::npos;
    });
    if (known != scalar.end())
      chosen = *known;
    else if (scalar.size() == 1)
      chosen = scalar.front();
    else
      return Error{concat("--grid is missing: none of its ", scalar.size(),
                          " grids of numbers is named density or "
                          "extinction; it has ",
                          all.empty() ? "none at all" : all)};
  } else if (std::find(scalar.begin(), scalar.end(), name) == scalar.end()) {
    return Error{concat("--grid is \"", name, "\"; it has no such grid of numbers, but ", all.empty() ? "none" : all)};
  }
  const openvdb::GridBase::Ptr grid = file.readGrid(chosen);
  if (grid->getGridClass() == openvdb::GRID_LEVEL_SET)
    return Error{"grid \"" + chosen + "\" is a level set, a distance from a surface; accepted: fog volumes"};
  if (grid->isType<openvdb::DoubleGrid>()) return volume_of<openvdb::DoubleGrid>(grid, scale);
  return volume_of<openvdb::FloatGrid>(grid, scale);
}

Result<void> write_vdb_volume(const std::string& path, VolumeReader& volume) {
  NEPHELE_CHECK((volume.axes() == std::array{2, 1, 0}), "planes across x");
  const std::string temporary = concat(path, ".tmp-", static_cast<long>(::getpid()));
  std::error_code ignored;
  const auto failed = [&](const std::string& why) {
    std::filesystem::remove(temporary, ignored);
    return Error{path + ": cannot be written: " + why};
  };
  try {
    openvdb::initialize();
    const openvdb::FloatGrid::Ptr grid = openvdb::FloatGrid::create(0.0f);
    grid->setName("density");
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    openvdb::math::Mat4d map = openvdb::math::Mat4d::identity();
    for (int axis = 0; axis < 3; ++axis) {
      const std::vector<double>& bounds = volume.grid().bounds_m[static_cast<std::size_t>(axis)];
      map(axis, axis) = (bounds.back() - bounds.front()) / static_cast<double>(bounds.size() - 1);
      map(3, axis) = bounds.front() + 0.5 * map(axis, axis);
    }
    grid->setTransform(openvdb::math::Transform::createLinearTransform(map));
    const std::size_t at_once = 8;  // a leaf
    std::vector<float> values;
    for (std::size_t first = 0; first < volume.planes(); first += at_once) {
      const std::size_t count = std::min(at_once, volume.planes() - first);
      values.resize(count * volume.plane_voxels());
      if (auto ok = volume.read_planes(first, count, values); !ok) return ok;
      const auto last = [&](int axis) { return static_cast<int>(volume.grid().count(axis)) - 1; };
      const openvdb::CoordBBox box(static_cast<int>(first), 0, 0, static_cast<int>(first + count) - 1, last(1),
                                   last(2));
      const openvdb::tools::Dense<float> dense(box, values.data());
      openvdb::tools::copyFromDense(dense, *grid, 0.0f, true);
    }
    openvdb::io::File file(temporary);
    file.write({grid});
    file.close();
  } catch (const std::exception& failure) {
    return failed(failure.what());
  }
  if (std::rename(temporary.c_str(), path.c_str()) != 0) return failed("its name cannot be taken");
  return {};
}

}  // namespace nephele::clouds

#else

namespace nephele::clouds {
namespace {
constexpr const char* kMissing =
    ": this program was built without OpenVDB; install libopenvdb-dev and build with -DNEPHELE_IMPORT=ON";
}

Result<std::unique_ptr<VolumeReader>> open_vdb_volume(const std::string& path, const std::string&, double) {
  return Error{path + kMissing};
}
Result<void> write_vdb_volume(const std::string& path, VolumeReader&) { return Error{path + kMissing}; }

}  // namespace nephele::clouds

#endif
