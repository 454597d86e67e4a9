#include "tremula/dynamics/basis.hpp"

#include <algorithm>
#include <utility>

#include "tremula/base/check.hpp"

namespace tremula {

std::string_view name_of(ShapeKind kind) {
  switch (kind) {
    case ShapeKind::lean:
      return "lean";
    case ShapeKind::mode:
      return "mode";
    case ShapeKind::static_shape:
      break;
  }
  return "static";
}

int Basis::count(ShapeKind of) const { return static_cast<int>(std::count(kind.begin(), kind.end(), of)); }

Basis join(const Eigen::VectorXd& lean, Modes modes, const StaticShapes& static_shapes) {
  check_equal("columns of the mode shapes", modes.shapes.cols(), modes.count());
  check_equal("rows of the mode shapes", modes.shapes.rows(), lean.size());
  check_equal("columns of the static shapes", static_shapes.shapes.cols(), static_shapes.count());
  if (static_shapes.count() > 0)
    check_equal("rows of the static shapes", static_shapes.shapes.rows(), lean.size());
  const Eigen::Index count = 1 + modes.count() + static_shapes.count();
  Basis basis{{ShapeKind::lean}, Eigen::VectorXd(count), std::move(modes.shapes)};
  basis.kind.insert(basis.kind.end(), static_cast<std::size_t>(modes.count()), ShapeKind::mode);
  basis.kind.insert(basis.kind.end(), static_cast<std::size_t>(static_shapes.count()),
                    ShapeKind::static_shape);
  basis.frequency << 0, modes.frequency, static_shapes.frequency;
  // In place: of a large tree the shapes are most of the memory there is.
  basis.columns.conservativeResize(lean.size(), count);
  for (Eigen::Index r = modes.count(); r > 0; --r) basis.columns.col(r) = basis.columns.col(r - 1);
  basis.columns.col(0) = lean;
  if (static_shapes.count() > 0) basis.columns.rightCols(static_shapes.count()) = static_shapes.shapes;
  return basis;
}

Eigen::VectorXd lean_of(const Basis& basis) {
  Eigen::VectorXd lean = Eigen::VectorXd::Zero(basis.columns.rows());
  for (std::size_t c = 0; c < basis.kind.size(); ++c) {
    if (basis.kind[c] == ShapeKind::lean) lean += basis.columns.col(static_cast<Eigen::Index>(c));
  }
  return lean;
}

void check_basis(const Basis& basis) {
  check_equal("kinds of the shapes", static_cast<std::ptrdiff_t>(basis.kind.size()), basis.count());
  check_equal("columns of the basis", basis.columns.cols(), basis.count());
  if (!basis.columns.allFinite() || !basis.frequency.allFinite())
    throw InputError("basis", "a number that is not finite", "finite numbers");
}

Eigen::VectorXd superpose(const Basis& basis, const Eigen::VectorXd& coordinates) {
  check_equal("coordinates", coordinates.size(), basis.columns.cols());
  const Eigen::MatrixXd& x = basis.columns;
  const Eigen::VectorXd& y = coordinates;
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(x.rows());
  if (y.size() > 0) sum = y[0] * x.col(0);
  // Four columns on one way through the sum, added one after the other as ever.
  Eigen::Index c = 1;
  for (; c + 4 <= y.size(); c += 4) {
    sum = (((sum + y[c] * x.col(c)) + y[c + 1] * x.col(c + 1)) + y[c + 2] * x.col(c + 2)) +
          y[c + 3] * x.col(c + 3);
  }
  for (; c < y.size(); ++c) sum += y[c] * x.col(c);
  return sum;
}

}  // namespace tremula
