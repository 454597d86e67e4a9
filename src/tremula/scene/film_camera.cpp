#include "tremula/scene/film_camera.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace tremula {
namespace {

// Eye x y z, look_at x y z, field of view.
using Pose = Eigen::Matrix<double, 7, 1>;
constexpr bool is_limited(Eigen::Index row) { return row == 2 || row >= 5; }

// The slope of the parabola through three values, h and d the steps and slopes before and after; of a limited
// one none at an extremum, and at most three times the smaller slope.
double slope_at_key(double step_before, double step_after, double before, double after, bool limited) {
  const double slope = (before * step_after + after * step_before) / (step_before + step_after);
  if (!limited) return slope;
  if (before * after <= 0) return 0;
  const double most = 3 * std::min(std::abs(before), std::abs(after));
  return std::clamp(slope, -most, most);
}

// A cubic of each coordinate between keys.
class Path {
 public:
  Path(const SceneCamera& camera, double period) : repeats_(camera.path_repeats), period_(period) {
    for (const CameraKey& key : camera.path) {
      Pose pose;
      pose << key.eye, key.look_at, key.field_of_view.value_or(camera.field_of_view);
      times_.push_back(key.time);
      poses_.push_back(pose);
    }
    if (repeats_) {  // the first key once more, so that every span has an end
      times_.push_back(times_.front() + period_);
      poses_.push_back(poses_.front());
    }
    for (std::size_t i = 0; i < poses_.size(); ++i) slopes_.push_back(slope(i));
  }

  Pose at(double time) const {
    if (repeats_) {
      time = times_.front() + std::fmod(time - times_.front(), period_);
      if (time < times_.front()) time += period_;
    }
    time = std::clamp(time, times_.front(), times_.back());
    const auto after = std::upper_bound(times_.begin() + 1, times_.end() - 1, time);
    const auto i = static_cast<std::size_t>(after - times_.begin()) - 1;
    const double step = times_[i + 1] - times_[i], s = (time - times_[i]) / step;
    return poses_[i] +
           s * (step * slopes_[i] + s * ((3 - 2 * s) * (poses_[i + 1] - poses_[i]) +
                                         step * ((s - 2) * slopes_[i] + (s - 1) * slopes_[i + 1])));
  }

 private:
  Pose slope(std::size_t i) const {
    const std::size_t last = poses_.size() - 1;
    const bool at_end = i == 0 || i == last;
    if (at_end && !repeats_) return Pose::Zero();  // it sets off gently, and rests
    const std::size_t from = at_end ? last - 1 : i - 1, to = at_end ? 0 : i;
    const double before = at_end ? times_[last] - times_[last - 1] : times_[i] - times_[i - 1],
                 after = times_[to + 1] - times_[to];
    const Pose slope_before = (poses_[from + 1] - poses_[from]) / before,
               slope_after = (poses_[to + 1] - poses_[to]) / after;
    Pose slope;
    for (Eigen::Index row = 0; row < slope.size(); ++row)
      slope[row] = slope_at_key(before, after, slope_before[row], slope_after[row], is_limited(row));
    return slope;
  }

  std::vector<double> times_;
  std::vector<Pose> poses_, slopes_;
  bool repeats_;
  double period_;
};

Camera camera_of(const Pose& pose, double aspect) {
  return look_at(pose.head<3>(), pose.segment<3>(3), aspect, std::tan(0.5 * pose[6]));
}

void check_path(const SceneCamera& camera, const CameraView& view) {
  if (camera.path.size() < 2)
    throw InputError(text_of(camera.place) + ": camera.path", std::to_string(camera.path.size()),
                     "two keys or more");
  for (std::size_t i = 1; i < camera.path.size(); ++i) {
    if (!(camera.path[i].time > camera.path[i - 1].time))
      throw InputError(text_of(camera.path[i].place) + ": camera.path.time",
                       number_text(camera.path[i].time) + " s", "a time after the last");
  }
  const CameraKey& last = camera.path.back();
  if (camera.path_repeats && !(last.time - camera.path.front().time < view.period)) {
    throw InputError(
        text_of(last.place) + ": camera.path.time", number_text(last.time) + " s",
        "less than the loop of " + number_text(view.period) + " s after the first, or path_repeats = false");
  }
}

// Between keys eye and look_at might meet.
void check_between(const SceneCamera& camera, const Path& path) {
  constexpr int steps = 16;
  for (std::size_t i = 0; i + 1 < camera.path.size(); ++i) {
    for (int step = 0; step <= steps; ++step) {
      const double share = static_cast<double>(step) / steps;
      const double time = camera.path[i].time + share * (camera.path[i + 1].time - camera.path[i].time);
      const Pose pose = path.at(time);
      if ((pose.head<3>() - pose.segment<3>(3)).norm() < 1e-6)
        throw InputError(text_of(camera.path[i].place) + ": camera.path",
                         "at " + number_text(time) + " s the eye is at what it looks at", "another way");
    }
  }
}

void check_above(const SceneCamera& camera, const SceneGround& ground, const FilePlace& place,
                 const Vec3& eye) {
  if (ground.kind == "none" || eye.z() > ground.height) return;
  const FilePlace& at = place.line > 0 ? place : camera.place;
  throw InputError((at.file.empty() ? std::string("camera") : text_of(at) + ": camera"),
                   "its eye would be at a height of " + number_text(eye.z()) + " m",
                   "above the ground, which is at " + number_text(ground.height) + " m");
}

}  // namespace

FilmCamera film_camera(const SceneCamera& camera, const SceneGround& ground, const CameraView& view) {
  FilmCamera film;
  film.lens_radius = camera.aperture / 2;
  const double half_height = std::tan(0.5 * camera.field_of_view);
  std::function<double(const Camera&, double)> looked_at;  // how far away
  if (!camera.path.empty()) {
    check_path(camera, view);
    for (const CameraKey& key : camera.path) check_above(camera, ground, key.place, key.eye);
    const Path path(camera, view.period);
    check_between(camera, path);
    film.camera = [path, aspect = view.aspect](double time) { return camera_of(path.at(time), aspect); };
    looked_at = [path](const Camera& from, double time) {
      return (path.at(time).segment<3>(3) - from.eye).dot(from.forward);
    };
  } else {
    Camera still;
    if (camera.eye) {
      still = look_at(*camera.eye, camera.look_at.value_or(Vec3::Zero()), view.aspect, half_height);
    } else {
      still = frame_points(view.points, camera.azimuth.value_or(view.azimuth), camera.elevation, view.aspect,
                           {half_height, camera.margin});
    }
    check_above(camera, ground, camera.place, still.eye);
    Vec3 middle = camera.look_at.value_or(Vec3::Zero());
    if (!camera.eye) {
      Eigen::AlignedBox3f box;
      for (const Eigen::Vector3f& point : view.points) box.extend(point);
      middle = box.center().cast<double>();
    }
    film.camera = [still](double) { return still; };
    looked_at = [middle](const Camera& from, double) { return (middle - from.eye).dot(from.forward); };
  }
  if (camera.focus_distance) {
    film.focus_distance = [distance = *camera.focus_distance](double) { return distance; };
  } else {
    if (camera.focus_at)
      looked_at = [at = *camera.focus_at](const Camera& from, double) {
        return (at - from.eye).dot(from.forward);
      };
    film.focus_distance = [looked_at, at = film.camera](double time) {
      return std::max(1e-3, looked_at(at(time), time));
    };
  }
  return film;
}

}  // namespace tremula
