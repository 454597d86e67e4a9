// The loop: a period and how finely it is sampled.
#pragma once

namespace tremula {

// Samples at t = p T / M, p = 0 … M-1; sample M equals sample 0. Frequency bins p / T, p = 0 … M/2.
struct TimeAxis {
  double period = 0;     // T [s]
  int sample_count = 0;  // M

  int bin_count() const { return sample_count / 2 + 1; }
  double frequency(int bin) const { return bin / period; }  // [Hz]
  // What a bin stands for in the middle [Hz]: bin 0 for all that is slower than the loop, 0 to half a bin.
  double middle_frequency(int bin) const { return bin == 0 ? 0.25 / period : frequency(bin); }
  double omega(int bin) const { return 6.283185307179586476925 * frequency(bin); }  // [rad/s] (errata S2)
};

}  // namespace tremula
