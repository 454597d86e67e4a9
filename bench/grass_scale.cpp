// A million blades of grass posed for a frame: time, and bytes moved beside what the memory can do.
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <string>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>

#include "seconds.hpp"
#include "tremula/deformation/grass_pose.hpp"
#include "tremula/wind/point_wind.hpp"

namespace tremula {
namespace {

// A copy on all threads, counted as bytes read and written [byte/s].
double bandwidth() {
  const std::size_t bytes = std::size_t{1} << 27U;
  const std::vector<char> from(bytes, 1);
  std::vector<char> to(bytes, 2);
  const double seconds = bench::seconds_a_call([&] {
    constexpr std::size_t block = std::size_t{1} << 20U;
    tbb::parallel_for(std::size_t{0}, bytes / block, [&](std::size_t i) {
      std::memcpy(to.data() + i * block, from.data() + i * block, block);
    });
  });
  return 2 * static_cast<double>(bytes) / seconds;
}

// Processor time of a call on all threads together [s]: what is left of the wall's on an idle machine is this
// over the cores.
template <typename Work>
double processor_seconds(const Work& work) {
  double least = 1e9;
  for (int i = 0; i < 5; ++i) {
    const std::clock_t before = std::clock();
    work();
    least = std::min(least, static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC);
  }
  return least;
}

void measure(const char* name, double side) {
  const GrassSpecies& species = grass_species_named(name);
  Meadow meadow;
  const double sown = bench::seconds_of([&] {
    meadow = sow(species, {.low = {-side / 2, -side / 2}, .high = {side / 2, side / 2}});
  });
  const Wind wind(turbulent_wind({.speed = 7}, 0.25));
  const std::vector<Vec3> corners = {Vec3(-side / 2, -side / 2, 0), Vec3(side / 2, side / 2, 0)};
  const TravellingField gusts =
      gust_field(wind, TimeAxis{10, 300}, plane_across(corners, 0, 0.25, {species.height}));
  GrassInWind grass;
  const double prepared = bench::seconds_of([&] { grass = put_in_wind(std::move(meadow), gusts); });
  std::vector<Eigen::Vector3f> positions(grass.all_vertices), normals(grass.all_vertices);
  double time = 0;
  const double posed = bench::seconds_a_call([&] { pose_grass(grass, time += 0.033, positions, {}); });
  const double processor = processor_seconds([&] { pose_grass(grass, time += 0.033, positions, {}); });
  const double with_normals =
      bench::seconds_a_call([&] { pose_grass(grass, time += 0.033, positions, normals); });
  // Of a blade: place, size, four cosines and sines, where it hangs, its makes, its vertices.
  const double read = static_cast<double>(grass.blade_count()) * (3 * 4 + 2 * 4 + 4 * 4 + 4 + 3 + 4);
  const double written = 12.0 * grass.all_vertices;
  std::printf("%-7s %9zu %9.3f %9.3f %9.1f %9.1f %9.1f %9.0f %9.1f\n", name, grass.blade_count(), sown,
              prepared, 1e3 * posed, 1e3 * processor, 1e3 * with_normals, 1e-6 * (read + written),
              1e-9 * (read + written) / posed);
}

}  // namespace
}  // namespace tremula

int main() {
  std::printf("memory: %.1f GB/s, a copy read and written\n", 1e-9 * tremula::bandwidth());
  std::printf("%-7s %9s %9s %9s %9s %9s %9s %9s %9s\n", "", "blades", "sown s", "ready s", "pose ms",
              "cpu ms", "+normals", "MB", "GB/s");
  tremula::measure("lawn", 12);      // a million
  tremula::measure("meadow", 24.4);  // a million
  tremula::measure("wheat", 10);
}
