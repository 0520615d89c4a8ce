#include "passes/layer/view_sort.h"

#include "nephele_shaders.h"
#include "shared/types.h"

namespace nephele {

using shared::FrameCounters;

namespace {
constexpr std::uint32_t kKeyBits = 24;
}

ViewSort::ViewSort(Workshop& make, std::uint32_t visible_capacity, ViewOrder order)
    : order_(order), keys_(make.compute(shaders::view_sort_keys_comp)), sort_(make, "view_sort", visible_capacity) {}

const Buffer& ViewSort::add(FrameBuilder& frame, const Buffer& particles, const Buffer& visible,
                            const Buffer& counters) {
  frame.compute({.name = "view_sort",
                 .kernel = &keys_,
                 .bindings = {{0, particles, Access::texels},
                              {1, visible, Access::storage_read},
                              {2, counters, Access::storage_read},
                              {3, sort_.keys(), Access::storage_write},
                              {4, sort_.values(), Access::storage_write}},
                 .push = as_push(order_),
                 .indirect = {&counters, offsetof(FrameCounters, visible_groups)}});
  return sort_.add(frame, "view_sort", counters, offsetof(FrameCounters, visible_count), kKeyBits).values;
}

}  // namespace nephele
