#include "tasks.hpp"

#include "tremula/io/atomic_file.hpp"
#include "tremula/io/gltf.hpp"
#include "tremula/io/html.hpp"
#include "tremula/io/modes_plot.hpp"
#include "tremula/io/pose_table.hpp"
#include "tremula/io/skeleton_files.hpp"
#include "tremula/io/spectrum_table.hpp"
#include "tremula/io/turbsim.hpp"
#include "tremula/io/vti.hpp"
#include "tremula/io/wind_plot.hpp"
#include "tremula/modes/mode_quality.hpp"
#include "tremula/pipeline.hpp"

#include <array>
#include <memory>

#include "fuzz/harness.hpp"

namespace tremula::test {
namespace {

// A little plant in leaf on its whole way, so that writers have something to write.
struct Example {
  Skeleton skeleton;
  Subject subject;
  Loop loop;
  TurbSimFile wind_file;
  WindField field;
  WindReport wind_report;
};

Example make_example() {
  Example example;
  example.skeleton = read_skeleton(fuzz::swc_seeds().back(), "seed").skeleton;
  example.subject = bake(example.skeleton, BakeOptions{.modes = {.count = 3}});
  Weather weather;
  weather.loop = {.period = 2, .sample_count = 16};
  example.loop = make_loop(example.subject.structure, mesh_surface(example.skeleton),
                           set_in_motion(example.subject, weather), {});
  example.wind_file = parse_turbsim(fuzz::turbsim_seeds().front(), "seed");
  example.field = wind_field(example.wind_file);
  example.wind_report = {.title = "seed", .statistics = field_statistics(example.field)};
  return example;
}

const Example& example() {
  static const Example made = make_example();
  return made;
}

MorphTargets morphs(MorphForm form) { return make_morph_targets(example().loop, form); }

std::size_t read_tree(const std::string& path) { return read_skeleton(path).skeleton.branches.size(); }

}  // namespace

const std::vector<ReadTask>& read_tasks() {
  static const std::vector<ReadTask> tasks = {
      {"Swc", [] { return fuzz::swc_seeds().back(); }, read_tree},
      {"TreeQsmText", [] { return fuzz::treeqsm_text_seeds().back(); }, read_tree},
      {"TreeQsmMat", [] { return fuzz::matlab_seeds().back(); }, read_tree},
      {"CylinderTable", [] { return fuzz::table_seeds().front(); }, read_tree},
      {"TurbSim", [] { return fuzz::turbsim_seeds().front(); },
       [](const std::string& path) { return wind_field(read_turbsim(path)).velocity[0].size(); }},
      {"SpectrumTable", [] { return fuzz::spectrum_seeds().front(); },
       [](const std::string& path) { return read_spectrum_table(path).at.size(); }},
  };
  return tasks;
}

const std::vector<WriteTask>& write_tasks() {
  static const std::vector<WriteTask> tasks = [] {
    std::vector<WriteTask> all = {
        {"Bytes", [](const std::string& path) { write_file_atomically(path, "some bytes"); }},
        {"Swc", [](const std::string& path) { write_swc(example().skeleton, path); }},
        {"TurbSimFile", [](const std::string& path) { write_turbsim(path, example().wind_file); }},
        {"TurbSimField", [](const std::string& path) { write_turbsim(path, example().field); }},
        {"Vti", [](const std::string& path) { write_vti(path, example().field); }},
        {"Glb",
         [](const std::string& path) {
           write_glb(path, *example().loop.rest, morphs(MorphForm::paired), example().loop.facts);
         },
         true},
        {"PoseTable",
         [](const std::string& path) {
           write_file_atomically(path, encode_pose_table(example().loop, std::array{0, 1, 2}));
         }},
        {"WindPlot", [](const std::string& path) { write_wind_plot(path, example().wind_report); }},
        {"ModesPlot",
         [](const std::string& path) {
           const Subject& subject = example().subject;
           write_file_atomically(path, plot_modes(subject.structure, subject.modes,
                                                  assess_modes(subject.structure, subject.modes,
                                                               trunk_branches(example().skeleton))));
         }},
    };
    if (can_write_html()) {
      all.push_back({"Html",
                     [](const std::string& path) {
                       write_html(path, *example().loop.rest, morphs(MorphForm::signed_weights),
                                  example().loop.facts);
                     },
                     true});
    }
    return all;
  }();
  return tasks;
}

}  // namespace tremula::test
