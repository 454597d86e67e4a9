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
struct Loop {
  Subject subject;
  Motion motion;
  Surface surface;
  TurbSimFile wind_file;
  WindField field;
  WindReport wind_report;
};

Loop make_loop() {
  Loop loop;
  loop.subject =
      bake(read_skeleton(fuzz::swc_seeds().back(), "seed").skeleton, BakeOptions{.modes = {.count = 3}});
  Weather weather;
  weather.loop = {.period = 2, .sample_count = 16};
  loop.motion = set_in_motion(loop.subject, weather);
  loop.surface = mesh_surface(loop.subject.skeleton);
  loop.wind_file = parse_turbsim(fuzz::turbsim_seeds().front(), "seed");
  loop.field = wind_field(loop.wind_file);
  loop.wind_report = {.title = "seed", .statistics = field_statistics(loop.field)};
  return loop;
}

const Loop& loop() {
  static const Loop made = make_loop();
  return made;
}

MorphTargets morphs(MorphForm form) {
  return make_morph_targets(loop().subject.skeleton, loop().subject.structure, loop().surface,
                            loop().subject.modes, loop().motion, form);
}

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
        {"Swc", [](const std::string& path) { write_swc(loop().subject.skeleton, path); }},
        {"TurbSimFile", [](const std::string& path) { write_turbsim(path, loop().wind_file); }},
        {"TurbSimField", [](const std::string& path) { write_turbsim(path, loop().field); }},
        {"Vti", [](const std::string& path) { write_vti(path, loop().field); }},
        {"Glb",
         [](const std::string& path) { write_glb(path, loop().surface, morphs(MorphForm::paired), {}); },
         true},
        {"PoseTable",
         [](const std::string& path) {
           write_file_atomically(path,
                                 encode_pose_table(loop().subject.skeleton, loop().subject.structure,
                                                   loop().subject.modes, loop().motion, std::array{0, 1, 2}));
         }},
        {"WindPlot", [](const std::string& path) { write_wind_plot(path, loop().wind_report); }},
        {"ModesPlot",
         [](const std::string& path) {
           const Subject& subject = loop().subject;
           write_file_atomically(path, plot_modes(subject.skeleton, subject.structure, subject.modes,
                                                  assess_modes(subject.structure, subject.modes,
                                                               trunk_branches(subject.skeleton))));
         }},
    };
    if (can_write_html()) {
      all.push_back({"Html",
                     [](const std::string& path) {
                       write_html(path, loop().surface, morphs(MorphForm::signed_weights), {});
                     },
                     true});
    }
    return all;
  }();
  return tasks;
}

}  // namespace tremula::test
