// Table 1 of Stam 1997, again: the five trees with M = 256, T = 256 s, m = 20, time by stage and peak memory.
//
//   bench_table_1 [--beside-stam]     his times beside ours, and what a frame takes, instead
//
// Each tree runs in a process of its own, so that the memory is its own.

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <map>
#include <string>

#include "paper.hpp"
#include "seconds.hpp"
#include "tremula/geometry/grow.hpp"
#include "tremula/geometry/plants.hpp"

namespace {

using namespace tremula;
using Clock = std::chrono::steady_clock;

double seconds(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

// S Table 1: seconds on an Iris Indigo (R4400, 150 MHz).
struct Printed {
  int branches;
  double lanz, noise;
};
constexpr Printed table_1[] = {
    {17, 0.2, 0.3}, {62, 0.5, 3.4}, {212, 5.5, 37.5}, {692, 10.1, 145.3}, {2257, 48.8, 451.4}};

void print_head(bool beside_stam) {
  if (beside_stam) {
    std::printf("%8s %8s %9s %8s %11s %10s %13s %10s %10s\n", "branches", "stam_s", "modes_s", "faster",
                "error_bound", "stam_s", "wind_forces_s", "faster", "a_frame_us");
  } else {
    std::printf("%8s %8s %11s %8s %8s %8s %10s %8s %8s\n", "branches", "grow_s", "structure_s", "modes_s",
                "loads_s", "wind_s", "response_s", "total_s", "peak_MB");
  }
  std::fflush(stdout);
}

// Prints the row of one tree and returns its total in seconds.
double run(const Printed& printed, bool beside_stam) {
  const std::string name = "stam-" + std::to_string(printed.branches);
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
  const Subject subject =
      bake(plant.skeleton, {.structure = bench::paper_structure(), .modes = {.count = 20}}, progress);
  const Motion motion = set_in_motion(subject, bench::paper_weather(), progress);
  next("");
  const double total = seconds(start, Clock::now());
  if (beside_stam) {
    const double forces = stage["loads"] + stage["wind"] + stage["response"];
    double time = 0;
    Eigen::VectorXd frame;
    const double a_frame = bench::seconds_a_call([&] { frame = displacement_at(motion, time += 0.7); });
    std::printf("%8d %8.1f %9.4f %8.0f %11.1e %10.1f %13.4f %10.0f %10.1f\n", printed.branches, printed.lanz,
                stage["modes"], printed.lanz / stage["modes"], subject.modes.error_bound.maxCoeff(),
                printed.noise, forces, printed.noise / forces, 1e6 * a_frame);
  } else {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    std::printf("%8d %8.4f %11.4f %8.4f %8.4f %8.4f %10.4f %8.4f %8.1f\n", printed.branches, stage["grow"],
                stage["structure"], stage["modes"], stage["loads"], stage["wind"], stage["response"], total,
                static_cast<double>(usage.ru_maxrss) / 1024);
  }
  std::fflush(stdout);
  return motion.sample_count() == 256 ? total : -1;
}

}  // namespace

int main(int argc, char** argv) {
  const bool beside_stam = argc > 1 && std::string(argv[1]) == "--beside-stam";
  print_head(beside_stam);
  double sum = 0;
  for (const Printed& printed : table_1) {
    int ends[2];
    if (pipe(ends) != 0) return 1;
    const pid_t child = fork();
    if (child == 0) {
      const double total = run(printed, beside_stam);
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
  if (!beside_stam) std::printf("all five %.3f seconds\n", sum);
}
