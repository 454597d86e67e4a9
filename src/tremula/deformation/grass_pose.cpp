#include "tremula/deformation/grass_pose.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/memory.hpp"
#include "tremula/deformation/principal_shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>
#include <utility>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace tremula {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3f;

constexpr int chain_pieces = 20, lanes = 4;
constexpr int table_in_plane = 17, table_across = 9;

// Four pieces of a blade side by side.
typedef float Lane4 __attribute__((vector_size(16)));

Lane4 lane4(const float* from) {
  Lane4 result;
  std::memcpy(&result, from, sizeof result);
  return result;
}

// ---- Shapes

// From piece directions of the fine chain to those of the drawn one, x, y, z of four lanes.
std::array<float, 12> drawn(const BladeKind& kind, const Eigen::Matrix3Xd& fine) {
  std::array<float, 12> result = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1};
  const std::vector<double> joints = joints_of(kind);
  for (std::size_t piece = 0; piece + 1 < joints.size(); ++piece) {
    const auto first = std::lround(joints[piece] * chain_pieces),
               end = std::lround(joints[piece + 1] * chain_pieces);
    const Vec3 direction = fine.middleCols(first, end - first).rowwise().sum().normalized();
    for (std::size_t axis = 0; axis < 3; ++axis)
      result[lanes * axis + piece] = static_cast<float>(direction[static_cast<Eigen::Index>(axis)]);
  }
  return result;
}

Vector2d angles_at(int column, int row) {
  constexpr double most = 0.9;  // of m; farther out the shape is as there
  Vector2d m(2.0 * column / (table_in_plane - 1) - 1, static_cast<double>(row) / (table_across - 1));
  if (m.norm() > most) m *= most / m.norm();
  return m / (1 - m.norm());
}

void tabulate_half(const BladeKind& kind, const BladeResponse& blade, int number, bool forwards,
                   BendTable& table) {
  RodBender bender(blade.rod, trajectory(kind, number, chain_pieces), 1e-6);
  constexpr int middle = table_in_plane / 2;
  // To and fro, so that every load is near the one before.
  for (int step = 0; step <= middle; ++step) {
    const int column = forwards ? middle + step : middle - step;
    for (int i = 0; i < table_across; ++i) {
      const int row = step % 2 == 0 ? i : table_across - 1 - i;
      const Vector2d angles = angles_at(column, row);
      const double size = angles.norm();
      const Vec3 heading = size > 0 ? Vec3(angles.x() / size, angles.y() / size, 0) : Vec3(Vec3::UnitX());
      const RodDrag drag{size * blade.load.along, size * blade.load.tip, blade.load.decay};
      const Eigen::Matrix3Xd& bent = bender.bend(drag, heading);
      if (forwards || column < middle)
        table.directions[index_of((number * table_across + row) * table_in_plane + column)] =
            drawn(kind, bent);
    }
  }
}

// ---- The skin of a blade, by where its vertices are about the joints.

BladeSkin skin_of_blade(int pieces) {
  static constexpr std::array<float, 5> three = {0.8F, 1, 0.65F, 0, 0}, four = {0.7F, 1, 0.9F, 0.55F, 0};
  const auto& widths = pieces == 3 ? three : four;
  // A blade is hollow: seen from the side that it looks to, its edges look inwards.
  const float tilt = 0.3F, level = std::sqrt(1 - tilt * tilt);
  BladeSkin skin{.vertices = {}, .triangles = {}, .two_sided = true};
  for (int joint = 0; joint < pieces; ++joint) {
    for (const float side : {-1.0F, 1.0F}) {
      skin.vertices.push_back(
          {joint, 0.5F * side * widths[index_of(joint)], 0, -tilt * side, level, 0.5F + 0.5F * side});
    }
  }
  skin.vertices.push_back({pieces, 0, 0, 0, 1, 0.5F});
  for (std::uint32_t joint = 0; joint + 1 < static_cast<std::uint32_t>(pieces); ++joint) {
    const std::uint32_t a = 2 * joint;
    skin.triangles.insert(skin.triangles.end(), {a, a + 1, a + 3, a, a + 3, a + 2});
  }
  const std::uint32_t last = 2 * static_cast<std::uint32_t>(pieces) - 2;
  skin.triangles.insert(skin.triangles.end(), {last, last + 1, last + 2});
  return skin;
}

void add_ring(BladeSkin& skin, int joint, int sides, float radius) {
  for (int side = 0; side < sides; ++side) {
    const float turn = 2 * std::numbers::pi_v<float> * static_cast<float>(side) / static_cast<float>(sides);
    const float c = std::cos(turn), s = std::sin(turn);
    skin.vertices.push_back(
        {joint, radius * c, radius * s, c, s, static_cast<float>(side) / static_cast<float>(sides)});
  }
}

// Quadrilaterals from the ring that begins at `below` to the next one.
void join_rings(BladeSkin& skin, std::uint32_t below, std::uint32_t sides) {
  for (std::uint32_t side = 0; side < sides; ++side) {
    const std::uint32_t a = below + side, b = below + (side + 1) % sides;
    skin.triangles.insert(skin.triangles.end(), {a, a + sides, b, b, a + sides, b + sides});
  }
}

BladeSkin skin_of_stem(int pieces) {
  constexpr std::uint32_t sides = 3;
  BladeSkin skin;
  for (int joint = 0; joint <= pieces; ++joint)
    add_ring(skin, joint, sides, 0.5F * (1 - 0.4F * static_cast<float>(joint) / static_cast<float>(pieces)));
  for (std::uint32_t joint = 0; joint < static_cast<std::uint32_t>(pieces); ++joint)
    join_rings(skin, sides * joint, sides);
  return skin;
}

BladeSkin skin_of_ear(int pieces) {
  constexpr std::uint32_t sides = 5;
  static constexpr std::array<float, 5> radii = {0.3F, 0.5F, 0.47F, 0.33F, 0.04F};
  BladeSkin skin;
  for (int joint = 0; joint <= pieces; ++joint)
    add_ring(skin, joint, sides, joint == pieces ? radii[4] : radii[index_of(joint)]);
  for (std::uint32_t joint = 0; joint < static_cast<std::uint32_t>(pieces); ++joint)
    join_rings(skin, sides * joint, sides);
  for (const std::uint32_t end : {0U, sides * static_cast<std::uint32_t>(pieces)}) {
    for (std::uint32_t side = 1; side + 1 < sides; ++side) {
      const std::uint32_t one = end + side, two = end + side + 1;
      skin.triangles.insert(skin.triangles.end(), {end, end == 0 ? two : one, end == 0 ? one : two});
    }
  }
  return skin;
}

// ---- Posing

// Where in the loop, 0 to 1, so that t + T has the bits of t.
double phase_of(double time, double period) {
  double periods = std::fmod(time / period, 1.0);
  if (periods < 0) periods += 1;
  const double rounded = std::round(periods * 1e9) * 1e-9;
  return std::abs(periods - rounded) < 1e-12 ? std::fmod(rounded, 1.0) : periods;
}

// The field at one time: sample and column from x and y.
struct Lookup {
  float cosine, sine;            // of the heading
  float now, samples_per_metre;  // sample at x = 0
  float samples, per_sample;
  float first_column, columns_per_metre;
  int columns, sample_count;

  Lookup(const GrassInWind& grass, double time) {
    const double heading = grass.heading * std::numbers::pi / 180;
    cosine = static_cast<float>(std::cos(heading));
    sine = static_cast<float>(std::sin(heading));
    sample_count = grass.loop.sample_count;
    samples = static_cast<float>(sample_count);
    per_sample = 1 / samples;
    now = static_cast<float>(phase_of(time, grass.loop.period) * sample_count);
    samples_per_metre =
        grass.speed > 0 ? static_cast<float>(sample_count / (grass.loop.period * grass.speed)) : 0;
    first_column = static_cast<float>(grass.plane.first_column);
    columns_per_metre = static_cast<float>(1 / grass.plane.spacing);
    columns = grass.plane.columns;
  }

  std::array<float, 2> operator()(const std::vector<std::array<float, 2>>& angle, float x, float y) const {
    const float along = cosine * x + sine * y, across = cosine * y - sine * x;
    float sample = now - samples_per_metre * along;
    // Not std::floor, which is a call where the machine is not known to round.
    float periods = static_cast<float>(static_cast<int>(sample * per_sample));
    periods -= periods > sample * per_sample ? 1.0F : 0.0F;
    sample -= samples * periods;
    const float column =
        std::clamp((across - first_column) * columns_per_metre, 0.0F, static_cast<float>(columns - 1));
    const int p = std::clamp(static_cast<int>(sample), 0, sample_count - 1);
    const int c = std::min(static_cast<int>(column), std::max(columns - 2, 0));
    const float t = sample - static_cast<float>(p), w = column - static_cast<float>(c);
    const int next = p + 1 == sample_count ? 0 : p + 1, right = c + 1 < columns ? 1 : 0;
    const auto* before =
        &angle[static_cast<std::size_t>(p) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(c)];
    const auto* after = &angle[static_cast<std::size_t>(next) * static_cast<std::size_t>(columns) +
                               static_cast<std::size_t>(c)];
    std::array<float, 2> value;
    for (std::size_t i = 0; i < 2; ++i) {
      const float low = before[0][i] + w * (before[right][i] - before[0][i]);
      const float high = after[0][i] + w * (after[right][i] - after[0][i]);
      value[i] = low + t * (high - low);
    }
    return value;
  }

  std::array<float, 2> operator()(const std::vector<std::array<float, 2>>& samples_of_blade) const {
    const int p = std::min(static_cast<int>(now), sample_count - 1), next = (p + 1) % sample_count;
    const float t = now - static_cast<float>(p);
    const auto &before = samples_of_blade[index_of(p)], &after = samples_of_blade[index_of(next)];
    return {before[0] + t * (after[0] - before[0]), before[1] + t * (after[1] - before[1])};
  }
};

// Along and across the wind, lean and gusts.
std::array<float, 2> wind_angles(const GrassInWind& grass, const Lookup& lookup, std::size_t i) {
  const Meadow& meadow = grass.meadow;
  const auto& follows =
      grass.follows[std::size_t{meadow.kind[i]} * frequency_classes + meadow.frequency_class[i]];
  std::array<float, 2> gust = grass.way == GrassMotion::in_time
                                  ? lookup(grass.of_blade[i])
                                  : lookup(follows.angle, meadow.x[i], meadow.y[i]);
  const float more = meadow.length[i] * follows.per_length;
  return {more * (follows.lean + gust[0]), more * gust[1]};
}

struct Directions {
  Lane4 x, y, z;
};

Directions rest_directions(const std::array<float, 12>& of) {
  return {lane4(of.data()), lane4(of.data() + 4), lane4(of.data() + 8)};
}

Lane4 reciprocal_root(Lane4 square) {
  Eigen::Array4f root;  // which knows how to take four at a time
  std::memcpy(root.data(), &square, sizeof square);
  root = root.sqrt();
  return 1 / lane4(root.data());
}

// The table at angles in the blade's plane and across.
inline Directions looked_up(const BendTable& table, int trajectory, float in_plane, float across) {
  const float shrink = 1 / (1 + std::sqrt(in_plane * in_plane + across * across));
  const float u = (in_plane * shrink + 1) * (0.5F * (table_in_plane - 1));
  const float v = std::abs(across) * shrink * (table_across - 1);
  const int column = std::min(static_cast<int>(u), table_in_plane - 2),
            row = std::min(static_cast<int>(v), table_across - 2);
  const float s = u - static_cast<float>(column), t = v - static_cast<float>(row);
  const auto* low = &table.directions[index_of((trajectory * table_across + row) * table_in_plane + column)];
  const auto* high = low + table_in_plane;
  const float a = (1 - s) * (1 - t), b = s * (1 - t), c = (1 - s) * t, d = s * t;
  const auto blend = [&](std::size_t axis) {
    return a * lane4(low[0].data() + axis) + b * lane4(low[1].data() + axis) +
           c * lane4(high[0].data() + axis) + d * lane4(high[1].data() + axis);
  };
  Directions found{blend(0), blend(4), blend(8)};
  const Lane4 unit = reciprocal_root(found.x * found.x + found.y * found.y + found.z * found.z + 1e-12F);
  found.x *= unit;
  found.y *= across < 0 ? -unit : unit;
  found.z *= unit;
  return found;
}

// The turn of z to t (unit) that does not twist, on v: v - (v.(z+t))/(1+t_z) (z+t) + 2 v_z t.
void carry(const Vector3f& t, Directions& v) {
  const float by = 1 / std::max(1 + t.z(), 1e-3F);
  const Lane4 share = (v.x * t.x() + v.y * t.y() + v.z * (1 + t.z())) * by, twice = 2 * v.z;
  v.x += (twice - share) * t.x();
  v.y += (twice - share) * t.y();
  v.z += twice * t.z() - share * (1 + t.z());
}

// A posed blade: joints, and at each the axes of its flat side.
struct Posed {
  std::array<Vector3f, lanes + 1> joint, across, out;
  std::array<Vector3f, lanes> piece;
};

struct KindSkin {
  BladeSkin skin;
  std::array<float, lanes> shares;  // lengths of pieces
  int pieces;
};

class Poser {
 public:
  Poser(const GrassInWind& grass, double time) : grass_(grass), lookup_(grass, time) {
    for (const BladeKind& kind : grass.meadow.species.kinds) {
      KindSkin skin{skin_of(kind), {}, kind.pieces};
      const std::vector<double> joints = joints_of(kind);
      for (std::size_t i = 0; i + 1 < joints.size(); ++i)
        skin.shares[i] = static_cast<float>(joints[i + 1] - joints[i]);
      skins_.push_back(std::move(skin));
    }
  }

  // Blades [first, end): the first stands on the ground.
  void pose(std::size_t first, std::size_t end, Vector3f* positions, Vector3f* normals, bool still) const {
    Posed stem, blade;
    const std::vector<BladeKind>& kinds = grass_.meadow.species.kinds;
    for (std::size_t i = first; i < end; ++i) {
      const std::size_t kind = grass_.meadow.kind[i];
      const bool is_stem = kinds[kind].form == BladeForm::stem;
      Posed& posed = is_stem ? stem : blade;
      const bool flat = !normals && kinds[kind].form == BladeForm::blade;
      const KindSkin& skin = skins_[kind];
      if (skin.pieces == 3) {
        flat ? stand<3, true>(i, skin, stem, still, posed) : stand<3, false>(i, skin, stem, still, posed);
      } else {
        flat ? stand<4, true>(i, skin, stem, still, posed) : stand<4, false>(i, skin, stem, still, posed);
      }
      const std::size_t vertex = grass_.first_vertex[i];
      if (flat)
        lay_flat(skin, grass_.meadow.width[i], posed, positions + vertex);
      else
        dress(skin.skin, grass_.meadow.width[i], posed, positions + vertex,
              normals ? normals + vertex : nullptr);
    }
  }

 private:
  // The number of pieces is known when this is compiled; so is whether it matters what is out of the flat
  // side.
  template <int pieces, bool flat>
  void stand(std::size_t i, const KindSkin& skin, const Posed& stem, bool still, Posed& posed) const {
    const Meadow& meadow = grass_.meadow;
    const std::size_t kind = meadow.kind[i];
    const BendTable& table = grass_.bends[kind];
    const float c = grass_.cos_azimuth[i], s = grass_.sin_azimuth[i];
    Directions d;
    if (table.in_plane == 1) {
      d = rest_directions(table.directions[meadow.trajectory[i]]);
    } else if (still) {
      d = looked_up(table, meadow.trajectory[i], 0, 0);
    } else {
      const auto [along, across] = wind_angles(grass_, lookup_, i);
      const float x = lookup_.cosine * along - lookup_.sine * across,
                  y = lookup_.sine * along + lookup_.cosine * across;
      d = looked_up(table, meadow.trajectory[i], c * x + s * y, c * y - s * x);
    }
    const Lane4 x = c * d.x - s * d.y, y = s * d.x + c * d.y;
    d.x = x;
    d.y = y;
    posed.joint[0] = Vector3f(meadow.x[i], meadow.y[i], meadow.z[i]);
    if (meadow.attached[i] >= 0) attach(meadow.attached[i], stem, posed.joint[0], d);
    const float length = meadow.length[i];
    for (int p = 0; p < pieces; ++p) {
      const auto at = index_of(p);
      posed.piece[at] = Vector3f(d.x[p], d.y[p], d.z[p]);
      posed.joint[at + 1] = posed.joint[at] + length * skin.shares[at] * posed.piece[at];
    }
    face<pieces, flat>(i, d, posed);
  }

  void attach(float where, const Posed& stem, Vector3f& foot, Directions& d) const {
    static constexpr std::array<float, 5> joints = {0, 0.3F, 0.55F, 0.8F, 1};
    std::size_t piece = 0;
    while (piece < 3 && where > joints[piece + 1]) ++piece;
    const float share = (where - joints[piece]) / (joints[piece + 1] - joints[piece]);
    foot = stem.joint[piece] + share * (stem.joint[piece + 1] - stem.joint[piece]);
    carry(stem.piece[piece], d);
  }

  // The flat side's axes are level where a blade stands upright and go with it without a twist.
  template <int pieces, bool flat>
  void face(std::size_t i, const Directions& d, Posed& posed) const {
    const float c = grass_.cos_facing[i], s = grass_.sin_facing[i];
    const Lane4 zero = {0, 0, 0, 0}, above = 1 + d.z;
    const Lane4 by = 1 / (above > 1e-3F ? above : zero + 1e-3F);
    // Out of the flat side (c, s, 0) and along it (-s, c, 0): v - (v.t)/(1+t_z) (z+t).
    const Lane4 out_t = c * d.x + s * d.y, out_by = out_t * by, across_t = c * d.y - s * d.x,
                across_by = across_t * by;
    const Lane4 out_x = c - out_by * d.x, out_y = s - out_by * d.y, across_x = -s - across_by * d.x,
                across_y = c - across_by * d.y;
    for (int joint = 0; joint <= pieces; ++joint) {
      const int low = std::max(joint - 1, 0), high = std::min(joint, pieces - 1);
      const auto mean = [&](const Lane4& values) { return 0.5F * (values[low] + values[high]); };
      if constexpr (!flat) posed.out[index_of(joint)] = Vector3f(mean(out_x), mean(out_y), -mean(out_t));
      posed.across[index_of(joint)] = Vector3f(mean(across_x), mean(across_y), -mean(across_t));
    }
  }

  // As dress does for blades without normals, in half the time.
  static void lay_flat(const KindSkin& skin, float width, const Posed& posed, Vector3f* positions) {
    for (int joint = 0; joint < skin.pieces; ++joint) {
      const auto at = index_of(joint);
      const Vector3f side = width * skin.skin.vertices[2 * at + 1].across * posed.across[at];
      positions[2 * at] = posed.joint[at] - side;
      positions[2 * at + 1] = posed.joint[at] + side;
    }
    positions[2 * skin.pieces] = posed.joint[index_of(skin.pieces)];
  }

  static void dress(const BladeSkin& skin, float width, const Posed& posed, Vector3f* positions,
                    Vector3f* normals) {
    for (std::size_t v = 0; v < skin.vertices.size(); ++v) {
      const BladeVertex& vertex = skin.vertices[v];
      const auto joint = index_of(vertex.joint);
      positions[v] =
          posed.joint[joint] + width * (vertex.across * posed.across[joint] + vertex.out * posed.out[joint]);
      if (normals)
        normals[v] =
            (vertex.normal_across * posed.across[joint] + vertex.normal_out * posed.out[joint]).normalized();
    }
  }

  const GrassInWind& grass_;
  Lookup lookup_;
  std::vector<KindSkin> skins_;
};

void pose_all(const GrassInWind& grass, double time, bool still, std::span<Vector3f> positions,
              std::span<Vector3f> normals) {
  check_equal("positions of the grass", static_cast<std::ptrdiff_t>(positions.size()), grass.all_vertices);
  if (!normals.empty())
    check_equal("normals of the grass", static_cast<std::ptrdiff_t>(normals.size()), grass.all_vertices);
  if (!std::isfinite(time)) throw InputError("time of the pose", number_text(time) + " s", "a finite one");
  const Poser poser(grass, time);
  const std::vector<float>& attached = grass.meadow.attached;
  // A plant stays in one piece of work.
  const auto whole = [&](std::size_t i) {
    while (i < attached.size() && attached[i] >= 0) ++i;
    return i;
  };
  constexpr std::size_t grain = 2048;
  tbb::parallel_for(std::size_t{0}, (attached.size() + grain - 1) / grain, [&](std::size_t part) {
    const std::size_t first = whole(part * grain), end = whole(std::min((part + 1) * grain, attached.size()));
    poser.pose(first, end, positions.data(), normals.empty() ? nullptr : normals.data(), still);
  });
}

void check_in_time(const GrassInWind& grass) {
  const double bytes = 8.0 * static_cast<double>(grass.blade_count()) * grass.loop.sample_count;
  if (bytes < 0.8 * static_cast<double>(available_memory())) return;
  throw InputError(
      "blades in time",
      std::to_string(grass.blade_count()) + " for " + std::to_string(grass.loop.sample_count) + " samples",
      "fewer, or blades that look their motion up");
}

std::vector<std::array<float, 2>> at_height(const TravellingField& field, double height) {
  const FieldPlane& plane = field.plane;
  const double heading = field.heading * std::numbers::pi / 180;
  const Vec3 across(-std::sin(heading), std::cos(heading), 0);
  std::vector<std::array<float, 2>> values;
  values.reserve(index_of(plane.columns) * index_of(field.loop.sample_count));
  for (int p = 0; p < field.loop.sample_count; ++p) {
    for (int c = 0; c < plane.columns; ++c) {
      const Vec3 place =
          (plane.first_column + c * plane.spacing) * across + (field.ground + height) * Vec3::UnitZ();
      const Vector3f value = local_value_at(field, place, field.loop.period * p / field.loop.sample_count);
      values.push_back({value.x(), value.y()});
    }
  }
  return values;
}

// One layer, at the height of the tips.
TravellingField layer_at(const TravellingField& gusts, double height) {
  TravellingField layer{.loop = gusts.loop,
                        .heading = gusts.heading,
                        .speed = gusts.speed,
                        .plane = gusts.plane,
                        .ground = gusts.ground,
                        .mean = {mean_at(gusts, gusts.ground + height)},
                        .values = {}};
  layer.plane.heights = {height};
  for (const auto& [along, across] : at_height(gusts, height)) layer.values.push_back({along, across, 0, 0});
  return layer;
}

void follow_in_time(GrassInWind& grass, const std::vector<BladeResponse>& blades,
                    const TravellingField& gusts) {
  check_in_time(grass);
  grass.of_blade.resize(grass.blade_count());
  tbb::parallel_for(std::size_t{0}, grass.blade_count(), [&](std::size_t i) {
    const Meadow& meadow = grass.meadow;
    const std::size_t make = std::size_t{meadow.kind[i]} * frequency_classes + meadow.frequency_class[i];
    if (blades[make].frequency == 0) return;
    const Vec3 place(static_cast<double>(meadow.x[i]), static_cast<double>(meadow.y[i]),
                     gusts.ground + gusts.plane.heights[0]);
    const Eigen::Matrix2Xd sway = sway_in_time(blades[make], gusts, place);
    for (Eigen::Index p = 0; p < sway.cols(); ++p)
      grass.of_blade[i].push_back({static_cast<float>(sway(0, p)), static_cast<float>(sway(1, p))});
  });
}

void lay_out_vertices(GrassInWind& grass) {
  const Meadow& meadow = grass.meadow;
  std::vector<std::uint64_t> blades(meadow.species.kinds.size(), 0), next(meadow.species.kinds.size(), 0);
  for (const std::uint8_t kind : meadow.kind) ++blades[kind];
  std::uint64_t all = 0;
  for (std::size_t k = 0; k < blades.size(); ++k) {
    grass.vertex_count.push_back(
        static_cast<std::uint32_t>(skin_of(meadow.species.kinds[k]).vertices.size()));
    next[k] = all;
    all += blades[k] * grass.vertex_count[k];
  }
  if (all >= (1ULL << 31U)) throw InputError("vertices of the grass", std::to_string(all), "fewer than 2^31");
  grass.all_vertices = static_cast<std::uint32_t>(all);
  for (const std::uint8_t kind : meadow.kind) {
    grass.first_vertex.push_back(static_cast<std::uint32_t>(next[kind]));
    next[kind] += grass.vertex_count[kind];
  }
}

}  // namespace

BladeSkin skin_of(const BladeKind& kind) {
  switch (kind.form) {
    case BladeForm::stem:
      return skin_of_stem(kind.pieces);
    case BladeForm::ear:
      return skin_of_ear(kind.pieces);
    case BladeForm::blade:
      break;
  }
  return skin_of_blade(kind.pieces);
}

BendTable tabulate_bends(const BladeKind& kind, const BladeResponse& blade) {
  BendTable table{.in_plane = table_in_plane, .across = table_across, .directions = {}};
  table.directions.resize(index_of(trajectories_per_kind * table_in_plane * table_across));
  tbb::parallel_for(0, 2 * trajectories_per_kind,
                    [&](int half) { tabulate_half(kind, blade, half / 2, half % 2 == 0, table); });
  return table;
}

BendTable tabulate_rest(const BladeKind& kind) {
  BendTable table;
  for (int number = 0; number < trajectories_per_kind; ++number)
    table.directions.push_back(drawn(kind, trajectory(kind, number, chain_pieces)));
  return table;
}

GrassInWind put_in_wind(Meadow meadow, const TravellingField& gusts, GrassMotion way) {
  check_species(meadow.species);
  check_at_least("blades of the meadow", static_cast<std::ptrdiff_t>(meadow.size()), 1);
  check_plane(gusts.plane, gusts.loop);
  GrassInWind grass;
  grass.meadow = std::move(meadow);
  grass.loop = gusts.loop;
  grass.heading = gusts.heading;
  grass.speed = gusts.speed;
  grass.plane = gusts.plane;
  grass.way = way;
  lay_out_vertices(grass);
  const GrassSpecies& species = grass.meadow.species;
  const double height = grass.meadow.height;
  const TravellingField layer = layer_at(gusts, height);
  const GustStatistics wind = statistics_at(layer, height);
  std::vector<BladeResponse> blades;
  for (std::size_t k = 0; k < species.kinds.size(); ++k) {
    const BladeKind& kind = species.kinds[k];
    for (int number = 0; number < frequency_classes; ++number) {
      blades.emplace_back();
      grass.follows.emplace_back();
      if (kind.frequency == 0) continue;
      BladeResponse& blade = blades.back();
      blade = blade_response(species, static_cast<int>(k), number, height, wind);
      GrassInWind::Follows& follows = grass.follows.back();
      follows.lean = static_cast<float>(blade.lean);
      follows.per_length = static_cast<float>(1 / blade.rod.length);
      if (way == GrassMotion::looked_up)
        follows.angle = at_height(respond(layer, field_response(blade)), height);
    }
    grass.bends.push_back(kind.frequency == 0 ? tabulate_rest(kind)
                                              : tabulate_bends(kind, blades[blades.size() - 2]));
  }
  if (way == GrassMotion::in_time) follow_in_time(grass, blades, layer);
  for (std::size_t i = 0; i < grass.blade_count(); ++i) {
    grass.cos_azimuth.push_back(std::cos(grass.meadow.azimuth[i]));
    grass.sin_azimuth.push_back(std::sin(grass.meadow.azimuth[i]));
    grass.cos_facing.push_back(std::cos(grass.meadow.facing[i]));
    grass.sin_facing.push_back(std::sin(grass.meadow.facing[i]));
  }
  return grass;
}

Eigen::Vector2d angles_of(const GrassInWind& grass, std::size_t blade, double time) {
  const Lookup lookup(grass, time);
  if (grass.bends[grass.meadow.kind[blade]].in_plane == 1) return Vector2d::Zero();
  const auto [along, across] = wind_angles(grass, lookup, blade);
  return Eigen::Vector2f(lookup.cosine * along - lookup.sine * across,
                         lookup.sine * along + lookup.cosine * across)
      .cast<double>();
}

void pose_grass(const GrassInWind& grass, double time, std::span<Vector3f> positions,
                std::span<Vector3f> normals) {
  pose_all(grass, time, false, positions, normals);
}

Surface grass_surface(const GrassInWind& grass) {
  Surface surface;
  const std::size_t vertices = grass.all_vertices;
  surface.position.resize(vertices);
  surface.normal.resize(vertices);
  surface.texture.resize(vertices);
  surface.branch.assign(vertices, 0);
  surface.along.resize(vertices);
  pose_all(grass, 0, true, surface.position, surface.normal);
  const std::vector<BladeKind>& kinds = grass.meadow.species.kinds;
  std::vector<BladeSkin> skins;
  for (const BladeKind& kind : kinds) {
    skins.push_back(skin_of(kind));
    surface.parts.push_back({.material = {.name = kind.material,
                                          .color = kind.color,
                                          .roughness = 0.6F,
                                          .two_sided = skins.back().two_sided},
                             .triangles = {},
                             .pieces = {.first_vertex = 0,
                                        .size = static_cast<std::uint32_t>(skins.back().vertices.size()),
                                        .count = 0}});
  }
  for (std::size_t i = 0; i < grass.blade_count(); ++i) {
    const std::size_t k = grass.meadow.kind[i];
    const BladeSkin& skin = skins[k];
    SurfacePart& part = surface.parts[k];
    const std::uint32_t first = grass.first_vertex[i];
    if (part.pieces.count++ == 0) part.pieces.first_vertex = first;
    const std::vector<double> joints = joints_of(kinds[k]);
    for (std::size_t v = 0; v < skin.vertices.size(); ++v) {
      const auto along = static_cast<float>(joints[index_of(skin.vertices[v].joint)]);
      surface.texture[first + v] = {skin.vertices[v].u, along};
      surface.along[first + v] = along;
      surface.branch[first + v] = static_cast<std::int32_t>(i);
    }
    for (const std::uint32_t corner : skin.triangles) part.triangles.push_back(first + corner);
  }
  std::erase_if(surface.parts, [](const SurfacePart& part) { return part.triangles.empty(); });
  return surface;
}

Loop make_grass_loop(Meadow meadow, const TravellingField& gusts, const LoopFacts& facts, GrassMotion way) {
  const auto grass = std::make_shared<const GrassInWind>(put_in_wind(std::move(meadow), gusts, way));
  const auto rest = std::make_shared<const Surface>(grass_surface(*grass));
  Loop loop;
  loop.facts = facts;
  loop.period = gusts.loop.period;
  loop.rest = rest;
  loop.skin_at = [grass, rest](double time) {
    SurfaceDelta delta;
    delta.position.resize(rest->vertex_count());
    delta.normal.resize(rest->vertex_count());
    pose_grass(*grass, time, delta.position, delta.normal);
    for (std::size_t i = 0; i < delta.position.size(); ++i) {
      delta.position[i] -= rest->position[i];
      delta.normal[i] -= rest->normal[i];
    }
    return delta;
  };
  const int samples = gusts.loop.sample_count;
  loop.coordinates.resize(samples, 0);
  if (rest->vertex_count() > most_morphed_vertices) return loop;
  const double height = grass->meadow.height;
  const auto principal = std::make_shared<const PrincipalShapes>(principal_shapes(
      samples, [&](int sample) { return loop.skin_at(loop.period * sample / samples); }, 0.005 * height));
  loop.kind.assign(principal->shapes.size(), ShapeKind::static_shape);
  loop.kind.front() = ShapeKind::lean;
  loop.frequency = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(principal->shapes.size()));
  loop.coordinates = principal->weights;
  loop.shape_of_skin = [principal](Eigen::Index shape, double weight) {
    SurfaceDelta delta = principal->shapes[index_of(shape)];
    for (Vector3f& position : delta.position) position *= static_cast<float>(weight);
    for (Vector3f& normal : delta.normal) normal *= static_cast<float>(weight);
    return delta;
  };
  return loop;
}

}  // namespace tremula
