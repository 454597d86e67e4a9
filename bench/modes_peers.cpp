// The modes of random trees by this program and by the solvers in use, same trees, same number of modes, same
// tolerance, one run: ARPACK with CHOLMOD (shift-invert), Spectra with SimplicialLDLT (shift-invert),
// LAPACK's dense generalised solver (small trees). Prints seconds, ratios to the best peer, and the largest
// relative error of a frequency against the dense or tightest solution of the compliance form. Usage:
// bench_modes_peers [MODES [BRANCHES…]]   (40; 17 62 212 692 2257)

#include <Spectra/SymGEigsShiftSolver.h>
#include <tbb/global_control.h>

#include <Eigen/CholmodSupport>
#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>
#include <arpack/arpack.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "plants.hpp"
#include "tremula/modes/solve_modes.hpp"
#include "tremula/structure/sparse_matrices.hpp"

namespace {

using namespace tremula;
using Sparse = Eigen::SparseMatrix<double>;

constexpr double tolerance = 1e-10;

// omega^2 of the lowest modes by ARPACK, mode 3 at shift 0.
Eigen::VectorXd by_arpack(const SparseMatrices& matrices, int count) {
  const Eigen::CholmodDecomposition<Sparse> factor(matrices.stiffness);
  const int n = static_cast<int>(matrices.stiffness.rows()), basis = std::min(n, 2 * count + 1);
  Eigen::MatrixXd vectors(n, basis);
  Eigen::VectorXd residual = Eigen::VectorXd::Ones(n), work(3 * n), values(count);
  std::vector<double> workl(static_cast<std::size_t>(basis * (basis + 8)));
  a_int ido = 0, info = 0, iparam[11] = {1, 0, 300, 1, 0, 0, 3}, ipntr[11] = {};
  const auto part = [&](a_int start) { return work.segment(start - 1, n); };
  while (true) {
    arpack::internal::dsaupd_c(&ido, "G", n, "LM", count, tolerance, residual.data(), basis, vectors.data(),
                               n, iparam, ipntr, work.data(), workl.data(), static_cast<a_int>(workl.size()),
                               &info);
    if (ido == -1) {
      const Eigen::VectorXd right = matrices.mass * part(ipntr[0]);
      part(ipntr[1]) = factor.solve(right);
    } else if (ido == 1) {
      const Eigen::VectorXd right = part(ipntr[2]);
      part(ipntr[1]) = factor.solve(right);
    } else if (ido == 2) {
      part(ipntr[1]) = (matrices.mass * part(ipntr[0])).eval();
    } else {
      break;
    }
  }
  if (info != 0) return {};
  std::vector<a_int> select(static_cast<std::size_t>(basis));
  arpack::internal::dseupd_c(1, "A", select.data(), values.data(), vectors.data(), n, 0.0, "G", n, "LM",
                             count, tolerance, residual.data(), basis, vectors.data(), n, iparam, ipntr,
                             work.data(), workl.data(), static_cast<a_int>(workl.size()), &info);
  std::sort(values.begin(), values.end());
  return info == 0 ? values : Eigen::VectorXd();
}

struct StiffnessSolve {
  using Scalar = double;
  const Sparse& stiffness;
  Eigen::SimplicialLDLT<Sparse> factor{};
  Eigen::Index rows() const { return stiffness.rows(); }
  Eigen::Index cols() const { return stiffness.cols(); }
  void set_shift(double) { factor.compute(stiffness); }
  void perform_op(const double* in, double* out) const {
    Eigen::VectorXd::Map(out, rows()) = factor.solve(Eigen::VectorXd::Map(in, rows()));
  }
};
struct MassProduct {
  using Scalar = double;
  const Sparse& mass;
  Eigen::Index rows() const { return mass.rows(); }
  Eigen::Index cols() const { return mass.cols(); }
  void perform_op(const double* in, double* out) const {
    Eigen::VectorXd::Map(out, rows()).noalias() = mass * Eigen::VectorXd::Map(in, rows());
  }
};

Eigen::VectorXd by_spectra(const SparseMatrices& matrices, int count) {
  StiffnessSolve solve{matrices.stiffness};
  MassProduct product{matrices.mass};
  const auto basis = std::min<Eigen::Index>(matrices.mass.rows(), 2 * count + 1);
  Spectra::SymGEigsShiftSolver<StiffnessSolve, MassProduct, Spectra::GEigsMode::ShiftInvert> solver(
      solve, product, count, basis, 0.0);
  solver.init();
  solver.compute(Spectra::SortRule::LargestMagn, 1000, tolerance);
  if (solver.info() != Spectra::CompInfo::Successful) return {};
  Eigen::VectorXd values = solver.eigenvalues();
  std::sort(values.begin(), values.end());
  return values;
}

Eigen::VectorXd by_dense(const SparseMatrices& matrices, int count) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(Eigen::MatrixXd(matrices.stiffness),
                                                                         Eigen::MatrixXd(matrices.mass));
  return solver.eigenvalues().head(count);
}

// The best of a few runs.
double seconds(const std::function<void()>& work) {
  double best = 1e30;
  const auto begun = std::chrono::steady_clock::now();
  for (int run = 0; run < 5; ++run) {
    const auto start = std::chrono::steady_clock::now();
    work();
    const auto now = std::chrono::steady_clock::now();
    best = std::min(best, std::chrono::duration<double>(now - start).count());
    if (std::chrono::duration<double>(now - begun).count() > 3) break;
  }
  return best;
}

double largest_error(const Eigen::VectorXd& squares, const Eigen::VectorXd& omega) {
  if (squares.size() != omega.size()) return -1;
  return (squares.cwiseSqrt().cwiseQuotient(omega).array() - 1).abs().maxCoeff();
}

void compare(int branches, int count) {
  const Structure structure = assemble(bench::stam_tree(branches), {});
  const int modes = std::min(count, static_cast<int>(structure.size()) / 3);
  const Eigen::VectorXd reference =
      solve_modes(structure, {.count = modes, .method = ModeMethod::iterative, .tolerance = 1e-13}).omega();
  const bool small = structure.size() <= 1300;
  Eigen::VectorXd own, arpack, spectra, dense;
  const double own_s =
      seconds([&] { own = solve_modes(structure, {.count = modes, .tolerance = tolerance}).omega(); });
  const double arpack_s = seconds([&] { arpack = by_arpack(assemble_sparse(structure), modes); });
  const double spectra_s = seconds([&] { spectra = by_spectra(assemble_sparse(structure), modes); });
  const double dense_s = small ? seconds([&] { dense = by_dense(assemble_sparse(structure), modes); }) : 1e30;
  const double best = std::min({arpack_s, spectra_s, dense_s});
  std::printf("%8d %5d | %9.4f %9.4f %9.4f %9.4f | %6.2f | %8.1e %8.1e %8.1e %8.1e\n", branches, modes, own_s,
              arpack_s, spectra_s, small ? dense_s : -1, best / own_s,
              (own.cwiseQuotient(reference).array() - 1).abs().maxCoeff(), largest_error(arpack, reference),
              largest_error(spectra, reference), small ? largest_error(dense, reference) : -1);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const int count = argc > 1 ? std::atoi(argv[1]) : 40;
  std::vector<int> sizes{17, 62, 212, 692, 2257};
  if (argc > 2) sizes.clear();
  for (int i = 2; i < argc; ++i) sizes.push_back(std::atoi(argv[i]));
  std::printf("%8s %5s | %9s %9s %9s %9s | %6s | relative errors of frequencies, in the same order\n",
              "branches", "modes", "tremula_s", "arpack_s", "spectra_s", "dense_s", "ratio");
  for (const int branches : sizes) compare(branches, count);
}
