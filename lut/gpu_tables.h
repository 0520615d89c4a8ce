// The baked tables as textures, ready to be fetched by shaders/layer/table_fetch.glsl with the device's linear_clamp
// sampler.
#pragma once

#include "engine/resources.h"
#include "lut/tables.h"

namespace nephele {

// A table as a 3D texture of its own shape.
Image upload_table(Device& device, const Table& table, VkFormat format, bool volume = true);

// One line naming the table and the device's limit if a table is larger than its 3D images may be.
Result<void> check_tables_fit(const DeviceInfo& device, const Tables& tables);

class GpuTables {
 public:
  GpuTables(Device& device, const Tables& tables);

  const TableParameters& parameters() const { return parameters_; }
  const Image& optical_depth() const { return optical_depth_; }  // R16G16_SFLOAT
  // The same as bytes (shaders/layer/packed_table_fetch.glsl); none where the tuning has no use for it (pixel_columns).
  const Buffer& packed_optical_depth() const { return packed_optical_depth_; }
  const Image& multiple_scattering() const { return multiple_scattering_; }  // R16G16B16A16_SFLOAT
  const Image& near_beam() const { return near_beam_; }                      // R16_SFLOAT
  float mean_fill() const { return mean_fill_; }

 private:
  TableParameters parameters_;
  Image optical_depth_, multiple_scattering_, near_beam_;
  Buffer packed_optical_depth_;
  float mean_fill_ = 0;
};

}  // namespace nephele
