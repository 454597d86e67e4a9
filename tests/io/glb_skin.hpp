// Plays the bones of a .glb by the specification of glTF 2.0, knowing nothing of the writer.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "io/glb_file.hpp"

namespace tremula::test {

class SkinPlayer {
 public:
  explicit SkinPlayer(const Glb& glb, std::size_t clip = 0, std::size_t skin = 0) : glb_(glb), skin_(skin) {
    const nlohmann::json& animation = glb.document["animations"].at(clip);
    for (const nlohmann::json& channel : animation["channels"]) {
      const nlohmann::json& sampler = animation["samplers"].at(channel["sampler"].get<std::size_t>());
      EXPECT_EQ(sampler["interpolation"], "LINEAR");
      Track& track = tracks_[channel["target"]["node"].get<std::size_t>()][channel["target"]["path"]];
      track.times = glb.numbers(sampler["input"]);
      track.values = glb.numbers(sampler["output"]);
    }
    const nlohmann::json& nodes = glb.document["nodes"];
    parents_.assign(nodes.size(), -1);
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      for (const nlohmann::json& child : nodes[n].value("children", nlohmann::json::array()))
        parents_.at(child.get<std::size_t>()) = static_cast<int>(n);
    }
  }

  struct Track {
    std::vector<double> times, values;
  };
  const std::map<std::size_t, std::map<std::string, Track>>& tracks() const { return tracks_; }
  const std::vector<int>& parents() const { return parents_; }  // of every node; -1

  // How a node stands against its parent.
  struct Pose {
    Eigen::Vector3d translation = Eigen::Vector3d::Zero(), scale = Eigen::Vector3d::Ones();
    Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  };
  Pose pose(std::size_t id, double time) const {
    Pose one = own_pose(id, time);
    if (other_ == nullptr) return one;
    const Pose two = other_->own_pose(id, time);
    one.translation = (1 - weight_) * one.translation + weight_ * two.translation;
    if (fade_ == Fade::even) {
      one.turn = one.turn.slerp(weight_, two.turn);
    } else {
      const double sign = one.turn.dot(two.turn) < 0 ? -1 : 1;
      one.turn.coeffs() = (1 - weight_) * one.turn.coeffs() + sign * weight_ * two.turn.coeffs();
      one.turn.normalize();
    }
    return one;
  }

  // Another clip of the same file has so much of every pose, turns by slerp or by lerp made unit, the short
  // way: three.js and Godot do the one, Unity and Unreal the other.
  enum class Fade { even, straight };
  void fade(const SkinPlayer& other, double weight, Fade fade) {
    other_ = &other;
    weight_ = weight;
    fade_ = fade;
  }

  // The vertices of a part, z up. [m]
  std::vector<Eigen::Vector3d> play(std::size_t part, double time) const {
    const nlohmann::json& skin = glb_.document["skins"].at(skin_);
    const std::vector<double> binds = glb_.numbers(skin["inverseBindMatrices"]);
    std::vector<Eigen::Matrix4d> matrices;
    std::map<std::size_t, Eigen::Matrix4d> known;
    for (std::size_t j = 0; j < skin["joints"].size(); ++j) {
      const Eigen::Map<const Eigen::Matrix4d> bind(&binds[16 * j]);
      matrices.push_back(world(skin["joints"][j].get<std::size_t>(), time, known) * bind);
    }
    const nlohmann::json& attributes = glb_.primitive(part)["attributes"];
    const std::vector<double> at = glb_.numbers(attributes["POSITION"]),
                              joints = glb_.numbers(attributes["JOINTS_0"]),
                              weights = glb_.numbers(attributes["WEIGHTS_0"]);
    std::vector<Eigen::Vector3d> played;
    for (std::size_t v = 0; v < at.size() / 3; ++v) {
      Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
      double all = 0;
      for (std::size_t i = 4 * v; i < 4 * v + 4; ++i) {
        sum += weights[i] * matrices.at(static_cast<std::size_t>(joints[i]));
        all += weights[i];
      }
      if (std::abs(all - 1) > 1e-9) ADD_FAILURE() << "shares of vertex " << v << " add up to " << all;
      const Eigen::Vector4d x = sum * Eigen::Vector4d(at[3 * v], at[3 * v + 1], at[3 * v + 2], 1);
      played.emplace_back(x.x(), -x.z(), x.y());
    }
    return played;
  }

 private:
  Eigen::Matrix4d world(std::size_t node, double time, std::map<std::size_t, Eigen::Matrix4d>& known) const {
    const auto found = known.find(node);
    if (found != known.end()) return found->second;
    Eigen::Matrix4d at = local(node, time).matrix();
    if (parents_[node] >= 0) at = world(static_cast<std::size_t>(parents_[node]), time, known) * at;
    return known[node] = at;
  }

  Eigen::Affine3d local(std::size_t id, double time) const {
    const Pose it = pose(id, time);
    return Eigen::Translation3d(it.translation) * it.turn * Eigen::Scaling(it.scale);
  }

  Pose own_pose(std::size_t id, double time) const {
    const nlohmann::json& node = glb_.document["nodes"].at(id);
    Pose it;
    Eigen::Vector4d rotation(0, 0, 0, 1);
    for (int k = 0; k < 4; ++k) {
      const auto i = static_cast<std::size_t>(k);
      if (node.contains("rotation")) rotation[k] = node["rotation"][i];
      if (k == 3) continue;
      if (node.contains("translation")) it.translation[k] = node["translation"][i];
      if (node.contains("scale")) it.scale[k] = node["scale"][i];
    }
    const auto found = tracks_.find(id);
    if (found != tracks_.end()) {
      for (const auto& [path, track] : found->second) {
        if (path == "translation") it.translation = between<3>(track, time, false);
        if (path == "rotation") rotation = between<4>(track, time, true);
      }
    }
    it.turn = Eigen::Quaterniond(rotation[3], rotation[0], rotation[1], rotation[2]).normalized();
    return it;
  }

  template <int width>
  static Eigen::Vector<double, width> between(const Track& track, double time, bool sphere) {
    const auto after = std::upper_bound(track.times.begin() + 1, track.times.end() - 1, time);
    const auto k = static_cast<std::size_t>(after - track.times.begin());
    const double part = (time - track.times[k - 1]) / (track.times[k] - track.times[k - 1]);
    const Eigen::Map<const Eigen::Vector<double, width>> a(&track.values[width * (k - 1)]),
        b(&track.values[width * k]);
    if (!sphere) return (1 - part) * a + part * b;
    const double angle = std::acos(std::clamp(a.normalized().dot(b.normalized()), -1.0, 1.0));
    if (angle < 1e-6) return (1 - part) * a + part * b;
    return (std::sin((1 - part) * angle) * a + std::sin(part * angle) * b) / std::sin(angle);
  }

  const Glb& glb_;
  std::size_t skin_;
  std::map<std::size_t, std::map<std::string, Track>> tracks_;
  std::vector<int> parents_;
  const SkinPlayer* other_ = nullptr;
  double weight_ = 0;
  Fade fade_ = Fade::even;
};

}  // namespace tremula::test
