// A sheet as a structure: K by sparse Cholesky, M with what the fluid adds, and six rows a node of which the
// sheet moves three at most.
#include "tremula/structure/plate_sites.hpp"
#include "tremula/structure/sheet.hpp"
#include "tremula/structure/sparse_pivots.hpp"
#include "tremula/structure/still_fluid.hpp"
#include "tremula/structure/structure.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"

namespace tremula {
namespace {

using Matrix = Eigen::SparseMatrix<double>;
using Cholesky = Eigen::SimplicialLLT<Matrix>;

// The fluid about the sheet, as rho area P^T A^-1 P on the unknowns: P gives w at the centres of the panels.
struct Fluid {
  Matrix at_panels;           // P
  Eigen::MatrixXd influence;  // A / (rho area)
  Eigen::LLT<Eigen::MatrixXd> factors;
};

// All that the functions of the structure work on.
struct SheetBody {
  Sheet sheet;
  SheetMatrices matrices;
  Matrix stiffness;
  std::vector<Node> nodes;
  Matrix
      carry;  // (rows x U) the unknowns as translations and rotations in world axes; columns are unit vectors
  Cholesky cholesky;
  std::optional<Fluid> fluid = {};

  Eigen::VectorXd mass(const Eigen::VectorXd& unknowns) const {
    Eigen::VectorXd forces = matrices.mass * unknowns;
    if (fluid) forces += fluid->at_panels.transpose() * fluid->factors.solve(fluid->at_panels * unknowns);
    return forces;
  }
};
using Body = std::shared_ptr<const SheetBody>;

void place_nodes(SheetBody& body) {
  const Sheet& sheet = body.sheet;
  const Vec3 directions[] = {sheet.normal(), sheet.along_width, sheet.along_height};
  std::vector<Eigen::Triplet<double>> entries;
  int rows = 0;
  for (int i = 0; i < sheet.node_count(); ++i) {
    const auto& unknowns = body.matrices.unknowns[index_of(i)];
    const bool held = std::all_of(unknowns.begin(), unknowns.end(), [](int u) { return u < 0; });
    body.nodes.push_back({sheet.position(sheet.place(i)), held ? -1 : rows, -1});
    if (held) continue;
    for (int k = 0; k < 3; ++k) {
      const int unknown = unknowns[index_of(k)];
      for (int axis = 0; unknown >= 0 && axis < 3; ++axis) {
        const double part = directions[k][axis];
        if (part != 0) entries.emplace_back(rows + (k == 0 ? 0 : 3) + axis, unknown, part);
      }
    }
    rows += 6;
  }
  body.carry.resize(rows, body.matrices.size());
  body.carry.setFromTriplets(entries.begin(), entries.end());
}

// w = 1, x / width and y / height over the unknowns, as far as what is held lets them: an orthonormal basis
// of the rigid motions that nothing holds.
Eigen::MatrixXd free_rigid_motions(const Sheet& sheet, const SheetMatrices& matrices) {
  Eigen::MatrixX3d motions = Eigen::MatrixX3d::Zero(matrices.size(), 3);
  Eigen::Matrix3d held = Eigen::Matrix3d::Zero();
  for (int i = 0; i < sheet.node_count(); ++i) {
    const Eigen::Vector2d place = sheet.place(i);
    Eigen::Matrix3d own;  // of w, theta_x and theta_y
    own << 1, place[0] / sheet.width, place[1] / sheet.height, 0, 0, 1, 0, -1, 0;
    for (int k = 0; k < 3; ++k) {
      const int unknown = matrices.unknowns[index_of(i)][index_of(k)];
      if (unknown < 0) {
        held += own.row(k).transpose() * own.row(k);
      } else {
        motions.row(unknown) = own.row(k);
        if (k == 1) motions.row(unknown) /= sheet.height;
        if (k == 2) motions.row(unknown) /= sheet.width;
      }
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(held);
  const Eigen::Index free = (solver.eigenvalues().array() < 1e-12 * (1 + solver.eigenvalues()[2])).count();
  return motions * solver.eigenvectors().leftCols(free);
}

double largest_force(const std::vector<MembraneForce>& membrane) {
  double largest = 0;
  for (const MembraneForce& force : membrane)
    largest = std::max({largest, std::abs(force.x), std::abs(force.y), std::abs(force.xy)});
  return largest;
}

// A sheet that could float away or turn about its hinges has no K^-1, unless a pull holds it there.
void check_held(const Sheet& sheet, const SheetMatrices& matrices) {
  if (sheet.clamped.empty() && sheet.pinned.empty() && sheet.pinned_points.empty())
    throw InputError("sheet", "clamped nowhere", "at least one edge that is clamped or two that are pinned");
  const Eigen::MatrixXd motions = free_rigid_motions(sheet, matrices);
  if (motions.cols() == 0) return;
  const Eigen::MatrixXd energy = motions.transpose() * (matrices.geometric * motions);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(energy, Eigen::EigenvaluesOnly);
  const double scale =
      largest_force(matrices.membrane) * (sheet.height / sheet.width + sheet.width / sheet.height);
  if (solver.eigenvalues()[0] > 1e-9 * scale) return;
  throw InputError("sheet", "free to turn about where it is pinned",
                   "an edge that is clamped, another that is pinned, or a pull that holds it");
}

bool is_pressed(const std::vector<MembraneForce>& membrane) {
  return std::any_of(membrane.begin(), membrane.end(), [](const MembraneForce& force) {
    return force.x < 0 || force.y < 0 || force.x * force.y < force.xy * force.xy;
  });
}

// Bisection on the factor at which K_bending + c K_G first has a pivot that is not above 0.
double buckling_factor(const SheetMatrices& matrices) {
  if (!is_pressed(matrices.membrane)) return LoadMargin{}.factor;
  Cholesky cholesky;
  cholesky.analyzePattern(matrices.bending + matrices.geometric);
  const auto stands = [&](double factor) {
    cholesky.factorize(matrices.bending + factor * matrices.geometric);
    return cholesky.info() == Eigen::Success;
  };
  double low = 0, high = 1;
  while (stands(high)) {
    low = high, high *= 16;
    if (high > 1e12) return LoadMargin{}.factor;
  }
  if (low == 0) {
    for (low = high / 16; !stands(low); low /= 16) {
      high = low;
      if (low < 1e-12) return 0;
    }
  }
  while (high - low > 1e-8 * high) {
    const double middle = 0.5 * (low + high);
    (stands(middle) ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

void factorise(SheetBody& body) {
  body.cholesky.compute(body.stiffness);
  if (body.cholesky.info() == Eigen::Success) return;
  const double factor = buckling_factor(body.matrices);
  if (factor < 1) {
    throw InputError("sheet", "it buckles: it bears " + number_text(factor) + " of its weight and tension",
                     "a thicker or stiffer one, a pull, or less of these; cloth: wrinkles");
  }
  throw InputError("sheet", "so slender that rounding takes all of its stiffness",
                   "a thicker one, or fewer elements");
}

Fluid fluid_about(const Sheet& sheet, const SheetMatrices& matrices, double density) {
  FluidPanels panels = fluid_panels(sheet.width, sheet.height);
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index p = 0; p < panels.centres.cols(); ++p) {
    const SheetPoint point = sheet_point(sheet, matrices, panels.centres.col(p));
    for (int k = 0; k < 12; ++k) {
      const int unknown = point.unknowns[index_of(k)];
      if (unknown >= 0) entries.emplace_back(static_cast<int>(p), unknown, point.shape.deflection[k]);
    }
  }
  Fluid fluid;
  fluid.at_panels.resize(panels.centres.cols(), matrices.size());
  fluid.at_panels.setFromTriplets(entries.begin(), entries.end());
  fluid.influence = std::move(panels.influence) / (density * panels.area);
  fluid.factors.compute(fluid.influence);
  return fluid;
}

// With S = K - omega^2 M, what the fluid adds is the Schur complement of a symmetric matrix that has S in one
// corner and F = A / (rho area) in the other. Its negative pivots, which are as many whichever corner goes
// first, are those of S and of F - omega^2 P S^-1 P^T; F itself has none.
int count_wet(const SheetBody& body, const Eigen::SimplicialLDLT<Matrix>& factors, double omega) {
  const Fluid& fluid = *body.fluid;
  const Eigen::MatrixXd columns = factors.solve(Eigen::MatrixXd(fluid.at_panels.transpose()));
  const Eigen::MatrixXd rest = fluid.influence - omega * omega * (fluid.at_panels * columns);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(0.5 * (rest + rest.transpose()),
                                                              Eigen::EigenvaluesOnly);
  return static_cast<int>((solver.eigenvalues().array() < 0).count());
}

// q = P^T L^-T s.
EigenProblem sheet_problem(const Body& body) {
  const auto indefinite = std::make_shared<Eigen::SimplicialLDLT<Matrix>>();
  indefinite->analyzePattern(body->stiffness + body->matrices.mass);
  const auto unknowns = [body](Eigen::Ref<const Eigen::VectorXd> s) -> Eigen::VectorXd {
    return body->cholesky.permutationPinv() * Eigen::VectorXd(body->cholesky.matrixU().solve(s));
  };
  return {.size = body->matrices.size(),
          .degrees_of_freedom = body->matrices.size(),
          .apply =
              [body, unknowns](Eigen::Ref<const Eigen::VectorXd> in, Eigen::Ref<Eigen::VectorXd> out) {
                const Eigen::VectorXd inertia = body->mass(unknowns(in));
                out =
                    body->cholesky.matrixL().solve(Eigen::VectorXd(body->cholesky.permutationP() * inertia));
                return in.dot(out);
              },
          .displacement = [body, unknowns](Eigen::Ref<const Eigen::VectorXd> s) -> Eigen::VectorXd {
            return body->carry * unknowns(s);
          },
          .count_below =
              [body, indefinite](double omega) {
                const int dry = count_below(*indefinite, body->stiffness, body->matrices.mass, omega);
                return body->fluid ? dry + count_wet(*body, *indefinite, omega) : dry;
              }};
}

Sites sheet_sites(const Body& body) {
  const Sheet& sheet = body->sheet;
  const auto points = std::make_shared<std::vector<SheetPoint>>();
  PlateSites laid = lay_sites(sheet);
  Sites result;
  result.points = std::move(laid.points);
  result.sites = std::move(laid.sites);
  for (const Eigen::Vector2d& place : laid.places)
    points->push_back(sheet_point(sheet, body->matrices, place));
  const Vec3 normal = sheet.normal();
  // The products of the shapes at a site with the unknowns, as vectors along the directions.
  const auto told = [body, points](std::size_t first, std::size_t last,
                                   Eigen::Ref<const Eigen::MatrixXd> displacements, const auto& of_site) {
    check_equal("rows of the displacements", displacements.rows(), body->carry.rows());
    const Eigen::MatrixXd unknowns = body->carry.transpose() * displacements;
    Eigen::MatrixXd moved(3 * static_cast<Eigen::Index>(last - first), displacements.cols());
    for (std::size_t s = first; s < last; ++s) {
      const SheetPoint& point = (*points)[s];
      Eigen::MatrixXd own = Eigen::MatrixXd::Zero(12, displacements.cols());
      for (int k = 0; k < 12; ++k) {
        if (point.unknowns[index_of(k)] >= 0) own.row(k) = unknowns.row(point.unknowns[index_of(k)]);
      }
      moved.middleRows<3>(3 * static_cast<Eigen::Index>(s - first)) = of_site(point.shape, own);
    }
    return moved;
  };
  result.motion = [told, normal](std::size_t first, std::size_t last,
                                 Eigen::Ref<const Eigen::MatrixXd> displacements) {
    return told(first, last, displacements,
                [&](const PlateShape& shape, const Eigen::MatrixXd& own) -> Eigen::MatrixXd {
                  return normal * (shape.deflection.transpose() * own);
                });
  };
  result.turning = [told, &sheet, body](std::size_t first, std::size_t last,
                                        Eigen::Ref<const Eigen::MatrixXd> displacements) {
    return told(first, last, displacements,
                [&](const PlateShape& shape, const Eigen::MatrixXd& own) -> Eigen::MatrixXd {
                  return sheet.along_width * (shape.slope_y.transpose() * own) -
                         sheet.along_height * (shape.slope_x.transpose() * own);
                });
  };
  result.gather = [body, points, normal](const Eigen::Matrix3Xd& forces) -> Eigen::VectorXd {
    check_equal("columns of the forces on the sites", forces.cols(),
                static_cast<Eigen::Index>(points->size()));
    Eigen::VectorXd unknowns = Eigen::VectorXd::Zero(body->matrices.size());
    for (std::size_t s = 0; s < points->size(); ++s) {
      const SheetPoint& point = (*points)[s];
      const double across_it = normal.dot(forces.col(static_cast<Eigen::Index>(s)));
      for (int k = 0; k < 12; ++k) {
        if (point.unknowns[index_of(k)] >= 0)
          unknowns[point.unknowns[index_of(k)]] += point.shape.deflection[k] * across_it;
      }
    }
    return body->carry * unknowns;
  };
  return result;
}

// Of the sheet without the fluid, which stays where it is when the ground moves. In its plane the sheet goes
// with the ground.
GroundInertia ground_inertia(const SheetBody& body) {
  const Sheet& sheet = body.sheet;
  const double mass_per_area = sheet.density * sheet.thickness;
  GroundInertia result{Eigen::MatrixX3d::Zero(body.carry.rows(), 3),
                       mass_per_area * sheet.width * sheet.height};
  const PlateElement element{sheet.width / sheet.elements[0], sheet.height / sheet.elements[1]};
  PlateVector rigid = PlateVector::Zero();
  for (int corner = 0; corner < 4; ++corner) rigid[3 * corner] = 1;
  const PlateVector forces = plate_mass(element, mass_per_area) * rigid;
  Eigen::VectorXd unknowns = Eigen::VectorXd::Zero(body.matrices.size());
  for (int j = 0; j < sheet.elements[1]; ++j) {
    for (int i = 0; i < sheet.elements[0]; ++i) {
      const Eigen::Vector2d middle(element.width * (i + 0.5), element.height * (j + 0.5));
      const SheetPoint own = sheet_point(sheet, body.matrices, middle);
      for (int k = 0; k < 12; ++k) {
        if (own.unknowns[index_of(k)] >= 0) unknowns[own.unknowns[index_of(k)]] += forces[k];
      }
    }
  }
  result.forces = (body.carry * unknowns) * sheet.normal().transpose();
  return result;
}

}  // namespace

Structure assemble(const Sheet& sheet, const SheetOptions& options) {
  if (!(options.fluid_density >= 0 && std::isfinite(options.fluid_density)))
    throw InputError("fluid density", number_text(options.fluid_density), "0 or more");
  if (!std::isfinite(options.gravity))
    throw InputError("gravity", number_text(options.gravity), "a finite number");
  if (!options.pull.allFinite()) throw InputError("pull", "a number that is not finite", "N/m^2");
  check_sheet(sheet);
  if (sheet.clamped.empty() && sheet.pinned.empty() && sheet.pinned_points.empty()) check_held(sheet, {});
  const auto making = std::make_shared<SheetBody>();
  making->sheet = sheet;
  making->matrices = assemble_sheet(sheet, options);
  making->stiffness = making->matrices.bending + making->matrices.geometric;
  check_held(sheet, making->matrices);
  place_nodes(*making);
  factorise(*making);
  if (options.fluid_density > 0) making->fluid = fluid_about(sheet, making->matrices, options.fluid_density);
  const Body body = making;

  Structure structure;
  structure.nodes = body->nodes;
  structure.mass = [body](const Eigen::VectorXd& displacement) -> Eigen::VectorXd {
    check_equal("rows of the displacement", displacement.size(), body->carry.rows());
    return body->carry * body->mass(body->carry.transpose() * displacement);
  };
  structure.flexibility = [body](const Eigen::VectorXd& force) -> Eigen::VectorXd {
    check_equal("rows of the force", force.size(), body->carry.rows());
    return body->carry * body->cholesky.solve(Eigen::VectorXd(body->carry.transpose() * force));
  };
  structure.eigen = {
      .rows = {all_rows(body->carry.rows())},
      .degrees_of_freedom = {body->matrices.size()},
      .problem = [body](std::size_t, bool) { return sheet_problem(body); },
      .count_below =
          [body](double omega) { return std::vector<int>{sheet_problem(body).count_below(omega)}; },
      .rows_explained = "one for how each node moves across the sheet and two for how it turns"};
  structure.find_sites = [body] { return sheet_sites(body); };
  structure.find_ground_inertia = [body] { return ground_inertia(*body); };
  structure.find_load_margin = [body] { return LoadMargin{buckling_factor(body->matrices)}; };
  structure.row_count = body->carry.rows();
  structure.sheet = {body, &body->sheet};
  return structure;
}

}  // namespace tremula
