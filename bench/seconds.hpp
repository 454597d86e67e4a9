// How long things take, for tables.
#pragma once

#include <algorithm>
#include <chrono>

namespace tremula::bench {

// Of one call [s].
template <typename Work>
double seconds_of(const Work& work) {
  const auto begun = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
}

// Of the fastest of a few calls [s], as many as a tenth of a second holds, three at least.
template <typename Work>
double seconds_a_call(const Work& work) {
  double best = seconds_of(work), spent = best;
  for (int calls = 1; calls < 3 || spent < 0.1; ++calls) {
    const double taken = seconds_of(work);
    best = std::min(best, taken);
    spent += taken;
  }
  return best;
}

}  // namespace tremula::bench
