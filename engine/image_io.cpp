#include "engine/image_io.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb_image_write.h>
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#define STBI_NO_STDIO
#include <stb_image.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <limits>

#include "engine/atomic_file.h"
#include "engine/check.h"
#include "engine/json_reader.h"

namespace nephele {
namespace {

constexpr std::size_t kMaxFloats = std::size_t{1} << 30;

// An OpenEXR output stream into memory, so that the file is written in one piece.
class MemoryStream : public Imf::OStream {
 public:
  MemoryStream() : Imf::OStream("memory") {}
  void write(const char bytes[], int count) override {
    const std::size_t end = position_ + static_cast<std::size_t>(count);
    if (data_.size() < end) data_.resize(end);
    std::memcpy(data_.data() + position_, bytes, static_cast<std::size_t>(count));
    position_ = end;
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = position; }
  std::span<const std::byte> bytes() const { return std::as_bytes(std::span(data_)); }

 private:
  std::vector<char> data_;
  std::size_t position_ = 0;
};

// One slice per channel of the interleaved data of a window.
Imf::FrameBuffer frame_buffer(const std::vector<std::string>& channels, const float* data, const Imath::Box2i& window) {
  const std::size_t pixel_bytes = channels.size() * sizeof(float);
  Imf::FrameBuffer buffer;
  for (std::size_t c = 0; c < channels.size(); ++c)
    buffer.insert(channels[c], Imf::Slice::Make(Imf::FLOAT, data + c, window, pixel_bytes));
  return buffer;
}

Error unreadable(const std::string& path, std::string reason) {
  std::replace(reason.begin(), reason.end(), '\n', ' ');
  return Error{path + ": can't be read as an OpenEXR image: " + reason};
}

Error unreadable_png(const std::string& path, const std::string& reason) {
  return Error{path + ": can't be read as a PNG image: " + reason};
}

// The bytes of a PNG whose header is read and whose size is accepted.
struct PngFile {
  std::string bytes;
  int channels = 0;

  const stbi_uc* data() const { return reinterpret_cast<const stbi_uc*>(bytes.data()); }
  int length() const { return static_cast<int>(std::min<std::size_t>(bytes.size(), std::numeric_limits<int>::max())); }
};

Result<PngFile> open_png(const std::string& path, std::uint32_t max_side_px) {
  Result<std::string> text = read_text_file(path);
  if (!text) return text.error();
  PngFile file{std::move(*text)};
  int width = 0, height = 0;
  if (!stbi_info_from_memory(file.data(), file.length(), &width, &height, &file.channels))
    return unreadable_png(path, stbi_failure_reason());
  const int most = static_cast<int>(max_side_px);
  if (width < 1 || height < 1 || width > most || height > most)
    return unreadable_png(path, concat("it is ", width, " x ", height, "; accepted: 1 to ", max_side_px, " a side"));
  return file;
}

}  // namespace

std::optional<std::size_t> ImageF::channel_index(std::string_view name) const {
  const auto found = std::find(channels.begin(), channels.end(), name);
  if (found == channels.end()) return std::nullopt;
  return static_cast<std::size_t>(found - channels.begin());
}

Result<void> write_png(const std::string& path, std::uint32_t width, std::uint32_t height,
                       std::span<const std::uint8_t> rgba) {
  const std::size_t pixels = std::size_t{width} * height;
  NEPHELE_CHECK(rgba.size() == pixels * 4, width, " x ", height, " pixels, ", rgba.size(), " bytes");
  std::vector<std::uint8_t> rgb(pixels * 3);
  for (std::size_t i = 0; i < pixels; ++i) std::copy_n(rgba.begin() + 4 * i, 3, rgb.begin() + 3 * i);
  std::vector<std::byte> file;
  const auto append = [](void* to, void* data, int count) {
    auto& bytes = *static_cast<std::vector<std::byte>*>(to);
    const auto* first = static_cast<const std::byte*>(data);
    bytes.insert(bytes.end(), first, first + count);
  };
  const int encoded = stbi_write_png_to_func(append, &file, static_cast<int>(width), static_cast<int>(height), 3,
                                             rgb.data(), static_cast<int>(width * 3));
  NEPHELE_CHECK(encoded != 0, "PNG of ", width, " x ", height);
  return write_file_atomically(path, file);
}

Result<ImageBytes> read_png(const std::string& path, std::uint32_t max_side_px) {
  const Result<PngFile> file = open_png(path, max_side_px);
  if (!file) return file.error();
  const int kept = file->channels < 3 ? 1 : 3;
  int width = 0, height = 0, channels = 0;
  stbi_uc* pixels = stbi_load_from_memory(file->data(), file->length(), &width, &height, &channels, kept);
  if (!pixels) return unreadable_png(path, stbi_failure_reason());
  ImageBytes image{
      static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), static_cast<std::uint32_t>(kept), {}};
  image.data.assign(pixels, pixels + std::size_t{image.width} * image.height * image.channels);
  stbi_image_free(pixels);
  return image;
}

Result<GreyImage> read_grey_png(const std::string& path, std::uint32_t max_side_px) {
  const Result<PngFile> file = open_png(path, max_side_px);
  if (!file) return file.error();
  if (file->channels > 2) return unreadable_png(path, "it has colours; accepted: a grey image of 8 or 16 bits");
  int width = 0, height = 0, channels = 0;
  stbi_us* pixels = stbi_load_16_from_memory(file->data(), file->length(), &width, &height, &channels, 1);
  if (!pixels) return unreadable_png(path, stbi_failure_reason());
  GreyImage image{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), {}};
  image.data.assign(pixels, pixels + std::size_t{image.width} * image.height);
  stbi_image_free(pixels);
  return image;
}

Result<void> write_exr(const std::string& path, const ImageF& image) {
  NEPHELE_CHECK(image.data.size() == std::size_t{image.width} * image.height * image.channels.size(), image.width,
                " x ", image.height, " x ", image.channels.size(), " values, not ", image.data.size());
  Imf::Header header(static_cast<int>(image.width), static_cast<int>(image.height));
  header.compression() = Imf::ZIP_COMPRESSION;
  for (const std::string& channel : image.channels) header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
  MemoryStream stream;
  {
    Imf::OutputFile file(stream, header);
    file.setFrameBuffer(frame_buffer(image.channels, image.data.data(), header.dataWindow()));
    file.writePixels(static_cast<int>(image.height));
  }
  return write_file_atomically(path, stream.bytes());
}

Result<ImageF> read_exr(const std::string& path) try {
  Imf::InputFile file(path.c_str());
  const Imath::Box2i window = file.header().dataWindow();
  const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
  const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
  if (width < 1 || height < 1 || width > kMaxImageSidePx || height > kMaxImageSidePx)
    return unreadable(path, concat("it is ", width, " x ", height, "; accepted: 1 to ", kMaxImageSidePx, " a side"));

  ImageF image;
  image.width = static_cast<std::uint32_t>(width);
  image.height = static_cast<std::uint32_t>(height);
  const Imf::ChannelList& channels = file.header().channels();
  for (auto channel = channels.begin(); channel != channels.end(); ++channel) image.channels.push_back(channel.name());
  const std::size_t floats = static_cast<std::size_t>(width * height) * image.channels.size();
  if (floats == 0 || floats > kMaxFloats) return unreadable(path, concat("it holds ", floats, " values"));

  image.data.resize(floats);
  file.setFrameBuffer(frame_buffer(image.channels, image.data.data(), window));
  file.readPixels(window.min.y, window.max.y);
  return image;
} catch (const std::exception& failure) {
  return unreadable(path, failure.what());
}

}  // namespace nephele
