#!/usr/bin/env bash
# Checks the code's format, builds everything and runs every test, with Vulkan's validation layers on. Ends with
# "N passed, N failed".
#   tools/test.sh [--preset release|debug|asan] [arguments of ctest, e.g. -R cpu]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

preset=release
if [[ ${1:-} == --preset ]]; then
  preset=${2:?--preset needs a name}
  shift 2
fi

tools/setup.sh xvfb xdotool  # a screen and keys for the tests of nephele fly
tools/check_format.sh
cmake --preset "$preset"
cmake --build --preset "$preset"

# Khronos validation with synchronisation validation: any message fails the test (tests/support/main.cpp).
export NEPHELE_VALIDATION=1
ctest_status=0
ctest --preset "$preset" --no-tests=error "$@" || ctest_status=$?

# Test cases of all executables. One that fails without a failed case (a crash, a validation message) counts as one.
build_dir=build
[[ $preset == release ]] || build_dir=build-$preset
read -r passed failed < <(awk '
  /^\[doctest\] test cases:/ {
    for (i = 2; i <= NF; ++i) {
      if ($i == "passed") passed += $(i - 1)
      if ($i == "failed") { failed += $(i - 1); failed_here += $(i - 1) }
    }
  }
  /^Test Passed\.$/ { failed_here = 0 }
  /^Test Failed\./ { if (failed_here == 0) ++failed; failed_here = 0 }
  END { print passed + 0, failed + 0 }' "$build_dir/Testing/Temporary/LastTest.log")
[[ $ctest_status -ne 0 && $failed -eq 0 ]] && failed=1
echo "$passed passed, $failed failed"
[[ $ctest_status -eq 0 && $failed -eq 0 ]]
