// What a program does that uses the library: grow a plant, bake it, set it in motion.
#include <cstdio>

#include <tremula/geometry/grow.hpp>
#include <tremula/geometry/plants.hpp>
#include <tremula/pipeline.hpp>

int main() {
  const auto plant = tremula::grow(tremula::parse_lsystem(tremula::find_preset("sapling").text, "sapling"));
  const tremula::Subject subject = tremula::bake(plant.skeleton, {.modes = {.count = 6}});
  const tremula::Motion motion = tremula::set_in_motion(subject, {.loop = {4, 60}});
  std::printf("first frequency %.3f Hz, %d samples\n", subject.modes.frequency[0], motion.sample_count());
}
