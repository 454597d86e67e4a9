#include "tremula/deformation/posed_blades.hpp"

#include "tremula/base/simd.hpp"
#include "tremula/base/types.hpp"
#include "tremula/wind/profile.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>

namespace tremula {
namespace {

using Eigen::Vector3f;

// Where in the loop, 0 to 1, so that t + T has the bits of t.
double phase_of(double time, double period) {
  double periods = std::fmod(time / period, 1.0);
  if (periods < 0) periods += 1;
  const double rounded = std::round(periods * 1e9) * 1e-9;
  return std::abs(periods - rounded) < 1e-12 ? std::fmod(rounded, 1.0) : periods;
}

// Plain loops over so many blades, of one kind, which compilers turn into vector code.
constexpr std::size_t together = 16;
constexpr std::size_t most_pieces = 4;
struct alignas(64) Row {
  float at[together];
};
struct Rows3 {
  Row x, y, z;
};

// Where a stem went, for what it carries.
struct PosedStem {
  std::array<std::array<float, 3>, most_pieces + 1> joint;
  std::array<std::array<float, 3>, most_pieces> piece;
};

struct Bundle {
  std::size_t count = 0;  // of them, the last one stands in the lanes that are left
  std::array<std::uint32_t, together> blade;
  bool side_by_side = false;  // no others between them in the meadow
  Row in_plane, across;       // driven angles
  Row cos_azimuth, sin_azimuth, cos_facing, sin_facing, length, width;
  std::array<Rows3, most_pieces> piece;                        // directions
  std::array<Rows3, most_pieces + 1> joint, beside, outwards;  // places, and axes of the flat side
};

// Whole plants in their order, their blades by kind.
struct Share {
  std::size_t first = 0;                           // blade
  std::vector<std::vector<std::uint32_t>> blades;  // (kinds)
  std::vector<std::uint32_t> stem_of;              // (blades) the last of `stems` before it, or itself
  std::vector<PosedStem> stems;
};

TREMULA_INLINE void gather(const std::vector<float>& column, const Bundle& bundle, Row& row) {
  if (bundle.side_by_side) {
    std::memcpy(row.at, column.data() + bundle.blade[0], sizeof row.at);
    return;
  }
  for (std::size_t b = 0; b < together; ++b) row.at[b] = column[bundle.blade[b]];
}

// ---- The wind at a blade

// A corner of the field, and how far on the next sample and column are.
struct alignas(64) Corners {
  float later[together], aside[together];
  std::int32_t before[together], after[together];
};

TREMULA_INLINE void find_corners(const FieldNow& field, const Row& x, const Row& y, Corners& corners) {
  const auto samples = static_cast<float>(field.sample_count);
  const float per_sample = 1 / samples, last_column = static_cast<float>(field.columns - 1);
  const int last_sample = field.sample_count - 1, last_pair = std::max(field.columns - 2, 0);
  for (std::size_t b = 0; b < together; ++b) {
    const float along = field.cosine * x.at[b] + field.sine * y.at[b],
                across = field.cosine * y.at[b] - field.sine * x.at[b];
    float sample = field.now - field.samples_per_metre * along;
    // Not std::floor, which is a call where the machine is not known to round.
    float periods = static_cast<float>(static_cast<int>(sample * per_sample));
    periods -= periods > sample * per_sample ? 1.0F : 0.0F;
    sample -= samples * periods;
    float column = (across - field.first_column) * field.columns_per_metre;
    column = column > 0 ? column : 0.0F;
    column = column < last_column ? column : last_column;
    int p = static_cast<int>(sample);
    p = p > 0 ? p : 0;
    p = p < last_sample ? p : last_sample;
    int c = static_cast<int>(column);
    c = c < last_pair ? c : last_pair;
    const int next = p == last_sample ? 0 : p + 1;
    corners.later[b] = sample - static_cast<float>(p);
    corners.aside[b] = column - static_cast<float>(c);
    corners.before[b] = p * field.columns + c;
    corners.after[b] = next * field.columns + c;
  }
}

// Along and across the wind, what gusts add.
struct GustRows {
  Row along, across;
};

const GrassInWind::Follows& follows_of(const GrassInWind& grass, std::size_t blade) {
  const Meadow& meadow = grass.meadow;
  return grass.follows[std::size_t{meadow.kind[blade]} * frequency_classes + meadow.frequency_class[blade]];
}

TREMULA_INLINE void look_up_gusts(const GrassInWind& grass, const FieldNow& field, const Bundle& bundle,
                                  GustRows& gusts) {
  Row x, y;
  gather(grass.meadow.x, bundle, x);
  gather(grass.meadow.y, bundle, y);
  Corners corners;
  find_corners(field, x, y, corners);
  // Along and across at the four corners.
  std::array<std::array<Row, 2>, 4> value;
  const std::size_t right = field.columns > 1 ? 1 : 0;
  for (std::size_t b = 0; b < together; ++b) {
    const auto* angle = follows_of(grass, bundle.blade[b]).angle.data();
    const auto *before = angle + corners.before[b], *after = angle + corners.after[b];
    for (std::size_t i = 0; i < 2; ++i) {
      value[0][i].at[b] = before[0][i];
      value[1][i].at[b] = before[right][i];
      value[2][i].at[b] = after[0][i];
      value[3][i].at[b] = after[right][i];
    }
  }
  for (const auto& [i, gust] : {std::pair{0UL, &gusts.along}, std::pair{1UL, &gusts.across}}) {
    for (std::size_t b = 0; b < together; ++b) {
      const float low = value[0][i].at[b] + corners.aside[b] * (value[1][i].at[b] - value[0][i].at[b]);
      const float high = value[2][i].at[b] + corners.aside[b] * (value[3][i].at[b] - value[2][i].at[b]);
      gust->at[b] = low + corners.later[b] * (high - low);
    }
  }
}

void gusts_in_time(const GrassInWind& grass, const FieldNow& field, const Bundle& bundle, GustRows& gusts) {
  const int p = std::min(static_cast<int>(field.now), field.sample_count - 1),
            next = (p + 1) % field.sample_count;
  const float later = field.now - static_cast<float>(p);
  for (std::size_t b = 0; b < together; ++b) {
    const auto& samples = grass.of_blade[bundle.blade[b]];
    const auto &before = samples[index_of(p)], &after = samples[index_of(next)];
    gusts.along.at[b] = before[0] + later * (after[0] - before[0]);
    gusts.across.at[b] = before[1] + later * (after[1] - before[1]);
  }
}

// Angles along x and y, lean and gusts.
TREMULA_INLINE void drive(const GrassInWind& grass, const FieldNow& field, const Bundle& bundle, Row& x,
                          Row& y) {
  GustRows gusts;
  if (grass.way == GrassMotion::in_time)
    gusts_in_time(grass, field, bundle, gusts);
  else
    look_up_gusts(grass, field, bundle, gusts);
  Row more, lean;
  for (std::size_t b = 0; b < together; ++b) {
    const GrassInWind::Follows& follows = follows_of(grass, bundle.blade[b]);
    more.at[b] = grass.meadow.length[bundle.blade[b]] * follows.per_length;
    lean.at[b] = follows.lean;
  }
  for (std::size_t b = 0; b < together; ++b) {
    const float along = more.at[b] * (lean.at[b] + gusts.along.at[b]),
                across = more.at[b] * gusts.across.at[b];
    x.at[b] = field.cosine * along - field.sine * across;
    y.at[b] = field.sine * along + field.cosine * across;
  }
}

// ---- How it stands

// Four pieces of a blade side by side.
typedef float Lane4 __attribute__((vector_size(16)));

TREMULA_INLINE Lane4 lane4(const float* from) {
  Lane4 result;
  std::memcpy(&result, from, sizeof result);
  return result;
}

TREMULA_INLINE void set_pieces(const Lane4 (&of)[3], std::size_t b, Bundle& bundle) {
  for (std::size_t p = 0; p < most_pieces; ++p) {
    bundle.piece[p].x.at[b] = of[0][p];
    bundle.piece[p].y.at[b] = of[1][p];
    bundle.piece[p].z.at[b] = of[2][p];
  }
}

TREMULA_INLINE void stand_stiff(const GrassInWind& grass, const BendTable& table, Bundle& bundle) {
  for (std::size_t b = 0; b < together; ++b) {
    const float* of = table.directions[grass.meadow.trajectory[bundle.blade[b]]].data();
    set_pieces({lane4(of), lane4(of + 4), lane4(of + 8)}, b, bundle);
  }
}

// The table at angles in the blade's plane and across.
TREMULA_INLINE void look_up_bends(const GrassInWind& grass, const BendTable& table, Bundle& bundle) {
  struct alignas(64) {
    float s[together], t[together];
    std::int32_t entry[together];
  } place;
  for (std::size_t b = 0; b < together; ++b)
    place.entry[b] = grass.meadow.trajectory[bundle.blade[b]] * (bends_across * bends_in_plane);
  for (std::size_t b = 0; b < together; ++b) {
    const float in_plane = bundle.in_plane.at[b], across = bundle.across.at[b];
    const float shrink = 1 / (1 + std::sqrt(in_plane * in_plane + across * across));
    const float u = (in_plane * shrink + 1) * (0.5F * (bends_in_plane - 1));
    const float v = std::abs(across) * shrink * (bends_across - 1);
    int column = static_cast<int>(u), row = static_cast<int>(v);
    column = column < bends_in_plane - 2 ? column : bends_in_plane - 2;
    row = row < bends_across - 2 ? row : bends_across - 2;
    place.s[b] = u - static_cast<float>(column);
    place.t[b] = v - static_cast<float>(row);
    place.entry[b] += row * bends_in_plane + column;
  }
  for (std::size_t b = 0; b < together; ++b) {
    const float s = place.s[b], t = place.t[b];
    const float *low = table.directions[static_cast<std::size_t>(place.entry[b])].data(),
                *high = low + 12 * bends_in_plane;
    Lane4 found[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float *before = low + 4 * axis, *after = high + 4 * axis;
      found[axis] = (1 - s) * (1 - t) * lane4(before) + s * (1 - t) * lane4(before + 12) +
                    (1 - s) * t * lane4(after) + s * t * lane4(after + 12);
    }
    set_pieces(found, b, bundle);
  }
  for (Rows3& piece : bundle.piece) {
    for (std::size_t b = 0; b < together; ++b) {
      const float x = piece.x.at[b], y = piece.y.at[b], z = piece.z.at[b];
      const float unit = 1 / std::sqrt(x * x + y * y + z * z + 1e-12F);
      piece.x.at[b] = x * unit;
      piece.y.at[b] = y * (bundle.across.at[b] < 0 ? -unit : unit);
      piece.z.at[b] = z * unit;
    }
  }
}

// From the frame of its azimuth to that of the meadow.
TREMULA_INLINE void turn_to_azimuth(Bundle& bundle) {
  for (Rows3& piece : bundle.piece) {
    for (std::size_t b = 0; b < together; ++b) {
      const float c = bundle.cos_azimuth.at[b], s = bundle.sin_azimuth.at[b];
      const float x = c * piece.x.at[b] - s * piece.y.at[b], y = s * piece.x.at[b] + c * piece.y.at[b];
      piece.x.at[b] = x;
      piece.y.at[b] = y;
    }
  }
}

// Feet go along with the stem, and directions by the turn of z to that of the stem's piece (t, unit) that
// does not twist: v - (v.(z+t))/(1+t_z) (z+t) + 2 v_z t.
TREMULA_INLINE void stand_on_stems(const GrassInWind& grass, const Share& plants, Bundle& bundle) {
  static constexpr std::array<float, most_pieces + 1> joints = {0, 0.3F, 0.55F, 0.8F, 1};
  Rows3& foot = bundle.joint[0];
  Rows3 to;
  for (std::size_t b = 0; b < together; ++b) {
    const std::uint32_t blade = bundle.blade[b];
    const float where = grass.meadow.attached[blade];
    if (where < 0) {
      to.x.at[b] = to.y.at[b] = 0, to.z.at[b] = 1;
      continue;
    }
    const PosedStem& stem = plants.stems[plants.stem_of[blade - plants.first]];
    std::size_t piece = 0;
    while (piece < most_pieces - 1 && where > joints[piece + 1]) ++piece;
    const float share = (where - joints[piece]) / (joints[piece + 1] - joints[piece]);
    const auto &low = stem.joint[piece], &high = stem.joint[piece + 1];
    foot.x.at[b] = low[0] + share * (high[0] - low[0]);
    foot.y.at[b] = low[1] + share * (high[1] - low[1]);
    foot.z.at[b] = low[2] + share * (high[2] - low[2]);
    to.x.at[b] = stem.piece[piece][0], to.y.at[b] = stem.piece[piece][1], to.z.at[b] = stem.piece[piece][2];
  }
  for (Rows3& piece : bundle.piece) {
    for (std::size_t b = 0; b < together; ++b) {
      const float tx = to.x.at[b], ty = to.y.at[b], up = 1 + to.z.at[b];
      const float x = piece.x.at[b], y = piece.y.at[b], z = piece.z.at[b];
      const float share = (x * tx + y * ty + z * up) / (up > 1e-3F ? up : 1e-3F), twice = 2 * z;
      piece.x.at[b] = x + (twice - share) * tx;
      piece.y.at[b] = y + (twice - share) * ty;
      piece.z.at[b] = z + twice * to.z.at[b] - share * up;
    }
  }
}

TREMULA_INLINE void lay_pieces(const PoseOfGrass::KindSkin& skin, Bundle& bundle) {
  Rows3 at = bundle.joint[0];
  for (std::size_t p = 0; p < index_of(skin.pieces); ++p) {
    const float share = skin.shares[p];
    const Rows3& piece = bundle.piece[p];
    for (std::size_t b = 0; b < together; ++b) {
      const float length = bundle.length.at[b] * share;
      at.x.at[b] += length * piece.x.at[b];
      at.y.at[b] += length * piece.y.at[b];
      at.z.at[b] += length * piece.z.at[b];
    }
    bundle.joint[p + 1] = at;
  }
}

// The flat side's axes are level where a blade stands upright and go with it without a twist: out of the flat
// side (c, s, 0) and along it (-s, c, 0), v - (v.t)/(1+t_z) (z+t); at joints the means of the pieces'.
TREMULA_INLINE void carry_along(const std::array<Rows3, most_pieces>& pieces, std::size_t count,
                                const Row& level_x, const Row& level_y,
                                std::array<Rows3, most_pieces + 1>& axes) {
  Rows3 before;
  for (std::size_t p = 0; p < count; ++p) {
    const Rows3& t = pieces[p];
    Rows3 axis;
    for (std::size_t b = 0; b < together; ++b) {
      const float above = 1 + t.z.at[b], dot = level_x.at[b] * t.x.at[b] + level_y.at[b] * t.y.at[b];
      const float by = dot / (above > 1e-3F ? above : 1e-3F);
      axis.x.at[b] = level_x.at[b] - by * t.x.at[b];
      axis.y.at[b] = level_y.at[b] - by * t.y.at[b];
      axis.z.at[b] = -dot;
    }
    if (p == 0) before = axis;
    Rows3& mean = axes[p];
    for (std::size_t b = 0; b < together; ++b) {
      mean.x.at[b] = 0.5F * (before.x.at[b] + axis.x.at[b]);
      mean.y.at[b] = 0.5F * (before.y.at[b] + axis.y.at[b]);
      mean.z.at[b] = 0.5F * (before.z.at[b] + axis.z.at[b]);
    }
    before = axis;
  }
  axes[count] = before;
}

// ---- What is drawn

// Coordinates of the vertices of a bundle, those of a vertex after each other.
constexpr std::size_t most_vertices = 32;
using Coordinates = std::array<Rows3, most_vertices>;

TREMULA_INLINE void weigh(const Rows3& beside, float across, const Rows3& outwards, float out, Rows3& sum) {
  for (std::size_t b = 0; b < together; ++b) {
    sum.x.at[b] = across * beside.x.at[b] + out * outwards.x.at[b];
    sum.y.at[b] = across * beside.y.at[b] + out * outwards.y.at[b];
    sum.z.at[b] = across * beside.z.at[b] + out * outwards.z.at[b];
  }
}

TREMULA_INLINE void place_vertices(const BladeSkin& skin, const Bundle& bundle, Coordinates& place) {
  for (std::size_t v = 0; v < skin.vertices.size(); ++v) {
    const BladeVertex& vertex = skin.vertices[v];
    const auto joint = index_of(vertex.joint);
    Rows3& to = place[v];
    const Rows3 &at = bundle.joint[joint], &beside = bundle.beside[joint];
    if (vertex.out == 0) {
      for (std::size_t b = 0; b < together; ++b) {
        const float across = bundle.width.at[b] * vertex.across;
        to.x.at[b] = at.x.at[b] + across * beside.x.at[b];
        to.y.at[b] = at.y.at[b] + across * beside.y.at[b];
        to.z.at[b] = at.z.at[b] + across * beside.z.at[b];
      }
      continue;
    }
    weigh(beside, vertex.across, bundle.outwards[joint], vertex.out, to);
    for (std::size_t b = 0; b < together; ++b) {
      to.x.at[b] = at.x.at[b] + bundle.width.at[b] * to.x.at[b];
      to.y.at[b] = at.y.at[b] + bundle.width.at[b] * to.y.at[b];
      to.z.at[b] = at.z.at[b] + bundle.width.at[b] * to.z.at[b];
    }
  }
}

TREMULA_INLINE void turn_normals(const BladeSkin& skin, const Bundle& bundle, Coordinates& normal) {
  for (std::size_t v = 0; v < skin.vertices.size(); ++v) {
    const BladeVertex& vertex = skin.vertices[v];
    const auto joint = index_of(vertex.joint);
    Rows3& to = normal[v];
    weigh(bundle.beside[joint], vertex.normal_across, bundle.outwards[joint], vertex.normal_out, to);
    for (std::size_t b = 0; b < together; ++b) {
      const float x = to.x.at[b], y = to.y.at[b], z = to.z.at[b];
      const float unit = 1 / std::sqrt(x * x + y * y + z * z + 1e-30F);
      to.x.at[b] = x * unit;
      to.y.at[b] = y * unit;
      to.z.at[b] = z * unit;
    }
  }
}

// Four coordinates of four blades, to where each of these blades has its own.
TREMULA_INLINE void put_four(const float* rows, float* const* to) {
  const Lane4 a = lane4(rows), b = lane4(rows + together), c = lane4(rows + 2 * together),
              d = lane4(rows + 3 * together);
  const Lane4 ab_low = __builtin_shufflevector(a, b, 0, 4, 1, 5),
              ab_high = __builtin_shufflevector(a, b, 2, 6, 3, 7),
              cd_low = __builtin_shufflevector(c, d, 0, 4, 1, 5),
              cd_high = __builtin_shufflevector(c, d, 2, 6, 3, 7);
  const Lane4 of[4] = {__builtin_shufflevector(ab_low, cd_low, 0, 1, 4, 5),
                       __builtin_shufflevector(ab_low, cd_low, 2, 3, 6, 7),
                       __builtin_shufflevector(ab_high, cd_high, 0, 1, 4, 5),
                       __builtin_shufflevector(ab_high, cd_high, 2, 3, 6, 7)};
  for (std::size_t i = 0; i < 4; ++i) std::memcpy(to[i], &of[i], sizeof of[i]);
}

TREMULA_INLINE void put_vertices(const GrassInWind& grass, const Bundle& bundle, const Coordinates& of,
                                 std::size_t vertices, Vector3f* to) {
  const float* rows = of[0].x.at;
  const std::size_t floats = 3 * vertices;  // of a blade: no fewer than four
  std::array<float*, together> start;
  for (std::size_t b = 0; b < together; ++b) start[b] = to[grass.first_vertex[bundle.blade[b]]].data();
  if (bundle.count < together) {
    for (std::size_t b = 0; b < bundle.count; ++b) {
      for (std::size_t i = 0; i < floats; ++i) start[b][i] = rows[i * together + b];
    }
    return;
  }
  for (std::size_t b = 0; b < together; b += 4) {
    for (std::size_t next = 0; next < floats; next += 4) {
      const std::size_t i = std::min(next, floats - 4);
      float* const four[4] = {start[b] + i, start[b + 1] + i, start[b + 2] + i, start[b + 3] + i};
      put_four(rows + i * together + b, four);
    }
  }
}

FieldNow field_at(const GrassInWind& grass, double time) {
  const Vec3 along = heading_direction(grass.heading);
  FieldNow field;
  field.cosine = static_cast<float>(along.x());
  field.sine = static_cast<float>(along.y());
  field.sample_count = grass.loop.sample_count;
  field.columns = grass.plane.columns;
  field.now = static_cast<float>(phase_of(time, grass.loop.period) * grass.loop.sample_count);
  if (grass.speed > 0)
    field.samples_per_metre = static_cast<float>(grass.loop.sample_count / (grass.loop.period * grass.speed));
  field.first_column = static_cast<float>(grass.plane.first_column);
  field.columns_per_metre = static_cast<float>(1 / grass.plane.spacing);
  return field;
}

// ---- Bundles

// Up to `together` blades of a kind.
Bundle bundle_of(std::span<const std::uint32_t> blades) {
  Bundle bundle;
  bundle.count = std::min(blades.size(), together);
  for (std::size_t b = 0; b < together; ++b) bundle.blade[b] = blades[std::min(b, bundle.count - 1)];
  bundle.side_by_side = bundle.blade.back() - bundle.blade.front() == together - 1;
  return bundle;
}

bool hangs(const Meadow& meadow, const Bundle& bundle) {
  return std::ranges::any_of(bundle.blade, [&](std::uint32_t blade) { return meadow.attached[blade] >= 0; });
}

void keep_stems(const Bundle& bundle, Share& share) {
  const auto at = [](const Rows3& rows, std::size_t b) {
    return std::array{rows.x.at[b], rows.y.at[b], rows.z.at[b]};
  };
  for (std::size_t b = 0; b < bundle.count; ++b) {
    PosedStem& stem = share.stems[share.stem_of[bundle.blade[b] - share.first]];
    for (std::size_t i = 0; i < stem.joint.size(); ++i) stem.joint[i] = at(bundle.joint[i], b);
    for (std::size_t i = 0; i < stem.piece.size(); ++i) stem.piece[i] = at(bundle.piece[i], b);
  }
}

TREMULA_CLONES void pose_bundle(const PoseOfGrass& pose, std::size_t kind, const Share& share, Bundle& bundle,
                                Vector3f* positions, Vector3f* normals) {
  const GrassInWind& grass = pose.grass;
  const Meadow& meadow = grass.meadow;
  const PoseOfGrass::KindSkin& skin = pose.skins[kind];
  const BendTable& table = grass.bends[kind];
  gather(grass.cos_azimuth, bundle, bundle.cos_azimuth);
  gather(grass.sin_azimuth, bundle, bundle.sin_azimuth);
  gather(grass.cos_facing, bundle, bundle.cos_facing);
  gather(grass.sin_facing, bundle, bundle.sin_facing);
  gather(meadow.length, bundle, bundle.length);
  gather(meadow.width, bundle, bundle.width);
  gather(meadow.x, bundle, bundle.joint[0].x);
  gather(meadow.y, bundle, bundle.joint[0].y);
  gather(meadow.z, bundle, bundle.joint[0].z);
  if (table.in_plane == 1) {
    stand_stiff(grass, table, bundle);
  } else {
    Row x{}, y{};
    if (!pose.still) drive(grass, pose.field, bundle, x, y);
    for (std::size_t b = 0; b < together; ++b) {
      const float c = bundle.cos_azimuth.at[b], s = bundle.sin_azimuth.at[b];
      bundle.in_plane.at[b] = c * x.at[b] + s * y.at[b];
      bundle.across.at[b] = c * y.at[b] - s * x.at[b];
    }
    look_up_bends(grass, table, bundle);
  }
  turn_to_azimuth(bundle);
  if (hangs(meadow, bundle)) stand_on_stems(grass, share, bundle);
  const auto pieces = index_of(skin.pieces);
  lay_pieces(skin, bundle);
  Row minus_sine;
  for (std::size_t b = 0; b < together; ++b) minus_sine.at[b] = -bundle.sin_facing.at[b];
  carry_along(bundle.piece, pieces, minus_sine, bundle.cos_facing, bundle.beside);
  if (normals || !skin.flat)
    carry_along(bundle.piece, pieces, bundle.cos_facing, bundle.sin_facing, bundle.outwards);
  Coordinates of;
  place_vertices(skin.skin, bundle, of);
  put_vertices(grass, bundle, of, skin.skin.vertices.size(), positions);
  if (!normals) return;
  turn_normals(skin.skin, bundle, of);
  put_vertices(grass, bundle, of, skin.skin.vertices.size(), normals);
}

}  // namespace

PoseOfGrass pose_of(const GrassInWind& grass, double time, bool still) {
  PoseOfGrass pose{grass, field_at(grass, time), {}, still};
  for (const BladeKind& kind : grass.meadow.species.kinds) {
    PoseOfGrass::KindSkin skin{skin_of(kind), false, {}, kind.pieces};
    skin.flat = std::ranges::all_of(skin.skin.vertices, [](const BladeVertex& v) { return v.out == 0; });
    const std::vector<double> joints = joints_of(kind);
    for (std::size_t i = 0; i + 1 < joints.size(); ++i)
      skin.shares[i] = static_cast<float>(joints[i + 1] - joints[i]);
    pose.skins.push_back(std::move(skin));
  }
  return pose;
}

Eigen::Vector2f driven_angles(const PoseOfGrass& pose, std::size_t blade) {
  const auto one = static_cast<std::uint32_t>(blade);
  const Bundle bundle = bundle_of({&one, 1});
  Row x, y;
  drive(pose.grass, pose.field, bundle, x, y);
  return {x.at[0], y.at[0]};
}

void pose_plants(const PoseOfGrass& pose, std::size_t first, std::size_t end, Vector3f* positions,
                 Vector3f* normals) {
  const Meadow& meadow = pose.grass.meadow;
  const std::vector<BladeKind>& kinds = meadow.species.kinds;
  Share share{.first = first, .blades = {}, .stem_of = {}, .stems = {}};
  share.blades.resize(kinds.size());
  share.stem_of.reserve(end - first);
  std::uint32_t stems = 0;
  for (std::size_t i = first; i < end; ++i) {
    const std::size_t kind = meadow.kind[i];
    share.blades[kind].push_back(static_cast<std::uint32_t>(i));
    if (kinds[kind].form == BladeForm::stem) ++stems;
    share.stem_of.push_back(stems > 0 ? stems - 1 : 0);
  }
  share.stems.resize(std::max(stems, 1U));
  const auto pose_kind = [&](std::size_t kind) {
    const std::span<const std::uint32_t> blades = share.blades[kind];
    for (std::size_t i = 0; i < blades.size(); i += together) {
      Bundle bundle = bundle_of(blades.subspan(i));
      pose_bundle(pose, kind, share, bundle, positions, normals);
      if (kinds[kind].form == BladeForm::stem) keep_stems(bundle, share);
    }
  };
  const auto is_stem = [&](std::size_t kind) { return kinds[kind].form == BladeForm::stem; };
  for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
    if (is_stem(kind)) pose_kind(kind);
  }
  for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
    if (!is_stem(kind)) pose_kind(kind);
  }
}

}  // namespace tremula
