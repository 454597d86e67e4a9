#include "tremula/numerics/block_lanczos.hpp"

#include "tremula/base/error.hpp"
#include "tremula/numerics/random.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <Eigen/Eigenvalues>

namespace tremula {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr Index widest_block = 32;
constexpr Index guards = 4;            // vectors of a block beyond the eigenpairs it is to find
constexpr Index blocks_in_basis = 10;  // before a restart
// A unit vector of which less than this is at right angles to the others was rounding before it was scaled.
constexpr double rounding_of_unit_vectors = 0.01;
constexpr int most_blocks = 2000;  // of a round; one that takes more has gone wrong

class BlockSearch {
 public:
  BlockSearch(const SymmetricOperator& apply, Index size, const LanczosOptions& options,
              const MatrixXd& deflated)
      : apply_(apply), size_(size), options_(options), known_(size, deflated.cols() + options.count) {
    known_count_ = deflated.cols();
    if (known_count_ == 0) return;
    known_.leftCols(known_count_) = deflated;
    Eigen::VectorXd image(size);
    apply_(known_.col(0), image);
    largest_ = image.norm();
  }

  LanczosResult run() {
    result_.values.resize(0);
    const Index before = known_count_, wanted = std::min<Index>(options_.count, size_ - before);
    result_.converged = true;
    while (result_.converged && known_count_ < before + wanted) {
      result_.converged = find(before + wanted - known_count_);
      if (options_.progress) {
        options_.progress(static_cast<double>(known_count_ - before) / static_cast<double>(wanted));
      }
    }
    result_.vectors = known_.middleCols(before, known_count_ - before);
    return std::move(result_);
  }

 private:
  // Finds the largest that are left, as many as one round is good for, and makes them known. False where the
  // round does not come to an end.
  bool find(Index wanted) {
    const Index room = size_ - known_count_;
    const Index fit = columns_that_fit();
    const Index width = std::min({wanted + guards, widest_block + guards, room, fit / 6});
    const Index target = std::min({wanted, widest_block, width});
    basis_.resize(size_, std::min({room, blocks_in_basis * width, fit}) + width);
    projection_ = MatrixXd::Zero(basis_.cols(), basis_.cols());
    done_ = 0;
    next_ = append_random(0, width);
    for (int block = 0; block < most_blocks && next_ > 0; ++block) {
      const MatrixXd border = expand();
      const bool invariant = next_ == done_;
      const bool full = next_ + width > basis_.cols();
      if (done_ < target + guards && !invariant && !full) continue;
      if (block % 2 == 0 && !invariant && !full) continue;
      const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(projection_.topLeftCorner(done_, done_));
      const Eigen::VectorXd values = solver.eigenvalues().reverse();
      const MatrixXd vectors = solver.eigenvectors().rowwise().reverse();
      largest_ = std::max(largest_, values[0]);
      const Eigen::VectorXd residual =
          (border * vectors.bottomRows(border.cols())).colwise().norm().transpose();
      const Index count = std::min(target, done_);
      if (converged(values, residual, count)) {
        accept(values.head(count), vectors.leftCols(count), residual.head(count));
        return true;
      }
      if (invariant) return false;
      if (full) restart(values, vectors, std::max(target + guards, basis_.cols() / 2));
    }
    return false;
  }

  // Of the basis, beside the vectors that are known or will be.
  Index columns_that_fit() const {
    const std::size_t column = static_cast<std::size_t>(size_) * sizeof(double);
    const std::size_t fit = options_.memory_limit / column, taken = static_cast<std::size_t>(known_.cols());
    if (fit < taken + 16) {
      throw InputError(
          "memory limit",
          std::to_string(options_.memory_limit / 1000000) + " MB for the vectors of the search",
          "at least " + std::to_string((taken + 16) * column / 1000000 + 1) + " MB, or fewer modes");
    }
    // A third is for what the work itself takes.
    return static_cast<Index>(2 * std::min<std::size_t>(fit - taken, 1U << 30U) / 3);
  }

  // A of the last block, as columns of the projection; what is left of it is orthonormalised to the next
  // block. Returns the factor (next block x last block) that makes the one of the other.
  MatrixXd expand() {
    const Index width = next_ - done_;
    MatrixXd image(size_, width);
    for (Index i = 0; i < width; ++i) apply_(basis_.col(done_ + i), image.col(i));
    result_.operator_count += static_cast<int>(width);
    MatrixXd coefficients = remove_known(image, next_);
    MatrixXd factor = orthonormalise(image, epsilon * largest_ * std::sqrt(static_cast<double>(size_)));
    // Twice: where much cancelled in the first pass, its rounding is no longer small beside what is left.
    coefficients.noalias() += remove_known(image, next_) * factor;
    factor = orthonormalise(image, rounding_of_unit_vectors) * factor;
    projection_.block(0, done_, next_, width) = coefficients;
    projection_.block(done_, 0, width, next_) = coefficients.transpose();
    largest_ = std::max(largest_, coefficients.bottomRows(width).diagonal().maxCoeff());
    done_ = next_;
    next_ = done_ + image.cols();
    basis_.middleCols(done_, image.cols()) = image;
    return factor;
  }

  // Takes from the block what it has of the eigenvectors that are known and of the basis. Returns the
  // products with the basis.
  MatrixXd remove_known(MatrixXd& block, Index basis_count) const {
    const auto known = known_.leftCols(known_count_);
    const auto basis = basis_.leftCols(basis_count);
    if (known_count_ > 0) block -= known * (known.transpose() * block).eval();
    MatrixXd coefficients = basis.transpose() * block;
    block.noalias() -= basis * coefficients;
    return coefficients;
  }

  // block = Q R: becomes Q, without the columns of which no more is left than rounding. Returns R.
  static MatrixXd orthonormalise(MatrixXd& block, double rounding) {
    const Index width = block.cols();
    MatrixXd factor = MatrixXd::Zero(width, width);
    Index rank = 0;
    for (Index i = 0; i < width; ++i) {
      Eigen::VectorXd column = block.col(i);
      for (int pass = 0; pass < 2; ++pass) {
        const Eigen::VectorXd products = block.leftCols(rank).transpose() * column;
        column.noalias() -= block.leftCols(rank) * products;
        factor.col(i).head(rank) += products;
      }
      const double norm = column.norm();
      if (!(norm > rounding)) continue;
      factor(rank, i) = norm;
      block.col(rank++) = column / norm;
    }
    block.conservativeResize(Eigen::NoChange, rank);
    return factor.topRows(rank);
  }

  // Random vectors at right angles to all others, at a place in the basis. Returns where they end.
  Index append_random(Index place, Index width) {
    MatrixXd block(size_, width);
    for (Index c = 0; c < width; ++c, ++random_address_) {
      for (Index i = 0; i < size_; ++i) {
        block(i, c) = uniform({options_.start, RandomStream::lanczos_start, random_address_,
                               static_cast<std::uint64_t>(i)}) -
                      0.5;
      }
      block.col(c).normalize();
    }
    for (int pass = 0; pass < 2; ++pass) {
      remove_known(block, place);
      orthonormalise(block, pass == 0 ? 1e-10 : rounding_of_unit_vectors);
    }
    basis_.middleCols(place, block.cols()) = block;
    return place + block.cols();
  }

  bool converged(const Eigen::VectorXd& values, const Eigen::VectorXd& residual, Index count) const {
    for (Index r = 0; r < count; ++r) {
      if (residual[r] > std::max(options_.tolerance * values[r], epsilon * largest_)) return false;
    }
    return true;
  }

  void accept(const Eigen::VectorXd& values, const MatrixXd& vectors, const Eigen::VectorXd& residual) {
    const Index count = values.size(), old_count = result_.values.size();
    known_.middleCols(known_count_, count).noalias() = basis_.leftCols(vectors.rows()) * vectors;
    known_count_ += count;
    result_.values.conservativeResize(old_count + count);
    result_.values.tail(count) = values;
    result_.residual.conservativeResize(old_count + count);
    result_.residual.tail(count) = residual;
  }

  // The best Ritz vectors and the block that comes next stay. What joins them comes out when that block is
  // expanded.
  void restart(const Eigen::VectorXd& values, const MatrixXd& vectors, Index kept) {
    const Index width = next_ - done_;
    kept = std::min({kept, done_, basis_.cols() - 2 * width});
    const MatrixXd best = basis_.leftCols(done_) * vectors.leftCols(kept);
    basis_.middleCols(kept, width) = basis_.middleCols(done_, width).eval();
    basis_.leftCols(kept) = best;
    projection_.setZero();
    projection_.diagonal().head(kept) = values.head(kept);
    done_ = kept;
    next_ = kept + width;
    ++result_.restart_count;
  }

  const SymmetricOperator& apply_;
  Index size_;
  const LanczosOptions& options_;
  MatrixXd known_;  // (n x …) the first known_count_ columns
  Index known_count_ = 0;
  MatrixXd basis_{}, projection_{};
  Index done_ = 0, next_ = 0;  // columns of the basis that A was applied to; columns there are
  double largest_ = 0;         // the size of the operator
  std::uint32_t random_address_ = 0;
  LanczosResult result_{};
};

}  // namespace

LanczosResult largest_eigenpairs_in_blocks(const SymmetricOperator& apply, Index size,
                                           const LanczosOptions& options, const MatrixXd& deflated) {
  return BlockSearch(apply, size, options, deflated).run();
}

}  // namespace tremula
