#include "tremula/io/skeleton_files.hpp"

#include <chrono>
#include <sstream>

#include "io/input_files.hpp"
#include "trees.hpp"

namespace tremula {
namespace {

using test::CylinderTable;
using test::TemporaryFolder;

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// The same small tree with a loose piece in every dialect.
struct Dialect {
  std::string format;
  std::string bytes;
};

std::vector<Dialect> every_dialect() {
  CylinderTable table = test::small_table();
  table.add(0.01, 0.25, {0.5, 0.25, 1}, {0, 1, 0}, 3);
  table.add(0.01, 0.25, {0.5, 0.1, 1}, {0, 1, 0}, 0);
  std::ostringstream swc, treeqsm, simpleforest;
  swc << "1 1 0 0 0 0.05 -1\n2 3 0 0 1 0.05 1\n3 3 0 0 2 0.04 2\n4 3 0.5 0 1 0.02 2\n5 1 0.5 0.1 1 0.01 -1\n"
         "6 3 0.5 0.35 1 0.01 5\n";
  simpleforest << "ID,parentID,startX,startY,startZ,endX,endY,endZ,radius\n";
  for (std::size_t k = 0; k < table.size(); ++k) {
    const Vec3 s = table.start[k], a = table.axis[k], e = s + table.length[k] * a;
    treeqsm << table.radius[k] << '\t' << table.length[k] << '\t' << s.x() << '\t' << s.y() << '\t' << s.z()
            << '\t' << a.x() << '\t' << a.y() << '\t' << a.z() << '\t' << table.parent[k]
            << "\t0\t1\t0\t1\t0\t1\n";
    simpleforest << k << ',' << table.parent[k] - 1 << ',' << s.x() << ',' << s.y() << ',' << s.z() << ','
                 << e.x() << ',' << e.y() << ',' << e.z() << ',' << table.radius[k] << "\r\n";
  }
  const TemporaryFolder folder;
  Skeleton skeleton = test::random_tree(6, 1);
  skeleton.branches[3].start_radius *= 0.5;
  skeleton.branches[4].start.x() += 0.125;
  Leaf leaf;
  leaf.branch = 2;
  leaf.base = skeleton.branches[2].end;
  leaf.length = leaf.width = leaf.area = leaf.mass = 0.1;
  skeleton.leaves.push_back(leaf);
  write_swc(skeleton, folder / "own.swc");
  test::save_model(folder / "packed.mat", test::mat_cylinder_fields(table));
  test::save_model(folder / "plain.mat", test::mat_cylinder_fields(table, false, MAT_C_SINGLE, MAT_C_UINT16),
                   false);
  test::save_mat(folder / "old.mat", test::mat_cylinder_fields(table, true), false);
  return {{"swc", swc.str()},
          {"swc", bytes_of(folder / "own.swc")},
          {"treeqsm-text", treeqsm.str()},
          {"simpleforest-csv", simpleforest.str()},
          {"archi-table",
           "startX,startY,startZ,endX,endY,endZ,cyl_ID,parent_ID,radius_cyl\n0,0,0,0,0,1,1,0,0.05\n"
           "0,0,1,0,0,2,2,1,0.04\n0,0,1,0.5,0,1,3,1,0.02\n"},
          {"treegraph-table",
           ",p1,p2,sx,sy,sz,ax,ay,az,radius,length\n0,8,7,0,0,1,0,0,-1,0.05,1\n"
           "1,9,8,0,0,2,0,0,-1,0.04,1\n2,12,8,0.5,0,1,-1,0,0,0.02,0.5\n"},
          {"raycloud-tree",
           "height,x,y,z,radius,parent_id,red\n2,0,0,0,0.1,-1,7, 0,0,1,0.05,0,7, 0,0,2,0.04,1,7, "
           "0.5,0,1,0.02,1,7\n"},
          {"treeqsm-mat", bytes_of(folder / "packed.mat")},
          {"treeqsm-mat", bytes_of(folder / "plain.mat")},
          {"treeqsm-mat", bytes_of(folder / "old.mat")}};
}

TEST(ReadSkeleton, KnowsADialectByItsContentWhateverItsName) {
  const TemporaryFolder folder;
  for (const Dialect& dialect : every_dialect()) {
    for (const char* name : {"tree", "tree.txt", "tree.csv", "tree.swc", "tree.mat", "tree.jpeg"}) {
      test::write_text(folder / name, dialect.bytes);
      EXPECT_EQ(read_skeleton(folder / name).format, dialect.format) << name;
    }
  }
}

// Damaged files either still hold a plant or are refused in one line. Never anything else.
TEST(ReadSkeleton, SurvivesEveryKindOfDamage) {
  constexpr std::uint64_t rounds = 2000;
  std::size_t read = 0, refused = 0;
  std::uint32_t which = 0;
  for (const Dialect& dialect : every_dialect()) {
    ++which;
    for (std::uint64_t round = 0; round < rounds; ++round) {
      const auto draw = [&](std::uint64_t k) { return uniform({round, RandomStream::test, which, k}); };
      const auto below = [&](std::uint64_t k, std::size_t n) {
        return static_cast<std::size_t>(draw(k) * static_cast<double>(n));
      };
      std::string bytes = dialect.bytes;
      const std::size_t changes = 1 + below(0, 2);
      for (std::uint64_t c = 1; c <= changes; ++c) {
        const std::size_t at = below(10 * c, bytes.size());
        const double kind = draw(10 * c + 1);
        if (kind < 0.3) {
          bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(10 * c + 2, 8)));
        } else if (kind < 0.5) {
          bytes[at] = "0123456789-+.eE \t\n,#"[below(10 * c + 2, 20)];
        } else if (kind < 0.6) {
          bytes[at] = static_cast<char>(below(10 * c + 2, 2) * 255);
        } else if (kind < 0.75) {
          bytes.erase(at, 1 + below(10 * c + 2, 20));
        } else if (kind < 0.9) {
          bytes.insert(at, bytes.substr(below(10 * c + 2, bytes.size()), below(10 * c + 3, 40)));
        } else {
          bytes.resize(at);
        }
        if (bytes.empty()) bytes.push_back('1');
      }
      try {
        const ImportedSkeleton imported = read_skeleton(bytes, "tree");
        check_skeleton(imported.skeleton, "damaged");
        ++read;
      } catch (const InputError& error) {
        const std::string text = error.what();
        EXPECT_TRUE(text.starts_with("tree")) << text;
        EXPECT_NE(text.find(", wanted "), std::string::npos) << text;
        EXPECT_TRUE(std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; }))
            << text;
        ++refused;
      }
    }
  }
  EXPECT_GT(read, rounds);  // damage that does not matter, or is mended, must not be the exception
  EXPECT_GT(refused, rounds);
}

TEST(ReadSkeleton, SaysTheSameThingTwice) {
  const TemporaryFolder folder;
  for (const Dialect& dialect : every_dialect()) {
    test::write_text(folder / "tree", dialect.bytes);
    write_swc(read_skeleton(folder / "tree").skeleton, folder / "a.swc");
    write_swc(read_skeleton(folder / "tree").skeleton, folder / "b.swc");
    EXPECT_EQ(bytes_of(folder / "a.swc"), bytes_of(folder / "b.swc"));
  }
}

// Loose pieces and children of one hub are where a careless reader becomes quadratic.
TEST(ReadSkeleton, JoinsAHundredThousandLoosePiecesInSeconds) {
#ifdef NDEBUG
  constexpr std::size_t count = 100000;
#else
  constexpr std::size_t count = 5000;  // the sanitizers alone make it fifty times slower
#endif
  std::ostringstream loose, hub;
  for (std::uint64_t k = 0; k < count; ++k) {
    const auto draw = [&](std::uint32_t what) { return uniform({1, RandomStream::test, what, k}); };
    loose << "0.01\t0.1\t" << 10 * draw(0) << '\t' << 10 * draw(1) << '\t' << 10 * draw(2)
          << "\t0\t0\t1\t0\t0\t1\t0\t1\t0\t1\n";
    hub << k + 1 << " 3 " << draw(0) << ' ' << draw(1) << ' ' << 1 + draw(2) << " 0.01 " << (k == 0 ? -1 : 1)
        << '\n';
  }
  const auto before = std::chrono::steady_clock::now();
  const ImportedSkeleton joined = read_skeleton(loose.str(), "loose", {.allow_gaps = true});
  EXPECT_EQ(test::count_of(joined, "joined_to_nearest"),
            count - static_cast<std::size_t>(joined.skeleton.root_count()));
  EXPECT_EQ(read_skeleton(hub.str(), "hub").skeleton.branches.size(), count - 1);
  // Takes one second; trying every branch for every loose piece takes a hundred times that.
  EXPECT_LT(std::chrono::steady_clock::now() - before, std::chrono::seconds(30));
}

}  // namespace
}  // namespace tremula
