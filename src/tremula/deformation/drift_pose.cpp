#include "tremula/deformation/drift_pose.hpp"

#include "tremula/base/check.hpp"
#include "tremula/numerics/random.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <queue>
#include <span>
#include <utility>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace tremula {
namespace {

using Eigen::Matrix3f;
using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float tau_float = 2 * std::numbers::pi_v<float>;

// ---- Sharing meshes

// To be placed: from begin, within the loop, to end.
struct Piece {
  double begin = 0, end = 0, birth = 0;
  std::uint32_t path = 0;

  bool operator>(const Piece& other) const {
    return begin != other.begin ? begin > other.begin : path > other.path;
  }
};

// A mesh that is free for a while.
struct Opening {
  double from = 0, until = 0;
  std::uint32_t mesh = 0;

  bool operator>(const Opening& other) const {
    return from != other.from ? from > other.from : mesh > other.mesh;
  }
};

template <class T>
using EarliestFirst = std::priority_queue<T, std::vector<T>, std::greater<>>;

class Sharing {
 public:
  Sharing(const DriftPaths& paths, double pause) : paths_(paths), period_(paths.loop.period), pause_(pause) {}

  DriftStays share(const std::vector<std::uint32_t>& members) {
    for (const std::uint32_t member : members) add(member);
    while (!waiting_.empty()) {
      const Piece piece = waiting_.top();
      waiting_.pop();
      place(piece);
    }
    return result();
  }

 private:
  // What is seen for longer than a loop less the pause is cut there; what is seen at the loop's seam takes a
  // mesh of its own, that is free in the middle.
  void add(std::uint32_t member) {
    const DriftPath& path = paths_.paths[member];
    const double longest = period_ - pause_;
    double begin = path.birth, birth = path.birth;
    double left = static_cast<double>(path.air_time) + static_cast<double>(path.lying_time);
    while (left > 0) {
      const double length = std::min(left, longest);
      const Piece piece{begin, begin + length, birth, member};
      if (piece.end > period_) {
        openings_.push({piece.end - period_ + pause_, piece.begin - pause_, new_mesh(piece)});
      } else {
        waiting_.push(piece);
      }
      left -= length, begin += length;
      if (begin >= period_) begin -= period_, birth -= period_;
    }
  }

  void place(const Piece& piece) {
    const double shortest = 2 * pause_;  // less is not worth a cut
    while (!openings_.empty() && openings_.top().from <= piece.begin) {
      Opening opening = openings_.top();
      openings_.pop();
      if (opening.until < std::min(piece.end, piece.begin + shortest)) continue;  // too late, and so forever
      const double end = std::min(piece.end, opening.until);
      stays_[opening.mesh].push_back(stay({piece.begin, end, piece.birth, piece.path}));
      if (end < piece.end) waiting_.push({end, piece.end, piece.birth, piece.path});
      opening.from = end + pause_;
      if (opening.from < opening.until) openings_.push(opening);
      return;
    }
    openings_.push({piece.end + pause_, piece.begin + period_ - pause_, new_mesh(piece)});
  }

  std::uint32_t new_mesh(const Piece& piece) {
    stays_.push_back({stay(piece)});
    return static_cast<std::uint32_t>(stays_.size() - 1);
  }

  static DriftStay stay(const Piece& piece) {
    return {.begin = static_cast<float>(piece.begin),
            .end = static_cast<float>(piece.end),
            .birth = static_cast<float>(piece.birth),
            .path = piece.path};
  }

  DriftStays result() {
    DriftStays all;
    all.pause = pause_;
    all.first.reserve(stays_.size() + 1);
    for (std::vector<DriftStay>& stays : stays_) {
      all.first.push_back(static_cast<std::uint32_t>(all.stays.size()));
      std::ranges::sort(stays, {}, &DriftStay::begin);
      for (std::size_t i = 0; i < stays.size(); ++i) {
        const float before = i > 0 ? stays[i - 1].end : stays.back().end - static_cast<float>(period_);
        stays[i].taken = 0.5F * (before + stays[i].begin);
        all.stays.push_back(stays[i]);
      }
    }
    all.first.push_back(static_cast<std::uint32_t>(all.stays.size()));
    return all;
  }

  const DriftPaths& paths_;
  double period_, pause_;
  EarliestFirst<Piece> waiting_;
  EarliestFirst<Opening> openings_;
  std::vector<std::vector<DriftStay>> stays_;  // by mesh
};

// ---- Meshes, of size 1

void add_normals(DriftMesh& mesh) {
  mesh.normal.assign(mesh.position.size(), Vector3f::Zero());
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    const std::uint32_t a = mesh.triangles[i], b = mesh.triangles[i + 1], c = mesh.triangles[i + 2];
    const Vector3f face = (mesh.position[b] - mesh.position[a]).cross(mesh.position[c] - mesh.position[a]);
    for (const std::uint32_t corner : {a, b, c}) mesh.normal[corner] += face;
  }
  for (Vector3f& normal : mesh.normal) normal.normalize();
}

constexpr std::size_t grain_corners = 6;

// An octahedron of the volume of a ball of diameter 1, that meshes shaded round.
DriftMesh grain() {
  const float radius = 0.5F * std::cbrt(std::numbers::pi_v<float>);
  DriftMesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {-1.0F, 1.0F}) mesh.position.emplace_back(side * radius * Vector3f::Unit(axis));
  }
  mesh.texture.assign(grain_corners, Vector2f::Constant(0.5F));
  mesh.triangles = {1, 3, 5, 3, 0, 5, 0, 2, 5, 2, 1, 5, 3, 1, 4, 0, 3, 4, 2, 0, 4, 1, 2, 4};
  add_normals(mesh);
  return mesh;
}

// As the cards of leaves on trees: folded along a midrib that arches; y along it. Texture across and along.
DriftMesh card(std::array<std::array<float, 3>, leaf_vertices> corners, float widest) {
  DriftMesh mesh;
  for (const auto& [x, y, z] : corners) {
    mesh.position.emplace_back(x, y, z);
    mesh.texture.emplace_back(x / widest + 0.5F, y + 0.5F);
  }
  mesh.triangles = {0, 1, 3, 3, 1, 4, 4, 1, 2, 0, 5, 1, 5, 6, 1, 6, 2, 1};
  add_normals(mesh);
  return mesh;
}

// Base, middle, tip, left edge, right edge; a fallen leaf is dry and bent more than one on its tree.
DriftMesh leaf_card() {
  return card({{{0, -0.5F, 0.1F},
                {0, 0, 0.02F},
                {0, 0.5F, 0.14F},
                {-0.34F, -0.24F, 0.1F},
                {-0.3F, 0.12F, 0.08F},
                {0.34F, -0.24F, 0.1F},
                {0.3F, 0.12F, 0.08F}}},
              0.68F);
}

// A wing with the nut, which it spins about, at its base.
DriftMesh samara_card() {
  return card({{{0.02F, -0.08F, 0},
                {0.03F, 0.4F, 0.02F},
                {-0.03F, 0.92F, 0},
                {-0.07F, 0.1F, 0},
                {-0.2F, 0.6F, 0},
                {0.08F, 0.1F, 0},
                {0.07F, 0.6F, 0}}},
              0.28F);
}

// ---- Turns

float random_of(const DriftPath& path, std::uint32_t number) {
  return static_cast<float>(uniform({path.mark, RandomStream::drift, number, 1}));
}

struct Turned {
  Matrix3f turn = Matrix3f::Identity();
  Vector3f aside = Vector3f::Zero();  // [m]
};

Matrix3f about_z(float angle) { return Eigen::AngleAxisf(angle, Vector3f::UnitZ()).toRotationMatrix(); }

// How much of the flight's turns is left shortly before it comes to rest.
float flying_at(const DriftPath& path, float age) {
  if (!(path.lying_time > 0)) return 1;
  const float left = std::clamp((path.air_time - age) / settling_time, 0.0F, 1.0F);
  return left * left * (3 - 2 * left);
}

// A leaf swings like a pendulum of its own length (Belmonte, Eisenberg & Moses 1998) and glides to the side
// it dips to; one in three tumbles.
DriftTurns turns_of_leaf(const DriftPath& path) {
  const float omega = std::sqrt(9.81F / path.size), swing = 0.5F + 0.5F * random_of(path, 6);
  DriftTurns turns;
  turns.phase = tau_float * random_of(path, 1);
  turns.rate = omega * (0.85F + 0.3F * random_of(path, 2));
  turns.yaw = tau_float * random_of(path, 3);
  turns.yaw_rate = 2 * random_of(path, 4) - 1;
  turns.tumbles = random_of(path, 5) < 0.33F;
  turns.swing = turns.tumbles ? 0 : swing;
  turns.lean = 0.5F * random_of(path, 7) - 0.25F;
  turns.glide = path.fall_speed * (turns.tumbles ? 0.3F : swing) / omega;
  return turns;
}

// Of maples: 130.9 rad/s at a coning angle of 22 degrees (Lee, Lee & Sohn 2014).
DriftTurns turns_of_seed(const DriftPath& path) {
  const float hand = random_of(path, 1) < 0.5F ? -1.0F : 1.0F;
  DriftTurns turns;
  turns.yaw = tau_float * random_of(path, 2);
  turns.yaw_rate = hand * 130.9F * path.fall_speed / 1.2F * std::sqrt(0.035F / path.size);
  turns.lean = 0.384F;
  return turns;
}

Turned turned_at(const DriftTurns& turns, const DriftPath& path, float age) {
  const float flying = flying_at(path, age), phase = turns.phase + turns.rate * age;
  const float tilt = turns.tumbles ? std::remainder(phase, tau_float) : turns.swing * std::sin(phase);
  const float air = std::min(age, path.air_time);
  const Matrix3f heading = about_z(turns.yaw + std::fmod(turns.yaw_rate * air, tau_float));
  Turned turned;
  turned.turn = heading * Eigen::AngleAxisf(flying * tilt, Vector3f::UnitY()).toRotationMatrix() *
                Eigen::AngleAxisf(flying * turns.lean, Vector3f::UnitX());
  turned.aside = flying * heading * Vector3f(-turns.glide * std::cos(phase), 0, 0);
  return turned;
}

// ---- The loop

struct Meshes {
  std::shared_ptr<const DriftPaths> paths;
  DriftStays shared;
  DriftMesh mesh;
  std::vector<Vector3f> home;  // where each is in the surface at rest, in full size
  std::vector<float> size;
};

// Who is on a mesh, and how old.
struct Shown {
  std::uint32_t path = 0;
  float age = 0;
  bool seen = false;
};

// At a time within the loop.
Shown shown_on(const DriftStays& shared, double period, std::size_t mesh, double time) {
  const DriftStay* first = shared.stays.data() + shared.first[mesh];
  const DriftStay* last = shared.stays.data() + shared.first[mesh + 1] - 1;
  const auto now = static_cast<float>(time);
  const DriftStay* stay = last;
  while (stay != first && stay->taken > now) --stay;
  double since = time;
  if (stay->taken > now) {
    stay = last, since += period;  // still that of the loop before
  } else if (stay == last && first->taken + static_cast<float>(period) <= now) {
    stay = first, since -= period;  // already that of the next one
  }
  const auto at = static_cast<float>(since);
  return {.path = stay->path,
          .age = static_cast<float>(since - static_cast<double>(stay->birth)),
          .seen = at >= stay->begin && at < stay->end};
}

void put_round(const Meshes& meshes, std::size_t mesh, const Vector3f& place, float size,
               Vector3f* position) {
  const Vector3f moved = place - meshes.home[mesh];
  const float grown = size - meshes.size[mesh];
  const Vector3f* shape = meshes.mesh.position.data();
  for (std::size_t v = 0; v < grain_corners; ++v) position[v] = moved + grown * shape[v];
}

void put_turned(const Meshes& meshes, std::size_t mesh, const Vector3f& place, const Turned& turned,
                float size, Vector3f* position, Vector3f* normal) {
  const Vector3f moved = place + turned.aside - meshes.home[mesh];
  for (std::size_t v = 0; v < meshes.mesh.position.size(); ++v) {
    position[v] =
        moved + size * (turned.turn * meshes.mesh.position[v]) - meshes.size[mesh] * meshes.mesh.position[v];
    normal[v] = turned.turn * meshes.mesh.normal[v] - meshes.mesh.normal[v];
  }
}

// Paths are far from each other: those of a few meshes are fetched together, then their samples.
void put_meshes(const Meshes& meshes, double now, std::size_t first, std::size_t last, SurfaceDelta& delta) {
  constexpr std::size_t together = 64;
  const DriftPaths& paths = *meshes.paths;
  const std::size_t corners = meshes.mesh.position.size();
  const bool turning = has_turns(paths.form);
  std::array<Shown, together> shown;
  for (std::size_t begin = first; begin < last; begin += together) {
    const std::size_t count = std::min(together, last - begin);
    for (std::size_t i = 0; i < count; ++i) {
      shown[i] = shown_on(meshes.shared, paths.loop.period, begin + i, now);
      const auto* path = reinterpret_cast<const char*>(paths.paths.data() + shown[i].path);
      __builtin_prefetch(path);
      __builtin_prefetch(path + sizeof(DriftPath) - 1);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const auto* samples = samples_at(paths, paths.paths[shown[i].path], shown[i].age);
      __builtin_prefetch(samples);
      __builtin_prefetch(samples + 3);  // four of them may end in the next line
    }
    for (std::size_t i = 0; i < count; ++i) {
      const DriftPath& path = paths.paths[shown[i].path];
      const float size = shown[i].seen ? path.size : 0;
      const Vector3f place = place_at(paths, path, shown[i].age);
      Vector3f* position = delta.position.data() + (begin + i) * corners;
      Vector3f* normal = delta.normal.data() + (begin + i) * corners;
      if (turning) {
        const Turned turned = turned_at(turns_of(paths.form, path), path, shown[i].age);
        put_turned(meshes, begin + i, place, turned, size, position, normal);
      } else {
        put_round(meshes, begin + i, place, size, position);
        std::fill_n(normal, corners, Vector3f::Zero());
      }
    }
  }
}

SurfaceDelta skin_of(const Meshes& meshes, double time) {
  const double now = within_loop(time, meshes.paths->loop.period);
  const std::size_t count = meshes.home.size(), vertices = count * meshes.mesh.position.size();
  SurfaceDelta delta;
  delta.position.resize(vertices);
  delta.normal.resize(vertices);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 4096),
                    [&](const auto& range) { put_meshes(meshes, now, range.begin(), range.end(), delta); });
  return delta;
}

void add_mesh(const DriftMesh& mesh, const Vector3f& home, float size, SurfacePart& part, Surface& surface) {
  const auto first = static_cast<std::uint32_t>(surface.vertex_count());
  for (std::size_t v = 0; v < mesh.position.size(); ++v) {
    surface.position.emplace_back(home + size * mesh.position[v]);
    surface.normal.push_back(mesh.normal[v]);
    surface.texture.push_back(mesh.texture[v]);
    surface.branch.push_back(0);
    surface.along.push_back(0);
  }
  for (const std::uint32_t corner : mesh.triangles) part.triangles.push_back(first + corner);
}

std::vector<std::vector<std::uint32_t>> paths_of_materials(const DriftPaths& paths, std::size_t materials) {
  std::vector<std::vector<std::uint32_t>> members(materials);
  for (std::size_t i = 0; i < paths.paths.size(); ++i)
    members[paths.paths[i].mark % materials].push_back(static_cast<std::uint32_t>(i));
  return members;
}

// Paths with their samples in the order in which meshes show them, so that a frame, which goes from mesh to
// mesh, goes through the memory once; stays name them by their new numbers.
std::shared_ptr<const DriftPaths> in_order_of(DriftStays& shared, const DriftPaths& paths) {
  constexpr std::uint32_t none = ~0U;
  auto ordered = std::make_shared<DriftPaths>();
  ordered->loop = paths.loop;
  ordered->form = paths.form;
  ordered->step = paths.step;
  ordered->ground = paths.ground;
  ordered->paths.reserve(paths.paths.size());
  ordered->off_line.reserve(paths.off_line.size());
  std::vector<std::uint32_t> number(paths.paths.size(), none);
  for (DriftStay& stay : shared.stays) {
    std::uint32_t& at = number[stay.path];
    if (at == none) {
      at = static_cast<std::uint32_t>(ordered->paths.size());
      DriftPath path = paths.paths[stay.path];
      const auto samples = paths.off_line.begin() + static_cast<std::ptrdiff_t>(path.first);
      path.first = ordered->off_line.size();
      ordered->off_line.insert(ordered->off_line.end(), samples, samples + path.count);
      ordered->paths.push_back(path);
    }
    stay.path = at;
  }
  return ordered;
}

void append(const DriftStays& more, DriftStays& to) {
  const auto stays = static_cast<std::uint32_t>(to.stays.size());
  if (!to.first.empty()) to.first.pop_back();
  for (const std::uint32_t first : more.first) to.first.push_back(stays + first);
  to.stays.insert(to.stays.end(), more.stays.begin(), more.stays.end());
}

}  // namespace

DriftStays share_meshes(const DriftPaths& paths, const std::vector<std::uint32_t>& members, double pause) {
  return Sharing(paths, pause).share(members);
}

std::vector<DriftStays> share_meshes(const DriftPaths& paths, std::size_t materials) {
  // Two samples and a little more, so that either half is longer than a shutter that sees one sample.
  const double pause = std::min(2.05 * paths.loop.period / paths.loop.sample_count, 0.25 * paths.loop.period);
  std::vector<DriftStays> shared;
  for (const std::vector<std::uint32_t>& members : paths_of_materials(paths, materials))
    shared.push_back(share_meshes(paths, members, pause));
  return shared;
}

DriftMesh mesh_of(DriftForm form) {
  switch (form) {
    case DriftForm::leaf:
      return leaf_card();
    case DriftForm::seed:
      return samara_card();
    case DriftForm::flake:
    case DriftForm::drop:
      break;
  }
  return grain();
}

bool has_turns(DriftForm form) { return form == DriftForm::leaf || form == DriftForm::seed; }

DriftTurns turns_of(DriftForm form, const DriftPath& path) {
  return form == DriftForm::leaf ? turns_of_leaf(path) : turns_of_seed(path);
}

DriftLook look_of(DriftForm form) {
  switch (form) {
    case DriftForm::flake:
      return {{{.name = "snow", .color = {0.97F, 0.97F, 0.98F}, .two_sided = true}}};
    case DriftForm::drop:
      return {{{.name = "rain", .color = {0.95F, 0.96F, 0.98F}, .roughness = 0.1F, .two_sided = true}}};
    case DriftForm::leaf:
      return {{{.name = "leaf", .color = {0.80F, 0.58F, 0.12F}, .roughness = 0.7F, .two_sided = true},
               {.name = "leaf", .color = {0.73F, 0.33F, 0.10F}, .roughness = 0.7F, .two_sided = true},
               {.name = "leaf", .color = {0.45F, 0.28F, 0.14F}, .roughness = 0.8F, .two_sided = true}}};
    case DriftForm::seed:
      break;
  }
  return {{{.name = "leaf", .color = {0.62F, 0.47F, 0.26F}, .roughness = 0.6F, .two_sided = true}}};
}

Loop make_loop(std::shared_ptr<const DriftPaths> paths, const LoopFacts& facts, const DriftLook& look) {
  if (!paths || paths->paths.empty()) throw InputError("drift", "nothing that drifts", "one flake or more");
  if (look.materials.empty()) throw InputError("look of the drift", "no material", "one or more");
  const double period = paths->loop.period;
  Meshes meshes{.paths = paths, .shared = {}, .mesh = mesh_of(paths->form), .home = {}, .size = {}};
  const std::vector<DriftStays> shared_by_material = share_meshes(*paths, look.materials.size());
  auto surface = std::make_shared<Surface>();
  for (std::size_t i = 0; i < shared_by_material.size(); ++i) {
    const DriftStays& stays = shared_by_material[i];
    SurfacePart part{.material = look.materials[i], .triangles = {}};
    part.pieces = {.first_vertex = static_cast<std::uint32_t>(surface->vertex_count()),
                   .size = static_cast<std::uint32_t>(meshes.mesh.position.size()),
                   .count = static_cast<std::uint32_t>(stays.mesh_count())};
    for (std::size_t m = 0; m < stays.mesh_count(); ++m) {
      const Shown shown = shown_on(stays, period, m, 0);
      const DriftPath& path = paths->paths[shown.path];
      meshes.home.push_back(place_at(*paths, path, shown.age));
      meshes.size.push_back(path.size);
      add_mesh(meshes.mesh, meshes.home.back(), path.size, part, *surface);
    }
    append(stays, meshes.shared);
    surface->parts.push_back(std::move(part));
  }
  Loop loop;
  loop.facts = facts;
  loop.period = period;
  loop.rest = std::move(surface);
  loop.coordinates.resize(paths->loop.sample_count, 0);
  meshes.paths = in_order_of(meshes.shared, *paths);
  const auto shared = std::make_shared<const Meshes>(std::move(meshes));
  loop.skin_at = [shared](double time) { return skin_of(*shared, time); };
  loop.nodes_at = [](double) { return NodePoses(6, 0); };
  return loop;
}

}  // namespace tremula
