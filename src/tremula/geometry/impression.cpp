#include "tremula/geometry/impression.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/base/noise.hpp"
#include "tremula/base/suggestion.hpp"
#include "tremula/numerics/random.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>

namespace tremula {
namespace {

constexpr double pi = std::numbers::pi;
constexpr int most_octaves = 16;

// A quadric by its level sections: at z above the centre an ellipse about -lean z, of the form `flat`, where
// the form is at most level - rise z^2.
struct Sections {
  Eigen::Matrix2d flat, inverse;
  Eigen::Vector2d lean;
  double rise = 0;

  explicit Sections(const Quadric& quadric)
      : flat(quadric.form.topLeftCorner<2, 2>()),
        inverse(flat.inverse()),
        lean(inverse * quadric.form.topRightCorner<2, 1>()),
        rise(quadric.form(2, 2) - quadric.form.topRightCorner<2, 1>().dot(lean)) {}
};

// The heights between which there is anything; low >= high where there is nothing.
struct Reach {
  double low = 0, high = 0;
};

Reach reach_of(const Quadric& quadric) {
  Reach reach{quadric.low, quadric.high};
  const Sections sections(quadric);
  if (sections.rise >= 0 && quadric.level < 0) return {0, 0};
  if (sections.rise > 0) {
    const double half = std::sqrt(quadric.level / sections.rise);
    reach.low = std::max(reach.low, quadric.centre.z() - half);
    reach.high = std::min(reach.high, quadric.centre.z() + half);
  }
  return reach;
}

// To 4e-6, and faster than that of the library.
inline float sine(float x) {
  constexpr float pi_f = std::numbers::pi_v<float>;
  x -= 2 * pi_f * std::floor(x * (0.5F / pi_f) + 0.5F);
  if (std::abs(x) > pi_f / 2) x = std::copysign(pi_f, x) - x;
  const float y = x * x;
  return x * (1 + y * (-1.0F / 6 + y * (1.0F / 120 + y * (-1.0F / 5040 + y / 362880))));
}

struct Doubled {  // an angle that is doubled again and again
  float sine, cosine;

  explicit Doubled(float angle) : sine(std::sin(angle)), cosine(std::cos(angle)) {}
  void go_on() {
    const float twice = 2 * sine * cosine;
    cosine = 1 - 2 * sine * sine;
    sine = twice;
  }
};

// ---- Shapes

class Draw {  // numbers of one tree, one after the other
 public:
  explicit Draw(std::uint64_t seed) : seed_(seed) {}
  double between(double low, double high) {
    return low +
           (high - low) * uniform({.seed = seed_, .stream = RandomStream::impressions, .place = next_++});
  }

 private:
  std::uint64_t seed_, next_ = 0;
};

// A crown about `middle`, whose outline is `axes`: one ellipsoid within, and lobes of about so much of its
// size, evenly by the golden angle, that reach the outline. `lowest`: of the directions that they stand in.
void add_lobes(ImpressionistTree& tree, Draw& draw, const Vec3& middle, const Vec3& axes, int count,
               double lobe, double lowest) {
  constexpr double golden_angle = 2.399963229728653;
  tree.crown.push_back(ellipsoid(middle, (1 - 0.9 * lobe) * axes));
  const double turn = draw.between(0, 2 * pi);
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (1 - lowest) * (i + 0.5) / count, r = std::sqrt(std::max(0.0, 1 - z * z));
    const double angle = turn + golden_angle * i + draw.between(-0.3, 0.3);
    const double size = lobe * draw.between(0.65, 1.2);
    const Vec3 out(r * std::cos(angle), r * std::sin(angle), z);
    const Vec3 round = axes.cwiseMin(1.5 * axes.minCoeff());
    const Vec3 own = size * round.cwiseProduct(Vec3(draw.between(0.9, 1.1), draw.between(0.9, 1.1),
                                                    draw.between(0.7, 0.95)));
    const Vec3 centre = middle + draw.between(0.88, 1.04) * out.cwiseProduct(axes - own);
    tree.crown.push_back(ellipsoid(centre, own));
  }
}

void grow_crown(ImpressionistTree& tree, double bottom, int lobes, double lobe, double lowest) {
  Draw draw(tree.seed);
  const double half = (tree.height - bottom) / 2;
  add_lobes(tree, draw, {0, 0, bottom + half}, {tree.width / 2, tree.width / 2, half}, lobes, lobe, lowest);
}

void grow_round(ImpressionistTree& tree) { grow_crown(tree, 0.2 * tree.height, 14, 0.45, -0.8); }

// Wide, flat below, of many lobes.
void grow_oak(ImpressionistTree& tree) {
  Draw draw(tree.seed);
  const double h = tree.height, w = tree.width / 2, middle = 0.5 * h;
  add_lobes(tree, draw, {0, 0, middle}, {w, w, h - middle}, 22, 0.36, -0.42);
}

// What is slim is all silhouette: it keeps more leaves there.
constexpr float edge_of_slim = 0.3F;

void grow_poplar(ImpressionistTree& tree) {
  tree.cover.edge = edge_of_slim;
  Draw draw(tree.seed);
  const double h = tree.height, w = tree.width / 2, bottom = 0.08 * h, half = (h - bottom) / 2;
  tree.crown.push_back(ellipsoid({0, 0, bottom + half}, {0.75 * w, 0.75 * w, half}));
  constexpr int count = 14;
  for (int i = 0; i < count; ++i) {
    const double along = (i + 0.7) / (count + 0.6), s = 2 * along - 1;
    const double wide = w * std::sqrt(std::max(0.0, 1 - s * s)) * (s < 0 ? 1 : 0.95);
    const double angle = 2.4 * i + draw.between(-0.4, 0.4), own = 0.55 * std::max(wide, 0.3 * w);
    const double out = std::max(0.0, wide - own);
    tree.crown.push_back(ellipsoid({out * std::cos(angle), out * std::sin(angle), bottom + along * 2 * half},
                                   {own, own, draw.between(0.13, 0.17) * half}));
  }
}

// Tiers of cones, each over the edge of the next.
void grow_pine(ImpressionistTree& tree) {
  tree.cover.edge = edge_of_slim;
  Draw draw(tree.seed);
  const double h = tree.height, bottom = 0.12 * h;
  constexpr int tiers = 9;
  for (int i = 0; i < tiers; ++i) {
    const double low = bottom + (h - bottom) * i / tiers * 0.96;
    const double share = (h - low) / (h - bottom);
    const double radius = tree.width / 2 * std::pow(share, 0.9) * draw.between(0.92, 1.08);
    const double tall = i + 1 == tiers ? h - low : std::min(h - low, (h - bottom) * 2.6 / tiers);
    const double across = 0.04 * radius;
    tree.crown.push_back(upright_cone(
        {draw.between(-across, across), draw.between(-across, across), low + tall}, tall, radius));
  }
}

void grow_bush(ImpressionistTree& tree) {
  Draw draw(tree.seed);
  const double h = tree.height, w = tree.width / 2;
  add_lobes(tree, draw, {0, 0, 0.42 * h}, {w, w, 0.58 * h}, 16, 0.42, -0.6);
}

struct KnownShape {
  ImpressionistShape shape;
  void (*grow)(ImpressionistTree& tree);
  double slenderness;    // height over the diameter of the trunk's foot
  const char* material;  // of structure/material.hpp
  double crown_density;  // ForestGALES: conifers 2.5, birch 1.22, beech and oak 1.38
  Eigen::Vector3f leaf_color, bark_color;
};

const std::vector<KnownShape>& known_shapes() {
  static const std::vector<KnownShape> shapes = {
      {{"round", "a broadleaf in a hedge or an orchard", 9, 0.8},
       grow_round,
       35,
       "beech",
       1.38,
       {0.31F, 0.40F, 0.18F},
       {0.36F, 0.31F, 0.25F}},
      {{"oak", "a broad oak that stands alone", 14, 1.1},
       grow_oak,
       22,
       "oak",
       1.38,
       {0.29F, 0.37F, 0.17F},
       {0.31F, 0.26F, 0.21F}},
      {{"poplar", "a Lombardy poplar", 22, 0.17},
       grow_poplar,
       50,
       "green-wood",
       1.22,
       {0.33F, 0.42F, 0.20F},
       {0.40F, 0.37F, 0.31F}},
      {{"pine", "a conifer of tiers", 18, 0.36},
       grow_pine,
       55,
       "scots-pine",
       2.5,
       {0.19F, 0.28F, 0.17F},
       {0.33F, 0.23F, 0.17F}},
      {{"bush", "leaves from the ground", 2.2, 1.2},
       grow_bush,
       40,
       "green-wood",
       1.38,
       {0.33F, 0.40F, 0.19F},
       {0.34F, 0.29F, 0.23F}},
  };
  return shapes;
}

const KnownShape& find_shape(std::string_view name) {
  std::string list;
  std::vector<std::string> names;
  for (const KnownShape& known : known_shapes()) {
    if (known.shape.name == name) return known;
    names.push_back(known.shape.name);
    list += (list.empty() ? "" : ", ") + known.shape.name;
  }
  throw InputError("shape of an impressionist tree", "'" + std::string(name) + "'",
                   "one of " + list + suggestion(std::string(name), names));
}

}  // namespace

Quadric ellipsoid(const Vec3& centre, const Vec3& semi_axes) {
  return {.centre = centre, .form = semi_axes.cwiseAbs2().cwiseInverse().asDiagonal()};
}

Quadric upright_cone(const Vec3& apex, double height, double radius) {
  const double across = 1 / (radius * radius), along = 1 / (height * height);
  return {.centre = apex,
          .form = Vec3(across, across, -along).asDiagonal(),
          .level = 0,
          .low = std::min(apex.z(), apex.z() - height),
          .high = std::max(apex.z(), apex.z() - height)};
}

Quadric tapered_column(double height, double base_radius, double top_radius) {
  const double taper = (base_radius - top_radius) / height;
  if (taper == 0) {
    const double across = 1 / (base_radius * base_radius);
    return {.form = Vec3(across, across, 0).asDiagonal(), .low = 0, .high = height};
  }
  const double apex = base_radius / taper;
  Quadric cone = upright_cone({0, 0, apex}, apex, base_radius);
  cone.low = 0;
  cone.high = height;
  return cone;
}

std::optional<QuadricSection> section_at(const Quadric& quadric, double height) {
  if (height < quadric.low || height > quadric.high) return {};
  const Sections sections(quadric);
  const double z = height - quadric.centre.z(), left = quadric.level - sections.rise * z * z;
  if (!(left >= 0)) return {};
  QuadricSection section;
  section.middle = quadric.centre.head<2>() - z * sections.lean;
  section.half = (left * sections.inverse.diagonal()).cwiseSqrt();
  section.area = pi * left * std::sqrt(sections.inverse.determinant());
  return section;
}

bool is_inside(const Quadric& quadric, const Vec3& point) {
  const Vec3 from = point - quadric.centre;
  return point.z() >= quadric.low && point.z() <= quadric.high &&
         from.dot(quadric.form * from) <= quadric.level;
}

Eigen::AlignedBox3d bounds_of(const Quadric& quadric) {
  Eigen::AlignedBox3d box;
  const auto add = [&](double height) {
    const std::optional<QuadricSection> at = section_at(quadric, height);
    if (!at) return;
    box.extend(Vec3(at->middle.x() - at->half.x(), at->middle.y() - at->half.y(), height));
    box.extend(Vec3(at->middle.x() + at->half.x(), at->middle.y() + at->half.y(), height));
  };
  // Along x and y it ends where the inverse of the form says, if its planes leave that, or else at a plane.
  const Reach reach = reach_of(quadric);
  const double inside = 1e-12 * (reach.high - reach.low);
  add(reach.low + inside);
  add(reach.high - inside);
  add(std::clamp(quadric.centre.z(), reach.low, reach.high));
  const Mat3 inverse = quadric.form.inverse();
  if (quadric.level > 0 && inverse.allFinite()) {
    for (int i = 0; i < 2; ++i) {
      if (!(inverse(i, i) > 0)) continue;
      const double farthest = inverse(2, i) * std::sqrt(quadric.level / inverse(i, i));
      for (const double height : {quadric.centre.z() - farthest, quadric.centre.z() + farthest}) add(height);
    }
  }
  return box;
}

double volume_of(const Quadric& quadric) {
  const Sections sections(quadric);
  const Reach reach = reach_of(quadric);
  if (!(reach.high > reach.low)) return 0;
  const auto sum_to = [&](double height) {
    const double z = height - quadric.centre.z();
    return quadric.level * z - sections.rise * z * z * z / 3;
  };
  return pi * std::sqrt(sections.inverse.determinant()) * (sum_to(reach.high) - sum_to(reach.low));
}

void check_quadric(const Quadric& quadric, const std::string& name) {
  const Mat3& form = quadric.form;
  if (!quadric.centre.allFinite() || !form.allFinite() || !std::isfinite(quadric.level) ||
      std::isnan(quadric.low) || std::isnan(quadric.high))
    throw InputError(name, "a number that is not finite", "a quadric without volume has such, or none");
  if (!form.isApprox(form.transpose())) throw InputError(name, "a form that is not symmetric", "one that is");
  const double across = form.topLeftCorner<2, 2>().determinant();
  if (!(form(0, 0) > 0 && across > 0))
    throw InputError(name, "a quadric that is not bounded", "level sections that are ellipses");
  const Reach reach = reach_of(quadric);
  if (!std::isfinite(reach.low) || !std::isfinite(reach.high))
    throw InputError(name, "a quadric that is not bounded", "heights where it ends");
  const double volume = reach.high > reach.low ? volume_of(quadric) : 0;
  if (!(volume > 0) || !std::isfinite(volume))
    throw InputError(name, "a quadric without volume", "one that is not flat or empty");
}

void check_texture(const GardnerTexture& texture) {
  if (texture.octaves < 1 || texture.octaves > most_octaves)
    throw InputError("octaves of the texture", std::to_string(texture.octaves), "1 to 16");
  check_positive("wavelength of the texture", texture.wavelength, " m");
  check_positive("stretch of the texture", texture.stretch);
  check_positive("falloff of the texture", texture.falloff);
}

float value_at(const GardnerTexture& texture, const Eigen::Vector3f& place) {
  constexpr float half_turn = std::numbers::pi_v<float>;
  const auto wavelength = static_cast<float>(texture.wavelength),
             stretch = static_cast<float>(texture.stretch);
  // Within the texture's period, where floats have digits for the finest sine.
  const auto phase = [&](float along, float factor) {
    const float periods = along * factor / (2 * wavelength);
    return 4 * half_turn * (periods - std::floor(periods));
  };
  const float x = phase(place.x(), 1), y = phase(place.y(), stretch);
  // Sines of half the phase, and of twice it in every further octave.
  Doubled of_x(x / 2), of_y(y / 2), of_z(phase(place.z(), 1) / 2),
      of_stretched_z(phase(place.z(), stretch) / 2);
  float along_x = 0, along_y = 0, sum = 0, amplitude = 1, scale = 1;
  for (int i = 0; i < texture.octaves; ++i) {
    const float shift_x = half_turn / 2 * of_y.sine + half_turn * of_z.sine;
    const float shift_y = half_turn / 2 * of_x.sine + half_turn * of_stretched_z.sine;
    along_x += amplitude * sine(scale * x + shift_x);
    along_y += amplitude * sine(scale * y + shift_y);
    sum += amplitude;
    amplitude *= static_cast<float>(texture.falloff);
    scale *= 2;
    for (Doubled* each : {&of_x, &of_y, &of_z, &of_stretched_z}) each->go_on();
  }
  // n T_0 is the sum of all C_i.
  return (along_x + sum) * (along_y + sum) / (4 * sum * sum);
}

TextureLevels levels_of(const GardnerTexture& texture) {
  check_texture(texture);
  // Points that fill one period of the texture evenly (Roberts' sequence by the plastic number's kin).
  constexpr int count = 1 << 14;
  constexpr double step[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
  const double period_x = 2 * texture.wavelength, period_y = period_x / texture.stretch;
  std::vector<float> values;
  for (int i = 0; i < count; ++i) {
    const auto share = [&](int k) { return std::fmod(0.5 + step[k] * (i + 1), 1.0); };
    const Eigen::Vector3f at(static_cast<float>(period_x * share(0)), static_cast<float>(period_y * share(1)),
                             static_cast<float>(period_x * share(2)));
    values.push_back(value_at(texture, at));
  }
  std::ranges::sort(values);
  TextureLevels levels;
  for (std::size_t k = 0; k < levels.quantile.size(); ++k) {
    const std::size_t at = k * values.size() / (levels.quantile.size() - 1);
    levels.quantile[k] = values[std::min(at, values.size() - 1)];
  }
  return levels;
}

float threshold_for(const TextureLevels& levels, float cover) {
  const float at = std::clamp(1 - cover, 0.0F, 1.0F) * static_cast<float>(levels.quantile.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(at), levels.quantile.size() - 2);
  const float share = at - static_cast<float>(low);
  return (1 - share) * levels.quantile[low] + share * levels.quantile[low + 1];
}

float opacity_at(const TextureLevels& levels, const CrownCover& cover, float value, float middle) {
  const float first = threshold_for(levels, cover.middle), last = threshold_for(levels, cover.edge);
  const float threshold = first + (last - first) * (1 - middle);
  return std::clamp(0.5F + (value - threshold) / cover.softness, 0.0F, 1.0F);
}

const std::vector<ImpressionistShape>& impressionist_shapes() {
  static const std::vector<ImpressionistShape> shapes = [] {
    std::vector<ImpressionistShape> all;
    for (const KnownShape& known : known_shapes()) all.push_back(known.shape);
    return all;
  }();
  return shapes;
}

ImpressionistTree impressionist_tree(std::string_view shape, double height, std::optional<double> width,
                                     std::uint64_t seed) {
  const KnownShape& known = find_shape(shape);
  check_positive("height of an impressionist tree", height, " m");
  if (width) check_positive("width of an impressionist tree", *width, " m");
  ImpressionistTree tree;
  tree.name = known.shape.name;
  tree.height = height;
  tree.width = width.value_or(known.shape.width_by_height * height);
  tree.trunk_height = 0.92 * height;
  tree.base_radius = height / known.slenderness / 2;
  tree.top_radius = 0.15 * tree.base_radius;
  tree.material = known.material;
  tree.crown_density = known.crown_density;
  tree.leaf_color = known.leaf_color;
  tree.bark_color = known.bark_color;
  tree.seed = seed;
  known.grow(tree);
  // Clumps as large as a lobe's half, down to a handful of leaves.
  const double size = std::sqrt(tree.height * tree.width);
  tree.texture.wavelength = std::clamp(0.13 * size, 0.3, 2.2);
  tree.leaf_size = std::clamp(0.008 * size, 0.03, 0.12);
  tree.texture.octaves =
      std::clamp(static_cast<int>(std::lround(std::log2(tree.texture.wavelength / tree.leaf_size))), 2, 6);
  check_tree(tree);
  return tree;
}

void check_tree(const ImpressionistTree& tree) {
  check_positive("height of the trunk", tree.trunk_height, " m");
  check_positive("radius of the trunk's foot", tree.base_radius, " m");
  check_positive("radius of the trunk's top", tree.top_radius, " m");
  if (tree.crown.empty()) throw InputError("crown of '" + tree.name + "'", "no quadrics", "one or more");
  for (std::size_t i = 0; i < tree.crown.size(); ++i)
    check_quadric(tree.crown[i], "quadric " + std::to_string(i + 1) + " of '" + tree.name + "'");
  check_texture(tree.texture);
  check_positive("size of the leaves", tree.leaf_size, " m");
  if (!(tree.crown_density >= 0) || !std::isfinite(tree.crown_density))
    throw InputError("density of the crown", number_text(tree.crown_density) + " kg/m^3", "0 or more");
}

std::vector<Quadric> quadrics_of(const ImpressionistTree& tree) {
  std::vector<Quadric> all{tapered_column(tree.trunk_height, tree.base_radius, tree.top_radius)};
  all.insert(all.end(), tree.crown.begin(), tree.crown.end());
  return all;
}

QuadricPaint paint_of(const Quadric& quadric, std::size_t number, std::uint64_t seed) {
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(quadric.form);
  const Vec3 size = solver.eigenvalues().cwiseAbs().cwiseSqrt();
  const auto draw = [&](std::uint32_t k) {
    return hash_to_unit(
        hash(static_cast<std::uint32_t>(seed) + 0x9e3779b9U * static_cast<std::uint32_t>(number)) + k);
  };
  const Eigen::Quaternionf turn = Eigen::AngleAxisf(6.2831853F * draw(0), Eigen::Vector3f::UnitZ()) *
                                  Eigen::AngleAxisf(std::acos(2 * draw(1) - 1), Eigen::Vector3f::UnitX()) *
                                  Eigen::AngleAxisf(6.2831853F * draw(2), Eigen::Vector3f::UnitZ());
  QuadricPaint paint;
  paint.turn = turn.toRotationMatrix();
  paint.offset = 40 * Eigen::Vector3f(draw(3), draw(4), draw(5));
  paint.root = (size.asDiagonal() * solver.eigenvectors().transpose()).cast<float>();
  paint.sign = solver.eigenvalues().cwiseSign().cast<float>();
  return paint;
}

float texture_shift(std::size_t copy) { return 0.37F * static_cast<float>(copy % 1024); }

std::vector<CrownLayer> crown_layers(const ImpressionistTree& tree, int count) {
  constexpr int cells = 32, rows = 4;  // of a level across the crown; levels of a layer
  Eigen::AlignedBox3d box;
  for (const Quadric& quadric : tree.crown) box.extend(bounds_of(quadric));
  const double low = std::max(0.0, box.min().z()), step = (box.max().z() - low) / count;
  const Eigen::Vector2d cell = box.sizes().head<2>() / cells;
  std::vector<CrownLayer> layers;
  for (int i = 0; i < count; ++i) {
    CrownLayer layer{.low = low + i * step, .high = low + (i + 1) * step};
    for (int row = 0; row < rows; ++row) {
      const double z = layer.low + (row + 0.5) * step / rows;
      int inside = 0, seen = 0;
      for (int cx = 0; cx < cells; ++cx) {
        int column = 0;
        for (int cy = 0; cy < cells; ++cy) {
          const Vec3 at(box.min().x() + (cx + 0.5) * cell.x(), box.min().y() + (cy + 0.5) * cell.y(), z);
          column += std::ranges::any_of(tree.crown, [&](const Quadric& q) { return is_inside(q, at); });
        }
        inside += column;
        seen += column > 0;
      }
      layer.volume += inside * cell.x() * cell.y() * step / rows;
      layer.frontal_area += seen * cell.x() * step / rows;
    }
    layers.push_back(layer);
  }
  return layers;
}

Skeleton trunk_skeleton(const ImpressionistTree& tree, double leaf_area) {
  check_tree(tree);
  constexpr int pieces = 12, count = 10;  // of the trunk; layers of the crown
  Skeleton skeleton;
  skeleton.roots.push_back(Vec3::Zero());
  const auto radius = [&](double share) {
    return tree.base_radius + share * (tree.top_radius - tree.base_radius);
  };
  for (int i = 0; i < pieces; ++i) {
    const double from = static_cast<double>(i) / pieces, to = static_cast<double>(i + 1) / pieces;
    skeleton.branches.push_back({.start_node = i,
                                 .start = {0, 0, from * tree.trunk_height},
                                 .end = {0, 0, to * tree.trunk_height},
                                 .start_radius = radius(from),
                                 .end_radius = radius(to)});
  }
  for (const CrownLayer& layer : crown_layers(tree, count)) {
    const double area = leaf_area * layer.frontal_area, mass = tree.crown_density * layer.volume;
    if (!(area > 0)) continue;
    const double height = std::min((layer.low + layer.high) / 2, tree.trunk_height);
    const double place = height / tree.trunk_height * pieces;
    const int branch = std::min(static_cast<int>(place), pieces - 1);
    // Square and level, its middle on the trunk: it turns with the trunk and twists nothing.
    const double side = std::sqrt(area);
    skeleton.leaves.push_back({.branch = branch,
                               .position = place - branch,
                               .base = {-side / 2, 0, height},
                               .axis = Vec3::UnitX(),
                               .normal = Vec3::UnitZ(),
                               .length = side,
                               .width = side,
                               .area = area,
                               .mass = std::max(mass, 1e-9)});
  }
  return skeleton;
}

}  // namespace tremula
