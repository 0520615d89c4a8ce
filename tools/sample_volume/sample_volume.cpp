// sample_volume [N [X Y Z]]: writes the cumulus of cumulus_volume.h to standard output, N^3 voxels (128 without N) as a
// float32 NumPy array indexed [x][y][z], its matter moved by X, Y, Z metres. A voxel is 2048 / N metres wide.
#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "tools/sample_volume/cumulus_volume.h"

int main(int argc, char** argv) {
  const int n = argc > 1 ? std::atoi(argv[1]) : 128;
  if ((argc != 1 && argc != 2 && argc != 5) || n < 1 || n > 1024) {
    std::fprintf(stderr, "usage: sample_volume [N [X Y Z]]; N from 1 to 1024\n");
    return 2;
  }
  std::array<double, 3> shift_m{};
  for (int i = 0; i < argc - 2; ++i) shift_m[static_cast<std::size_t>(i)] = std::atof(argv[i + 2]);
  const std::string side = std::to_string(n);
  std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (" + side;
  header.append(", ").append(side).append(", ").append(side).append("), }");
  while ((10 + header.size() + 1) % 64 != 0) header += ' ';
  header += '\n';
  std::fwrite("\x93NUMPY\x01\x00", 1, 8, stdout);
  std::fputc(static_cast<int>(header.size() & 255), stdout);
  std::fputc(static_cast<int>(header.size() >> 8), stdout);
  std::fwrite(header.data(), 1, header.size(), stdout);
  std::vector<float> values;
  nephele::sample::for_cumulus_voxels(static_cast<std::size_t>(n), shift_m,
                                      [&](std::size_t, std::size_t, std::size_t, float v) { values.push_back(v); });
  std::fwrite(values.data(), sizeof(float), values.size(), stdout);
  return 0;
}
