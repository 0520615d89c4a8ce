#include "lut/gpu_tables.h"

#include <algorithm>

#include "engine/check.h"
#include "lut/packed_optical_depth.h"

namespace nephele {

Image upload_table(Device& device, const Table& table, VkFormat format, bool volume) {
  Image image(device, table.name,
              {.format = format,
               .width = table.width(),
               .height = table.height(),
               .depth = table.depth(),
               .attachment = false,
               .force_3d = volume});
  image.write(table.array.data);
  return image;
}

Result<void> check_tables_fit(const DeviceInfo& device, const Tables& tables) {
  for (const Table* table : {&tables.optical_depth, &tables.multiple_scattering, &tables.near_beam})
    if (std::max({table->width(), table->height(), table->depth()}) > device.max_volume_side_px)
      return Error{concat("table ", table->name, " is ", table->width(), "x", table->height(), "x", table->depth(),
                          " texels; ", device.name, " allows 3D images of 1 to ", device.max_volume_side_px,
                          " a side (see nephele bake --help for smaller tables)")};
  return {};
}

GpuTables::GpuTables(Device& device, const Tables& tables)
    : parameters_(tables.parameters),
      optical_depth_(upload_table(device, tables.optical_depth, VK_FORMAT_R16G16_SFLOAT)),
      multiple_scattering_(upload_table(device, tables.multiple_scattering, VK_FORMAT_R16G16B16A16_SFLOAT)),
      near_beam_(upload_table(device, tables.near_beam, VK_FORMAT_R16_SFLOAT, false)),
      mean_fill_(tables.mean_fill) {
  if (!device.tuning().pixel_columns) return;
  const std::vector<std::uint32_t> words = pack_optical_depth(tables.optical_depth);
  packed_optical_depth_ = Buffer(device, "packed_optical_depth", words.size() * sizeof(std::uint32_t));
  packed_optical_depth_.write_vector(words);
}

}  // namespace nephele
