#include "engine/image_io.h"

#include <doctest/doctest.h>
#include <sys/stat.h>

#include <cstring>
#include <filesystem>
#include <limits>

#include "engine/atomic_file.h"
#include "tests/support/support.h"

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

using namespace nephele;

namespace {

ImageF ramp(std::uint32_t width, std::uint32_t height, std::vector<std::string> channels) {
  ImageF image{width, height, std::move(channels), {}};
  for (std::size_t i = 0; i < std::size_t{width} * height * image.channels.size(); ++i)
    image.data.push_back(static_cast<float>(i) * 0.37f - 3.0f);
  return image;
}

void ok(const Result<void>& result) {
  if (!result) FAIL(result.error().message);
}

}  // namespace

TEST_CASE("image: EXR keeps every float bit, found again by channel name") {
  const test::TempDirectory directory;
  const std::string path = directory / "layers.exr";
  ImageF written = ramp(7, 5, {"R", "G", "B", "T", "Z"});
  written.data[4] = std::numeric_limits<float>::infinity();
  written.data[9] = std::numeric_limits<float>::denorm_min();
  written.data[14] = -0.0f;
  written.data[19] = std::numeric_limits<float>::max();
  ok(write_exr(path, written));
  const Result<ImageF> read = read_exr(path);
  if (!read) FAIL(read.error().message);
  CHECK(read->width == 7);
  CHECK(read->height == 5);
  REQUIRE(read->channels.size() == 5);
  CHECK_FALSE(read->channel_index("A").has_value());
  for (std::size_t c = 0; c < written.channels.size(); ++c) {
    const auto index = read->channel_index(written.channels[c]);
    REQUIRE(index.has_value());
    for (std::uint32_t y = 0; y < 5; ++y)
      for (std::uint32_t x = 0; x < 7; ++x) {
        const float a = written.at(x, y, c), b = read->at(x, y, *index);
        CHECK(std::memcmp(&a, &b, sizeof a) == 0);
      }
  }
}

TEST_CASE("image: the same pixels give the same bytes, and nothing else is left in the directory") {
  const test::TempDirectory directory;
  const ImageF image = ramp(64, 33, {"R", "G", "B"});
  ok(write_exr(directory / "a.exr", image));
  ok(write_exr(directory / "b.exr", image));
  CHECK(test::read_file(directory / "a.exr") == test::read_file(directory / "b.exr"));
  const std::vector<std::uint8_t> pixels(64 * 33 * 4, 77);
  ok(write_png(directory / "a.png", 64, 33, pixels));
  ok(write_png(directory / "b.png", 64, 33, pixels));
  CHECK(test::read_file(directory / "a.png") == test::read_file(directory / "b.png"));
  CHECK(directory.entries() == std::vector<std::string>{"a.exr", "a.png", "b.exr", "b.png"});
}

TEST_CASE("image: PNG holds the bytes it was given, alpha dropped") {
  const test::TempDirectory directory;
  std::vector<std::uint8_t> rgba;
  for (int i = 0; i < 5 * 3 * 4; ++i) rgba.push_back(static_cast<std::uint8_t>(i * 37));
  ok(write_png(directory / "x.png", 5, 3, rgba));
  int width = 0, height = 0, channels = 0;
  unsigned char* pixels = stbi_load((directory / "x.png").c_str(), &width, &height, &channels, 0);
  REQUIRE(pixels != nullptr);
  CHECK(width == 5);
  CHECK(height == 3);
  REQUIRE(channels == 3);
  for (int i = 0; i < 15; ++i)
    for (int c = 0; c < 3; ++c) CHECK(pixels[3 * i + c] == rgba[static_cast<std::size_t>(4 * i + c)]);
  stbi_image_free(pixels);
}

// 2 x 1 grey pixels of 51 and 204, without and with alpha.
constexpr const char* kGreyPng =
    "89504e470d0a1a0a0000000d4948445200000002000000010800000000d14920560000000b4944415478da63303e0300013501007d17a19600"
    "00000049454e44ae426082";
constexpr const char* kGreyAlphaPng =
    "89504e470d0a1a0a0000000d49484452000000020000000108040000005e2bb7010000000d4944415478da6330e63cc30e00028b0110aa3a09"
    "650000000049454e44ae426082";

std::string from_hex(const std::string& hex) {
  std::string bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2) bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  return bytes;
}

TEST_CASE("image: PNG bytes come back as they stand in the file, grey ones as one channel") {
  const test::TempDirectory directory;
  std::vector<std::uint8_t> rgba;
  for (int i = 0; i < 5 * 3 * 4; ++i) rgba.push_back(static_cast<std::uint8_t>(i * 37));
  ok(write_png(directory / "x.png", 5, 3, rgba));
  const Result<ImageBytes> image = read_png(directory / "x.png");
  REQUIRE(image);
  CHECK(image->width == 5);
  CHECK(image->height == 3);
  REQUIRE(image->channels == 3);
  for (std::size_t i = 0; i < 15; ++i)
    for (std::size_t c = 0; c < 3; ++c) CHECK(image->data[3 * i + c] == rgba[4 * i + c]);
  for (const char* hex : {kGreyPng, kGreyAlphaPng}) {
    test::write_file(directory / "grey.png", from_hex(hex));
    const Result<ImageBytes> grey = read_png(directory / "grey.png");
    REQUIRE(grey);
    CHECK(grey->width == 2);
    CHECK(grey->channels == 1);
    CHECK(grey->data == std::vector<std::uint8_t>{51, 204});
  }
}

TEST_CASE("image: a damaged, truncated, foreign or oversized PNG is an error on one line") {
  const test::TempDirectory directory;
  std::vector<std::uint8_t> rgba(64 * 64 * 4);
  for (std::size_t i = 0; i < rgba.size(); ++i) rgba[i] = static_cast<std::uint8_t>(i * i * 31 >> 3);
  ok(write_png(directory / "whole.png", 64, 64, rgba));
  const std::string whole = test::read_file(directory / "whole.png");
  std::vector<std::string> files{"", "not an image\n", "P6 1 1 255\nabc"};
  for (std::size_t length = 1; length < whole.size() - 16; length += 97) files.push_back(whole.substr(0, length));
  for (const std::string& text : files) {
    test::write_file(directory / "bad.png", text);
    const Result<ImageBytes> read = read_png(directory / "bad.png");
    REQUIRE_FALSE(read);
    CHECK(read.error().message.starts_with(directory / "bad.png" + ": can't be read as a PNG image: "));
    CHECK(read.error().message.find('\n') == std::string::npos);
  }
  const Result<ImageBytes> large = read_png(directory / "whole.png", 63);
  REQUIRE_FALSE(large);
  CHECK(large.error().message ==
        directory / "whole.png" + ": can't be read as a PNG image: it is 64 x 64; accepted: 1 to 63 a side");
  CHECK_FALSE(read_png(directory / "missing.png"));
}

TEST_CASE("image: a damaged, truncated or foreign EXR is an error on one line") {
  const test::TempDirectory directory;
  ok(write_exr(directory / "whole.exr", ramp(16, 40, {"R", "G", "B"})));
  const std::string whole = test::read_file(directory / "whole.exr");
  std::vector<std::string> files{"", "not an image\n", whole.substr(0, whole.size() - 1)};
  for (std::size_t length = 1; length < whole.size(); length += 97) files.push_back(whole.substr(0, length));
  for (const std::string& text : files) {
    test::write_file(directory / "bad.exr", text);
    const Result<ImageF> read = read_exr(directory / "bad.exr");
    REQUIRE_FALSE(read);
    CHECK(read.error().message.starts_with(directory / "bad.exr" + ": can't be read as an OpenEXR image: "));
    CHECK(read.error().message.find('\n') == std::string::npos);
  }
  CHECK_FALSE(read_exr(directory / "missing.exr"));
}

TEST_CASE("atomic file: replaces an old file, with the permissions of any new file") {
  const test::TempDirectory directory;
  test::write_file(directory / "plain", "old");
  const std::string path = directory / "new";
  ok(write_file_atomically(path, std::string_view("first")));
  ok(write_file_atomically(path, std::string_view("second")));
  CHECK(test::read_file(path) == "second");
  CHECK(std::filesystem::status(path).permissions() == std::filesystem::status(directory / "plain").permissions());
}

TEST_CASE("atomic file: a symbolic link stays one") {
  const test::TempDirectory directory;
  test::write_file(directory / "target", "old");
  std::filesystem::create_symlink(directory / "target", directory / "link");
  ok(write_file_atomically(directory / "link", std::string_view("new")));
  CHECK(std::filesystem::is_symlink(directory / "link"));
  CHECK(test::read_file(directory / "target") == "new");
}

TEST_CASE("atomic file: what can't be written is said beforehand, and nothing is left") {
  const test::TempDirectory directory;
  test::write_file(directory / "file", "x");
  REQUIRE(::mkfifo((directory / "pipe").c_str(), 0600) == 0);
  for (const std::string& path : {std::string(), directory.path().string(), directory / "none/x.png",
                                  directory / "file/x.png", directory / "pipe", std::string("/dev/null")}) {
    CAPTURE(path);
    CHECK_FALSE(check_writable(path));
    CHECK_FALSE(write_file_atomically(path, std::string_view("y")));
  }
  CHECK(check_writable(directory / "file"));
  CHECK(test::read_file(directory / "file") == "x");
  CHECK(check_writable(directory / "fresh"));
  CHECK(directory.entries() == std::vector<std::string>{"file", "pipe"});
}

TEST_CASE("image: grey PNGs keep their 16 bits, eight are spread over them, alpha is dropped") {
  const test::TempDirectory directory;
  test::write_file(directory / "deep.png", test::grey_png(3, 2, 16, {0, 1, 65535, 256, 40000, 12345}));
  const Result<GreyImage> deep = read_grey_png(directory / "deep.png");
  if (!deep) FAIL(deep.error().message);
  CHECK(deep->width == 3);
  CHECK(deep->height == 2);
  CHECK(deep->data == std::vector<std::uint16_t>{0, 1, 65535, 256, 40000, 12345});
  test::write_file(directory / "shallow.png", test::grey_png(2, 1, 8, {3, 254}));
  const Result<GreyImage> shallow = read_grey_png(directory / "shallow.png");
  if (!shallow) FAIL(shallow.error().message);
  CHECK(shallow->data == std::vector<std::uint16_t>{3 * 257, 254 * 257});
  ok(write_png(directory / "color.png", 1, 1, std::vector<std::uint8_t>{1, 2, 3, 255}));
  CHECK_FALSE(read_grey_png(directory / "color.png"));
  CHECK_FALSE(read_grey_png(directory / "deep.png", 2));
}
