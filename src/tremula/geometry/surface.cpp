#include "tremula/geometry/surface.hpp"

#include "tremula/base/error.hpp"
#include "tremula/geometry/axes.hpp"
#include "tremula/geometry/skeleton_checks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <string>
#include <utility>

#include <Eigen/Geometry>

namespace tremula {
namespace {

constexpr double pi = std::numbers::pi;

std::size_t at(int index) { return static_cast<std::size_t>(index); }

// What is known of the tube around every branch before any of it is meshed. (N) each.
struct Tubes {
  std::vector<std::vector<int>> axes;
  std::vector<Vec3> direction;
  std::vector<Vec3> end_tangent;  // of the axis, half-way between the branch and its continuation
  std::vector<double> start_radius;
  std::vector<double> end_radius;
  std::vector<int> sides;
  std::vector<char> is_tip;
};

Vec3 unit_or(const Vec3& v, const Vec3& otherwise) {
  const double length = v.norm();
  return length > 1e-9 ? Vec3(v / length) : otherwise;
}

// The cylinders of scans have one radius each and step at every node. The geometric mean of both sides turns
// stairs into a taper, and a trunk that ends in twigs into a short taper rather than a long cone.
Tubes measure_tubes(const Skeleton& skeleton, const SurfaceOptions& options) {
  const std::size_t count = skeleton.branches.size();
  Tubes tubes{split_into_axes(skeleton), branch_directions(skeleton), {}, {}, {}, {}, {}};
  tubes.end_tangent = tubes.direction;
  tubes.start_radius.resize(count);
  tubes.end_radius.resize(count);
  tubes.sides.resize(count);
  tubes.is_tip.resize(count);
  double thickest = 0;
  for (const Branch& branch : skeleton.branches)
    thickest = std::max({thickest, branch.start_radius, branch.end_radius});
  for (const std::vector<int>& axis : tubes.axes) {
    double radius = 0;
    for (std::size_t i = 0; i < axis.size(); ++i) {
      const std::size_t k = at(axis[i]);
      tubes.end_radius[k] = skeleton.branches[k].end_radius;
      if (i == 0) {
        tubes.start_radius[k] = skeleton.branches[k].start_radius;
      } else {
        const std::size_t below = at(axis[i - 1]);
        const double shared = std::sqrt(tubes.end_radius[below] * skeleton.branches[k].start_radius);
        tubes.end_radius[below] = tubes.start_radius[k] = shared;
        tubes.end_tangent[below] =
            unit_or(tubes.direction[below] + tubes.direction[k], tubes.direction[below]);
      }
      radius = std::max(radius, tubes.start_radius[k]);
    }
    tubes.is_tip[at(axis.back())] = 1;
    const auto sides = static_cast<int>(std::lround(options.max_sides * std::sqrt(radius / thickest)));
    for (const int k : axis) tubes.sides[at(k)] = std::clamp(sides, options.min_sides, options.max_sides);
  }
  return tubes;
}

// The smallest rotation that takes unit vector `from` to `to`, applied to `v` at right angles to `from`; a
// frame carried along an axis this way does not twist.
Vec3 transport(const Vec3& v, const Vec3& from, const Vec3& to) {
  const Vec3 sum = from + to;
  const double scale = 1 + from.dot(to);
  const Vec3 turned = scale > 1e-9 ? Vec3(v - sum * (v.dot(to) / scale)) : v;
  return unit_or(turned - to * turned.dot(to), to.unitOrthogonal());
}

// An axis by the distance along it from its base. A rigid arm between two of its branches adds none.
struct Path {
  std::span<const int> branches;  // (n)
  std::vector<double> distance;   // (n + 1) of base and nodes
  std::vector<double> turns;      // (n + 1) the same in circumferences
  std::vector<Vec3> side;         // (n) with the direction, the frame of each branch
};

// A cross section: centre, frame and size, and what the skin there hangs on.
struct Section {
  int branch;
  double along;
  Vec3 centre, direction, side, across;
  double radius;
  double slope;  // of the radius along the axis
  double turns;
};

Path lay_path(const Skeleton& skeleton, const Tubes& tubes, std::span<const int> axis) {
  Path path{axis, {0.0}, {0.0}, {}};
  for (std::size_t i = 0; i < axis.size(); ++i) {
    const std::size_t k = at(axis[i]);
    const double length = skeleton.branches[k].length();
    path.distance.push_back(path.distance.back() + length);
    path.turns.push_back(path.turns.back() + length / (pi * (tubes.start_radius[k] + tubes.end_radius[k])));
    const Vec3& direction = tubes.direction[k];
    if (i == 0) {
      // One rule for all axes, so that a small change of the tree is a small change of its skin.
      const Vec3 reference = std::abs(direction.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY();
      path.side.push_back((reference - direction * reference.dot(direction)).normalized());
    } else {
      path.side.push_back(transport(path.side.back(), tubes.direction[at(axis[i - 1])], direction));
    }
  }
  return path;
}

Section section_of(const Skeleton& skeleton, const Tubes& tubes, const Path& path, std::size_t i,
                   double along) {
  const int branch = path.branches[i];
  const std::size_t k = at(branch);
  const Branch& b = skeleton.branches[k];
  const double rise = tubes.end_radius[k] - tubes.start_radius[k];
  const double length = path.distance[i + 1] - path.distance[i];
  Section s;
  s.branch = branch;
  s.along = along;
  s.centre = b.start + along * (b.end - b.start);
  s.direction = tubes.direction[k];
  s.side = path.side[i];
  s.across = s.direction.cross(s.side);
  s.radius = tubes.start_radius[k] + along * rise;
  s.slope = length > 0 ? std::clamp(rise / length, -2.0, 2.0) : 0.0;
  s.turns = path.turns[i] + along * (path.turns[i + 1] - path.turns[i]);
  return s;
}

Section section_at(const Skeleton& skeleton, const Tubes& tubes, const Path& path, double distance) {
  const auto above = std::upper_bound(path.distance.begin() + 1, path.distance.end() - 1, distance);
  const auto i = static_cast<std::size_t>(above - path.distance.begin()) - 1;
  const double length = path.distance[i + 1] - path.distance[i];
  const double along = length > 0 ? std::clamp((distance - path.distance[i]) / length, 0.0, 1.0) : 1.0;
  return section_of(skeleton, tubes, path, i, along);
}

Vec3 spoke(const Section& s, double angle) { return std::cos(angle) * s.side + std::sin(angle) * s.across; }

// Rings of one tube, joined as they come.
class TubeWriter {
 public:
  TubeWriter(Surface& surface, int sides) : surface_(surface), sides_(static_cast<std::uint32_t>(sides)) {}

  double angle(std::uint32_t i) const { return 2 * pi * (i % sides_) / sides_; }
  std::uint32_t sides() const { return sides_; }

  // vertex(i) for i = 0 … sides; the last lies on the first and closes the seam of the texture.
  template <typename Vertex>
  void add_ring(const Vertex& vertex) {
    const auto first = static_cast<std::uint32_t>(surface_.position.size());
    for (std::uint32_t i = 0; i <= sides_; ++i) vertex(i);
    if (rings_++ == 0) {
      for (std::uint32_t i = 1; i + 1 < sides_; ++i) add_triangle(first, first + i + 1, first + i);
    } else {
      for (std::uint32_t i = 0; i < sides_; ++i) {
        add_triangle(ring_ + i, ring_ + i + 1, first + i + 1);
        add_triangle(ring_ + i, first + i + 1, first + i);
      }
    }
    ring_ = first;
  }

  void add_vertex(const Vec3& position, const Vec3& normal, double u, double v, int branch, double along) {
    surface_.position.emplace_back(position.cast<float>());
    surface_.normal.emplace_back(normal.cast<float>());
    surface_.texture.emplace_back(static_cast<float>(u), static_cast<float>(v));
    surface_.branch.push_back(branch);
    surface_.along.push_back(static_cast<float>(along));
  }

  // A ring across the axis; `tangent` tilts it half-way between two branches that meet at a bend.
  void add_section(const Section& s, const Vec3& tangent) {
    Section tilted = s;
    tilted.direction = tangent;
    tilted.side = transport(s.side, s.direction, tangent);
    tilted.across = tangent.cross(tilted.side);
    // A mitre is an ellipse: longer in the plane of the bend, so that neither tube is pinched. Sharp bends
    // are.
    const double cosine = s.direction.dot(tangent);
    const Vec3 in_bend = unit_or(s.direction - tangent * cosine, Vec3::Zero());
    const double stretch = std::min(1 / std::max(cosine, 0.1), 1.5) - 1;
    const double tilt = std::hypot(1.0, s.slope);
    add_ring([&](std::uint32_t i) {
      const Vec3 out = spoke(tilted, angle(i));
      const Vec3 offset = s.radius * (out + in_bend * (stretch * out.dot(in_bend)));
      add_vertex(s.centre + offset, (out - s.slope * tangent) / tilt, static_cast<double>(i) / sides_,
                 s.turns, s.branch, s.along);
    });
  }

  void close(const Section& tip) {
    const auto apex = static_cast<std::uint32_t>(surface_.position.size());
    add_vertex(tip.centre, tip.direction, 0.5, tip.turns, tip.branch, tip.along);
    for (std::uint32_t i = 0; i < sides_; ++i) add_triangle(ring_ + i, ring_ + i + 1, apex);
  }

 private:
  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    std::vector<std::uint32_t>& triangles = surface_.parts.front().triangles;
    triangles.insert(triangles.end(), {a, b, c});
  }

  Surface& surface_;
  std::uint32_t sides_;
  std::uint32_t ring_ = 0;  // first vertex of the last ring
  int rings_ = 0;
};

// Where a side axis leaves the tube it springs from: that tube seen as a cylinder, and for every corner of
// the side axis' first ring the distance at which it comes out of it. From there to `end` the skin goes over
// from the one to the other.
struct Collar {
  Vec3 centre, tangent;      // of the tube below
  double flare = 0;          // share by which the first ring is wider
  std::vector<double> root;  // (sides) [m] along the axis
  double end = 0;            // [m] along the axis; 0: there is no collar
};

// Distance along the path at which the line at `angle` and `radius` from it leaves the cylinder, at most
// `limit`.
double exit_distance(const Skeleton& skeleton, const Tubes& tubes, const Path& path, const Collar& collar,
                     double cylinder_radius, double angle, double radius, double limit) {
  const auto across = [&](const Vec3& v) -> Vec3 { return v - collar.tangent * v.dot(collar.tangent); };
  const double wall = cylinder_radius * cylinder_radius;
  for (std::size_t i = 0; i < path.branches.size() && path.distance[i] < limit; ++i) {
    const Section s = section_of(skeleton, tubes, path, i, 0);
    const Vec3 from = across(s.centre + radius * spoke(s, angle) - collar.centre);
    const Vec3 step = across(s.direction);
    const double outside = from.squaredNorm() - wall;
    if (outside >= 0) return path.distance[i];
    const double a = step.squaredNorm();
    const double b = from.dot(step);
    const double length = path.distance[i + 1] - path.distance[i];
    if (a < 1e-12) continue;
    const double exit = (-b + std::sqrt(b * b - a * outside)) / a;
    if (exit < length) return std::min(path.distance[i] + exit, limit);
  }
  return limit;
}

Collar find_collar(const Skeleton& skeleton, const Tubes& tubes, const Path& path) {
  Collar collar;
  const int first = path.branches.front();
  const int below = skeleton.parent(first);
  if (below < 0) return collar;
  const std::size_t p = at(below);
  const Branch& carrier = skeleton.branches[p];
  const Vec3 span = carrier.end - carrier.start;
  const Vec3 start = skeleton.branches[at(first)].start;
  const double where = span.squaredNorm() > 0
                           ? std::clamp((start - carrier.start).dot(span) / span.squaredNorm(), 0.0, 1.0)
                           : 1.0;
  if (tubes.is_tip[p] && where > 0.7) return collar;  // the tube below closes here
  collar.centre = carrier.start + where * span;
  collar.tangent = where > 0.999 ? tubes.end_tangent[p] : tubes.direction[p];

  // The mesh of the tube below lies inside its radius by what its flat sides cut off.
  const double outer = tubes.start_radius[p] + where * (tubes.end_radius[p] - tubes.start_radius[p]);
  const double inner = 0.97 * outer * std::cos(pi / tubes.sides[p]);
  const double radius = tubes.start_radius[at(first)];
  const double total = path.distance.back();
  const double limit = std::min(0.5 * total, 6 * outer);
  collar.flare = std::clamp(0.92 * inner / radius - 1, 0.0, 0.5);
  double farthest = 0;
  const int sides = tubes.sides[at(first)];
  for (int i = 0; i < sides; ++i) {
    collar.root.push_back(exit_distance(skeleton, tubes, path, collar, inner, 2 * pi * i / sides,
                                        radius * (1 + collar.flare), limit));
    farthest = std::max(farthest, collar.root.back());
  }
  if (farthest > 0) collar.end = std::min(farthest + 1.5 * radius, 0.7 * total);
  return collar;
}

// The ring a share t of the way from the collar's root (0: on the tube below, facing as that does) to its
// end.
void add_collar_ring(const Skeleton& skeleton, const Tubes& tubes, const Path& path, const Collar& collar,
                     double t, TubeWriter& writer) {
  const double grown = (1 - t) * (1 - t);
  writer.add_ring([&](std::uint32_t i) {
    const double root = collar.root[i % writer.sides()];
    const Section s = section_at(skeleton, tubes, path, root + t * (collar.end - root));
    const Vec3 out = spoke(s, writer.angle(i));
    const Vec3 position = s.centre + s.radius * (1 + collar.flare * grown) * out;
    const Vec3 own = (out - s.slope * s.direction).normalized();
    const Vec3 away = position - collar.centre;
    const Vec3 below = unit_or(away - collar.tangent * away.dot(collar.tangent), own);
    const Vec3 normal = unit_or((1 - grown) * own + grown * below, own);
    writer.add_vertex(position, normal, static_cast<double>(i) / writer.sides(), s.turns, s.branch, s.along);
  });
}

void mesh_axis(const Skeleton& skeleton, const Tubes& tubes, const Path& path, const SurfaceOptions& options,
               Surface& surface) {
  const int sides = tubes.sides[at(path.branches.front())];
  TubeWriter writer(surface, sides);
  double last = 0;  // distance of the last ring
  const Collar collar = find_collar(skeleton, tubes, path);
  if (collar.end > 0) {
    add_collar_ring(skeleton, tubes, path, collar, 0.0, writer);
    if (sides > 4) add_collar_ring(skeleton, tubes, path, collar, 0.35, writer);
    add_collar_ring(skeleton, tubes, path, collar, 1.0, writer);
    last = collar.end;
  } else {
    const Section base = section_of(skeleton, tubes, path, 0, 0);
    writer.add_section(base, base.direction);
  }

  const auto add = [&](std::size_t i, double along, const Vec3& tangent) {
    const Section s = section_of(skeleton, tubes, path, i, along);
    const double distance = path.distance[i] + along * (path.distance[i + 1] - path.distance[i]);
    if (distance <= last + 0.05 * std::min(s.radius, path.distance.back())) return;
    writer.add_section(s, tangent);
    last = distance;
  };
  const std::size_t count = path.branches.size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t k = at(path.branches[i]);
    const double length = path.distance[i + 1] - path.distance[i];
    const bool is_last = i + 1 == count;
    // The tip is a blunt cone: as long as thick, but at most a quarter of its branch.
    const double end = is_last ? 1 - std::min(tubes.end_radius[k] / std::max(length, 1e-12), 0.25) : 1.0;
    if (length > tubes.start_radius[k] + tubes.end_radius[k]) {
      for (int j = 1; j <= options.bend_subdivisions; ++j) {
        add(i, end * j / (options.bend_subdivisions + 1), tubes.direction[k]);
      }
    }
    add(i, end, is_last ? tubes.direction[k] : tubes.end_tangent[k]);
  }
  writer.close(section_of(skeleton, tubes, path, count - 1, 1));
}

double distance_to_axis(const Vec3& point, const Branch& branch) {
  const Vec3 span = branch.end - branch.start;
  const double length2 = span.squaredNorm();
  const double s = length2 > 0 ? std::clamp((point - branch.start).dot(span) / length2, 0.0, 1.0) : 0.0;
  return (point - branch.start - s * span).norm();
}

// The branches that start on each node, as lists: the first of every node, and the next of every branch.
struct Children {
  std::vector<int> first, next;
};

Children children_by_node(const Skeleton& skeleton) {
  Children children{std::vector<int>(at(skeleton.node_count()), -1),
                    std::vector<int>(skeleton.branches.size(), -1)};
  for (int k = skeleton.branch_count() - 1; k >= 0; --k) {
    int& first = children.first[at(skeleton.branches[at(k)].start_node)];
    children.next[at(k)] = std::exchange(first, k);
  }
  return children;
}

// Whether a branch starts clear of the skin of every branch that meets at its node: only its rigid arm holds
// it. On a hub the first 256 are asked.
bool hangs_on_an_arm(const Skeleton& skeleton, const Children& children, int branch) {
  const Branch& own = skeleton.branches[at(branch)];
  if (own.start == skeleton.node_position(own.start_node)) return false;
  const auto touches = [&](int other) {
    const Branch& b = skeleton.branches[at(other)];
    return distance_to_axis(own.start, b) <= std::max(b.start_radius, b.end_radius) + own.start_radius;
  };
  const int below = skeleton.parent(branch);
  if (below >= 0 && touches(below)) return false;
  int asked = 0;
  for (int k = children.first[at(own.start_node)]; k >= 0 && asked < 256; k = children.next[at(k)], ++asked) {
    if (k != branch && touches(k)) return false;
  }
  return true;
}

// A rigid arm that shows, as a spike from the node to the start it holds: its foot moves with the branch that
// ends at the node, its tip with the one that starts.
void mesh_arm(const Skeleton& skeleton, int branch, int sides, Surface& surface) {
  const Branch& own = skeleton.branches[at(branch)];
  const int below = skeleton.parent(branch);
  Section foot;
  foot.branch = below >= 0 ? below : branch;
  foot.along = below >= 0 ? 1 : 0;
  foot.centre = skeleton.node_position(own.start_node);
  const Vec3 arm = own.start - foot.centre;
  foot.direction = unit_or(arm, Vec3::UnitZ());
  foot.side = foot.direction.unitOrthogonal();
  foot.across = foot.direction.cross(foot.side);
  foot.radius = own.start_radius;
  foot.slope = 0;
  foot.turns = 0;
  TubeWriter writer(surface, sides);
  writer.add_section(foot, foot.direction);
  Section tip = foot;
  tip.branch = branch;
  tip.along = 0;
  tip.centre = own.start;
  tip.turns = arm.norm() / (2 * pi * foot.radius);
  writer.close(tip);
}

// A broad leaf in its own frame (x across in widths, y along in lengths, z up in lengths): folded upwards
// along the midrib, which arches. Base, middle, tip, left edge, right edge.
constexpr std::array<std::array<float, 3>, leaf_vertices> leaf_shape = {{{0, 0, 0},
                                                                         {0, 0.45F, 0.06F},
                                                                         {0, 1, 0},
                                                                         {-0.5F, 0.24F, 0.12F},
                                                                         {-0.43F, 0.58F, 0.12F},
                                                                         {0.5F, 0.24F, 0.12F},
                                                                         {0.43F, 0.58F, 0.12F}}};
constexpr std::array<std::uint32_t, 3 * leaf_triangle_count> leaf_faces = {0, 1, 3, 3, 1, 4, 4, 1, 2,
                                                                           0, 5, 1, 5, 6, 1, 6, 2, 1};

void add_leaf(const Leaf& leaf, Surface& surface) {
  const Vec3 axis = unit_or(leaf.axis, Vec3::UnitX());
  const Vec3 up = unit_or(leaf.normal - axis * leaf.normal.dot(axis), axis.unitOrthogonal());
  const Vec3 across = axis.cross(up);
  const auto first = static_cast<std::uint32_t>(surface.position.size());
  std::array<Vec3, leaf_vertices> corners;
  for (std::size_t i = 0; i < leaf_vertices; ++i) {
    const auto& [x, y, z] = leaf_shape[i];
    corners[i] = leaf.base + (x * leaf.width) * across + (y * leaf.length) * axis + (z * leaf.width) * up;
    surface.position.emplace_back(corners[i].cast<float>());
    surface.texture.emplace_back(x + 0.5F, y);
    surface.branch.push_back(leaf.branch);
    surface.along.push_back(static_cast<float>(leaf.position));
  }
  std::array<Vec3, leaf_vertices> normals;
  normals.fill(Vec3::Zero());
  for (std::size_t f = 0; f < leaf_faces.size(); f += 3) {
    const std::uint32_t a = leaf_faces[f], b = leaf_faces[f + 1], c = leaf_faces[f + 2];
    const Vec3 face = (corners[b] - corners[a]).cross(corners[c] - corners[a]);
    for (const std::uint32_t corner : {a, b, c}) normals[corner] += face;
    for (const std::uint32_t corner : {a, b, c}) surface.parts.back().triangles.push_back(first + corner);
  }
  for (const Vec3& normal : normals) {
    surface.normal.emplace_back(unit_or(normal / (leaf.length * leaf.width), up).cast<float>());
  }
}

// The pieces of ribbon as strips: a piece goes on in the one on the branch that starts where its own ends.
std::vector<std::vector<const Leaf*>> ribbon_strips(const Skeleton& skeleton) {
  std::vector<const Leaf*> on_branch(skeleton.branches.size(), nullptr);
  for (const Leaf& leaf : skeleton.leaves) {
    if (leaf.is_ribbon) on_branch[at(leaf.branch)] = &leaf;
  }
  std::vector<std::vector<const Leaf*>> strips;
  std::vector<int> strip_that_ends_on(skeleton.branches.size(), -1);
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    const Leaf* piece = on_branch[at(k)];
    if (piece == nullptr) continue;
    const int parent = skeleton.parent(k);
    int& strip = strip_that_ends_on[at(k)];
    if (parent >= 0) std::swap(strip, strip_that_ends_on[at(parent)]);
    if (strip < 0) {
      strip = static_cast<int>(strips.size());
      strips.emplace_back();
    }
    strips[at(strip)].push_back(piece);
  }
  return strips;
}

// Three vertices across a strip: the midrib, which lies a little deeper, and both edges.
struct StripSection {
  int branch;
  double along, width;
  Vec3 centre, across, up;
};

std::vector<StripSection> strip_sections(const Skeleton& skeleton, const std::vector<const Leaf*>& strip) {
  std::vector<StripSection> sections;
  for (std::size_t i = 0; i < strip.size(); ++i) {
    const Leaf& piece = *strip[i];
    const Branch& branch = skeleton.branches[at(piece.branch)];
    const auto add = [&](double s, const Vec3& normal, const Vec3& axis) {
      const Vec3 up = unit_or(normal - axis * axis.dot(normal), axis.unitOrthogonal());
      sections.push_back({piece.branch, s, piece.width + s * (piece.end_width - piece.width),
                          branch.start + s * (branch.end - branch.start), axis.cross(up), up});
    };
    const Vec3 axis = unit_or(branch.end - branch.start, Vec3::UnitZ());
    if (i == 0) add(0, piece.normal, axis);
    add(0.5, piece.normal, axis);
    if (i + 1 == strip.size()) {
      add(1, piece.normal, axis);
      continue;
    }
    // Half-way to the next.
    const Branch& next = skeleton.branches[at(strip[i + 1]->branch)];
    add(1, piece.normal + strip[i + 1]->normal, unit_or(axis + unit_or(next.end - next.start, axis), axis));
  }
  return sections;
}

void add_strip(const std::vector<StripSection>& sections, Surface& surface) {
  constexpr float depth = 0.08F;  // of the width
  const auto first = static_cast<std::uint32_t>(surface.position.size());
  const std::size_t count = sections.size();
  std::vector<std::uint32_t>& triangles = surface.parts.back().triangles;
  for (std::size_t i = 0; i < count; ++i) {
    const StripSection& section = sections[i];
    for (int side = -1; side <= 1; ++side) {
      const Vec3 place = section.centre + 0.5 * side * section.width * section.across +
                         (side == 0 ? 0 : depth) * section.width * section.up;
      surface.position.emplace_back(place.cast<float>());
      surface.texture.emplace_back(0.5F + 0.5F * static_cast<float>(side),
                                   static_cast<float>(i) / static_cast<float>(count - 1));
      surface.branch.push_back(section.branch);
      surface.along.push_back(static_cast<float>(section.along));
    }
    if (i == 0) continue;
    const auto low = first + static_cast<std::uint32_t>(3 * i) - 3, high = low + 3;
    for (const std::uint32_t a : {0U, 1U}) {
      for (const std::uint32_t corner : {low + a, low + a + 1, high + a, high + a, low + a + 1, high + a + 1})
        triangles.push_back(corner);
    }
  }
  std::vector<Vec3> normals(3 * count, Vec3::Zero());
  const auto place = [&](std::uint32_t v) { return Vec3(surface.position[v].cast<double>()); };
  for (std::size_t f = triangles.size() - 12 * (count - 1); f < triangles.size(); f += 3) {
    const std::uint32_t a = triangles[f], b = triangles[f + 1], c = triangles[f + 2];
    const Vec3 face = (place(b) - place(a)).cross(place(c) - place(a));
    for (const std::uint32_t corner : {a, b, c}) normals[corner - first] += face;
  }
  for (std::size_t v = 0; v < normals.size(); ++v) {
    const double size = normals[v].norm();
    surface.normal.emplace_back((size > 0 ? Vec3(normals[v] / size) : sections[v / 3].up).cast<float>());
  }
}

void check_options(const SurfaceOptions& options) {
  const auto check = [](const char* name, int value, int low, int high) {
    if (value >= low && value <= high) return;
    throw InputError(std::string("surface options: ") + name, std::to_string(value),
                     "a number from " + std::to_string(low) + " to " + std::to_string(high));
  };
  check("min_sides", options.min_sides, 3, 256);
  check("max_sides", options.max_sides, options.min_sides, 256);
  check("bend_subdivisions", options.bend_subdivisions, 0, 64);
}

}  // namespace

Surface mesh_surface(const Skeleton& skeleton, const SurfaceOptions& options) {
  check_skeleton(skeleton, "skeleton", {.branches_without_length = true, .leaves_of_any_shape = true});
  check_options(options);
  const Tubes tubes = measure_tubes(skeleton, options);
  Surface surface;
  surface.parts.push_back({options.tube, {}});
  const Children children = children_by_node(skeleton);
  for (const std::vector<int>& axis : tubes.axes) {
    mesh_axis(skeleton, tubes, lay_path(skeleton, tubes, axis), options, surface);
    if (hangs_on_an_arm(skeleton, children, axis.front()))
      mesh_arm(skeleton, axis.front(), options.min_sides, surface);
  }
  const auto ribbons = std::ranges::count(skeleton.leaves, true, &Leaf::is_ribbon);
  const auto leaves = std::ssize(skeleton.leaves) - ribbons;
  if (options.leaves && leaves > 0) {
    surface.parts.push_back({options.leaf,
                             {},
                             {.first_vertex = static_cast<std::uint32_t>(surface.vertex_count()),
                              .size = leaf_vertices,
                              .count = static_cast<std::uint32_t>(leaves)}});
    for (const Leaf& leaf : skeleton.leaves) {
      if (!leaf.is_ribbon) add_leaf(leaf, surface);
    }
  }
  if (options.leaves && ribbons > 0) {
    surface.parts.push_back({options.leaf, {}});
    surface.parts.back().material.name = "ribbon";
    for (const std::vector<const Leaf*>& strip : ribbon_strips(skeleton))
      add_strip(strip_sections(skeleton, strip), surface);
  }
  return surface;
}

}  // namespace tremula
