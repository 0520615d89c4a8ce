// The barrier planner as a pure function: each hazard gets exactly the barrier it needs, and no other.
#include "engine/barriers.h"

#include <doctest/doctest.h>

using namespace nephele;

namespace {

constexpr std::uint32_t kA = 0, kB = 1;

std::vector<PlannedBarrier> plan(const std::vector<StepDeclaration>& steps) { return plan_barriers(steps, 2); }

}  // namespace

TEST_CASE("the first touch of a resource needs no barrier") {
  const auto barriers = plan({{"write", {{kA, Access::storage_write}}}});
  CHECK(barriers[0].empty());
}

TEST_CASE("read after write waits for the write and sees it") {
  const auto barriers = plan({{"write", {{kA, Access::storage_write}}}, {"read", {{kA, Access::sampled}}}});
  CHECK((barriers[1].src_stages & VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT) != 0);
  CHECK(barriers[1].src_access == VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
  CHECK(barriers[1].dst_access == VK_ACCESS_2_SHADER_SAMPLED_READ_BIT);
}

TEST_CASE("a second read of the same kind is already covered, a read of another kind is not") {
  const auto barriers = plan({{"write", {{kA, Access::storage_write}}},
                              {"read", {{kA, Access::storage_read}}},
                              {"again", {{kA, Access::storage_read}}},
                              {"indirect", {{kA, Access::indirect}}}});
  CHECK(barriers[2].empty());
  CHECK(barriers[3].dst_stages == VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT);
  CHECK(barriers[3].dst_access == VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT);
}

TEST_CASE("write after read orders execution without making memory visible") {
  const auto barriers = plan({{"read", {{kA, Access::storage_read}}}, {"write", {{kA, Access::storage_write}}}});
  CHECK_FALSE(barriers[1].empty());
  CHECK(barriers[1].src_access == 0);
}

TEST_CASE("write after write waits, also through atomics") {
  const auto barriers = plan({{"fill", {{kA, Access::transfer_write}}}, {"count", {{kA, Access::storage_read_write}}}});
  CHECK(barriers[1].src_access == VK_ACCESS_2_TRANSFER_WRITE_BIT);
  CHECK((barriers[1].dst_access & VK_ACCESS_2_SHADER_STORAGE_READ_BIT) != 0);
  CHECK((barriers[1].dst_access & VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT) != 0);
}

TEST_CASE("independent resources do not wait for each other") {
  const auto barriers = plan({{"a", {{kA, Access::storage_write}}}, {"b", {{kB, Access::storage_write}}}});
  CHECK(barriers[1].empty());
}

TEST_CASE("one resource's barrier serves another with the same hazard") {
  const auto barriers = plan({{"write both", {{kA, Access::storage_write}, {kB, Access::storage_write}}},
                              {"read a", {{kA, Access::storage_read}}},
                              {"read b", {{kB, Access::storage_read}}}});
  CHECK_FALSE(barriers[1].empty());
  CHECK(barriers[2].empty());
}

TEST_CASE("a barrier before the write does not cover it") {
  const auto barriers = plan({{"write b", {{kB, Access::storage_write}}},
                              {"read b, write a", {{kB, Access::storage_read}, {kA, Access::storage_write}}},
                              {"read a", {{kA, Access::storage_read}}}});
  CHECK_FALSE(barriers[2].empty());
}

TEST_CASE("reading and writing one resource in one step counts as a write for what follows") {
  const auto barriers = plan({{"both", {{kA, Access::color_ordered}}}, {"resolve", {{kA, Access::sampled}}}});
  CHECK(barriers[1].src_stages != 0);
  CHECK((barriers[1].src_access & VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT) != 0);
}

TEST_CASE("the plan can be read") {
  const std::vector<StepDeclaration> steps = {{"sort", {{kA, Access::storage_write}}},
                                              {"draw", {{kA, Access::storage_read}}}};
  const std::vector<std::string> names = {"order", "image"};
  const auto barriers = plan_barriers(steps, 2);
  const std::string text = describe_plan(steps, barriers, names);
  CHECK(text.find("sort: order=storage_write") != std::string::npos);
  CHECK(text.find("barrier") != std::string::npos);
  CHECK(text.find("draw: order=storage_read") != std::string::npos);
}
