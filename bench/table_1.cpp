// Table 1 of Stam 1997, again: the five trees with M = 256, T = 256 s, m = 20, time by stage and peak memory.
// Each tree runs in a process of its own, so that the memory is its own.

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <map>
#include <string>

#include "tremula/geometry/grow.hpp"
#include "tremula/geometry/plants.hpp"
#include "tremula/pipeline.hpp"

namespace {

using namespace tremula;
using Clock = std::chrono::steady_clock;

double seconds(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

// Prints the row of one tree and returns its total in seconds.
double run(int branches) {
  const std::string name = "stam-" + std::to_string(branches);
  std::map<std::string, double> stage;
  std::string current = "grow";
  const Clock::time_point start = Clock::now();
  Clock::time_point begun = start;
  const auto next = [&](std::string_view begins) {
    const Clock::time_point now = Clock::now();
    stage[current] += seconds(begun, now);
    current = begins;
    begun = now;
  };
  const Progress progress = [&](std::string_view begins, double done) {
    if (done == 0) next(begins);  // only the thread that runs the cascade begins stages
  };
  const GrownPlant plant = grow(parse_lsystem(find_preset(name).text, name));
  const StructureOptions paper{.material = find_material("paper"), .section = Section::paper, .gravity = 0};
  const Subject subject = bake(plant.skeleton, {.structure = paper, .modes = {.count = 20}}, progress);
  Weather weather;
  weather.wind = StamWind{};
  weather.loads.model = LoadModel::paper;
  weather.damping = {.mass_proportional = 0.5, .aerodynamic = false};
  weather.transfer = Transfer::sampled;
  weather.static_correction = false;
  weather.loop = {.period = 256, .sample_count = 256};
  const Motion motion = set_in_motion(subject, weather, progress);
  next("");
  const double total = seconds(start, Clock::now());
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf("%8d %8.4f %10.4f %8.4f %8.4f %8.4f %10.4f %8.4f %8.1f\n", branches, stage["grow"],
              stage["structure"], stage["modes"], stage["loads"], stage["wind"], stage["response"], total,
              static_cast<double>(usage.ru_maxrss) / 1024);
  std::fflush(stdout);
  return motion.sample_count() == 256 ? total : -1;
}

}  // namespace

int main() {
  std::printf("%8s %8s %10s %8s %8s %8s %10s %8s %8s\n", "branches", "grow", "structure", "modes", "loads",
              "wind", "response", "total_s", "peak_MB");
  std::fflush(stdout);
  double sum = 0;
  for (const int branches : {17, 62, 212, 692, 2257}) {
    int ends[2];
    if (pipe(ends) != 0) return 1;
    const pid_t child = fork();
    if (child == 0) {
      const double total = run(branches);
      const bool told = write(ends[1], &total, sizeof total) == sizeof total;
      _exit(told ? 0 : 1);
    }
    double total = 0;
    int status = 0;
    const bool heard = read(ends[0], &total, sizeof total) == sizeof total;
    waitpid(child, &status, 0);
    if (!heard || status != 0) return 1;
    sum += total;
  }
  std::printf("all five %.3f s\n", sum);
}
