// The modes of random trees by this program and by the solvers in use, same trees, same number of modes, same
// tolerance, one run: ARPACK with CHOLMOD (shift-invert), Spectra with SimplicialLDLT (shift-invert),
// a dense generalised solver (small trees). Every solver runs in a process of its own, on one thread (tremula
// on two as well). Prints seconds, the ratio to the best peer, peak memory, and the largest relative error of
// a frequency against Ritz values in long double. Usage: bench_modes_peers [MODES [BRANCHES…]]   (40; 17 62
// 212 692 2257 20000)

#include <Spectra/SymGEigsShiftSolver.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <tbb/global_control.h>
#include <unistd.h>

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

#include "long_double_reference.hpp"
#include "plants.hpp"
#include "tremula/modes/solve_modes.hpp"
#include "tremula/reference/sparse_matrices.hpp"

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

// What a solver gave, in a process of its own.
struct Outcome {
  double seconds = -1, peak_gigabytes = 0;
  Eigen::VectorXd omega;
};

// The best of a few runs of `solve`, which gives omega [rad/s].
Outcome measure(int threads, Eigen::Index count, const std::function<Eigen::VectorXd()>& solve) {
  int ends[2];
  if (pipe(ends) != 0) std::abort();
  const pid_t child = fork();
  if (child == 0) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(threads));
    double best = 1e30;
    Eigen::VectorXd omega;
    const auto begun = std::chrono::steady_clock::now();
    for (int run = 0; run < 5; ++run) {
      const auto start = std::chrono::steady_clock::now();
      omega = solve();
      const auto now = std::chrono::steady_clock::now();
      best = std::min(best, std::chrono::duration<double>(now - start).count());
      if (std::chrono::duration<double>(now - begun).count() > 3) break;
    }
    if (omega.size() != count) best = -1;
    omega.conservativeResize(count);
    const bool written = write(ends[1], &best, sizeof best) == sizeof best &&
                         write(ends[1], omega.data(), static_cast<std::size_t>(count) * sizeof(double)) > 0;
    _exit(written ? 0 : 1);
  }
  close(ends[1]);
  Outcome outcome;
  outcome.omega.resize(count);
  if (read(ends[0], &outcome.seconds, sizeof outcome.seconds) != sizeof outcome.seconds ||
      read(ends[0], outcome.omega.data(), static_cast<std::size_t>(count) * sizeof(double)) <= 0) {
    outcome.seconds = -1;
  }
  close(ends[0]);
  rusage usage{};
  int status = 0;
  wait4(child, &status, 0, &usage);
  outcome.peak_gigabytes = static_cast<double>(usage.ru_maxrss) * 1024 / 1e9;
  return outcome;
}

void compare(int branches, int count) {
  const Skeleton skeleton = bench::stam_tree(branches);
  const Structure structure = assemble(skeleton, {.gravity = 0});  // K and M alone go to all of them
  const BeamTree tree = assemble_tree(skeleton, {});
  const int modes = std::min(count, static_cast<int>(structure.size()) / 3);
  const auto own = [&] { return solve_modes(structure, {.count = modes, .tolerance = tolerance}).omega(); };
  const auto peer = [&](Eigen::VectorXd (*solve)(const SparseMatrices&, int)) {
    return [&tree, modes, solve]() -> Eigen::VectorXd {
      return solve(assemble_sparse(tree), modes).cwiseSqrt();
    };
  };
  const Outcome nothing =
      measure(1, modes, [&]() -> Eigen::VectorXd { return Eigen::VectorXd::Zero(modes); });
  const Outcome one = measure(1, modes, own), two = measure(2, modes, own);
  const Outcome arpack = measure(1, modes, peer(by_arpack)), spectra = measure(1, modes, peer(by_spectra));
  const Outcome dense = structure.size() <= 1300 ? measure(1, modes, peer(by_dense)) : Outcome{};
  double best = 1e30;
  for (const Outcome* other : {&arpack, &spectra, &dense}) {
    if (other->seconds > 0) best = std::min(best, other->seconds);
  }
  const test::LongVector reference =
      test::long_frequencies(tree, solve_modes(structure, {.count = modes, .tolerance = 1e-12}).shapes);
  const auto error = [&](const Outcome& outcome) {
    if (outcome.seconds < 0) return -1.0;
    const test::LongVector frequency =
        outcome.omega.cast<long double>() / (2 * std::numbers::pi_v<long double>);
    return static_cast<double>((frequency.cwiseQuotient(reference).array() - 1).abs().maxCoeff());
  };
  std::printf(
      "%8d %5d | %9.5f %9.5f %9.4f %9.4f %9.4f | %6.2f %6.2f | %8.1e %8.1e %8.1e %8.1e | %6.3f %6.3f %6.3f\n",
      branches, modes, one.seconds, two.seconds, arpack.seconds, spectra.seconds, dense.seconds,
      best / one.seconds, best / two.seconds, error(one), error(arpack), error(spectra), error(dense),
      one.peak_gigabytes - nothing.peak_gigabytes, arpack.peak_gigabytes - nothing.peak_gigabytes,
      spectra.peak_gigabytes - nothing.peak_gigabytes);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const int count = argc > 1 ? std::atoi(argv[1]) : 40;
  std::vector<int> sizes{17, 62, 212, 692, 2257, 20000};
  if (argc > 2) sizes.clear();
  for (int i = 2; i < argc; ++i) sizes.push_back(std::atoi(argv[i]));
  std::printf(
      "%8s %5s | %9s %9s %9s %9s %9s | %6s %6s | relative errors of frequencies (tremula, arpack, "
      "spectra, dense) | memory beside the tree [GB] (tremula, arpack, spectra)\n",
      "branches", "modes", "tremula_s", "2threads", "arpack_s", "spectra_s", "dense_s", "ratio", "ratio2");
  for (const int branches : sizes) compare(branches, count);
}
