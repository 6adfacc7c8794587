// Work on all cores of the host.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace turner {

// Runs task(0) .. task(count - 1), in any order and at once; the first exception is thrown here.
template <class Task>
void onAllCores(size_t count, const Task& task) {
  std::atomic<size_t> next = 0;
  std::exception_ptr failure;
  std::mutex failureMutex;
  const auto work = [&] {
    try {
      for (size_t i = next++; i < count; i = next++) task(i);
    } catch (...) {
      const std::scoped_lock lock(failureMutex);
      if (!failure) failure = std::current_exception();
      next = count;
    }
  };
  {
    std::vector<std::jthread> others;
    for (size_t i = 1; i < std::min<size_t>(count, std::max(1u, std::thread::hardware_concurrency())); ++i)
      others.emplace_back(work);
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

// Runs task(i) for all i below count, in pieces that are worth a thread.
template <class Task>
void forAll(size_t count, const Task& task) {
  constexpr size_t kPiece = 1 << 14;
  onAllCores((count + kPiece - 1) / kPiece, [&](size_t piece) {
    for (size_t i = piece * kPiece, end = std::min(count, i + kPiece); i < end; ++i) task(i);
  });
}

}  // namespace turner
