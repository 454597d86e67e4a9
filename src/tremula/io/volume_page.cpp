#include "tremula/io/volume_page.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/base/noise.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/deformation/volume.hpp"
#include "tremula/io/finite.hpp"
#include "tremula/io/html.hpp"
#include "tremula/io/page_block.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

namespace tremula {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2f;
using Eigen::Vector3f;
using Json = nlohmann::ordered_json;

constexpr double least_share = 0.02;

std::size_t triangles_of(const StrandPatch& patch) {
  std::size_t count = 0;
  for (const Strand& strand : patch.strands) count += 2 * (strand.points.size() - 1);
  return count;
}

bool stands_in(const StrandField& field, const PatchSquare& square, const Vector2f& foot) {
  const Vector2d at = (square.corner + foot).cast<double>();
  return (at.array() >= field.low.array()).all() && (at.array() <= field.high.array()).all();
}

void check_field(const StrandField& field) {
  if (field.patches.empty()) throw InputError("volume of the page", "no patch", "one or more");
  for (const StrandPatch& patch : field.patches) {
    if (patch.size != field.patches.front().size || !(patch.size.minCoeff() > 0) || patch.strands.empty())
      throw InputError("patches of the volume of the page", "sizes that differ, or nothing on them",
                       "one size, with strands");
  }
  check_positive("height of the volume", field.height, " m");
  if (!field.low.allFinite() || !field.high.allFinite() || !((field.high - field.low).minCoeff() > 0))
    throw InputError("field of the volume", "no area", "one that ends after it begins");
  constexpr double most_squares_away = 1e8;  // which are counted by whole numbers
  const double farthest = std::max(field.low.cwiseAbs().maxCoeff(), field.high.cwiseAbs().maxCoeff());
  if (farthest > most_squares_away * static_cast<double>(field.patches.front().size.minCoeff()))
    throw InputError("field of the volume", number_text(farthest) + " m from the origin", "one nearer to it");
  if (field.sway.field.values.empty() || field.sway.field.plane.heights.size() != 1)
    throw InputError("sway of the volume of the page", "a field of other than one layer", "one layer");
  const double share = share_of_page(field);
  if (share < least_share) {
    const Vector2d size = field.high - field.low;
    throw InputError(
        "volume of the page",
        number_text(size.x()) + " x " + number_text(size.y()) + " m, of which it can show " +
            number_text(std::round(1e4 * share) / 100) + " % of the strands",
        "at most " + number_text(std::floor(size.x() * size.y() * share / least_share * 100) / 100) + " m^2");
  }
}

// Both colours in 24 bits each, which a float holds.
float packed(const Vector3f& color) {
  std::uint32_t word = 0;
  for (int i = 0; i < 3; ++i)
    word = word << 8U | static_cast<std::uint32_t>(std::lround(255 * std::clamp(color[i], 0.0F, 1.0F)));
  return static_cast<float>(word);
}

void add_squares(const StrandField& field, Json& document, std::string& bytes) {
  std::vector<float> values;
  for (const PatchSquare& square : squares_of(field)) {
    values.insert(values.end(),
                  {square.corner.x(), square.corner.y(), static_cast<float>(square.variant), 0});
  }
  append_part(values, 4, "squares", document, bytes);
}

void add_strands(const StrandField& field, double share, Json& document, std::string& bytes) {
  const auto wider = static_cast<float>(1 / share);
  std::vector<float> points, strands;
  Json patches = Json::array();
  for (std::size_t variant = 0; variant < field.patches.size(); ++variant) {
    const StrandPatch& patch = field.patches[variant];
    const std::vector<std::size_t> left = strands_left(field, variant, share);
    patches.push_back({{"first_strand", strands.size() / 8}, {"strands", left.size()}});
    for (const std::size_t number : left) {
      const Strand& strand = patch.strands[number];
      const Vector2f& foot = patch.feet[strand.plant];
      strands.insert(strands.end(), {static_cast<float>(points.size() / 4),
                                     static_cast<float>(strand.points.size()), foot.x(), foot.y(),
                                     strand.held, packed(strand.first_color), packed(strand.last_color), 0});
      for (std::size_t i = 0; i < strand.points.size(); ++i) {
        const Vector3f& at = strand.points[i];
        points.insert(points.end(), {at.x(), at.y(), at.z(), wider * strand.widths[i]});
      }
    }
  }
  document["patches"] = std::move(patches);
  append_part(points, 4, "points", document, bytes);
  append_part(strands, 8, "strands", document, bytes);
}

void add_tallness(const StrandField& field, Json& document, std::string& bytes) {
  constexpr double most = 512;
  const Vector2d size = field.high - field.low;
  const double spacing = field.tallness ? std::max(0.02, size.maxCoeff() / (most - 1)) : size.maxCoeff();
  const int columns = 2 + static_cast<int>(size.x() / spacing),
            rows = 2 + static_cast<int>(size.y() / spacing);
  std::vector<std::uint8_t> values(static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns), 255);
  for (std::size_t i = 0; field.tallness && i < values.size(); ++i) {
    const auto column = static_cast<double>(i % static_cast<std::size_t>(columns)),
               row = static_cast<double>(i / static_cast<std::size_t>(columns));
    const double tall = field.tallness(field.low + spacing * Vector2d(column, row));
    check_finite("page: volume", tall);
    values[i] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(tall, 0.0, 1.0)));
  }
  append_part(values, 1, "tallness", document, bytes);
  document["tallness"].update({{"columns", columns}, {"rows", rows}, {"spacing_m", spacing}});
  bytes.resize((bytes.size() + 3) / 4 * 4, 0);
}

void add_sway(const CanopySway& sway, Json& document, std::string& bytes) {
  const TravellingField& field = sway.field;
  const Vec3 lean = 0.5 * mean_at(field, field.ground + sway.height);
  check_finite("page: volume", std::span<const double>(lean.data(), 3));
  document["field"] = axes_json(field.loop, field.plane, field.heading, field.speed);
  append_field(field, 2, "sway", document, bytes);
  document["sway"]["lean_m"] = {lean.x(), lean.y()};
}

}  // namespace

std::vector<PatchSquare> squares_of(const StrandField& field) {
  const Vector2d size = field.patches.front().size.cast<double>();
  const auto first = [&](const Vector2d& at, int i) { return static_cast<int>(std::floor(at[i] / size[i])); };
  std::vector<PatchSquare> squares;
  for (int row = first(field.low, 1); row * size.y() < field.high.y(); ++row) {
    for (int column = first(field.low, 0); column * size.x() < field.high.x(); ++column) {
      squares.push_back({Vector2d(column * size.x(), row * size.y()).cast<float>(),
                         variant_at(field.patches.size(), field.seed, column, row)});
    }
  }
  return squares;
}

double share_of_page(const StrandField& field) {
  double on_patches = 0, of_patches = 0;
  for (const StrandPatch& patch : field.patches) {
    on_patches += static_cast<double>(triangles_of(patch));
    of_patches += static_cast<double>(patch.size.prod());
  }
  const double all = on_patches / of_patches * (field.high - field.low).prod();
  return all > most_triangles_of_volume ? most_triangles_of_volume / all : 1;
}

std::vector<std::size_t> strands_left(const StrandField& field, std::size_t variant, double share) {
  const StrandPatch& patch = field.patches[variant];
  const std::vector<PatchSquare> squares = squares_of(field);
  std::vector<std::size_t> left;
  for (std::size_t i = 0; i < patch.strands.size(); ++i) {
    const bool chosen =
        share >= 1 || static_cast<double>(hash_to_unit(static_cast<std::uint32_t>(i))) < share;
    if (!chosen) continue;
    const Vector2f& foot = patch.feet[patch.strands[i].plant];
    if (std::ranges::any_of(squares, [&](const PatchSquare& square) {
          return square.variant == variant && stands_in(field, square, foot);
        }))
      left.push_back(i);
  }
  return left;
}

std::size_t shown_strands(const StrandField& field, double share) {
  std::vector<std::vector<std::size_t>> left;
  for (std::size_t i = 0; i < field.patches.size(); ++i) left.push_back(strands_left(field, i, share));
  std::size_t count = 0;
  for (const PatchSquare& square : squares_of(field)) {
    const StrandPatch& patch = field.patches[square.variant];
    count += static_cast<std::size_t>(std::ranges::count_if(left[square.variant], [&](std::size_t number) {
      return stands_in(field, square, patch.feet[patch.strands[number].plant]);
    }));
  }
  return count;
}

std::string encode_volume(const StrandField& field, const LoopFacts& facts) {
  check_field(field);
  const double share = share_of_page(field);
  const std::size_t shown = shown_strands(field, share);
  if (shown == 0)
    throw InputError("volume of the page", "no strand that stands in the field", "a larger one");
  Json document = {{"name", facts.name},
                   {"facts", facts_json(facts, field.sway.field.loop.period)},
                   {"low_m", {field.low.x(), field.low.y()}},
                   {"high_m", {field.high.x(), field.high.y()}},
                   {"ground_m", field.sway.field.ground},
                   {"height_m", field.height},
                   {"translucent", field.translucent},
                   {"share", share},
                   {"shown", shown}};
  std::string numbers;
  add_squares(field, document, numbers);
  add_strands(field, share, document, numbers);
  add_tallness(field, document, numbers);
  add_sway(field.sway, document, numbers);
  return page_block("TRMV", document, numbers);
}

std::string encode_volume_page(const StrandField& field, const LoopFacts& facts) {
  return encode_page(encode_volume(field, facts), facts.name);
}

}  // namespace tremula
