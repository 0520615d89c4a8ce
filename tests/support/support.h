// What tests share: the device (test_device.h), a directory to write in, and the program as a user runs it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tests/support/test_device.h"

namespace nephele::test {

// A fresh directory, removed with everything in it.
class TempDirectory {
 public:
  TempDirectory();
  ~TempDirectory();
  TempDirectory(const TempDirectory&) = delete;
  TempDirectory& operator=(const TempDirectory&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  // Names of everything in it, sorted: what a program left behind.
  std::vector<std::string> entries() const;

 private:
  std::filesystem::path path_;
};

std::string read_file(const std::string& path);
void write_file(const std::string& path, const std::string& text);

// A grey PNG's bytes, of 8 or 16 bits a sample, rows from the top; written by the standard alone (stored, not packed).
std::string grey_png(std::uint32_t width, std::uint32_t height, int bits, const std::vector<std::uint16_t>& samples);

struct ProgramResult {
  int status = -1;  // exit status; 128 + signal when killed
  std::string out, err;
};

// Runs build/nephele with the arguments, an empty standard input and this process's environment, changed as given.
ProgramResult run_program(const std::vector<std::string>& arguments,
                          const std::map<std::string, std::string>& environment = {});

}  // namespace nephele::test
