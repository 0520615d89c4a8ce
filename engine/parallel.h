// Runs body(i) for i in [0, count) on every core, or on at most as many as asked for; returns when all are done.
// Results must not depend on the order.
#pragma once

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace nephele {

template <class Body>
void parallel_for(int count, Body&& body, int most_workers = 0) {
  const int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const int workers = std::min(count, most_workers > 0 ? most_workers : cores);
  std::atomic<int> next{0};
  const auto work = [&] {
    for (int i = next.fetch_add(1); i < count; i = next.fetch_add(1)) body(i);
  };
  std::vector<std::jthread> threads;
  for (int i = 1; i < workers; ++i) threads.emplace_back(work);
  work();
}

}  // namespace nephele
