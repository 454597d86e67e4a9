#include "tremula/io/drift_page.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/io/finite.hpp"
#include "tremula/io/html.hpp"
#include "tremula/io/page_block.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <span>
#include <utility>
#include <vector>

namespace tremula {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t path_words = 16, turn_words = 8;

std::size_t words_of(DriftForm form) { return path_words + (has_turns(form) ? turn_words : 0); }

double bytes_of(const DriftPaths& paths, std::size_t stays) {
  return static_cast<double>(sizeof(paths.off_line[0]) * paths.off_line.size() +
                             sizeof(std::uint32_t) * words_of(paths.form) * stays);
}

void check_drift_of_page(const Drift& drift, const DriftPaths& paths, double share, const DriftLook& look) {
  if (paths.paths.empty()) throw InputError("drift of the page", "nothing that drifts", "one flake or more");
  if (look.materials.empty()) throw InputError("look of the drift", "no material", "one or more");
  const double bytes = bytes_of(paths, paths.paths.size());
  if (bytes > 1.25 * most_bytes_of_drift) {
    throw InputError("drift of the page", number_text(std::round(bytes / 1e6)) + " MB of paths",
                     "at most " + number_text(most_bytes_of_drift / 1e6) + ": a share of them");
  }
  check_finite("page: drift", share);
  for (const Vec3& corner : {drift.low, drift.high})
    check_finite("page: drift", std::span<const double>(corner.data(), 3));
}

std::vector<std::uint32_t> bits_of(std::span<const float> values) {
  check_finite("page: drift", values);
  std::vector<std::uint32_t> words;
  for (const float value : values) words.push_back(std::bit_cast<std::uint32_t>(value));
  return words;
}

std::vector<std::uint32_t> words_of(const DriftStay& stay, const DriftPaths& paths) {
  const DriftPath& path = paths.paths[stay.path];
  std::vector<float> values = {
      stay.taken,        stay.begin,     stay.end,  stay.birth,        path.start.x(),
      path.start.y(),    path.start.z(), path.unit, path.velocity.x(), path.velocity.y(),
      path.velocity.z(), path.air_time,  path.size, path.fall_speed,   path.lying_time > 0 ? 1.0F : 0.0F};
  std::vector<std::uint32_t> words = bits_of(values);
  words.push_back(static_cast<std::uint32_t>(path.first));
  if (!has_turns(paths.form)) return words;
  const DriftTurns turns = turns_of(paths.form, path);
  values = {turns.phase, turns.rate,  turns.yaw,  turns.yaw_rate,
            turns.swing, turns.glide, turns.lean, turns.tumbles ? 1.0F : 0.0F};
  std::ranges::copy(bits_of(values), std::back_inserter(words));
  return words;
}

// The meshes of all materials; says of each material which are its own.
void add_stays(const DriftPaths& paths, const DriftLook& look, Json& document, std::string& bytes) {
  std::vector<std::uint32_t> first{0};
  std::vector<DriftStay> stays;
  Json materials = Json::array();
  const std::vector<DriftStays> shared = share_meshes(paths, look.materials.size());
  for (std::size_t i = 0; i < shared.size(); ++i) {
    const SurfaceMaterial& material = look.materials[i];
    materials.push_back({{"name", material.name},
                         {"color_srgb", {material.color.x(), material.color.y(), material.color.z()}},
                         {"roughness", material.roughness},
                         {"meshes", shared[i].mesh_count()}});
    const auto before = static_cast<std::uint32_t>(stays.size());
    for (std::size_t m = 0; m < shared[i].mesh_count(); ++m) first.push_back(before + shared[i].first[m + 1]);
    stays.insert(stays.end(), shared[i].stays.begin(), shared[i].stays.end());
  }
  document["materials"] = std::move(materials);
  document["meshes"] = {{"count", first.size() - 1}, {"first_byte", bytes.size()}};
  append_numbers(bytes, first);
  const std::size_t width = words_of(paths.form);
  std::vector<std::uint32_t> words(width * stays.size());
  for (std::size_t s = 0; s < stays.size(); ++s) {
    const std::vector<std::uint32_t> of_stay = words_of(stays[s], paths);
    for (std::size_t w = 0; w < width; ++w) words[w * stays.size() + s] = of_stay[w];
  }
  document["stays"] = {{"count", stays.size()}, {"words", width}, {"first_byte", bytes.size()}};
  append_numbers(bytes, words);
}

Json mesh_json(const DriftMesh& mesh) {
  Json vertices = Json::array();
  for (std::size_t v = 0; v < mesh.position.size(); ++v) {
    const auto &at = mesh.position[v], &normal = mesh.normal[v];
    vertices.push_back({at.x(), at.y(), at.z(), normal.x(), normal.y(), normal.z()});
  }
  return {{"vertices", std::move(vertices)}, {"triangles", mesh.triangles}};
}

const char* name_of(DriftForm form) {
  switch (form) {
    case DriftForm::flake:
      return "flake";
    case DriftForm::drop:
      return "drop";
    case DriftForm::leaf:
      return "leaf";
    case DriftForm::seed:
      break;
  }
  return "seed";
}

}  // namespace

double share_of_page(const DriftPaths& paths) {
  // Some paths are cut where they stay longer than a mesh is free; they are few.
  return std::min(1.0, most_bytes_of_drift / bytes_of(paths, paths.paths.size()));
}

std::string encode_drift(const Drift& drift, const DriftPaths& paths, double share, const DriftLook& look,
                         const LoopFacts& facts) {
  check_drift_of_page(drift, paths, share, look);
  Json document = {{"name", facts.name},
                   {"facts", facts_json(facts, paths.loop.period)},
                   {"form", name_of(paths.form)},
                   {"low_m", {drift.low.x(), drift.low.y(), drift.low.z()}},
                   {"high_m", {drift.high.x(), drift.high.y(), drift.high.z()}},
                   {"ground_m", paths.ground},
                   {"step_s", static_cast<float>(paths.step)},
                   {"settling_s", settling_time},
                   {"seen", std::round(mean_seen(paths))},
                   {"share", share},
                   {"mesh", mesh_json(mesh_of(paths.form))}};
  std::string numbers;
  add_stays(paths, look, document, numbers);
  document["samples"] = {{"count", paths.off_line.size()}, {"first_byte", numbers.size()}};
  append_numbers(numbers, paths.off_line);
  return page_block("TRMD", document, numbers);
}

std::string encode_drift_page(const Drift& drift, const DriftPaths& paths, double share,
                              const DriftLook& look, const LoopFacts& facts) {
  return encode_page(encode_drift(drift, paths, share, look, facts), facts.name);
}

}  // namespace tremula
