// Scenes from TOML: refused in one line, or placed and looked at.
#include "tremula/scene/film_camera.hpp"
#include "tremula/scene/placing.hpp"
#include "tremula/scene/scene_file.hpp"

#include <array>

#include "finite.hpp"
#include "harness.hpp"
#include "scene/vocabulary.hpp"

namespace tremula::fuzz {
namespace {

constexpr std::int64_t most_placed = 2000;
constexpr double period = 20;  // [s]

bool same(const Instance& a, const Instance& b) {
  return a.position == b.position && a.turn == b.turn && a.scale == b.scale && a.time_shift == b.time_shift;
}

void check_copies(const Scene& scene) {
  std::int64_t count = 0;
  for (const SceneObject& object : scene.objects) count += count_instances(object.crowd);
  require(count <= most_instances, "a scene of more copies than may be placed");
  if (count > most_placed) return;
  const Vec3 advection(8, 1, 0);
  const auto copies = place_objects(scene.objects, advection, period);
  require(copies.size() == scene.objects.size(), "an object without its copies");
  const auto again = place_objects(scene.objects, advection, period);
  for (std::size_t i = 0; i < copies.size(); ++i) {
    require(std::equal(copies[i].begin(), copies[i].end(), again[i].begin(), again[i].end(), same),
            "copies of a scene stand elsewhere the second time");
    if (!copies[i].empty()) check_instances(copies[i]);
    for (const Instance& copy : copies[i])
      require(copy.time_shift >= 0 && copy.time_shift < period, "a time shift outside the loop");
    split_by_heading(copies[i], scene.objects[i].headings);
  }
}

void check_camera(const Scene& scene) {
  const std::array<Eigen::Vector3f, 2> points{Eigen::Vector3f(-1, -1, 0), Eigen::Vector3f(1, 1, 3)};
  taken_by_stages([&] {
    const FilmCamera film = film_camera(scene.camera, scene.ground, {.points = points, .period = period});
    for (const double time : {0.0, 0.3, 7.0, 19.99, 1e4}) {
      const Camera camera = film.camera(time);
      for (const Vec3& v : {camera.eye, camera.right, camera.up, camera.forward})
        require_finite(v, "the camera");
      require_finite(std::array{camera.half_height, film.focus_distance(time)}, "what the camera sees");
    }
  });
}

}  // namespace

void try_scene(std::string_view bytes) {
  Scene scene;
  if (!taken([&] { scene = parse_scene(std::string(bytes), input_name, test::vocabulary()); })) return;
  require(!scene.objects.empty(), "a scene without objects");
  for (const SceneObject& object : scene.objects) settings_of(scene, object);
  check_copies(scene);
  check_camera(scene);
}

std::vector<std::string> scene_seeds() {
  return {
      "[[objects]]\nsource = \"oak\"\n",
      "name = \"wood\"\n[wind]\nwind_speed = 8\ndecay_y = [16, 10, 8.5]\n[motion]\nperiod = 12\nno_shelter = "
      "true\n"
      "[ground]\nkind = \"plain\"\ncolor = [0.1, 0.2, 0.3]\nheight = -2\n[sky]\nsun_elevation = "
      "30\n[medium]\n"
      "visibility = 5e3\n[camera]\neye = [-30, 4, 1.7]\nlook_at = [0, 0, 6]\naperture = 0.02\n[picture]\n"
      "size = \"64x36\"\n[[objects]]\nsource = \"birch\"\nmodes = 4\n[[objects.scatter]]\ndensity = 0.01\n"
      "low = [-100, -50]\nhigh = [100, 50]\ndistance = 4\ninside = [[[-90, -40], [90, -40], [0, 40]]]\n"
      "outside = [[0, 0], [10, 0], [10, 10]]\nscale = [0.8, 1.2]\nturn = \"random\"\nrandom_shift = 2\n",
      "[camera]\nfield_of_view = 30\n[[camera.path]]\ntime = 0\neye = [9, 0, 2]\nlook_at = [0, 0, 1]\n"
      "[[camera.path]]\ntime = 4\neye = [0, 9, 2]\nlook_at = [0, 0, 1]\n[[objects]]\nsource = 'oak'\nset = "
      "['a=1']\n"
      "[[objects.instances]]\nposition = [1, 2]\nturn = 90\n[[objects.grid]]\ncolumns = 3\nrows = 2\njitter "
      "= 0.1\n"
      "[[objects]]\nsource = 'flag'\ntravelling_gusts = false\n",
  };
}

}  // namespace tremula::fuzz
