// Work on all cores of the host.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

namespace turner {

// Runs task(0) .. task(count - 1), in any order and at once. The first exception is thrown here, after a stop was
// requested: no further task begins then, and those that run may look at `stop` to end early.
// `progress` is called ten times a second from the calling thread, with the share of the tasks that is done, in [0, 1].
// It may throw too. Without it the calling thread works along.
template <class Task>
void parallelFor(size_t count, const Task& task, const std::function<void(double)>& progress = {},
                 const std::stop_source& stop = {}) {
  std::atomic<size_t> next = 0, done = 0;
  // The rest is under the mutex; `finished` tells the calling thread that nothing is running any more.
  std::mutex mutex;
  std::condition_variable finished;
  size_t running = 0;
  std::exception_ptr failure;
  const auto fail = [&] {
    const std::scoped_lock lock(mutex);
    if (!failure) failure = std::current_exception();
    stop.request_stop();
  };
  const auto work = [&] {
    try {
      for (size_t i = next++; i < count && !stop.stop_requested(); i = next++) {
        task(i);
        ++done;
      }
    } catch (...) {
      fail();
    }
  };
  const auto workBeside = [&] {
    work();
    const std::scoped_lock lock(mutex);
    --running;
    finished.notify_one();
  };
  {
    std::vector<std::jthread> threads;
    try {
      const size_t cores = std::min<size_t>(count, std::max(1u, std::thread::hardware_concurrency()));
      for (size_t i = progress ? 0 : 1; i < cores; ++i) {
        {
          const std::scoped_lock lock(mutex);
          ++running;
        }
        threads.emplace_back(workBeside);
      }
      if (!progress) work();
      std::unique_lock lock(mutex);
      while (progress && !finished.wait_for(lock, std::chrono::milliseconds(100), [&] { return running == 0; })) {
        lock.unlock();
        progress(double(done) / double(count));
        lock.lock();
      }
    } catch (...) {
      fail();
    }
  }
  if (failure) std::rethrow_exception(failure);
}

// Runs task(i) for all i below count, in pieces that are worth a thread.
template <class Task>
void forAll(size_t count, const Task& task) {
  constexpr size_t kPiece = 1 << 14;
  parallelFor((count + kPiece - 1) / kPiece, [&](size_t piece) {
    for (size_t i = piece * kPiece, end = std::min(count, i + kPiece); i < end; ++i) task(i);
  });
}

}  // namespace turner
