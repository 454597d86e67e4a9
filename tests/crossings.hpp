// How often a record rises through its mean.
#pragma once

#include <Eigen/Core>

namespace tremula::test {

// Of samples `step` apart [s], between the first crossing and the last [Hz]; 0 where there are not two.
inline double frequency_of_crossings(const Eigen::VectorXd& samples, double step) {
  const double mean = samples.mean();
  double first = 0, last = 0;
  int crossings = 0;
  for (Eigen::Index i = 1; i < samples.size(); ++i) {
    if (!(samples[i - 1] < mean && samples[i] >= mean)) continue;
    last = (static_cast<double>(i) - (samples[i] - mean) / (samples[i] - samples[i - 1])) * step;
    if (crossings++ == 0) first = last;
  }
  return crossings > 1 ? (crossings - 1) / (last - first) : 0;
}

}  // namespace tremula::test
