// Blurs noise at scattered points with a filter that decays exponentially with distance:
//
//   filtered_k = sum over l of exp(-decay |x_k - x_l|) noise_l
//
// Points are sorted into compact blocks; pairs of blocks that are farther apart than the filter reaches are
// left out. What remains is about 50 flops a pair on data in the first-level cache, both ways at once: bound
// by arithmetic, not by memory.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace tremula {

class PairwiseFilter {
 public:
  static constexpr int channels = 6;  // real and imaginary parts of three components
  using Channels = Eigen::Matrix<float, Eigen::Dynamic, channels>;

  // points (3 x N) [m]
  explicit PairwiseFilter(const Eigen::Matrix3Xd& points);

  struct Result {
    Channels filtered;  // (N x 6)
    Eigen::VectorXf
        squared_weights;  // (N) sum over l of exp(-2 decay d_kl): the variance that unit noise gets
  };
  // noise (N x 6) in the order of the points; decay [1/m] >= 0; filters below `cutoff` count as 0 (0 keeps
  // every pair) as far as whole blocks are out of reach. The same bytes on any machine.
  Result apply(double decay, double cutoff, const Channels& noise) const;

 private:
  struct Block {
    int first, count;  // of order_
    Eigen::Array3f low, high;
  };
  std::vector<int> order_;  // caller's index of the sorted point
  std::vector<Block> blocks_;
  std::vector<float> coordinates_;  // by block: 3 rows of block_size, padded
};

}  // namespace tremula
