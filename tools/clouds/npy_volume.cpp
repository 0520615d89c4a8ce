#include "tools/clouds/npy_volume.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/packing.hpp>
#include <system_error>
#include <utility>
#include <vector>

#include "engine/check.h"
#include "engine/npy.h"

namespace nephele::clouds {
namespace {

constexpr std::size_t kMaxVoxels = std::size_t{1} << 38;

class NpyVolume : public VolumeReader {
 public:
  NpyVolume(std::string path, std::ifstream file, const NpyLayout& layout, VolumeGrid grid, double scale)
      : path_(std::move(path)),
        file_(std::move(file)),
        layout_(layout),
        grid_(std::move(grid)),
        scale_(static_cast<float>(scale)) {}

  const VolumeGrid& grid() const override { return grid_; }
  std::array<int, 3> axes() const override { return {2, 1, 0}; }

  Result<void> read_planes(std::size_t first, std::size_t count, std::span<float> values) override {
    NEPHELE_CHECK(values.size() == count * plane_voxels() && first + count <= planes());
    const std::size_t bytes = element_bytes(layout_.type);
    bytes_.resize(values.size() * bytes);
    file_.seekg(static_cast<std::streamoff>(layout_.data_at + first * plane_voxels() * bytes));
    if (!file_.read(bytes_.data(), static_cast<std::streamsize>(bytes_.size())))
      return Error{path_ + ": cannot be read to its end"};
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = scale_ * value(i);
    return {};
  }

 private:
  float value(std::size_t i) const {
    if (layout_.type == ElementType::uint8) return static_cast<float>(static_cast<std::uint8_t>(bytes_[i]));
    if (layout_.type == ElementType::float16) {
      std::uint16_t half = 0;
      std::memcpy(&half, &bytes_[2 * i], sizeof half);
      return glm::unpackHalf2x16(half).x;
    }
    float whole = 0.0f;
    std::memcpy(&whole, &bytes_[4 * i], sizeof whole);
    return whole;
  }

  std::string path_;
  std::ifstream file_;
  NpyLayout layout_;
  VolumeGrid grid_;
  float scale_;
  std::vector<char> bytes_;
};

}  // namespace

Result<std::unique_ptr<VolumeReader>> open_npy_volume(const std::string& path, const glm::dvec3& voxel_m,
                                                      double scale) {
  const Result<NpyLayout> layout = read_npy_layout(path, kMaxVoxels);
  if (!layout) return layout.error();
  if (layout->shape.size() != 3)
    return Error{concat(path, ": shape: ", layout->shape.size(), " axes; accepted: 3, indexed [x][y][z]")};
  VolumeGrid grid;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (layout->shape[axis] > kMaxVoxelsAlongAxis)
      return Error{concat(path, ": shape: ", layout->shape[axis], " voxels along an axis; accepted: at most ",
                          kMaxVoxelsAlongAxis)};
    grid.bounds_m[axis] = even_bounds(layout->shape[axis], 0.0, voxel_m[static_cast<glm::length_t>(axis)]);
  }
  if (auto ok = check_grid(grid); !ok) return Error{path + ": " + ok.error().message};
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{path + ": cannot be opened for reading"};
  return std::unique_ptr<VolumeReader>(
      std::make_unique<NpyVolume>(path, std::move(file), *layout, std::move(grid), scale));
}

Result<void> write_npy_volume(const std::string& path, VolumeReader& volume) {
  NEPHELE_CHECK((volume.axes() == std::array{2, 1, 0}), "planes across x");
  const VolumeGrid& grid = volume.grid();
  std::string header = concat("{'descr': '<f4', 'fortran_order': False, 'shape': (", grid.count(0), ", ", grid.count(1),
                              ", ", grid.count(2), "), }");
  while ((10 + header.size() + 1) % 64 != 0) header += ' ';  // the data begin at a multiple of 64 bytes
  header += '\n';
  const std::string temporary = concat(path, ".tmp-", static_cast<long>(::getpid()));
  std::error_code failure;
  std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
  file.write("\x93NUMPY\x01\x00", 8);
  file.put(static_cast<char>(header.size() & 255)).put(static_cast<char>(header.size() >> 8));
  file.write(header.data(), static_cast<std::streamsize>(header.size()));
  const std::size_t at_once = std::clamp<std::size_t>((std::size_t{1} << 22) / volume.plane_voxels(), 1, 16);
  std::vector<float> values;
  Result<void> read;
  for (std::size_t first = 0; first < volume.planes() && file && read; first += at_once) {
    const std::size_t count = std::min(at_once, volume.planes() - first);
    values.resize(count * volume.plane_voxels());
    read = volume.read_planes(first, count, values);
    file.write(reinterpret_cast<const char*>(values.data()),
               static_cast<std::streamsize>(values.size() * sizeof(float)));
  }
  file.close();
  const bool written = read && file;
  if (written) std::filesystem::rename(temporary, path, failure);
  if (!written || failure) {
    std::error_code ignored;
    std::filesystem::remove(temporary, ignored);
    return read ? Error{path + ": cannot be written"} : read;
  }
  return {};
}

}  // namespace nephele::clouds
