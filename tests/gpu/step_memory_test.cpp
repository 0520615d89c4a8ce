// What stands from frame to frame: only what was recorded, from equal inputs, in the very same resource.
#include <doctest/doctest.h>

#include <optional>

#include "engine/frame.h"
#include "tests/support/test_device.h"

using namespace nephele;
using nephele::test::test_device;

namespace {

// A frame that fills the buffer with a value unless the value stands there; whether it had to.
bool add_fill(FrameBuilder& frame, const Buffer& buffer, std::uint32_t value, Keep keep = Keep::while_equal) {
  if (frame.stands(&buffer, as_inputs(value), keep)) return false;
  frame.fill("fill", buffer, value);
  return true;
}

bool run_fill(FrameExecutor& executor, const Buffer& buffer, std::uint32_t value, Reuse reuse = Reuse::all,
              Keep keep = Keep::while_equal) {
  FrameBuilder frame(executor, reuse);
  const bool filled = add_fill(frame, buffer, value, keep);
  executor.run(frame);
  return filled;
}

}  // namespace

TEST_CASE("a step is left out while its inputs stay equal, and not when they change") {
  FrameExecutor executor(test_device());
  const Buffer buffer(test_device(), "kept", 16);
  CHECK(run_fill(executor, buffer, 7));
  CHECK_FALSE(run_fill(executor, buffer, 7));
  CHECK(buffer.read_vector<std::uint32_t>(1)[0] == 7);
  CHECK(run_fill(executor, buffer, 8));
  CHECK_FALSE(run_fill(executor, buffer, 8));
  CHECK(run_fill(executor, buffer, 7));  // two views in turn: right, if not spared
  CHECK(buffer.read_vector<std::uint32_t>(1)[0] == 7);
}

TEST_CASE("a frame that is built and dropped leaves no trace") {
  FrameExecutor executor(test_device());
  const Buffer buffer(test_device(), "kept", 16);
  run_fill(executor, buffer, 1);
  {
    FrameBuilder dropped(executor);
    CHECK(add_fill(dropped, buffer, 2));
  }
  CHECK_FALSE(run_fill(executor, buffer, 1));
  CHECK(run_fill(executor, buffer, 2));
  executor.memory().forget();
  CHECK(run_fill(executor, buffer, 2));
}

TEST_CASE("frames without reuse keep what lasts and nothing else") {
  FrameExecutor executor(test_device());
  const Buffer camera(test_device(), "camera", 16), table(test_device(), "table", 16);
  CHECK(run_fill(executor, camera, 1, Reuse::lasting));
  CHECK(run_fill(executor, camera, 1, Reuse::lasting));
  CHECK_FALSE(run_fill(executor, camera, 1, Reuse::all));  // what such a frame left may serve a later one
  CHECK(run_fill(executor, table, 1, Reuse::lasting, Keep::lasting));
  CHECK_FALSE(run_fill(executor, table, 1, Reuse::lasting, Keep::lasting));
  FrameBuilder without_executor(test_device());
  CHECK(add_fill(without_executor, table, 1, Keep::lasting));
}

TEST_CASE("a new resource holds nothing, wherever it lies") {
  FrameExecutor executor(test_device());
  std::optional<Buffer> buffer;
  buffer.emplace(test_device(), "first", 16);
  run_fill(executor, *buffer, 5);
  buffer.emplace(test_device(), "second", 16);  // in the same place
  CHECK(run_fill(executor, *buffer, 5));
}
