// Tile lists made of rectangles: which items a tile gets, in which order, and what happens when pairs find no room.
#include <doctest/doctest.h>

#include <algorithm>
#include <random>

#include "nephele_shaders.h"
#include "passes/kit/tile_pairs.h"
#include "shared/tile_rectangle.h"
#include "tests/support/test_device.h"

using namespace nephele;
using namespace nephele::test;

namespace {

constexpr std::uint32_t kColumns = 7, kRows = 5;

// The counters that TilePairs works with, nothing else.
struct Counters {
  std::uint32_t item_count, demand, pair_count;
  glm::uvec3 item_groups, pair_groups;
};

struct Item {
  glm::uvec2 low, past;
};

struct Built {
  Counters counters;
  std::vector<std::vector<std::uint32_t>> lists;  // by tile
};

std::vector<Item> any_items(std::uint32_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<Item> items;
  for (std::uint32_t i = 0; i < count; ++i) {
    const glm::uvec2 low(random() % kColumns, random() % kRows);
    items.push_back({low, low + glm::uvec2(random() % (kColumns - low.x + 1),
                                           random() % (kRows - low.y + 1))});  // some cover nothing
  }
  return items;
}

// Item i stands at place count - 1 - i of the order.
Built build(const std::vector<Item>& items, std::uint32_t pair_capacity, std::uint32_t columns = kColumns,
            std::uint32_t rows = kRows) {
  Device& device = test_device();
  const std::uint32_t count = static_cast<std::uint32_t>(items.size());
  std::vector<glm::uvec2> rectangle_values;
  std::vector<std::uint32_t> order_values;
  for (std::uint32_t i = 0; i < count; ++i) {
    rectangle_values.push_back(shared::tile_rectangle(items[i].low, items[i].past));
    order_values.push_back(count - 1 - i);
  }
  Buffer rectangles(device, "rectangles", count * sizeof(glm::uvec2)), order(device, "order", count * 4),
      counters(device, "counters", sizeof(Counters));
  rectangles.write_vector(rectangle_values);
  order.write_vector(order_values);
  counters.write_vector(std::vector{Counters{count, 0, 0, {(count + 63) / 64, 1, 1}, {}}});
  Workshop make(test_kernels());
  TilePairs pairs(make, "test_tile", count, pair_capacity, columns, rows);
  FrameBuilder frame(device);
  const TileLists lists =
      pairs.add(frame, "tile_pairs", counters,
                {offsetof(Counters, item_count), offsetof(Counters, item_groups), offsetof(Counters, demand),
                 offsetof(Counters, pair_count), offsetof(Counters, pair_groups)},
                order, rectangles);
  FrameExecutor(device).run(frame);
  Built built{counters.read_vector<Counters>(1)[0], {}};
  const auto list = lists.list.read_vector<std::uint32_t>(built.counters.pair_count);
  for (const glm::uvec2 range : lists.ranges.read_vector<glm::uvec2>(columns * rows)) {
    REQUIRE(range.y <= list.size());
    built.lists.emplace_back(list.begin() + range.x, list.begin() + range.y);
  }
  return built;
}

// The same on the CPU: the first pair_capacity pairs, item by item in the order, row by row.
std::vector<std::vector<std::uint32_t>> expected(const std::vector<Item>& items, std::uint32_t pair_capacity,
                                                 std::uint32_t columns = kColumns, std::uint32_t rows = kRows) {
  std::vector<std::vector<std::uint32_t>> lists(columns * rows);
  std::uint32_t pairs = 0;
  for (std::uint32_t item = static_cast<std::uint32_t>(items.size()); item-- > 0;)
    for (std::uint32_t y = items[item].low.y; y < items[item].past.y; ++y)
      for (std::uint32_t x = items[item].low.x; x < items[item].past.x; ++x)
        if (pairs++ < pair_capacity) lists[y * columns + x].push_back(item);
  return lists;
}

}  // namespace

TEST_CASE("tile lists hold every item of a tile in the order given, with each tuning") {
  const std::vector<Item> items = any_items(300, 1);
  for (const TestTuning tuning : kTestTunings) {
    CAPTURE(std::string(test_tuning_name(tuning)));
    const WithTuning with(tuning);
    const Built built = build(items, 1u << 16);
    CHECK(built.counters.pair_count == built.counters.demand);
    CHECK(built.lists == expected(items, 1u << 16));
  }
}

TEST_CASE("pairs without room are counted; those of the last items are left out, wherever the room ends") {
  const std::vector<Item> items = any_items(300, 2);
  const std::uint32_t demand = build(items, 1u << 16).counters.demand;
  for (const std::uint32_t capacity : {1u, 64u, 65u, 1000u, demand - 1, demand, demand + 1}) {
    CAPTURE(capacity);
    const Built built = build(items, capacity);
    CHECK(built.counters.demand == demand);
    CHECK(built.counters.pair_count == std::min(capacity, demand));
    CHECK(built.counters.pair_groups == glm::uvec3((built.counters.pair_count + 63) / 64, 1, 1));
    CHECK(built.lists == expected(items, capacity));
  }
}

// Lavapipe ends loops after 65 535 rounds: as many tiles as an image of 3 840 x 2 160 has are twice that.
TEST_CASE("an item may cover every tile of a large image") {
  constexpr std::uint32_t kWide = 480, kHigh = 270, kAll = kWide * kHigh;
  const std::vector<Item> items = {{{3, 5}, {4, 6}}, {{0, 0}, {kWide, kHigh}}, {{7, 0}, {kWide - 2, kHigh}}};
  const Built built = build(items, 3 * kAll, kWide, kHigh);
  CHECK(built.counters.pair_count == built.counters.demand);
  CHECK(built.lists == expected(items, 3 * kAll, kWide, kHigh));
}

// 65 items on each of 65 536 tiles are 66 561 groups of 64 pairs; Vulkan guarantees 65 535 in a row.
TEST_CASE("more pairs than a row of groups holds all get their tiles") {
  constexpr std::uint32_t kSide = 256, kItems = 65, kPairs = kItems * kSide * kSide;
  const std::vector<Item> items(kItems, Item{{0, 0}, {kSide, kSide}});
  const Built built = build(items, kPairs, kSide, kSide);
  CHECK(built.counters.pair_count == kPairs);
  CHECK(built.counters.pair_groups == glm::uvec3(65535, 2, 1));
  CHECK(built.lists == expected(items, kPairs, kSide, kSide));
}

// Lavapipe drops writes past a buffer's end, so this one goes on behind the room that the shader is told of.
TEST_CASE("nothing is written past the room for pairs") {
  Device& device = test_device();
  struct Push {
    std::uint32_t item_count_at, pair_demand_at, pair_count_at, pair_groups_at, item_capacity, pair_capacity,
        tile_columns;
  };
  constexpr std::uint32_t kUntouched = 0xABCDu, kCapacity = 20;
  Buffer counters(device, "counters", 4), order(device, "order", 8), rectangles(device, "rectangles", 16),
      places(device, "places", 8), keys(device, "keys", 256), values(device, "values", 256);
  counters.write_vector(std::vector<std::uint32_t>{2});
  order.write_vector(std::vector<std::uint32_t>{0, 1});
  rectangles.write_vector(std::vector{shared::tile_rectangle({0, 0}, {4, 4}), shared::tile_rectangle({1, 1}, {5, 5})});
  places.write_vector(std::vector<std::uint32_t>{0, 16});
  keys.write_vector(std::vector<std::uint32_t>(64, kUntouched));
  values.write_vector(std::vector<std::uint32_t>(64, kUntouched));
  const ComputeKernel emit(device, shaders::tile_emit_comp);
  FrameBuilder frame(device);
  frame.compute({.name = "emit",
                 .kernel = &emit,
                 .bindings = {{0, counters, Access::storage_read},
                              {1, order, Access::words},
                              {2, rectangles, Access::words},
                              {3, places, Access::words},
                              {4, keys, Access::storage_write},
                              {5, values, Access::storage_write}},
                 .push = as_push(Push{0, 0, 0, 0, 2, kCapacity, kColumns}),
                 .groups = {1, 1, 1}});
  FrameExecutor(device).run(frame);
  const auto key = keys.read_vector<std::uint32_t>(64), value = values.read_vector<std::uint32_t>(64);
  for (std::uint32_t i = 0; i < 64; ++i) {
    CAPTURE(i);
    CHECK((key[i] != kUntouched) == (i < kCapacity));
    CHECK(value[i] == (i < 16 ? 0u : i < kCapacity ? 1u : kUntouched));
  }
}
