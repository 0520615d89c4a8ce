// Runs body(i) for i in [0, count) on every core; returns when all are done. Results must not depend on the order.
#pragma once

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace nephele {

template <class Body>
void parallel_for(int count, Body&& body) {
  const int workers = std::min<int>(count, static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
  std::atomic<int> next{0};
  const auto work = [&] {
    for (int i = next.fetch_add(1); i < count; i = next.fetch_add(1)) body(i);
  };
  std::vector<std::jthread> threads;
  for (int i = 1; i < workers; ++i) threads.emplace_back(work);
  work();
}

}  // namespace nephele
