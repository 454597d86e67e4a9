#include "tremula/base/error.hpp"
#include "tremula/io/finite.hpp"
#include "tremula/io/glb_builder.hpp"
#include "tremula/io/gltf.hpp"
#include "tremula/io/gltf_parts.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <Eigen/Geometry>

namespace tremula {
namespace {

using namespace gltf;

Json vector_json(const Vec3& v) {
  const Vec3f up = y_up(v.cast<float>());
  return {up.x() + 0.0F, up.y() + 0.0F, up.z() + 0.0F};
}

// Every coordinate in 16 bits.
float step_of(const Surface& surface) {
  float largest = std::numeric_limits<float>::min();
  for (const Vec3f& position : surface.position)
    largest = std::max(largest, position.lpNorm<Eigen::Infinity>());
  return largest / 32767;
}

template <class Storage>
void add_vectors(GlbBuilder& builder, const Surface& surface, const Part& part, const Storage& storage,
                 Json& primitive) {
  Vectors<typename Storage::Position> position(part.vertices.size());
  Vectors<typename Storage::Normal> normal(part.vertices.size());
  for_all(part.vertices.size(), [&](std::size_t i) {
    const std::uint32_t v = part.vertices[i];
    position[i] = stored<typename Storage::Position>(y_up(surface.position[v]), storage.position_unit, 0);
    normal[i] = stored<typename Storage::Normal>(y_up(surface.normal[v]), storage.normal_unit, 0);
  });
  const int id = builder.add_attribute(position);
  add_bounds(builder.accessor(id), position);
  primitive["attributes"] = {
      {"POSITION", id},
      {"NORMAL", builder.add_attribute(normal, std::is_integral_v<typename Storage::Normal>)}};
}

template <class Number>
int add_joints(GlbBuilder& builder, const Rig& rig, const Part& part) {
  std::vector<std::array<Number, 4>> joints(part.vertices.size());
  for (std::size_t i = 0; i < joints.size(); ++i) {
    for (std::size_t n = 0; n < 4; ++n)
      joints[i][n] = static_cast<Number>(rig.shares[part.vertices[i]].joint[n]);
  }
  return builder.add_attribute(joints);
}

Json make_primitive(GlbBuilder& builder, const Surface& surface, const Rig& rig, const Triangles& triangles,
                    float step, bool quantised, int material) {
  const Part part = lay_out(triangles, surface.vertex_count());
  Json primitive = Json::object();
  if (quantised) {
    add_vectors(builder, surface, part, Whole{step, 1.0F / 127}, primitive);
  } else {
    add_vectors(builder, surface, part, Floats{1, 1}, primitive);
  }
  std::vector<std::array<std::uint8_t, 4>> shares;
  for (const std::uint32_t v : part.vertices) shares.push_back(rig.shares[v].share);
  Json& attributes = primitive["attributes"];
  attributes["JOINTS_0"] = rig.joints.size() <= 256 ? add_joints<std::uint8_t>(builder, rig, part)
                                                    : add_joints<std::uint16_t>(builder, rig, part);
  attributes["WEIGHTS_0"] = builder.add_attribute(shares, true);
  add_rest_of_primitive(builder, surface, part, material, primitive);
  return primitive;
}

// From the mesh, in steps, into the frame of each joint at rest; by columns.
int add_bind_matrices(GlbBuilder& builder, const Rig& rig, float step) {
  std::vector<float> matrices;
  for (const RigJoint& joint : rig.joints) {
    const Vec3f at = y_up(joint.position.cast<float>());
    for (int column = 0; column < 3; ++column) {
      for (int row = 0; row < 4; ++row) matrices.push_back(row == column ? step : 0);
    }
    matrices.insert(matrices.end(), {0 - at.x(), 0 - at.y(), 0 - at.z(), 1});
  }
  return builder.add_vectors(matrices, 16);
}

// The keys of a track in the file's axes, for whoever is ahead by some time.
struct Keys {
  std::vector<float> times;  // [s]
  std::vector<StoredTurn> turns;
  std::vector<float> positions;  // (3 a key) of a joint that travels
};

StoredTurn turn_y_up(const StoredTurn& turn) {
  return {turn[0], turn[2], static_cast<std::int16_t>(-turn[1]), turn[3]};
}

Keys keys_of(const RigClip& clip, const JointTrack& track) {
  Keys keys;
  for (std::size_t k = 0; k < track.turn.size(); ++k) {
    const double sample = std::min<double>(static_cast<double>(k) * track.stride, clip.sample_count);
    keys.times.push_back(static_cast<float>(clip.period * sample / clip.sample_count));
    keys.turns.push_back(turn_y_up(track.turn[k]));
    if (track.position.empty()) continue;
    const Vec3f at = y_up(track.position[k]);
    keys.positions.insert(keys.positions.end(), {at.x(), at.y(), at.z()});
  }
  return keys;
}

StoredTurn between(const StoredTurn& a, const StoredTurn& b, double part) {
  const auto read = [](const StoredTurn& t) {
    return Eigen::Quaterniond(t[3], t[0], t[1], t[2]).normalized();
  };
  const Eigen::Vector4d turn = 32767 * read(a).slerp(part, read(b)).coeffs();
  StoredTurn result{};
  for (std::size_t i = 0; i < 4; ++i)
    result[i] = static_cast<std::int16_t>(std::lround(turn[static_cast<Eigen::Index>(i)]));
  return result;
}

// Turned round, with a key where the loop now begins; the first again at the end.
Keys ahead_by(const Keys& keys, double shift) {
  const auto period = static_cast<double>(keys.times.back());
  const double begin = shift - period * std::floor(shift / period);
  if (begin == 0) return keys;
  std::size_t first = 0;  // the key at or before the beginning
  while (first + 2 < keys.times.size() && static_cast<double>(keys.times[first + 1]) <= begin) ++first;
  const bool travels = !keys.positions.empty();
  Keys result;
  const auto add = [&](double time, const StoredTurn& turn, const Vec3f& at) {
    const auto rounded = static_cast<float>(time);
    if (!result.times.empty() && rounded <= result.times.back()) return;
    result.times.push_back(rounded);
    result.turns.push_back(turn);
    if (travels) result.positions.insert(result.positions.end(), {at.x(), at.y(), at.z()});
  };
  const auto place = [&](std::size_t k) {
    return travels ? Vec3f(Eigen::Map<const Vec3f>(&keys.positions[3 * k])) : Vec3f::Zero();
  };
  const auto time = [&](std::size_t k) { return static_cast<double>(keys.times[k]); };
  const double part = (begin - time(first)) / (time(first + 1) - time(first));
  add(0, between(keys.turns[first], keys.turns[first + 1], part),
      static_cast<float>(1 - part) * place(first) + static_cast<float>(part) * place(first + 1));
  const std::size_t count = keys.times.size() - 1;  // the last is the first
  for (std::size_t i = 1; i <= count; ++i) {
    const std::size_t k = (first + i) % count;
    const double at = time(k) - begin;
    add(at > 0 ? at : at + period, keys.turns[k], place(k));
  }
  if (result.times.back() < keys.times.back()) {
    add(period, result.turns.front(),
        travels ? Vec3f(Eigen::Map<const Vec3f>(result.positions.data())) : Vec3f::Zero());
  } else {
    result.times.back() = keys.times.back();
    result.turns.back() = result.turns.front();
    if (travels) std::copy_n(result.positions.begin(), 3, result.positions.end() - 3);
  }
  return result;
}

// Times that have been written, by what they come from.
using WrittenTimes = std::map<std::vector<float>, int>;

int add_times(GlbBuilder& builder, const std::vector<float>& times, WrittenTimes& written) {
  const auto [it, is_new] = written.try_emplace(times, 0);
  if (!is_new) return it->second;
  it->second = builder.add_numbers(times);
  builder.accessor(it->second)["min"] = {times.front()};
  builder.accessor(it->second)["max"] = {times.back()};
  return it->second;
}

// A channel for every joint of every instance; those that move at the same time share their keys.
Json make_animation(GlbBuilder& builder, const Rig& rig, const RigClip& clip,
                    const std::vector<Instance>& instances, WrittenTimes& written) {
  Json channels = Json::array(), samplers = Json::array();
  struct Samplers {
    std::size_t turn, position;
  };
  std::map<std::pair<double, std::size_t>, Samplers> shared;
  const auto add_sampler = [&](int input, int output) {
    samplers.push_back({{"input", input}, {"output", output}, {"interpolation", "LINEAR"}});
    return samplers.size() - 1;
  };
  for (std::size_t i = 0; i < instances.size(); ++i) {
    for (std::size_t j = 1; j < rig.joints.size(); ++j) {
      const auto [it, is_new] = shared.try_emplace({instances[i].time_shift, j});
      if (is_new) {
        const Keys keys = ahead_by(keys_of(clip, clip.tracks[j]), instances[i].time_shift);
        const int input = add_times(builder, keys.times, written);
        it->second.turn = add_sampler(input, builder.add_turns(keys.turns));
        if (!keys.positions.empty())
          it->second.position = add_sampler(input, builder.add_vectors(keys.positions, 3));
      }
      const std::size_t node = i * (1 + rig.joints.size()) + 1 + j;
      channels.push_back({{"sampler", it->second.turn}, {"target", {{"node", node}, {"path", "rotation"}}}});
      if (!clip.tracks[j].position.empty()) {
        channels.push_back(
            {{"sampler", it->second.position}, {"target", {{"node", node}, {"path", "translation"}}}});
      }
    }
  }
  return {{"name", clip.name}, {"channels", std::move(channels)}, {"samplers", std::move(samplers)}};
}

void place_instance(const Instance& instance, Json& node) {
  if (!instance.position.isZero(0))
    node["translation"] = {instance.position.x(), instance.position.z(), 0 - instance.position.y()};
  if (instance.turn != 0) node["rotation"] = {0, std::sin(instance.turn / 2), 0, std::cos(instance.turn / 2)};
  if (instance.scale != 1) node["scale"] = {instance.scale, instance.scale, instance.scale};
}

// The skinned mesh and then its joints, for every instance.
Json make_nodes(const Rig& rig, const std::vector<Instance>& instances, const std::string& name) {
  std::vector<std::vector<std::size_t>> children(rig.joints.size());
  for (std::size_t j = 1; j < rig.joints.size(); ++j) children[index_of(rig.joints[j].parent)].push_back(j);
  Json nodes = Json::array();
  for (std::size_t i = 0; i < instances.size(); ++i) {
    std::string number;
    if (i > 0) number.append(" ").append(std::to_string(i + 1));
    const std::size_t first = nodes.size() + 1;
    Json mesh = {{"name", name + number}, {"mesh", 0}, {"skin", i}};
    if (instances[i].time_shift != 0)
      mesh["extras"] = {{"tremula", {{"time_shift_s", instances[i].time_shift}}}};
    nodes.push_back(std::move(mesh));
    for (std::size_t j = 0; j < rig.joints.size(); ++j) {
      const RigJoint& joint = rig.joints[j];
      Json node = {{"name", joint.name + number}};
      if (j == 0) {
        place_instance(instances[i], node);
      } else {
        node["translation"] = vector_json(joint.position - rig.joints[index_of(joint.parent)].position);
      }
      for (const std::size_t child : children[j]) node["children"].push_back(first + child);
      nodes.push_back(std::move(node));
    }
  }
  return nodes;
}

void check_finite_shapes(const RigShapes& shapes) {
  if (!shapes.turn.allFinite() || !shapes.travel.allFinite() || !shapes.coordinates.allFinite())
    throw Error("glTF: a shape of the rig is not finite");
}

void check_fit(const Loop& loop, const Rig& rig) {
  const Surface& surface = *loop.rest;
  if (std::all_of(surface.parts.begin(), surface.parts.end(),
                  [](const SurfacePart& part) { return part.triangles.empty(); }))
    throw Error("glTF: the surface has no triangles");
  check_finite("glTF: positions of the surface", surface.position);
  check_finite("glTF: normals of the surface", surface.normal);
  check_instances(loop.instances, loop.repeats);
  if (rig.shares.size() != surface.vertex_count()) {
    throw Error("glTF: the rig has " + std::to_string(rig.shares.size()) + " vertices, wanted " +
                std::to_string(surface.vertex_count()));
  }
  if (rig.joints.empty() || rig.joints.size() > 65535) {
    throw Error("glTF: the rig has " + std::to_string(rig.joints.size()) + " joints, wanted 1 to 65535");
  }
  check_finite_shapes(rig.shapes);
  for (const RigClip& clip : rig.clips) {
    if (clip.tracks.size() != rig.joints.size()) {
      throw Error("glTF: clip '" + clip.name + "' has " + std::to_string(clip.tracks.size()) +
                  " tracks, wanted one for each joint");
    }
  }
}

Json frequencies_of(const Loop& loop) {
  Json frequencies = Json::array();
  for (std::size_t c = 0; c < loop.kind.size(); ++c) {
    if (loop.kind[c] == ShapeKind::mode) frequencies.push_back(loop.frequency[static_cast<Eigen::Index>(c)]);
  }
  return frequencies;
}

// Vectors of all joints under each shape, (joints x shapes) in whole numbers of a step for each shape.
Json add_shape_vectors(GlbBuilder& builder, const Eigen::MatrixXf& of_joints) {
  Json steps = Json::array();
  Vectors<std::int16_t> all;
  for (Eigen::Index c = 0; c < of_joints.cols(); ++c) {
    const float largest = of_joints.col(c).lpNorm<Eigen::Infinity>();
    const float step = largest > 0 ? largest / 32767 : 1;
    steps.push_back(step);
    for (Eigen::Index row = 0; row < of_joints.rows(); row += 3)
      all.push_back(stored<std::int16_t>(y_up(of_joints.col(c).segment<3>(row)), step, 0));
  }
  return {{"accessor", builder.add_attribute(all)}, {"steps", std::move(steps)}};
}

Json add_shapes(GlbBuilder& builder, const RigShapes& shapes) {
  Json kinds = Json::array(), frequencies = Json::array();
  for (std::size_t c = 0; c < shapes.kind.size(); ++c) {
    kinds.push_back(name_of(shapes.kind[c]));
    frequencies.push_back(shapes.frequency[static_cast<Eigen::Index>(c)]);
  }
  // Of every shape as parts of how far it goes.
  const Eigen::VectorXd size = shapes.coordinates.cwiseAbs().colwise().maxCoeff().cwiseMax(1e-300);
  std::vector<float> weights;
  for (Eigen::Index p = 0; p < shapes.coordinates.rows(); ++p) {
    for (Eigen::Index c = 0; c < shapes.coordinates.cols(); ++c)
      weights.push_back(static_cast<float>(shapes.coordinates(p, c) / size[c]));
  }
  const Eigen::VectorXf unit = size.cast<float>();
  return {{"clip", shapes.clip},
          {"kinds", std::move(kinds)},
          {"frequencies_hz", std::move(frequencies)},
          {"weights", builder.add_numbers(weights)},
          {"turns", add_shape_vectors(builder, shapes.turn * unit.asDiagonal())},
          {"travels", add_shape_vectors(builder, shapes.travel * unit.asDiagonal())}};
}

Json make_extras(const Loop& loop, const Rig& rig) {
  const Vec3 low(rig.low.x(), rig.low.z(), -rig.high.y()), high(rig.high.x(), rig.high.z(), -rig.low.y());
  const auto numbers = [](const Vec3& v) { return Json({v.x(), v.y(), v.z()}); };
  Json clips = Json::array();
  for (const RigClip& clip : rig.clips)
    clips.push_back({{"name", clip.name}, {"wind_speed_m_s", clip.wind_speed}});
  return {{"period_s", loop.period},
          {"repeats", loop.repeats},
          {"frames_per_second", loop.facts.frames_per_second},
          {"wind_speed_m_s", loop.facts.wind_speed},
          {"heading_deg", loop.facts.heading},
          {"seed", loop.facts.seed},
          {"frequencies_hz", frequencies_of(loop)},
          {"clips", std::move(clips)},
          {"bounds_m", {numbers(low), numbers(high)}},
          {"largest_error_m", rig.largest_error}};
}

}  // namespace

std::string encode_glb(const Loop& loop, const Rig& rig, const GltfOptions& options) {
  check_fit(loop, rig);
  const Surface& surface = *loop.rest;
  const bool quantised = options.compression != MeshCompression::none;
  const float step = quantised ? step_of(surface) : 1;

  GlbBuilder builder(options.compression);
  Json primitives = Json::array(), materials = Json::array();
  for (const SurfacePart& part : surface.parts) {
    if (part.triangles.empty()) continue;
    primitives.push_back(make_primitive(builder, surface, rig, part.triangles, step, quantised,
                                        static_cast<int>(materials.size())));
    materials.push_back(make_material(part.material));
  }
  const int bind_matrices = add_bind_matrices(builder, rig, step);
  const std::size_t stride = 1 + rig.joints.size();
  Json skins = Json::array(), roots = Json::array();
  for (std::size_t i = 0; i < loop.instances.size(); ++i) {
    Json joints = Json::array();
    for (std::size_t j = 0; j < rig.joints.size(); ++j) joints.push_back(i * stride + 1 + j);
    skins.push_back(
        {{"inverseBindMatrices", bind_matrices}, {"skeleton", i * stride + 1}, {"joints", joints}});
    roots.push_back(i * stride);
    roots.push_back(i * stride + 1);
  }
  Json document = {
      {"asset", {{"version", "2.0"}, {"generator", "tremula " TREMULA_VERSION}}},
      {"scene", 0},
      {"scenes", Json::array({{{"name", loop.facts.name},
                               {"nodes", std::move(roots)},
                               {"extras", {{"tremula", make_extras(loop, rig)}}}}})},
      {"nodes", make_nodes(rig, loop.instances, loop.facts.name)},
      {"meshes", Json::array({{{"name", loop.facts.name}, {"primitives", std::move(primitives)}}})},
      {"materials", std::move(materials)},
      {"skins", std::move(skins)}};
  if (quantised) {
    Json extensions = Json::array({"KHR_mesh_quantization"});
    if (options.compression == MeshCompression::meshopt) extensions.push_back("EXT_meshopt_compression");
    document["extensionsUsed"] = document["extensionsRequired"] = extensions;
  }
  if (options.shapes && rig.shapes.clip >= 0) {
    document["scenes"][0]["extras"]["tremula"]["shapes"] = add_shapes(builder, rig.shapes);
  }
  WrittenTimes written;
  for (const RigClip& clip : rig.clips) {
    if (rig.joints.size() > 1)
      document["animations"].push_back(make_animation(builder, rig, clip, loop.instances, written));
  }
  return std::move(builder).pack(document);
}

}  // namespace tremula
