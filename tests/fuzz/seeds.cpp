// Where mutation begins: small files of every form that the readers know, made by the project's own writers
// and by libmatio.
#include "tremula/geometry/grow.hpp"
#include "tremula/geometry/plants.hpp"
#include "tremula/io/skeleton_files.hpp"
#include "tremula/io/turbsim.hpp"

#include "harness.hpp"
#include "io/input_files.hpp"
#include "trees.hpp"

namespace tremula::fuzz {
namespace {

std::string swc_of(const Skeleton& skeleton, const PlantColors& colors = {}) {
  return bytes_written([&](const std::string& path) { write_swc(skeleton, path, colors); });
}

Skeleton grown(const std::string& text) { return grow(parse_lsystem(text, "seed")).skeleton; }

const std::string little_plant =
    "# two shoots in leaf\n"
    "leaf = 0.1\n"
    "axiom: !(0.02) T(-3) /(rand(0, 360)) Stem(3)\n"
    "steps: 10\n"
    "Stem(n) : n > 0 -> F(0.3, 0.01) [ &(55) !(0.008) F(0.2) Leaf(0.5) ] Stem(n - 1)\n"
    "Leaf(x) -> [ &(rand(40, 70)) $ L(leaf * rand(0.8, 1.2), 0.45 * leaf, 0.02, x) ]\n"
    "leaf_color: 0.33, 0.47, 0.16\n";

WindField small_field(int y_count, int z_count, int step_count, int tower_count, bool periodic) {
  WindField field;
  field.grid = {.y_count = y_count,
                .z_count = z_count,
                .step_count = step_count,
                .y_spacing = 2.5,
                .z_spacing = 1.25,
                .bottom = 3.5,
                .step = 0.125,
                .mean_speed = 8.5,
                .reference_height = 10.25,
                .periodic = periodic};
  field.tower_count = tower_count;
  std::uint64_t place = 0;
  const double mean[] = {8, 0, -0.5}, width[] = {9, 4, 1};
  for (std::size_t c = 0; c < 3; ++c) {
    field.velocity[c].resize(field.grid.point_count() * static_cast<std::size_t>(step_count));
    field.tower[c].resize(static_cast<std::size_t>(tower_count * step_count));
    for (auto* values : {&field.velocity[c], &field.tower[c]}) {
      for (float& value : *values) {
        const double random = uniform({7, RandomStream::test, 0, place++});
        value = static_cast<float>(mean[c] + width[c] * (random - 0.5));
      }
    }
  }
  return field;
}

std::string model(std::vector<test::MatVariable> cylinder_fields, bool compressed) {
  return bytes_written(
      [&](const std::string& path) { test::save_model(path, std::move(cylinder_fields), compressed); });
}

}  // namespace

std::vector<std::string> swc_seeds() {
  return {
      "1 1 0 0 0 1 -1\n2 3 0 0 2 1 1\n3 3 0.5 0 3 0.5 2\n4 3 -0.5 0 3 0.5 2\n",
      "# a comment\r\n1 1 0 0 0 0.1 -1\r\n\r\n2 2 0 0 1 0.1 1\r\n3 1 3 0 0 0.1 -1\r\n4 2 3 0 1 0.1 3\r\n",
      // A type for every column, ids in disorder, a lone root, a zero length, a root in the air.
      "7 5 1e5 2e5 3 0.2 -1\n3 6 1e5 2e5 4 0.1 7\n9 0 1e5 2e5 4 0.1 3\n1 1 1e5 2e5 9 0.1 -1\n2 0 1e5 2e5 10 "
      "0.1 1\n",
      swc_of(test::straight_stem(3, 2, 0.05, 0.02)),
      swc_of(test::random_tree(6, 2)),
      swc_of(grown(little_plant),
             {.bark = Eigen::Vector3f(0.5F, 0.4F, 0.3F), .leaf = Eigen::Vector3f(0, 1, 0)}),
  };
}

std::vector<std::string> treeqsm_text_seeds() {
  const std::string rows =
      "0.1\t1\t0\t0\t0\t0\t0\t1\t0\t2\t1\t0\t1\t0\t0.1\n"
      "0.08\t1\t0\t0\t1\t0\t0\t1\t1\t0\t1\t0\t2\t0\t0.08\n"
      "0.04\t0.5\t0.05\t0\t1\t1\t0\t0\t1\t0\t2\t1\t1\t0\t0.04\n";
  return {
      rows,
      "radius (m)\tlength "
      "(m)\tstart_point\taxis_direction\tparent\textension\tbranch\tbranch_order\tposition\tadded\t"
      "UnmodRadius\n" +
          rows,
      // 17 columns, a second stem, a cylinder of no length.
      "0.1 1 0 0 0 0 0 1 0 2 1 0 1 0.001 0.9 0 0.1\n"
      "0.1 1 0 0 1 0 0 1 1 0 1 0 2 0.001 0.9 0 0.1\n"
      "0.1 1 3 0 0 0 0 1 0 0 2 0 1 0.001 0.9 0 0.1\n"
      "0.05 0 0 0 2 0 0 1 2 0 1 0 3 0.001 0.9 1 0.05\n",
  };
}

std::vector<std::string> table_seeds() {
  const std::string header = "ID, parentID, startX, startY, startZ, endX, endY, endZ, radius, length\n";
  return {
      header + "0,-1,0,0,0,0,0,2,0.1,2\n1,0,0,0,2,0,0,3,0.1,1\n2,0,0.1,0,2,1,0,2.5,0.05,1\n",
      "branchID,branchOrder,ID,parentID,volume,radius,startX,startY,startZ,endX,endY,endZ\n"
      "0,0,10,-1,0.1,0.1,500000,4649776,250,500000,4649776,252\n"
      "0,0,11,10,0.1,0.08,500000,4649776,252,500000.1,4649776,254\n"
      "1,1,12,-1,0.1,0.03,500000,4649776.2,253,500001,4649777,254\n",
      // TreeQSM's columns in another order, R's row names, treegraph, raycloudtools.
      "\"\",\"extension\",\"parent\",\"radius\",\"length\",\"start\",\"axis\"\n"
      "\"1\",2,0,0.1,1,0,0,0,0,0,1\n\"2\",0,1,0.08,1,0,0,1,0,0,1\n",
      "\"\",\"start.1\",\"start.2\",\"start.3\",\"axis.1\",\"axis.2\",\"axis.3\",\"radius\",\"length\","
      "\"parent\"\n"
      "\"1\",0,0,0,0,0,1,0.1,1,0\n\"2\",0,0,1,0,0,1,0.08,1,1\n",
      "p1,p2,sx,sy,sz,ax,ay,az,radius,length\n1,-1,0,0,1,0,0,-1,0.1,1\n2,1,0,0,2,0,0,-1,0.08,1\n",
      "# tree file\nheight, x,y,z,radius,parent_id,section_id\n"
      "2, 0,0,0,0.1,-1,0, 0,0,1,0.1,0,1, 0,0,2,0.08,1,2, 0.5,0,2,0.04,1,3\n",
  };
}

std::vector<std::string> matlab_seeds() {
  std::vector<std::string> seeds;
  for (const bool compressed : {false, true}) {
    seeds.push_back(model(test::mat_cylinder_fields(test::small_table()), compressed));
    seeds.push_back(
        model(test::mat_cylinder_fields(test::small_table(), false, MAT_C_SINGLE, MAT_C_INT32), compressed));
    seeds.push_back(bytes_written([&](const std::string& path) {
      test::save_mat(path, test::mat_cylinder_fields(test::small_table(), true), compressed);
    }));
  }
  return seeds;
}

std::vector<std::string> skeleton_seeds() {
  std::vector<std::string> seeds;
  for (const auto& some : {swc_seeds(), treeqsm_text_seeds(), table_seeds(), matlab_seeds()})
    seeds.insert(seeds.end(), some.begin(), some.end());
  return seeds;
}

std::vector<std::string> frame_seeds() {
  return {
      "clamped = [\"a\"]\npieces = 2\n[points]\na = [0, 0, 0]\nb = [0, 0, 2]\nc = [1.0, 0, 2]\n"
      "[[beams]]\nthrough = [\"a\", \"b\", \"c\"]\nradius = [0.04, 0.02]\nmaterial = \"oak\"\n",
      "name = \"loop\"\nmaterial = \"birch\"\nclamped = ['a', 'b']\n[points]\na = [0, 0, 0]\nb = [1, 0, 0]\n"
      "top = [0.5, 0.2, 1]\n[[beams]]\nthrough = ['a', 'top', 'b', 'a']\nradius = 1e-2\npieces = 1\n"
      "[[masses]]\nat = 'top'\nmass = 0.5\n",
  };
}

std::vector<std::string> lsystem_seeds() {
  std::vector<std::string> seeds = {
      little_plant,
      "axiom: !(0.02) Stem(6)\nsteps: 10\nStem(n) : n > 0 -> F(0.3) Stem(n - 1)\n",
      "n = 3\naxiom: [ &(90) f(0.3) ^(90) A(n) ] A(n)\nsteps: n\nseed: 7\nradius: pipe\ntip_radius: 0.002\n"
      "A(k) : k > 0 && height() < 5 -> 3 F(rand(0.1, 0.2)) [ +(35) A(k - 1) ] -(25) A(k - 2)\n"
      "A(k) : k > 0 && height() < 5 -> 1 F(max(0.1, normal(0.2, 0.05))) \\(30) A(k - 1)\n"
      "A(k) : k <= 0 -> L(0.1, if(k == 0, 0.05, 0.1))\n",
  };
  for (const PlantPreset& preset : plant_presets()) {
    if (!preset.name.starts_with("stam-") || preset.name == "stam-17") seeds.push_back(preset.text);
  }
  return seeds;
}

std::vector<std::string> turbsim_seeds() {
  const auto bytes = [](const WindField& field) {
    return bytes_written([&](const std::string& path) { write_turbsim(path, field, "made for a test"); });
  };
  WindField still = small_field(1, 2, 4, 0, true);
  for (auto& component : still.velocity) component.assign(component.size(), 3.0F);
  return {bytes(small_field(3, 2, 16, 0, true)), bytes(small_field(2, 3, 8, 2, false)),
          bytes(small_field(1, 1, 1, 0, true)), bytes(still)};
}

std::vector<std::string> spectrum_seeds() {
  return {
      "frequency S_u S_v S_w\n0.01 10 6 1\n0.1 5 4 1\n1 0.2 0.2 0.1\n",
      "# by wave "
      "number\nk1_rad_per_m,Fu,Fv,Fw\n0.001,100,60,10\n0.01,50,40,10\n0.1,2,2,1\n1,0.05,0.06,0.05\n",
      "\xEF\xBB\xBFnote;frequency;S_u;S_v;S_w\r\n1;0.01;10;6;1\r\n2;1e3;1e-9;1e-9;1e-9\r\n",
  };
}

std::vector<std::string> profile_seeds() {
  return {
      "height_m speed_m_s direction_deg\n2 3 350\n10 5 355\n50 8 10\n",
      "# a mast\nz [m];U [m/s];heading [deg]\r\n0;0;-10\r\n40.5;6.25;20\r\n",
      "note,speed (m/s),height (m)\nlow,0,1\nhigh,100,1000\n",
  };
}

}  // namespace tremula::fuzz
