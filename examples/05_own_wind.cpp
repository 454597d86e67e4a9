// A wind of your own: any function that says, at the points of the plant, what the mean is and what each wave
// of the loop is. Here gusts that come as one front: every point feels the same gust when the front reaches
// it.

#include <tremula/geometry/grow.hpp>
#include <tremula/geometry/plants.hpp>
#include <tremula/pipeline.hpp>

#include <cmath>
#include <complex>
#include <cstdio>

int main() {
  using namespace tremula;

  const double speed = 5, gust = 1.5;  // m/s
  const int gust_bin = 3;              // so many gusts a loop

  Wind front;
  front.reference.speed = speed;  // what reports and captions say
  front.at_points = [=](const TimeAxis& loop, const Eigen::Matrix3Xd& points) {
    PointWind wind;
    wind.mean = Eigen::Vector3d(speed, 0, 0).replicate(1, points.cols());
    wind.has_draws = false;       // it is what it is, and not one of many realisations
    wind.has_slow_gusts = false;  // and nothing in it is slower than the loop
    // v(t) = sum over p of v_p exp(2 pi i p t/T) over positive and negative p: a cosine has half its
    // amplitude in each. Called from several threads.
    wind.velocity = [=](int bin, int) {
      Eigen::Matrix3Xcd velocity = Eigen::Matrix3Xcd::Zero(3, points.cols());
      for (Eigen::Index k = 0; k < points.cols() && bin == gust_bin; ++k)
        velocity(0, k) = 0.5 * gust * std::polar(1.0, -loop.omega(bin) * points(0, k) / speed);
      return velocity;
    };
    return wind;
  };

  const GrownPlant plant = grow(parse_lsystem(find_preset("sapling").text, "sapling"));
  const Subject subject = bake(plant.skeleton, {.modes = {.count = 10}});
  Weather weather;
  weather.wind = front;
  weather.loop = {.period = 12, .sample_count = 360};
  const Motion motion = set_in_motion(subject, weather);

  // Three equal gusts a loop: the plant does the same in each third of it.
  const double third = motion.period / 3;
  const Eigen::VectorXd first = displacement_at(motion, 1), second = displacement_at(motion, 1 + third);
  const Vec3 top = first.tail<6>().head<3>();
  std::printf("a second after the start the last branch is %.3f m downwind\n", top.x());
  const bool alike = (first - second).norm() < 1e-6 * first.norm();
  return top.x() > 0 && alike ? 0 : 1;
}
