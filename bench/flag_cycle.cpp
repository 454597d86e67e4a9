// The cycle that a flag ends in, in an even wind: the table of docs/theory/dynamics.md, "Flags that flap".
//
//   bench_flag_cycle [PRESET]     by default flag
#include <chrono>
#include <cstdio>
#include <numbers>
#include <string>

#include "crossings.hpp"
#include "tremula/base/error.hpp"
#include "tremula/dynamics/flapping.hpp"
#include "tremula/structure/sheet_presets.hpp"

namespace {

using namespace tremula;

void run(const std::string& name) {
  const FlappingOptions options;
  for (const SheetPreset& preset : sheet_presets()) {
    if (preset.name != name) continue;
    const std::optional<Flag> flag = flag_of(preset.sheet);
    if (!flag) throw InputError("preset", name, "a flag");
    std::printf("%8s %12s %6s %6s %6s %10s %15s\n", "wind m/s", "frequency Hz", "fL/U", "fA/U", "drag",
                "droop deg", "ms per second");
    for (const double speed : {1.0, 2.0, 4.0, 8.0, 16.0}) {
      const double step = 0.05 * flag->length / speed;
      const auto begin = std::chrono::steady_clock::now();
      const FlappingCourse course = integrate_flapping(
          *flag, options, flapping_start(*flag, options), [&](double) { return Vec3(speed, 0, 0); }, step,
          2000);
      const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      const Eigen::MatrixXd late = course.angles.rightCols(800);
      Eigen::VectorXd fly(late.cols());
      for (Eigen::Index i = 0; i < fly.size(); ++i) fly[i] = thread(*flag, options, late.col(i), 40)(1, 40);
      const double frequency = test::frequency_of_crossings(fly, step),
                   sway = fly.maxCoeff() - fly.minCoeff();
      std::printf("%8g %12.2f %6.2f %6.2f %6.2f %10.0f %15.1f\n", speed, frequency,
                  frequency * flag->length / speed, frequency * sway / speed,
                  course.pull.tail(800).mean() / (0.5 * options.fluid_density * speed * speed * flag->length),
                  late.row(options.modes).mean() * 180 / std::numbers::pi, 1000 * seconds / (2000 * step));
    }
  }
}

}  // namespace

int main(int count, char** arguments) {
  try {
    run(count > 1 ? arguments[1] : "flag");
  } catch (const Error& error) {
    std::fprintf(stderr, "bench_flag_cycle: %s\n", error.what());
    return 2;
  }
}
