// Long thin sets of vectors, and the few products of them that iterations need, at the speed of memory.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace tremula {

// Vectors of one length, each with a factor that is kept apart: vector i is scale[i] times the numbers in
// column(i). They are held one by one, so that there can be more of them without moving those there are.
class Columns {
 public:
  explicit Columns(Eigen::Index rows) : rows_(rows) {}

  Eigen::Index rows() const { return rows_; }
  Eigen::Index count() const { return static_cast<Eigen::Index>(columns_.size()); }
  Eigen::Map<Eigen::VectorXd> column(Eigen::Index i) { return {data(i), rows_}; }
  Eigen::Map<const Eigen::VectorXd> column(Eigen::Index i) const { return {data(i), rows_}; }
  double* data(Eigen::Index i) { return columns_[static_cast<std::size_t>(i)].get(); }
  const double* data(Eigen::Index i) const { return columns_[static_cast<std::size_t>(i)].get(); }

  void append();  // a column of any numbers
  void drop_from(Eigen::Index count);

  std::vector<double> scale{};

 private:
  struct Free {
    void operator()(double* memory) const;
  };
  Eigen::Index rows_;
  std::vector<std::unique_ptr<double[], Free>> columns_{};
};

// next = a next - b current - c previous; returns |next|^2. previous may be null.
double three_term_step(double* next, const double* current, const double* previous, Eigen::Index rows,
                       double a, double b, double c);

double dot(const double* a, const double* b, Eigen::Index rows);

// Takes from one or two vectors what they have of the first `count` vectors of the basis (orthonormal but for
// rounding), reading the basis twice for both. `second` may be null. Returns the largest of those parts of
// `second`, or of `first` where it is alone.
double remove_projection(const Columns& basis, Eigen::Index count, double* first, double* second);

// The first k columns become the first vectors of the basis times coefficients (count x k), k <= count, with
// scale 1; the others are freed. In place: no second basis is ever held.
void rotate(Columns& basis, const Eigen::MatrixXd& coefficients);

}  // namespace tremula
