#include "tremula/geometry/strands.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/numerics/random.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

namespace tremula {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float pi = std::numbers::pi_v<float>;
constexpr float seen_of_flat = 2 / pi;  // the mean of |cos|

// The numbers of one plant, in order.
class Draw {
 public:
  Draw(std::uint64_t seed, std::uint32_t bin, std::uint64_t plant) : seed_(seed), bin_(bin), plant_(plant) {}
  float unit() {
    return static_cast<float>(uniform(
        {.seed = seed_, .stream = RandomStream::strands, .bin = bin_, .place = plant_ << 16 | next_++}));
  }
  float between(float low, float high) { return low + (high - low) * unit(); }

 private:
  std::uint64_t seed_;
  std::uint32_t bin_;
  std::uint64_t plant_, next_ = 0;
};

Vector3f direction_of(float from_vertical, float azimuth) {
  const float across = std::sin(from_vertical);
  return {across * std::cos(azimuth), across * std::sin(azimuth), std::cos(from_vertical)};
}

// A line in a vertical plane that starts at an angle from the vertical and ends at another, which it nears
// slowly at first.
struct Arc {
  Vector3f start = Vector3f::Zero();
  float length = 1, azimuth = 0, first_angle = 0, last_angle = 0;
  float sharpness = 2;  // the angle goes by this power of the way
  int pieces = 6;
};

std::vector<Vector3f> points_of(const Arc& arc) {
  std::vector<Vector3f> points = {arc.start};
  for (int i = 0; i < arc.pieces; ++i) {
    const float middle = (static_cast<float>(i) + 0.5F) / static_cast<float>(arc.pieces);
    const float angle =
        arc.first_angle + (arc.last_angle - arc.first_angle) * std::pow(middle, arc.sharpness);
    points.emplace_back(points.back() +
                        arc.length / static_cast<float>(arc.pieces) * direction_of(angle, arc.azimuth));
  }
  return points;
}

// Widths from one end to the other; a blade is broadest at a third of its length.
std::vector<float> tapered(std::size_t count, float first, float last) {
  std::vector<float> widths;
  for (std::size_t i = 0; i < count; ++i)
    widths.push_back(first + (last - first) * static_cast<float>(i) / static_cast<float>(count - 1));
  return widths;
}
std::vector<float> blade(std::size_t count, float breadth) {
  std::vector<float> widths;
  for (std::size_t i = 0; i < count; ++i) {
    const float s = static_cast<float>(i) / static_cast<float>(count - 1);
    widths.push_back(seen_of_flat * breadth * std::min(1.0F, 0.5F + 1.5F * s) * std::sqrt(1 - s * s));
  }
  return widths;
}

struct Look {
  Vector3f first, last;
};

Look varied(const Look& look, Draw& draw, float much) {
  const float bright = 1 + much * (draw.unit() - 0.5F), warm = 1 + 0.5F * much * (draw.unit() - 0.5F);
  const Vector3f factor(bright * warm, bright, bright / warm);
  return {look.first.cwiseProduct(factor).cwiseMin(1.0F), look.last.cwiseProduct(factor).cwiseMin(1.0F)};
}

void add(StrandPatch& patch, std::vector<Vector3f> points, std::vector<float> widths, const Look& look,
         float held = -1) {
  patch.strands.push_back({.points = std::move(points),
                           .widths = std::move(widths),
                           .first_color = look.first,
                           .last_color = look.last,
                           .plant = static_cast<std::uint32_t>(patch.feet.size() - 1),
                           .held = held});
}

// Where plants stand: a grid, each off its place by up to so much of it.
struct Rows {
  int columns = 1, rows = 1;
  Vector2f spacing{1, 1};
  float jitter = 0;
};

// `grow(foot, draw)` for each. Those nearer to the border of the patch than `margin` are the same in all
// variants.
template <class Grow>
void plant(StrandPatch& patch, const Rows& rows, float margin, const StrandOptions& options,
           std::uint32_t bin, const Grow& grow) {
  for (int i = 0; i < rows.columns * rows.rows; ++i) {
    const auto number = static_cast<std::uint64_t>(i);
    Draw place(options.seed, bin, number);
    const Vector2f middle(static_cast<float>(i % rows.columns) + 0.5F,
                          static_cast<float>(i / rows.columns) + 0.5F);
    const Vector2f off(place.between(-1, 1), place.between(-1, 1));
    const Vector2f foot = (middle + rows.jitter * off).cwiseProduct(rows.spacing);
    const float inside = std::min(foot.minCoeff(), (patch.size - foot).minCoeff());
    const std::uint32_t variant = inside < margin ? 0U : static_cast<std::uint32_t>(options.variant);
    Draw draw(options.seed, bin + 16 * (variant + 1), number);
    grow(foot, draw);
  }
}

// ---- Rice

const Look rice_culm = {{0.17F, 0.19F, 0.06F}, {0.24F, 0.31F, 0.08F}};
const Look rice_leaf = {{0.075F, 0.17F, 0.03F}, {0.20F, 0.27F, 0.06F}};
const Look rice_ear = {{0.27F, 0.29F, 0.09F}, {0.46F, 0.36F, 0.14F}};

void add_panicle(StrandPatch& patch, const Vector3f& start, float azimuth, float angle, Draw& draw) {
  const Look look = varied(rice_ear, draw, 0.3F);
  const Arc rachis{.start = start,
                   .length = draw.between(0.17F, 0.23F),
                   .azimuth = azimuth,
                   .first_angle = angle,
                   .last_angle = draw.between(1.7F, 2.5F),
                   .sharpness = 1.3F,
                   .pieces = 8};
  const std::vector<Vector3f> along = points_of(rachis);
  add(patch, along, tapered(along.size(), 0.002F, 0.001F), look, start.z());
  for (std::size_t k = 1; k < along.size(); ++k) {
    const float s = static_cast<float>(k) / static_cast<float>(along.size() - 1);
    const Arc branch{.start = along[k],
                     .length = draw.between(0.06F, 0.09F) * (1.2F - 0.5F * s),
                     .azimuth = azimuth + draw.between(-0.9F, 0.9F),
                     .first_angle = angle + (rachis.last_angle - angle) * s - 0.2F,
                     .last_angle = draw.between(2.4F, 3.0F),
                     .sharpness = 1,
                     .pieces = 4};
    const std::vector<Vector3f> points = points_of(branch);
    add(patch, points, {0.001F, 0.006F, 0.007F, 0.006F, 0.003F}, look, start.z());
  }
}

void add_culm(StrandPatch& patch, const Vector2f& hill, Draw& draw) {
  const float around = draw.between(-pi, pi), out = 0.035F * std::sqrt(draw.unit());
  const Vector3f foot(hill.x() + out * std::cos(around), hill.y() + out * std::sin(around), 0);
  patch.feet.emplace_back(foot.head<2>());
  const float azimuth = around + draw.between(-0.5F, 0.5F), lean = draw.between(0, 0.06F) + 3 * out;
  const Arc culm{.start = foot,
                 .length = draw.between(0.64F, 0.78F),
                 .azimuth = azimuth,
                 .first_angle = lean,
                 .last_angle = lean + draw.between(0, 0.1F),
                 .pieces = 8};
  const std::vector<Vector3f> stem = points_of(culm);
  add(patch, stem, tapered(stem.size(), 0.006F, 0.003F), varied(rice_culm, draw, 0.3F));
  float side = draw.between(-pi, pi);
  for (const std::size_t node : {1U, 3U, 4U, 6U, 7U}) {
    const bool flag = node == 7;  // the last leaf stands up beside the panicle
    side += pi + draw.between(-0.6F, 0.6F);
    const Arc leaf{.start = stem[node],
                   .length = flag ? draw.between(0.2F, 0.3F) : draw.between(0.3F, 0.48F),
                   .azimuth = side,
                   .first_angle = draw.between(0.15F, 0.45F),
                   .last_angle = flag ? draw.between(0.3F, 0.9F) : draw.between(0.9F, 2.3F),
                   .sharpness = 1.6F,
                   .pieces = 8};
    const std::vector<Vector3f> points = points_of(leaf);
    add(patch, points, blade(points.size(), draw.between(0.008F, 0.012F)), varied(rice_leaf, draw, 0.4F),
        stem[node].z());
  }
  if (draw.unit() < 0.7F) add_panicle(patch, stem.back(), azimuth, culm.last_angle, draw);
}

StrandPatch rice(const StrandOptions& options) {
  StrandPatch patch{.size = {1.8F, 1.8F}, .height = 0, .feet = {}, .strands = {}};
  plant(patch, {.columns = 12, .rows = 6, .spacing = {0.15F, 0.3F}, .jitter = 0.12F}, 0.45F, options, 0,
        [&](const Vector2f& foot, Draw& draw) {
          const int culms = 10 + static_cast<int>(5 * draw.unit());
          for (int i = 0; i < culms; ++i) add_culm(patch, foot, draw);
        });
  return patch;
}

// ---- Moss

const Look moss_stem = {{0.05F, 0.045F, 0.015F}, {0.10F, 0.16F, 0.025F}};
const Look moss_leaf = {{0.09F, 0.17F, 0.02F}, {0.24F, 0.36F, 0.05F}};
const Look moss_seta = {{0.30F, 0.10F, 0.03F}, {0.38F, 0.17F, 0.05F}};

constexpr float moss_patch = 0.12F;  // [m]

// Moss grows in cushions, highest in their middles: how high a shoot is there, by the highest. Cushions reach
// over the border of the patch.
float cushion_at(const Vector2f& at, std::uint64_t seed) {
  constexpr int across = 5;
  constexpr float apart = moss_patch / across;
  const Eigen::Array2i cell = (at / apart).array().floor().cast<int>();
  float highest = 0.45F;
  for (int k = 0; k < 9; ++k) {
    const int x = cell.x() + k % 3 - 1, y = cell.y() + k / 3 - 1;
    const int number = (y + across) % across * across + (x + across) % across;
    Draw draw(seed, 3, static_cast<std::uint64_t>(number));
    const Vector2f middle(static_cast<float>(x) + draw.unit(), static_cast<float>(y) + draw.unit());
    const float radius = draw.between(0.55F, 1.0F), top = draw.between(0.7F, 1.0F);
    const float off = (at / apart - middle).squaredNorm() / (radius * radius);
    if (off < 1) highest = std::max(highest, top * std::sqrt(1 - 0.75F * off));
  }
  return highest;
}

void add_shoot(StrandPatch& patch, const Vector2f& at, std::uint64_t seed, Draw& draw) {
  const Vector3f foot(at.x(), at.y(), 0);
  patch.feet.push_back(at);
  const Arc shoot{.start = foot,
                  .length = cushion_at(at, seed) * draw.between(0.019F, 0.028F),
                  .azimuth = draw.between(-pi, pi),
                  .first_angle = draw.between(0, 0.25F),
                  .last_angle = draw.between(0, 0.6F),
                  .pieces = 6};
  const std::vector<Vector3f> stem = points_of(shoot);
  add(patch, stem, tapered(stem.size(), 0.0005F, 0.0004F), moss_stem);
  float side = draw.between(-pi, pi);
  constexpr int leaves = 22;
  const Look look = varied(moss_leaf, draw, 0.5F);
  for (int i = 0; i < leaves; ++i) {
    const float s = 0.2F + 0.8F * static_cast<float>(i + 1) / leaves, place = s * 6;
    const auto node = std::min(static_cast<std::size_t>(place), std::size_t{5});
    const Vector3f start = stem[node] + (place - static_cast<float>(node)) * (stem[node + 1] - stem[node]);
    side += 2.4F;  // the golden angle
    const float open = 1.25F - 0.8F * s * s;
    const Arc leaf{.start = start,
                   .length = draw.between(0.003F, 0.0045F),
                   .azimuth = side,
                   .first_angle = open - 0.3F,
                   .last_angle = open + 0.3F,
                   .sharpness = 1,
                   .pieces = 3};
    const std::vector<Vector3f> points = points_of(leaf);
    add(patch, points, blade(points.size(), 0.0009F),
        {(0.4F + 0.6F * s) * look.first, (0.4F + 0.6F * s) * look.last}, start.z());
  }
  if (draw.unit() > 0.05F) return;
  const Arc seta{.start = stem.back(),
                 .length = draw.between(0.012F, 0.022F),
                 .azimuth = draw.between(-pi, pi),
                 .first_angle = 0.05F,
                 .last_angle = 0.2F,
                 .pieces = 5};
  std::vector<Vector3f> points = points_of(seta);
  const Look red = varied(moss_seta, draw, 0.4F);
  add(patch, points, tapered(points.size(), 0.0003F, 0.0003F), red);
  const Arc capsule{.start = points.back(),
                    .length = 0.0028F,
                    .azimuth = seta.azimuth,
                    .first_angle = 0.4F,
                    .last_angle = 1.2F,
                    .sharpness = 1,
                    .pieces = 4};
  points = points_of(capsule);
  add(patch, points, {0.0004F, 0.0011F, 0.0013F, 0.001F, 0.0003F}, red);
}

StrandPatch moss(const StrandOptions& options) {
  StrandPatch patch{.size = {moss_patch, moss_patch}, .height = 0, .feet = {}, .strands = {}};
  plant(patch, {.columns = 44, .rows = 44, .spacing = Vector2f::Constant(moss_patch / 44), .jitter = 0.8F},
        0.012F, options, 0,
        [&](const Vector2f& foot, Draw& draw) { add_shoot(patch, foot, options.seed, draw); });
  return patch;
}

// ---- Fur

const Look guard_hair = {{0.10F, 0.055F, 0.025F}, {0.42F, 0.26F, 0.13F}};
const Look under_fur = {{0.14F, 0.10F, 0.07F}, {0.22F, 0.15F, 0.10F}};

// Hairs stick together in tufts, and tufts in locks: the nearest to a foot of the middles that are strewn
// over the patch, one in every square of a grid, with numbers of its own, 0 to 1.
constexpr float fur_patch = 0.12F;  // [m]
struct Tuft {
  Vector2f middle{0, 0};
  float first = 0, second = 0;
};
Tuft tuft_of(const Vector2f& at, int across, std::uint32_t bin, std::uint64_t seed) {
  const float apart = fur_patch / static_cast<float>(across);
  const Eigen::Array2i cell = (at / apart).array().floor().cast<int>();
  Tuft nearest;
  float least = fur_patch;
  for (int k = 0; k < 9; ++k) {
    const int x = cell.x() + k % 3 - 1, y = cell.y() + k / 3 - 1;
    const int number = (y + across) % across * across + (x + across) % across;
    Draw draw(seed, bin, static_cast<std::uint64_t>(number));
    const Vector2f inside(draw.unit(), draw.unit());
    const Vector2f middle = apart * (Vector2f(static_cast<float>(x), static_cast<float>(y)) + inside);
    const float far = (middle - at).norm();
    if (!(far < least)) continue;
    least = far;
    nearest = {middle, draw.unit(), draw.unit()};
  }
  return nearest;
}

// Of a coat some hairs are old, and stand out, and some have just begun to grow; a tuft is longer than the
// next, and what a tuft has at its middle reaches further than what is at its side. So the top is ragged.
float guard_length(const Tuft& tuft, const Tuft& lock, float off, Draw& draw) {
  const float grown = 1 - 0.55F * std::pow(draw.unit(), 2.5F);
  return 0.047F * (0.72F + 0.36F * tuft.first) * (0.85F + 0.3F * lock.first) * (1 - 0.2F * off) * grown;
}

void add_hair(StrandPatch& patch, const Vector2f& at, bool guard, std::uint64_t seed, Draw& draw) {
  patch.feet.push_back(at);
  constexpr int tufts = 12, locks = 4;  // along a side of the patch
  const Tuft tuft = tuft_of(at, tufts, 2, seed), lock = tuft_of(at, locks, 3, seed);
  const Vector2f to_tuft = tuft.middle - at, to_lock = lock.middle - at;
  const float combed = 1.1F * (lock.second - 0.5F);  // [rad] locks part
  const Vector2f away =
      0.012F * Vector2f(std::cos(combed), std::sin(combed)) + 1.6F * to_tuft + 0.25F * to_lock;
  const float loose = guard ? 0.15F : 0.9F, lean = std::min(1.0F, away.norm() / 0.016F);
  const float off = std::min(1.0F, to_tuft.norm() / (0.8F * fur_patch / tufts));
  const Arc hair{.start = {at.x(), at.y(), 0},
                 .length = guard ? guard_length(tuft, lock, off, draw) : draw.between(0.012F, 0.022F),
                 .azimuth = std::atan2(away.y(), away.x()) + draw.between(-loose, loose),
                 .first_angle = draw.between(0.05F, 0.3F) + 0.3F * lean,
                 .last_angle = guard
                                   ? 0.3F + 0.8F * lean + 0.4F * (tuft.second - 0.5F) + draw.between(0, 0.3F)
                                   : draw.between(0.6F, 1.8F),
                 .sharpness = 1,
                 .pieces = 7};
  const std::vector<Vector3f> points = points_of(hair);
  const float width = guard ? 0.00012F : 0.00006F;
  add(patch, points, tapered(points.size(), width, 0.3F * width),
      varied(guard ? guard_hair : under_fur, draw, 0.5F));
}

StrandPatch fur(const StrandOptions& options) {
  StrandPatch patch{.size = {fur_patch, fur_patch}, .height = 0, .feet = {}, .strands = {}};
  const auto hairs = [&](int across, bool guard, std::uint32_t bin) {
    plant(patch,
          {.columns = across,
           .rows = across,
           .spacing = Vector2f::Constant(fur_patch / static_cast<float>(across)),
           .jitter = 0.9F},
          0.04F, options, bin,
          [&](const Vector2f& foot, Draw& draw) { add_hair(patch, foot, guard, options.seed, draw); });
  };
  hairs(110, true, 0);
  hairs(120, false, 1);
  return patch;
}

using Grower = StrandPatch (*)(const StrandOptions&);
constexpr std::array<std::pair<std::string_view, Grower>, 3> growers = {
    {{"rice", rice}, {"moss", moss}, {"fur", fur}}};

}  // namespace

double area_of(const Strand& strand) {
  double area = 0;
  for (std::size_t i = 0; i + 1 < strand.points.size(); ++i) {
    area += static_cast<double>((strand.points[i + 1] - strand.points[i]).norm()) *
            static_cast<double>(strand.widths[i] + strand.widths[i + 1]) / 2;
  }
  return area;
}

VolumePlant volume_plant_of(std::string_view name) {
  std::string names;
  for (std::size_t i = 0; i < growers.size(); ++i) {
    if (growers[i].first == name) return static_cast<VolumePlant>(i);
    names += (i == 0 ? "" : i + 1 < growers.size() ? ", " : " or ") + std::string(growers[i].first);
  }
  throw InputError("plant of a volume", "'" + std::string(name) + "'", names);
}

StrandPatch grow_strands(VolumePlant plant, const StrandOptions& options) {
  check_positive("scale of the strands", options.scale);
  if (options.variant < 0 || options.variant > 0xffff)
    throw InputError("variant of the strands", std::to_string(options.variant), "0 to 65535");
  StrandPatch patch = growers[static_cast<std::size_t>(plant)].second(options);
  const auto scale = static_cast<float>(options.scale);
  patch.size *= scale;
  for (Vector2f& foot : patch.feet) foot *= scale;
  for (Strand& strand : patch.strands) {
    if (strand.held > 0) strand.held *= scale;
    for (float& width : strand.widths) width *= scale;
    for (Vector3f& point : strand.points) {
      point *= scale;
      patch.height = std::max(patch.height, point.z());
    }
  }
  return patch;
}

}  // namespace tremula
