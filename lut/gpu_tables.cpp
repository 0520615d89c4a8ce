#include "lut/gpu_tables.h"

namespace nephele {

namespace {

Image upload(Device& device, const Table& table, VkFormat format) {
  Image image(device, table.name,
              {.format = format,
               .width = table.width(),
               .height = table.height(),
               .depth = table.depth(),
               .attachment = false,
               .force_3d = true});
  image.write(table.array.data);
  return image;
}

}  // namespace

GpuTables::GpuTables(Device& device, const Tables& tables)
    : parameters_(tables.parameters),
      optical_depth_(upload(device, tables.optical_depth, VK_FORMAT_R16G16_SFLOAT)),
      multiple_scattering_(upload(device, tables.multiple_scattering, VK_FORMAT_R16G16B16A16_SFLOAT)),
      mean_fill_(tables.mean_fill) {}

}  // namespace nephele
