// Stands in for oneTBB's header of this name in builds under ThreadSanitizer. The system's oneTBB is not built
// for it, so that it sees neither who hands work over nor who waits for it and reports a race in every loop;
// suppressed, each report still costs a tenth of a second. Here the same loops run on std::thread, all of whose
// steps it sees: what is left to report is ours.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>

namespace tbb {

namespace for_thread_sanitizer {

inline bool& inside_a_loop() {
  thread_local bool inside = false;
  return inside;
}

// Calls work(i) for each i < count, on as many threads as tbb::global_control allows; a loop within a loop stays
// on its thread. Of several exceptions the first is thrown.
template <class Work>
void run(std::size_t count, const Work& work) {
  const std::size_t allowed =
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  const std::size_t thread_count = inside_a_loop() ? 1 : std::min(count, allowed);
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex failing;
  const auto take_all = [&] {
    const bool nested = inside_a_loop();
    inside_a_loop() = true;
    try {
      for (std::size_t i; (i = next++) < count;) work(i);
    } catch (...) {
      const std::lock_guard lock(failing);
      if (!failure) failure = std::current_exception();
      next = count;
    }
    inside_a_loop() = nested;
  };
  std::vector<std::thread> others;
  for (std::size_t t = 1; t < thread_count; ++t) others.emplace_back(take_all);
  take_all();
  for (std::thread& other : others) other.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace for_thread_sanitizer

template <class Index, class Body>
void parallel_for(Index first, Index last, const Body& body) {
  if (!(first < last)) return;
  // A few pieces a thread, as with oneTBB: threads meet in the middle of an array, and pieces stay cheap.
  const auto count = static_cast<std::size_t>(last - first);
  const std::size_t pieces = std::min(count, std::size_t{16});
  for_thread_sanitizer::run(pieces, [&](std::size_t piece) {
    const auto begin = static_cast<Index>(first + static_cast<Index>(piece * count / pieces));
    const auto end = static_cast<Index>(first + static_cast<Index>((piece + 1) * count / pieces));
    for (Index i = begin; i < end; ++i) body(i);
  });
}

template <class Value, class Body>
void parallel_for(const blocked_range<Value>& range, const Body& body) {
  const std::size_t grain = range.grainsize(), count = (range.size() + grain - 1) / grain;
  for_thread_sanitizer::run(count, [&](std::size_t piece) {
    const auto begin = static_cast<Value>(range.begin() + static_cast<Value>(piece * grain));
    const auto end = static_cast<Value>(std::min(range.size(), (piece + 1) * grain));
    body(blocked_range<Value>(begin, static_cast<Value>(range.begin() + end), grain));
  });
}

}  // namespace tbb
