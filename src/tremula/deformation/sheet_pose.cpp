#include "tremula/deformation/sheet_pose.hpp"

#include "tremula/base/check.hpp"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

// Vertices in rows from the bottom.
struct Grid {
  int across, up;  // vertices along the width and along the height
  std::size_t at(int column, int row) const { return index_of(row * across + column); }
  std::size_t count() const { return index_of(across * up); }
};

// w and its slopes along width and height.
struct Deflection {
  double w, along_width, along_height;
};

const Sheet& sheet_of(const Structure& structure) {
  if (!structure.sheet) throw InputError("structure", "no sheet", "a sheet");
  return *structure.sheet;
}

Grid grid_of(const Sheet& sheet, int pieces) {
  return {sheet.elements[0] * pieces + 1, sheet.elements[1] * pieces + 1};
}

Grid grid_of(const Sheet& sheet, const Surface& surface) {
  for (int pieces = 1; pieces <= 64; ++pieces) {
    const Grid grid = grid_of(sheet, pieces);
    if (grid.count() == surface.vertex_count()) return grid;
  }
  throw InputError("vertices of the surface", std::to_string(surface.vertex_count()), "a grid on the sheet");
}

Eigen::Vector2d place_of(const Sheet& sheet, const Grid& grid, int column, int row) {
  return {sheet.width * column / (grid.across - 1), sheet.height * row / (grid.up - 1)};
}

std::vector<Deflection> deflections(const Structure& structure, const Grid& grid,
                                    const Eigen::VectorXd& displacement) {
  const Sheet& sheet = sheet_of(structure);
  check_equal("rows of the displacement", displacement.size(), structure.size());
  const Vec3 normal = sheet.normal();
  std::vector<Deflection> result(grid.count());
  tbb::parallel_for(0, grid.up, [&](int row) {
    for (int column = 0; column < grid.across; ++column) {
      const SheetPlace place = place_on(sheet, place_of(sheet, grid, column, row));
      PlateVector corners;
      for (int corner = 0; corner < 4; ++corner) {
        const Vec6 node = node_displacement(structure, displacement, index_of(place.nodes[index_of(corner)]));
        corners.segment<3>(3 * corner) << normal.dot(node.head<3>()), sheet.along_width.dot(node.tail<3>()),
            sheet.along_height.dot(node.tail<3>());
      }
      result[grid.at(column, row)] = {place.shape.deflection.dot(corners), place.shape.slope_x.dot(corners),
                                      place.shape.slope_y.dot(corners)};
    }
  });
  return result;
}

// The frame of a piece of the sheet that slopes, its first two columns in the sheet; turned from rest.
Mat3 frame_of(const Sheet& sheet, const Vec3& along_width, const Vec3& along_height) {
  Mat3 rest, now;
  rest << sheet.along_width, sheet.along_height, sheet.normal();
  const Vec3 normal = along_width.cross(along_height).normalized(), first = along_width.normalized();
  now << first, normal.cross(first), normal;
  return now * rest.transpose();
}

// Which way lines run from what holds them to a free edge.
enum class Lines { none, right, left, up, down };

Lines lines_of(const Sheet& sheet) {
  bool held[4] = {};  // as SheetEdge counts
  for (const auto* edges : {&sheet.clamped, &sheet.pinned}) {
    for (const SheetEdge edge : *edges) held[static_cast<int>(edge)] = true;
  }
  for (const Eigen::Vector2d& point : sheet.pinned_points) {
    const Eigen::Array2d share = point.array() / Eigen::Array2d(sheet.width, sheet.height);
    held[static_cast<int>(SheetEdge::left)] |= share[0] < 0.01;
    held[static_cast<int>(SheetEdge::right)] |= share[0] > 0.99;
    held[static_cast<int>(SheetEdge::bottom)] |= share[1] < 0.01;
    held[static_cast<int>(SheetEdge::top)] |= share[1] > 0.99;
  }
  const auto [left, right, bottom, top] = held;
  if (left && right) return bottom == top ? Lines::none : top ? Lines::down : Lines::up;
  if (bottom && top) return left == right ? Lines::none : left ? Lines::right : Lines::left;
  if (left || right) return left ? Lines::right : Lines::left;
  if (bottom || top) return top ? Lines::down : Lines::up;
  return Lines::none;
}

// The n vertices of one line, from what holds it on: they lie `step` apart.
void run_on(const std::vector<Deflection>& deflection, const std::vector<std::size_t>& line, double step,
            const Vec3& onwards, const Vec3& normal, const std::vector<Vec3>& rest,
            std::vector<BentPoint>& bent) {
  Vec3 position = rest[line[0]] + deflection[line[0]].w * normal;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (i > 0) {
      const double rise = (deflection[line[i]].w - deflection[line[i - 1]].w) / step;
      position += step * (onwards + rise * normal) / std::hypot(1, rise);
    }
    bent[line[i]].position = position;
  }
}

std::vector<BentPoint> bent_grid(const Structure& structure, const Grid& grid,
                                 const Eigen::VectorXd& displacement) {
  const Sheet& sheet = sheet_of(structure);
  const std::vector<Deflection> deflection = deflections(structure, grid, displacement);
  const Vec3 normal = sheet.normal();
  std::vector<Vec3> rest(grid.count());
  std::vector<BentPoint> bent(grid.count());
  for (int row = 0; row < grid.up; ++row) {
    for (int column = 0; column < grid.across; ++column) {
      const std::size_t i = grid.at(column, row);
      rest[i] = sheet.position(place_of(sheet, grid, column, row));
      bent[i].position = rest[i] + deflection[i].w * normal;
      bent[i].frame = frame_of(sheet, sheet.along_width + deflection[i].along_width * normal,
                               sheet.along_height + deflection[i].along_height * normal);
    }
  }
  const Lines lines = lines_of(sheet);
  if (lines == Lines::none) return bent;
  const bool level = lines == Lines::right || lines == Lines::left;
  const bool backwards = lines == Lines::left || lines == Lines::down;
  const int line_count = level ? grid.up : grid.across, length = level ? grid.across : grid.up;
  const double step = (level ? sheet.width : sheet.height) / (length - 1);
  const Vec3 onwards = (backwards ? -1 : 1) * (level ? sheet.along_width : sheet.along_height);
  tbb::parallel_for(0, line_count, [&](int k) {
    std::vector<std::size_t> line(index_of(length));
    for (int i = 0; i < length; ++i) {
      const int along = backwards ? length - 1 - i : i;
      line[index_of(i)] = level ? grid.at(along, k) : grid.at(k, along);
    }
    run_on(deflection, line, step, onwards, normal, rest, bent);
  });
  return bent;
}

// What four values in a row make between the second and the third; a half of the way: 0.5. At an end of the
// row the missing one goes on straight.
using Weights = std::array<double, 4>;
struct Stencil {
  std::array<int, 4> at;
  Weights weights;
};

Stencil stencil(int pieces, int count, int vertex) {
  const int element = std::min(vertex / pieces, count - 1);
  const double t = static_cast<double>(vertex - element * pieces) / pieces;
  Weights w = {0.5 * t * (-1 + t * (2 - t)), 1 + t * t * (-2.5 + 1.5 * t), 0.5 * t * (1 + t * (4 - 3 * t)),
               0.5 * t * t * (t - 1)};
  std::array<int, 4> at = {element - 1, element, element + 1, element + 2};
  if (at[0] < 0) {
    w[1] += 2 * w[0];
    w[2] -= w[0];
    w[0] = at[0] = 0;
  }
  if (at[3] > count) {
    w[2] += 2 * w[3];
    w[1] -= w[3];
    w[3] = 0;
    at[3] = count;
  }
  return {at, w};
}

std::vector<BentPoint> carried_grid(const Structure& structure, int pieces,
                                    const Eigen::VectorXd& displacement) {
  const Sheet& sheet = sheet_of(structure);
  check_equal("rows of the displacement", displacement.size(), structure.size());
  const Grid grid = grid_of(sheet, pieces);
  std::vector<Vec3> nodes;
  for (std::size_t i = 0; i < structure.nodes.size(); ++i)
    nodes.push_back(structure.nodes[i].position + node_displacement(structure, displacement, i).head<3>());
  std::vector<BentPoint> carried(grid.count());
  for (int row = 0; row < grid.up; ++row) {
    const Stencil up = stencil(pieces, sheet.elements[1], row);
    for (int column = 0; column < grid.across; ++column) {
      const Stencil across = stencil(pieces, sheet.elements[0], column);
      Vec3& position = carried[grid.at(column, row)].position;
      position.setZero();
      for (std::size_t j = 0; j < 4; ++j) {
        for (std::size_t i = 0; i < 4; ++i)
          position += up.weights[j] * across.weights[i] * nodes[index_of(sheet.node(across.at[i], up.at[j]))];
      }
    }
  }
  const auto along = [&](int column, int row, int right, int above) -> Vec3 {
    const auto clamped = [&](int sign) {
      return grid.at(std::clamp(column + sign * right, 0, grid.across - 1),
                     std::clamp(row + sign * above, 0, grid.up - 1));
    };
    return carried[clamped(1)].position - carried[clamped(-1)].position;
  };
  for (int row = 0; row < grid.up; ++row) {
    for (int column = 0; column < grid.across; ++column)
      carried[grid.at(column, row)].frame =
          frame_of(sheet, along(column, row, 1, 0), along(column, row, 0, 1));
  }
  return carried;
}

SurfaceDelta delta_of(const Sheet& sheet, const Surface& surface, const std::vector<BentPoint>& bent) {
  SurfaceDelta delta;
  for (std::size_t i = 0; i < bent.size(); ++i) {
    delta.position.push_back((bent[i].position - surface.position[i].cast<double>()).cast<float>());
    delta.normal.push_back((bent[i].frame * sheet.normal() - sheet.normal()).cast<float>());
  }
  return delta;
}

}  // namespace

Surface sheet_surface(const Sheet& sheet, const SurfaceMaterial& material, int pieces) {
  check_sheet(sheet);
  check_at_least("pieces of an element's side", pieces, 1);
  const Grid grid = grid_of(sheet, pieces);
  Surface surface;
  SurfacePart part{.material = material, .triangles = {}, .pieces = {}};
  part.material.two_sided = true;
  for (int row = 0; row < grid.up; ++row) {
    for (int column = 0; column < grid.across; ++column) {
      const Eigen::Vector2d place = place_of(sheet, grid, column, row);
      surface.position.push_back(sheet.position(place).cast<float>());
      surface.normal.push_back(sheet.normal().cast<float>());
      surface.texture.emplace_back(static_cast<float>(place[0] / sheet.width),
                                   static_cast<float>(place[1] / sheet.height));
      surface.branch.push_back(std::min(row / pieces, sheet.elements[1] - 1) * sheet.elements[0] +
                               std::min(column / pieces, sheet.elements[0] - 1));
      surface.along.push_back(0);
      if (row + 1 == grid.up || column + 1 == grid.across) continue;
      const auto at = [&](int right, int above) {
        return static_cast<std::uint32_t>(grid.at(column + right, row + above));
      };
      part.triangles.insert(part.triangles.end(),
                            {at(0, 0), at(1, 0), at(1, 1), at(0, 0), at(1, 1), at(0, 1)});
    }
  }
  surface.parts = {std::move(part)};
  return surface;
}

SurfaceDelta deform_sheet(const Structure& structure, const Surface& surface,
                          const Eigen::VectorXd& displacement) {
  const Sheet& sheet = sheet_of(structure);
  const std::vector<Deflection> deflection = deflections(structure, grid_of(sheet, surface), displacement);
  const Vec3 normal = sheet.normal();
  SurfaceDelta delta;
  for (const Deflection& here : deflection) {
    delta.position.push_back((here.w * normal).cast<float>());
    delta.normal.push_back(
        (-here.along_width * sheet.along_width - here.along_height * sheet.along_height).cast<float>());
  }
  return delta;
}

SurfaceDelta bend_sheet(const Structure& structure, const Surface& surface,
                        const Eigen::VectorXd& displacement) {
  const Sheet& sheet = sheet_of(structure);
  return delta_of(sheet, surface, bent_grid(structure, grid_of(sheet, surface), displacement));
}

std::vector<BentPoint> bent_nodes(const Structure& structure, const Eigen::VectorXd& displacement) {
  return bent_grid(structure, grid_of(sheet_of(structure), 1), displacement);
}

SurfaceDelta carry_sheet(const Structure& structure, const Surface& surface,
                         const Eigen::VectorXd& displacement) {
  const Sheet& sheet = sheet_of(structure);
  const int pieces = (grid_of(sheet, surface).across - 1) / sheet.elements[0];
  return delta_of(sheet, surface, carried_grid(structure, pieces, displacement));
}

std::vector<BentPoint> carried_nodes(const Structure& structure, const Eigen::VectorXd& displacement) {
  return carried_grid(structure, 1, displacement);
}

}  // namespace tremula
