#include "tools/clouds/png_volume.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>
#include <vector>

#include "engine/atomic_file.h"
#include "engine/check.h"
#include "engine/image_io.h"
#include "engine/json_reader.h"

namespace nephele::clouds {
namespace {

namespace fs = std::filesystem;

constexpr const char* kNote = "slices.json";
constexpr std::uint32_t kMaxSidePx = 65535;
constexpr std::size_t kMostSlices = 8192;

// What slices.json says.
struct Note {
  glm::dvec3 voxel_m{0.0}, corner_m{0.0};
  double scale_per_m = 0.0;
};

Result<Note> read_note(const std::string& path) {
  const Result<std::string> text = read_text_file(path);
  if (!text) return text.error();
  const Result<nlohmann::json> document = parse_json(*text, path);
  if (!document) return document.error();
  JsonReader reader(path);
  JsonObject json = reader.root(*document);
  Note note;
  for (const char* key : {"voxel_m", "corner_m", "extinction_per_m_per_unit"}) json.require(key);
  json.vector("voxel_m", note.voxel_m, {{1e-3, 1e5}});
  json.vector("corner_m", note.corner_m, {{-1e6, 1e6}});
  json.number("extinction_per_m_per_unit", note.scale_per_m, {1e-12, 1e9});
  json.finish();
  if (reader.error()) return *reader.error();
  return note;
}

// The last number in a name; names without one come first.
std::int64_t number_in(const std::string& name) {
  const std::size_t last = name.find_last_of("0123456789");
  if (last == std::string::npos) return -1;
  std::size_t first = last;
  while (first > 0 && std::isdigit(static_cast<unsigned char>(name[first - 1])) != 0) --first;
  std::int64_t number = 0;
  for (std::size_t i = first; i <= last && number < (std::int64_t{1} << 50); ++i)
    number = 10 * number + (name[i] - '0');
  return number;
}

class SliceVolume : public VolumeReader {
 public:
  SliceVolume(std::vector<std::string> files, VolumeGrid grid, double scale)
      : files_(std::move(files)), grid_(std::move(grid)), scale_(static_cast<float>(scale / 255.0)) {}

  const VolumeGrid& grid() const override { return grid_; }

  Result<void> read_planes(std::size_t first, std::size_t count, std::span<float> values) override {
    NEPHELE_CHECK(values.size() == count * plane_voxels() && first + count <= planes());
    const std::size_t width = grid_.count(0), height = grid_.count(1);
    for (std::size_t z = first; z < first + count; ++z) {
      const Result<ImageBytes> image = read_png(files_[z], kMaxSidePx);
      if (!image) return image.error();
      if (image->width != width || image->height != height)
        return Error{concat(files_[z], ": ", image->width, "x", image->height, " pixels; accepted: ", width, "x",
                            height, ", as the first slice has")};
      for (std::size_t y = 0; y < height; ++y)  // rows from the north
        for (std::size_t x = 0; x < width; ++x)
          values[((z - first) * height + y) * width + x] =
              scale_ *
              static_cast<float>(image->data[((height - 1 - y) * width + x) * image->channels + image->channels - 1]);
    }
    return {};
  }

 private:
  std::vector<std::string> files_;
  VolumeGrid grid_;
  float scale_;
};

Result<std::unique_ptr<VolumeReader>> open_strip(const std::string& path, const PngOptions& options) {
  if (!options.voxel_m) return Error{path + ": --voxel-m is missing; a picture does not say how large its voxels are"};
  const Result<ImageBytes> image = read_png(path, kMaxSidePx);
  if (!image) return image.error();
  const std::size_t side = image->height, slices = side > 0 ? image->width / side : 0;
  if (slices == 0 || image->width % side != 0)
    return Error{
        concat(path, ": ", image->width, "x", side, " pixels; accepted: a width that is a multiple of the height")};
  VolumeGrid grid;
  const std::array<std::size_t, 3> counts{side, side, slices};
  for (std::size_t axis = 0; axis < 3; ++axis)
    grid.bounds_m[axis] = even_bounds(counts[axis], 0.0, (*options.voxel_m)[static_cast<int>(axis)]);
  const float scale = static_cast<float>(options.scale_per_m.value_or(1.0) / 255.0);
  std::vector<float> values(side * side * slices);
  for (std::size_t z = 0, at = 0; z < slices; ++z)
    for (std::size_t y = 0; y < side; ++y)
      for (std::size_t x = 0; x < side; ++x, ++at)
        values[at] =
            scale *
            static_cast<float>(
                image->data[((side - 1 - y) * image->width + z * side + x) * image->channels + image->channels - 1]);
  return std::unique_ptr<VolumeReader>(std::make_unique<MemoryVolume>(std::move(grid), std::move(values)));
}

}  // namespace

Result<std::unique_ptr<VolumeReader>> open_png_volume(const std::string& path, const PngOptions& options) {
  std::error_code failure;
  if (!fs::is_directory(path, failure)) return open_strip(path, options);
  std::vector<std::string> files;
  for (fs::directory_iterator at(path, failure), end; !failure && at != end; at.increment(failure)) {
    std::string extension = at->path().extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    if (extension == ".png" && files.size() <= kMostSlices) files.push_back(at->path().string());
  }
  if (failure) return Error{path + ": cannot be listed: " + failure.message()};
  if (files.empty() || files.size() > kMostSlices)
    return Error{concat(path, ": ", files.empty() ? "no" : "too many", " PNG slices; accepted: 1 to ", kMostSlices)};
  std::sort(files.begin(), files.end(), [](const std::string& a, const std::string& b) {
    const std::string first = fs::path(a).stem().string(), second = fs::path(b).stem().string();
    return std::pair(number_in(first), first) < std::pair(number_in(second), second);
  });
  for (std::size_t i = 1; i < files.size(); ++i) {
    const std::int64_t below = number_in(fs::path(files[i - 1]).stem().string());
    const std::int64_t here = number_in(fs::path(files[i]).stem().string());
    if (here != below + 1)
      return Error{files[i] + ": follows " + files[i - 1] + "; accepted: slices numbered without a gap"};
  }
  Note note;
  const std::string note_path = (fs::path(path) / kNote).string();
  const bool noted = fs::exists(note_path, failure);
  if (noted) {
    const Result<Note> read = read_note(note_path);
    if (!read) return read.error();
    note = *read;
  } else if (!options.voxel_m) {
    return Error{path + ": --voxel-m is missing; pictures do not say how large their voxels are"};
  }
  const Result<ImageBytes> first = read_png(files.front(), kMaxSidePx);
  if (!first) return first.error();
  VolumeGrid grid;
  const std::array<std::size_t, 3> counts{first->width, first->height, files.size()};
  const glm::dvec3 voxel_m = options.voxel_m.value_or(note.voxel_m);
  for (std::size_t axis = 0; axis < 3; ++axis)
    grid.bounds_m[axis] =
        even_bounds(counts[axis], note.corner_m[static_cast<int>(axis)], voxel_m[static_cast<int>(axis)]);
  if (auto ok = check_grid(grid); !ok) return Error{path + ": " + ok.error().message};
  const double scale = options.scale_per_m.value_or(noted ? note.scale_per_m : 1.0);
  return std::unique_ptr<VolumeReader>(std::make_unique<SliceVolume>(std::move(files), std::move(grid), scale));
}

Result<void> write_png_volume(const std::string& directory, VolumeReader& volume) {
  NEPHELE_CHECK((volume.axes() == std::array{0, 1, 2}), "planes across z");
  std::error_code failure;
  fs::create_directories(directory, failure);
  if (failure) return Error{directory + ": cannot be made: " + failure.message()};
  const std::size_t width = volume.grid().count(0), height = volume.grid().count(1);
  std::vector<float> values(volume.plane_voxels());
  float peak = 0.0f;  // white
  for (std::size_t z = 0; z < volume.planes(); ++z) {
    if (auto ok = volume.read_planes(z, 1, values); !ok) return ok;
    peak = std::max(peak, *std::max_element(values.begin(), values.end()));
  }
  std::vector<std::uint8_t> rgba(4 * width * height, 255);
  for (std::size_t z = 0; z < volume.planes(); ++z) {
    if (auto ok = volume.read_planes(z, 1, values); !ok) return ok;
    for (std::size_t y = 0; y < height; ++y)
      for (std::size_t x = 0; x < width; ++x) {
        const float value = peak > 0.0f ? values[(height - 1 - y) * width + x] / peak : 0.0f;
        for (std::size_t channel = 0; channel < 3; ++channel)
          rgba[4 * (y * width + x) + channel] = static_cast<std::uint8_t>(255.0f * value + 0.5f);
      }
    char name[32];
    std::snprintf(name, sizeof name, "slice_%04zu.png", z);
    if (auto ok = write_png((fs::path(directory) / name).string(), static_cast<std::uint32_t>(width),
                            static_cast<std::uint32_t>(height), rgba);
        !ok)
      return ok;
  }
  const auto step = [&](std::size_t axis) { return volume.grid().bounds_m[axis][1] - volume.grid().bounds_m[axis][0]; };
  const auto corner = [&](std::size_t axis) { return volume.grid().bounds_m[axis][0]; };
  const nlohmann::ordered_json note{{"voxel_m", {step(0), step(1), step(2)}},
                                    {"corner_m", {corner(0), corner(1), corner(2)}},
                                    {"extinction_per_m_per_unit", peak > 0.0f ? static_cast<double>(peak) : 1.0}};
  return write_file_atomically((fs::path(directory) / kNote).string(), note.dump(2) + '\n');
}

}  // namespace nephele::clouds
