#include "tremula/io/impression_page.hpp"

#include "tremula/base/error.hpp"
#include "tremula/geometry/quadric_mesh.hpp"
#include "tremula/io/html.hpp"
#include "tremula/io/page_block.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

namespace tremula {
namespace {

using Json = nlohmann::ordered_json;

struct Fineness {
  int rings, sides;

  std::size_t triangles() const { return 2 * static_cast<std::size_t>((rings - 1) * sides); }
};
constexpr std::array<Fineness, 4> finenesses{{{13, 20}, {10, 14}, {7, 10}, {5, 8}}};
constexpr std::size_t comfortable_triangles = 2'000'000;

template <class Matrix>
Json rows(const Matrix& m) {
  Json list = Json::array();
  for (Eigen::Index i = 0; i < m.rows(); ++i) {
    for (Eigen::Index k = 0; k < m.cols(); ++k) list.push_back(m(i, k));
  }
  return list;
}

// (vectors x 3)
std::vector<float> flat(const std::vector<Eigen::Vector3f>& vectors) {
  std::vector<float> values;
  values.reserve(3 * vectors.size());
  for (const Eigen::Vector3f& v : vectors) values.insert(values.end(), v.data(), v.data() + 3);
  return values;
}

void check_field(const TravellingField& field, const TravellingField& other) {
  const bool fit = field.plane.heights.size() == 1 && field.loop.period == other.loop.period &&
                   field.loop.sample_count == other.loop.sample_count && field.speed == other.speed &&
                   field.heading == other.heading && field.plane.columns == other.plane.columns &&
                   field.plane.first_column == other.plane.first_column &&
                   field.plane.spacing == other.plane.spacing;
  if (!fit)
    throw InputError("motion of impressionist trees of the page", "fields on other planes or in layers",
                     "sway and tremble on one plane of one layer");
}

void add_motion(const ImpressionMotion& motion, Json& document, std::string& bytes) {
  TravellingField still;
  still.loop.sample_count = 1;
  still.values.resize(1);
  const TravellingField* sway = motion.sway.get();
  const TravellingField* tremble = motion.tremble.get();
  const TravellingField& field = sway != nullptr ? *sway : tremble != nullptr ? *tremble : still;
  for (const TravellingField* each : {sway, tremble}) {
    if (each != nullptr) check_field(*each, field);
  }
  document["field"] = axes_json(field.loop, field.plane, motion.heading, field.speed);
  append_field(sway != nullptr ? *sway : still, 2, "sway", document, bytes);
  append_field(tremble != nullptr ? *tremble : still, 4, "tremble", document, bytes);
  const TrunkCurve curve = trunk_curve(motion);
  Json knots = Json::array(), slopes = Json::array();
  for (const Eigen::Vector4f& knot : curve.knots) knots.push_back(rows(knot));
  for (const Eigen::Vector4f& slope : curve.slopes) slopes.push_back(rows(slope));
  document["curve"] = {{"step_m", curve.step}, {"knots", std::move(knots)}, {"slopes", std::move(slopes)}};
}

void add_copies(const std::vector<Instance>& instances, Json& document, std::string& bytes) {
  std::vector<float> words;
  for (std::size_t i = 0; i < instances.size(); ++i) {
    const Instance& at = instances[i];
    for (const double word : {at.position.x(), at.position.y(), at.position.z(), at.scale, std::cos(at.turn),
                              std::sin(at.turn), at.time_shift})
      words.push_back(static_cast<float>(word));
    words.push_back(texture_shift(i));
  }
  append_part(words, 8, "copies", document, bytes);
}

void add_mesh(const ImpressionMesh& mesh, Json& document, std::string& bytes) {
  append_part(flat(mesh.positions), 3, "positions", document, bytes);
  append_part(flat(mesh.normals), 3, "normals", document, bytes);
  append_part(mesh.quadric, 1, "quadrics", document, bytes);
  append_part(mesh.triangles, 3, "triangles", document, bytes);
}

void add_paint(const ImpressionistTree& tree, Json& document) {
  Json paints = Json::array();
  const std::vector<Quadric> quadrics = quadrics_of(tree);
  for (std::size_t i = 0; i < quadrics.size(); ++i) {
    const QuadricPaint paint = paint_of(quadrics[i], i, tree.seed);
    paints.push_back({{"centre_m", rows(quadrics[i].centre.cast<float>().eval())},
                      {"turn", rows(paint.turn)},
                      {"offset_m", rows(paint.offset)},
                      {"root", rows(paint.root)},
                      {"sign", rows(paint.sign)}});
  }
  document["paint"] = std::move(paints);
  document["bark_srgb"] = rows(tree.bark_color);
  document["leaf_srgb"] = rows(tree.leaf_color);
  document["leaf_size_m"] = tree.leaf_size;
  document["texture"] = {{"octaves", tree.texture.octaves},
                         {"wavelength_m", tree.texture.wavelength},
                         {"stretch", tree.texture.stretch},
                         {"falloff", tree.texture.falloff}};
  const TextureLevels levels = levels_of(tree.texture);
  document["cover"] = {{"middle_threshold", threshold_for(levels, tree.cover.middle)},
                       {"edge_threshold", threshold_for(levels, tree.cover.edge)},
                       {"softness", tree.cover.softness},
                       {"first_decile", threshold_for(levels, 0.9F)},
                       {"ninth_decile", threshold_for(levels, 0.1F)}};
}

// Where the trees stand, with room for the height of each.
Eigen::AlignedBox3d bounds_of(const ImpressionMesh& mesh, const std::vector<Instance>& instances) {
  Eigen::AlignedBox3d tree, all;
  for (const Eigen::Vector3f& place : mesh.positions) tree.extend(place.cast<double>());
  for (const Instance& at : instances) {
    for (const auto corner : {Eigen::AlignedBox3d::BottomLeftFloor, Eigen::AlignedBox3d::BottomRightFloor,
                              Eigen::AlignedBox3d::TopLeftFloor, Eigen::AlignedBox3d::TopRightCeil})
      all.extend(at.position + at.scale * (at.rotation() * tree.corner(corner)));
  }
  return all;
}

}  // namespace

ImpressionMesh mesh_for_page(const ImpressionistTree& tree, std::size_t copies) {
  check_tree(tree);
  if (copies == 0) throw InputError("impressionist trees of the page", "none", "one or more");
  const std::vector<Quadric> quadrics = quadrics_of(tree);
  const std::size_t least = finenesses.back().triangles() * quadrics.size();  // of a tree
  if (const std::size_t most = most_triangles_of_impressions / least; copies > most) {
    throw InputError("impressionist trees of the page",
                     std::to_string(copies) + " of " + std::to_string(quadrics.size()) + " quadrics",
                     "at most " + std::to_string(most) + " such trees: a smaller area or a lower density");
  }
  Fineness taken = finenesses.front();
  for (std::size_t i = 1;
       i < finenesses.size() && taken.triangles() * quadrics.size() * copies > comfortable_triangles; ++i)
    taken = finenesses[i];
  ImpressionMesh mesh;
  for (std::size_t q = 0; q < quadrics.size(); ++q) {
    const QuadricMesh one = mesh_of(quadrics[q], taken.rings, taken.sides);
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), one.positions.begin(), one.positions.end());
    mesh.normals.insert(mesh.normals.end(), one.normals.begin(), one.normals.end());
    mesh.quadric.insert(mesh.quadric.end(), one.positions.size(), static_cast<std::uint32_t>(q));
    for (const std::uint32_t corner : one.triangles) mesh.triangles.push_back(first + corner);
  }
  return mesh;
}

std::string encode_impressions(const ImpressionistTree& tree, const std::vector<Instance>& instances,
                               const ImpressionMotion& motion, const LoopFacts& facts) {
  const ImpressionMesh mesh = mesh_for_page(tree, instances.size());
  check_instances(instances);
  check_motion(motion);
  const double period = motion.sway      ? motion.sway->loop.period
                        : motion.tremble ? motion.tremble->loop.period
                                         : 0;
  const Eigen::AlignedBox3d box = bounds_of(mesh, instances);
  Json document = {{"name", facts.name},
                   {"facts", facts_json(facts, period)},
                   {"low_m", rows(box.min())},
                   {"high_m", rows(box.max())}};
  std::string numbers;
  add_copies(instances, document, numbers);
  add_mesh(mesh, document, numbers);
  add_paint(tree, document);
  add_motion(motion, document, numbers);
  return page_block("TRMI", document, numbers);
}

std::string encode_impressions_page(const ImpressionistTree& tree, const std::vector<Instance>& instances,
                                    const ImpressionMotion& motion, const LoopFacts& facts) {
  return encode_page(encode_impressions(tree, instances, motion, facts), facts.name);
}

}  // namespace tremula
