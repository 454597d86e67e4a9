#include "tremula/geometry/meadow.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/memory.hpp"
#include "tremula/base/suggestion.hpp"
#include "tremula/numerics/random.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace tremula {
namespace {

using Eigen::Vector2d;

constexpr double cell = 0.5;  // side of a square of ground [m]
// While a meadow is posed and drawn, a blade of 7 to 10 vertices takes this much [bytes].
constexpr double bytes_of_blade = 1200;

double between(const Vector2d& bounds, double share) { return bounds[0] + (bounds[1] - bounds[0]) * share; }

// Leaves of one blade: 0.2 to 0.25 mm thick, of fresh tissue of some 900 kg/m^3 (crop.017, water.024 of the
// collected literature have both).
double flat_mass(double width, double thickness) { return 900 * width * thickness; }

GrassSpecies lawn() {
  BladeKind blade;
  blade.width = 0.0028;
  blade.lean = {0.05, 0.6};
  blade.droop = {0.1, 1.1};
  blade.length_spread = 0.35;
  // 5 to 20 Hz at 10 to 3 cm (Vincent 1982, 1991).
  blade.frequency = 8;
  blade.mass = flat_mass(blade.width, 0.0002);
  return {
      .name = "lawn", .height = 0.06, .density = 7000, .canopy_decay = 2, .tufts = 0.35, .kinds = {blade}};
}

GrassSpecies meadow() {
  BladeKind blade;
  blade.width = 0.0042;
  blade.lean = {0.05, 0.55};
  blade.droop = {0.15, 1.5};
  blade.length_spread = 0.4;
  // Stems of alfalfa, 0.69 m: 1.05 Hz (Py et al. 2006); as 1/length.
  blade.frequency = 1.6;
  blade.mass = flat_mass(blade.width, 0.00025);
  BladeKind stem;
  stem.form = BladeForm::stem;
  stem.material = "straw";
  stem.color = {0.55F, 0.53F, 0.30F};
  stem.length = 1.35;
  stem.pieces = 4;
  stem.drag_coefficient = 1;
  stem.width = 0.0016;
  stem.lean = {0, 0.25};
  stem.droop = {0, 0.45};
  stem.each = 0.05;
  stem.frequency = 1.5;
  stem.mass = 1.2e-3;
  stem.tip_mass = 2e-4;
  stem.drag_area = 2e-4;
  BladeKind head;
  head.form = BladeForm::ear;
  head.material = "ear";
  head.color = {0.56F, 0.47F, 0.30F};
  head.length = 0.16;
  head.pieces = 4;
  head.width = 0.006;
  head.lean = {0, 0.3};
  head.droop = {0, 0.8};
  head.attached = {1, 1};
  return {.name = "meadow",
          .height = 0.4,
          .density = 1600,
          .canopy_decay = 2,
          .tufts = 0.4,
          .kinds = {blade, stem, head}};
}

GrassSpecies wheat() {
  BladeKind stem;
  stem.form = BladeForm::stem;
  stem.material = "straw";
  stem.color = {0.64F, 0.58F, 0.36F};
  stem.length = 1;
  stem.length_spread = 0.1;
  stem.pieces = 4;
  stem.drag_coefficient = 1;
  stem.width = 0.0035;
  stem.lean = {0, 0.12};
  stem.droop = {0, 0.25};
  // 0.5 to 1.5 Hz with ears (Baker 1995, Berry 2003), 2.5 Hz in the field of Py et al. 2006; damping 0.08;
  // C_D A of an ear 0.001 to 0.002 m^2 (Baker, Berry & Sterling).
  stem.frequency = 1.4;
  stem.mass = 4e-3;
  stem.tip_mass = 2.5e-3;
  stem.drag_area = 1.5e-3;
  BladeKind ear;
  ear.form = BladeForm::ear;
  ear.material = "ear";
  ear.color = {0.68F, 0.59F, 0.37F};
  ear.length = 0.13;
  ear.length_spread = 0.15;
  ear.pieces = 4;
  ear.width = 0.014;
  ear.lean = {0.05, 0.5};
  ear.droop = {0.1, 0.8};
  ear.attached = {1, 1};
  BladeKind leaf;
  leaf.material = "leaf";
  leaf.color = {0.47F, 0.49F, 0.20F};
  leaf.length = 0.38;
  leaf.pieces = 4;
  leaf.width = 0.011;
  leaf.lean = {0.35, 0.8};
  leaf.droop = {0.8, 2.6};
  leaf.each = 2.6;
  leaf.attached = {0.2, 0.8};
  leaf.frequency = 2.5;
  leaf.mass = flat_mass(leaf.width, 0.0002);
  // a = 2.5 to 2.8 (Cionco 1978).
  return {.name = "wheat",
          .height = 0.75,
          .density = 350,
          .canopy_decay = 2.65,
          .tufts = 0.08,
          .kinds = {stem, ear, leaf}};
}

GrassSpecies rice() {
  GrassSpecies rice = wheat();
  rice.name = "rice";
  rice.height = 0.85;
  rice.density = 260;
  rice.canopy_decay = 1.6;  // Cionco 1978
  BladeKind &stem = rice.kinds[0], &panicle = rice.kinds[1], &leaf = rice.kinds[2];
  // EI 0.005 to 0.03 N m^2 (Ookawa; Oladokun & Ennos 2006), which these masses make of 1.1 Hz.
  stem.color = {0.50F, 0.52F, 0.22F};
  stem.width = 0.0045;
  stem.lean = {0, 0.3};
  stem.droop = {0.05, 0.5};
  stem.frequency = 1.1;
  stem.mass = 5e-3;
  stem.tip_mass = 3e-3;
  panicle.color = {0.64F, 0.59F, 0.33F};
  panicle.length = 0.24;
  panicle.width = 0.011;
  panicle.lean = {0.5, 1.1};
  panicle.droop = {1.6, 4};
  leaf.color = {0.38F, 0.50F, 0.16F};
  leaf.length = 0.5;
  leaf.width = 0.011;
  leaf.lean = {0.12, 0.5};
  leaf.droop = {0.4, 1.5};
  leaf.each = 3.4;
  leaf.attached = {0.1, 0.75};
  leaf.frequency = 2;
  return rice;
}

GrassSpecies reed() {
  GrassSpecies reed = wheat();
  reed.name = "reed";
  reed.height = 2;
  reed.density = 70;
  reed.canopy_decay = 4.4;  // a stand of giant reed (Speck 2003)
  reed.tufts = 0.2;
  BladeKind &stem = reed.kinds[0], &plume = reed.kinds[1], &leaf = reed.kinds[2];
  stem.color = {0.52F, 0.52F, 0.28F};
  stem.width = 0.007;
  stem.lean = {0, 0.14};
  stem.droop = {0, 0.2};
  stem.frequency = 0.9;  // no source: between wheat and bamboo of its size
  stem.mass = 0.02;
  stem.tip_mass = 4e-3;
  stem.drag_area = 4e-3;
  plume.color = {0.47F, 0.36F, 0.28F};
  plume.length = 0.13;
  plume.width = 0.045;
  plume.lean = {0.2, 0.7};
  plume.droop = {0.2, 1};
  leaf.color = {0.36F, 0.47F, 0.20F};
  leaf.length = 0.24;
  leaf.width = 0.022;
  leaf.lean = {0.5, 1};
  leaf.droop = {0.5, 2};
  leaf.each = 8;
  leaf.attached = {0.2, 0.95};
  leaf.frequency = 2;
  leaf.mass = flat_mass(leaf.width, 0.0003);
  return reed;
}

// The particle after a time t [v0/g] stands at (sin phi t, cos phi t - t^2/2) [v0^2/g].
double path_length(double lean, double time) {
  // int sqrt(sin^2 + (cos - t)^2) dt in closed form.
  const double sine = std::sin(lean), cosine = std::cos(lean);
  const auto antiderivative = [&](double w) {
    const double speed = std::hypot(sine, w);
    if (sine < 1e-9) return 0.5 * w * std::abs(w);
    return 0.5 * (w * speed + sine * sine * std::asinh(w / sine));
  };
  return antiderivative(cosine) - antiderivative(cosine - time);
}

double time_of_length(double lean, double length) {
  double low = 0, high = 1;
  while (path_length(lean, high) < length) high *= 2;
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (low + high);
    (path_length(lean, middle) < length ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

// ---- Sowing

enum class Drawn : std::uint64_t { place, size, turns, kind, rest };

struct Draws {
  std::uint64_t seed, cell;
  std::uint32_t plant;

  std::array<double, 2> operator()(Drawn what, std::uint32_t blade = 0) const {
    return two_uniforms({seed, RandomStream::grass,
                         (plant << 8U) + 8 * (blade & 31U) + static_cast<std::uint32_t>(what), cell});
  }
};

std::uint64_t address_of(std::int64_t column, std::int64_t row) {
  return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(column)) << 32U) |
         static_cast<std::uint32_t>(row);
}

// Smooth, 0 to 1, one value in half a metre.
double patch(std::uint64_t seed, const Vector2d& place) {
  const double x = place.x() / cell, y = place.y() / cell;
  const auto column = static_cast<std::int64_t>(std::floor(x)),
             row = static_cast<std::int64_t>(std::floor(y));
  const auto value = [&](int dx, int dy) {
    return uniform({seed, RandomStream::grass, ~0U, address_of(column + dx, row + dy)});
  };
  const auto eased = [](double t) { return t * t * (3 - 2 * t); };
  const double tx = eased(x - std::floor(x)), ty = eased(y - std::floor(y));
  return (1 - ty) * ((1 - tx) * value(0, 0) + tx * value(1, 0)) +
         ty * ((1 - tx) * value(0, 1) + tx * value(1, 1));
}

struct Sower {
  const GrassSpecies& species;
  const SowOptions& options;
  double height, density;
  Meadow& meadow;

  double share_at(const std::function<double(const Vector2d&)>& mask, const Vector2d& place) const {
    return mask ? std::clamp(mask(place), 0.0, 1.0) : 1;
  }

  // The largest share within `around` [m] of a place.
  double kept_at(const Vector2d& place, double around = 0) const {
    if (!options.thinning) return 1;
    double away = options.thinning->eyes.empty() ? 0 : std::numeric_limits<double>::infinity();
    for (const Vector2d& eye : options.thinning->eyes) away = std::min(away, (place - eye).norm());
    return std::min(1.0, options.thinning->full_until / std::max(away - around, 1e-9));
  }

  void add_blade(int number, const BladeKind& kind, const Vector2d& place, double tall, double wider,
                 const Draws& draw, std::uint32_t blade, int count_before) const {
    const auto [long_by, attached_at] = draw(Drawn::size, blade);
    const auto [azimuth, facing] = draw(Drawn::turns, blade);
    const auto shape = static_cast<int>(draw(Drawn::rest, blade)[0] * trajectories_per_kind);
    const double length = tall * kind.length * (1 + kind.length_spread * (2 * long_by - 1));
    const double turn = 2 * std::numbers::pi * azimuth;
    // What is round would grow in two directions.
    const double thicker = kind.form == BladeForm::ear ? std::sqrt(wider) : wider;
    meadow.x.push_back(static_cast<float>(place.x()));
    meadow.y.push_back(static_cast<float>(place.y()));
    meadow.z.push_back(static_cast<float>(options.ground));
    meadow.length.push_back(static_cast<float>(length));
    meadow.width.push_back(
        static_cast<float>(kind.width * thicker * (0.75 + 0.5 * draw(Drawn::rest, blade)[1])));
    // Leaves of one stem stand on its alternate sides.
    const bool on_stem = kind.attached[1] > 0;
    meadow.azimuth.push_back(static_cast<float>(turn + (on_stem ? 2.4 * count_before : 0)));
    // The flat side looks where the blade leans to, roughly.
    meadow.facing.push_back(meadow.azimuth.back() + static_cast<float>(1.2 * (facing - 0.5)));
    meadow.attached.push_back(on_stem ? static_cast<float>(between(kind.attached, attached_at)) : -1.0F);
    meadow.kind.push_back(static_cast<std::uint8_t>(number));
    meadow.trajectory.push_back(static_cast<std::uint8_t>(std::min(shape, trajectories_per_kind - 1)));
    meadow.frequency_class.push_back(static_cast<std::uint8_t>(
        std::min(static_cast<int>(frequency_classes * long_by), frequency_classes - 1)));
  }

  void add_plant(const Vector2d& place, double kept, const Draws& draw) const {
    const double mask = share_at(options.height_at, place);
    const double tuft = species.tufts * (2 * patch(options.seed, place) - 1);
    const double tall = height * mask * (1 + tuft);
    if (!(tall > 0)) return;
    const double wider = options.thinning ? std::min(1 / kept, options.thinning->widest) : 1;
    std::uint32_t blade = 0;
    bool stem = false;
    for (std::size_t k = 0; k < species.kinds.size(); ++k) {
      const BladeKind& kind = species.kinds[k];
      if (kind.attached[1] > 0 && !stem) continue;
      const int count = static_cast<int>(kind.each + draw(Drawn::kind, static_cast<std::uint32_t>(k))[0]);
      for (int i = 0; i < count; ++i) {
        add_blade(static_cast<int>(k), kind, place, tall, wider, draw, blade++, i);
        stem |= kind.form == BladeForm::stem;
      }
    }
  }

  void sow_cell(std::int64_t column, std::int64_t row) const {
    const std::uint64_t address = address_of(column, row);
    const double wanted = density * cell * cell;
    const auto count =
        static_cast<std::uint32_t>(wanted + uniform({options.seed, RandomStream::grass, ~1U, address}));
    const Vector2d middle(cell * (static_cast<double>(column) + 0.5),
                          cell * (static_cast<double>(row) + 0.5));
    const double most = kept_at(middle, cell);
    for (std::uint32_t plant = 0; plant < count && plant < most * count; ++plant) {
      const Draws draw{options.seed, address, plant};
      const auto [u, v] = draw(Drawn::place);
      const Vector2d place(cell * (static_cast<double>(column) + u), cell * (static_cast<double>(row) + v));
      if ((place.array() < options.low.array()).any() || (place.array() >= options.high.array()).any())
        continue;
      const double kept = kept_at(place);
      // The later a plant, the sooner it goes where there are to be fewer.
      const double rank = (plant + draw(Drawn::kind, 31)[1]) / count;
      if (rank >= kept * share_at(options.density_at, place)) continue;
      add_plant(place, kept, draw);
    }
  }
};

double blades_of_plant(const GrassSpecies& species) {
  double blades = 0, stems = 0;
  for (const BladeKind& kind : species.kinds) {
    if (kind.form == BladeForm::stem) stems += kind.each;
    blades += kind.attached[1] > 0 ? std::min(stems, 1.0) * kind.each : kind.each;
  }
  return blades;
}

// What a field will hold, by squares, as masks and thinning go by place.
double expected_plants(const Sower& sower) {
  const Vector2d extent = sower.options.high - sower.options.low;
  if (!sower.options.thinning && !sower.options.density_at) return sower.density * extent.prod();
  constexpr int squares = 64;
  double plants = 0;
  for (int i = 0; i < squares; ++i) {
    for (int j = 0; j < squares; ++j) {
      const Vector2d share((i + 0.5) / squares, (j + 0.5) / squares);
      const Vector2d place = sower.options.low + share.cwiseProduct(extent);
      plants += sower.kept_at(place) * sower.share_at(sower.options.density_at, place);
    }
  }
  return sower.density * extent.prod() * plants / (squares * squares);
}

void check_options(const SowOptions& options, double density, double height) {
  if (!options.low.allFinite() || !options.high.allFinite() || !((options.high - options.low).minCoeff() > 0))
    throw InputError("the field of grass", "it ends before it begins", "low below high, along x and y");
  if (options.low.cwiseAbs().maxCoeff() > 1e6 || options.high.cwiseAbs().maxCoeff() > 1e6)
    throw InputError("the field of grass", "an edge beyond 1000 km", "one within 1000 km of the origin");
  check_positive("density of the grass", density, " per m^2");
  check_positive("height of the grass", height, " m");
  if (density > 1e6)
    throw InputError("density of the grass", number_text(density) + " per m^2", "at most 1e6");
  if (!std::isfinite(options.ground)) throw InputError("ground of the grass", "no finite height", "a height");
  if (options.thinning) check_positive("distance to thin grass from", options.thinning->full_until, " m");
}

}  // namespace

const std::vector<GrassSpecies>& grass_species() {
  static const std::vector<GrassSpecies> species = {lawn(), meadow(), wheat(), rice(), reed()};
  return species;
}

const GrassSpecies& grass_species_named(std::string_view name) {
  std::vector<std::string> names;
  std::string all;
  for (const GrassSpecies& species : grass_species()) {
    if (species.name == name) return species;
    names.push_back(species.name);
    all += (all.empty() ? "" : ", ") + species.name;
  }
  throw InputError("species of grass", "'" + std::string(name) + "'" + suggestion(std::string(name), names),
                   "one of " + all);
}

void check_species(const GrassSpecies& species) {
  const std::string place = "species '" + species.name + "'";
  check_positive("height of the grass", species.height, " m");
  check_positive("density of the grass", species.density, " per m^2");
  if (species.kinds.empty()) throw InputError(place, "no kinds of blades", "one or more");
  if (species.kinds.size() > 8)
    throw InputError(place, std::to_string(species.kinds.size()) + " kinds", "8 or fewer");
  if (species.kinds[0].attached[1] > 0)
    throw InputError(place, "a first kind on a stem", "one that stands on the ground");
  if (!(species.mean_share >= 0) || !(species.gust_share >= 0) || !(species.mean_share <= 1) ||
      !(species.gust_share <= 1))
    throw InputError(place, "a share of the wind out of range", "0 to 1");
  if (!(species.canopy_decay >= 0) || !std::isfinite(species.canopy_decay) || !(std::abs(species.tufts) < 1))
    throw InputError(place, "a decay or tufts out of range", "a decay of 0 or more, tufts from 0 to 1");
  for (const BladeKind& kind : species.kinds) {
    check_positive("length of blades", kind.length);
    check_positive("width of blades", kind.width, " m");
    check_positive("mass of blades", kind.mass, " kg/m");
    if (kind.pieces != 3 && kind.pieces != 4)
      throw InputError(place, "blades of " + std::to_string(kind.pieces) + " pieces", "3 or 4");
    const bool finite = kind.lean.allFinite() && kind.droop.allFinite() && kind.attached.allFinite();
    if (!finite || kind.lean.minCoeff() < 0 || kind.lean.maxCoeff() > 3 || kind.droop.minCoeff() < 0 ||
        kind.droop.maxCoeff() > 20 || !(kind.each >= 0) || kind.each > 30 || !(kind.length_spread >= 0) ||
        !(kind.length_spread < 1) || !(kind.frequency >= 0) || !(kind.damping_ratio >= 0) ||
        !(kind.tip_mass >= 0) || !(kind.drag_area >= 0) || !(kind.drag_coefficient >= 0))
      throw InputError(
          place, "blades with numbers out of range",
          "lean 0 to 3 rad, droop 0 to 20, at most 30 on a plant, spread 0 to 1, the rest 0 or more");
  }
}

std::vector<double> joints_of(const BladeKind& kind) {
  if (kind.pieces == 3) return {0, 0.4, 0.75, 1};
  return {0, 0.3, 0.55, 0.8, 1};
}

Eigen::Matrix3Xd trajectory(const BladeKind& kind, int number, int pieces) {
  check_at_least("pieces of a trajectory", pieces, 1);
  if (number < 0 || number >= trajectories_per_kind)
    throw InputError("trajectory", std::to_string(number),
                     "0 to " + std::to_string(trajectories_per_kind - 1));
  // Evenly over the square of both bounds (Roberts's sequence).
  const auto spread = [&](double step) { return std::fmod(0.5 + step * number, 1.0); };
  const double lean = between(kind.lean, spread(0.7548776662)),
               droop = between(kind.droop, spread(0.5698402910));
  Eigen::Matrix3Xd directions(3, pieces);
  for (int i = 0; i < pieces; ++i) {
    const auto place = [&](double share) -> Vec3 {
      if (droop < 1e-6) return share * Vec3(std::sin(lean), 0, std::cos(lean));
      const double t = time_of_length(lean, share * droop);
      return {std::sin(lean) * t, 0, (std::cos(lean) - 0.5 * t) * t};
    };
    directions.col(i) = (place((i + 1.0) / pieces) - place(static_cast<double>(i) / pieces)).normalized();
  }
  return directions;
}

Meadow sow(const GrassSpecies& species, const SowOptions& options) {
  check_species(species);
  Meadow meadow;
  meadow.species = species;
  const Sower sower{species, options, options.height.value_or(species.height),
                    options.density.value_or(species.density), meadow};
  check_options(options, sower.density, sower.height);
  meadow.height = sower.height;
  const double blades = expected_plants(sower) * blades_of_plant(species);
  const double bytes = bytes_of_blade * blades, most = 0.8 * static_cast<double>(available_memory());
  if (bytes > most) {
    throw InputError(
        "field of grass",
        number_text(std::round(blades)) + " blades, " + number_text(std::round(bytes * 1e-8) / 10) + " GB",
        "at most " + number_text(std::round(most / bytes_of_blade)) +
            " in the memory that is free: less density, or a smaller field");
  }
  const auto first = [](double low) { return static_cast<std::int64_t>(std::floor(low / cell)); };
  for (std::int64_t row = first(options.low.y()); row <= first(options.high.y()); ++row) {
    for (std::int64_t column = first(options.low.x()); column <= first(options.high.x()); ++column)
      sower.sow_cell(column, row);
  }
  if (meadow.size() == 0)
    throw InputError("field of grass", "no blade in it", "ground that the masks leave, and a density for it");
  return meadow;
}

}  // namespace tremula
