#include "tremula/io/grass_page.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/finite.hpp"
#include "tremula/io/html.hpp"
#include "tremula/io/page_block.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

namespace tremula {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_kinds = 8, farthest_stem = 8191;
constexpr double full_word = 65535, full_signed = 32767;

// From `low` in `count` steps.
struct Steps {
  double low = 0, step = 0;

  Steps(std::span<const float> values, double count, bool from_zero) {
    const auto [least, most] = std::ranges::minmax(values);
    low = from_zero ? 0 : static_cast<double>(least);
    step = (static_cast<double>(most) - low) / count;
  }
  std::uint32_t of(float value) const {
    return step > 0 ? static_cast<std::uint32_t>(std::lround((static_cast<double>(value) - low) / step)) : 0;
  }
};

// In 2^bits parts of a turn.
std::uint32_t turn_of(float angle, unsigned bits) {
  const double parts = std::ldexp(1, static_cast<int>(bits));
  const double turns = static_cast<double>(angle) / (2 * std::numbers::pi);
  return static_cast<std::uint32_t>(std::lround((turns - std::floor(turns)) * parts)) & ((1U << bits) - 1);
}

std::int16_t in_steps(float value, double step) {
  if (step == 0) return 0;
  return static_cast<std::int16_t>(
      std::clamp(std::round(static_cast<double>(value) / step), -full_signed, full_signed));
}

void check_grass(const GrassInWind& grass) {
  const Meadow& meadow = grass.meadow;
  check_blades_of_page(meadow.size());
  if (grass.way != GrassMotion::looked_up)
    throw InputError("blades of the page", "an oscillator each", "blades that look their motion up");
  if (meadow.species.kinds.size() > most_kinds) {
    throw InputError("kinds of blades of the page", std::to_string(meadow.species.kinds.size()),
                     "at most " + std::to_string(most_kinds));
  }
  for (const auto* values : {&meadow.x, &meadow.y, &meadow.z, &meadow.length, &meadow.width, &meadow.azimuth,
                             &meadow.facing, &meadow.attached})
    check_finite("page: blades", std::span<const float>(*values));
}

// How many blades before each its stem is; 0 where it stands on the ground.
std::vector<std::uint32_t> distances_to_stems(const Meadow& meadow) {
  std::vector<std::uint32_t> distances(meadow.size(), 0);
  std::size_t stem = 0;
  for (std::size_t i = 0; i < meadow.size(); ++i) {
    if (meadow.species.kinds[meadow.kind[i]].form == BladeForm::stem) stem = i;
    if (meadow.attached[i] < 0) continue;
    if (i - stem > farthest_stem) {
      throw InputError("blades on a stem of the page", std::to_string(i - stem),
                       "at most " + std::to_string(farthest_stem));
    }
    distances[i] = static_cast<std::uint32_t>(i - stem);
  }
  return distances;
}

void add_blades(const Meadow& meadow, Json& document, std::string& bytes) {
  const Steps x(meadow.x, full_word, false), y(meadow.y, full_word, false), z(meadow.z, full_word, false),
      length(meadow.length, full_word, true), width(meadow.width, 255, true);
  const std::vector<std::uint32_t> stems = distances_to_stems(meadow);
  const std::size_t n = meadow.size();
  std::vector<std::uint32_t> words(4 * n);
  for (std::size_t i = 0; i < n; ++i) {
    const float where = meadow.attached[i];
    const auto attached =
        where < 0 ? 0U : 1U + static_cast<std::uint32_t>(std::lround(std::min(where, 1.0F) * 1022));
    words[i] = x.of(meadow.x[i]) | y.of(meadow.y[i]) << 16U;
    words[n + i] = z.of(meadow.z[i]) | length.of(meadow.length[i]) << 16U;
    words[2 * n + i] = turn_of(meadow.azimuth[i], 14) | turn_of(meadow.facing[i], 10) << 14U |
                       width.of(meadow.width[i]) << 24U;
    words[3 * n + i] = attached | std::uint32_t{meadow.kind[i]} << 10U |
                       std::uint32_t{meadow.trajectory[i]} << 13U |
                       std::uint32_t{meadow.frequency_class[i]} << 17U | stems[i] << 19U;
  }
  document["blades"] = {{"count", n},
                        {"first_byte", bytes.size()},
                        {"low_m", {x.low, y.low, z.low}},
                        {"step_m", {x.step, y.step, z.step}},
                        {"length_step_m", length.step},
                        {"width_step_m", width.step}};
  append_numbers(bytes, words);
}

// What a make follows; the number of its response, -1 where it is stiff.
Json add_response(const GrassInWind::Follows& follows, int& responses, std::string& bytes) {
  if (follows.angle.empty()) return {{"response", -1}, {"lean_rad", 0}, {"per_length", 0}, {"step_rad", 0}};
  double most = 0;
  for (const auto& angles : follows.angle) {
    check_finite("page: responses", std::span<const float>(angles));
    most =
        std::max({most, std::abs(static_cast<double>(angles[0])), std::abs(static_cast<double>(angles[1]))});
  }
  const double step = most / full_signed;
  std::vector<std::int16_t> numbers;
  numbers.reserve(2 * follows.angle.size());
  for (const auto& [along, across] : follows.angle) {
    numbers.push_back(in_steps(along, step));
    numbers.push_back(in_steps(across, step));
  }
  append_numbers(bytes, numbers);
  return {{"response", responses++},
          {"lean_rad", follows.lean},
          {"per_length", follows.per_length},
          {"step_rad", step}};
}

Json skin_json(const BladeSkin& skin, const std::vector<double>& joints) {
  Json vertices = Json::array();
  for (const BladeVertex& v : skin.vertices) {
    vertices.push_back({v.joint, v.across, v.out, v.normal_across, v.normal_out, v.u,
                        joints[static_cast<std::size_t>(v.joint)]});
  }
  return {{"vertices", std::move(vertices)}, {"triangles", skin.triangles}};
}

Json kind_json(const BladeKind& kind) {
  const std::vector<double> joints = joints_of(kind);
  Json shares = Json::array();
  for (std::size_t i = 0; i + 1 < joints.size(); ++i)
    shares.push_back(static_cast<float>(joints[i + 1] - joints[i]));
  const BladeSkin skin = skin_of(kind);
  return {{"name", kind.material},
          {"color_srgb", {kind.color.x(), kind.color.y(), kind.color.z()}},
          {"two_sided", skin.two_sided},
          {"shares", std::move(shares)},
          {"skin", skin_json(skin, joints)}};
}

void add_kinds(const GrassInWind& grass, Json& document, std::string& bytes) {
  Json kinds = Json::array();
  int responses = 0;
  const std::size_t first_response = bytes.size();
  for (std::size_t k = 0; k < grass.bends.size(); ++k) {
    kinds.push_back(kind_json(grass.meadow.species.kinds[k]));
    Json makes = Json::array();
    for (std::size_t c = 0; c < frequency_classes; ++c)
      makes.push_back(add_response(grass.follows[k * frequency_classes + c], responses, bytes));
    kinds.back()["makes"] = std::move(makes);
  }
  const std::size_t first_bend = bytes.size();
  std::size_t entries = 0;
  for (std::size_t k = 0; k < grass.bends.size(); ++k) {
    const BendTable& table = grass.bends[k];
    std::vector<std::int16_t> numbers;
    numbers.reserve(12 * table.directions.size());
    for (const auto& entry : table.directions) {
      check_finite("page: bends", std::span<const float>(entry));
      for (const float number : entry) numbers.push_back(in_steps(number, 1 / full_signed));
    }
    kinds[k]["bends"] = {{"first", entries}, {"in_plane", table.in_plane}, {"across", table.across}};
    entries += table.directions.size();
    append_numbers(bytes, numbers);
  }
  document["responses"] = {{"count", responses}, {"first_byte", first_response}};
  document["bends"] = {{"count", entries}, {"first_byte", first_bend}};
  document["kinds"] = std::move(kinds);
}

}  // namespace

void check_blades_of_page(std::size_t count) {
  if (count <= most_blades_of_page) return;
  throw InputError("blades of the page", std::to_string(count),
                   "at most " + std::to_string(most_blades_of_page) + ": a smaller field or a lower density");
}

std::string encode_grass(const GrassInWind& grass, const LoopFacts& facts) {
  check_grass(grass);
  Json document = {{"name", facts.name},
                   {"facts", facts_json(facts, grass.loop.period)},
                   {"height_m", grass.meadow.height},
                   {"field", axes_json(grass.loop, grass.plane, grass.heading, grass.speed)}};
  std::string numbers;
  add_blades(grass.meadow, document, numbers);
  add_kinds(grass, document, numbers);
  return page_block("TRMG", document, numbers);
}

std::string encode_grass_page(const GrassInWind& grass, const LoopFacts& facts) {
  return encode_page(encode_grass(grass, facts), facts.name);
}

}  // namespace tremula
