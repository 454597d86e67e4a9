// A field of plants as texels: a patch repeated over an area, bent by how the wind moves the tops of the
// plants at every place.
#pragma once

#include "tremula/deformation/bent_space.hpp"
#include "tremula/geometry/texels.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace tremula {

struct VolumeField {
  // (variants) textures of one patch, each with its mip levels; all of the same sizes. Every square of the
  // field takes one of them by chance.
  std::vector<std::vector<Texels>> patches;
  Eigen::Vector2d low{-10, -10}, high{10, 10};  // of the field [m]
  double ground = 0;                            // its height [m]
  double height = 1;                            // of the texture, 0 … that: the plants may be lower [m]
  // How tall plants are at a place, by what they would be, 0 … 1; empty: 1.
  std::function<double(const Eigen::Vector2d& place)> tallness;
  TopSway sway;          // empty: they stand still
  double most_sway = 0;  // no top is displaced further, or that far counts [m]
  std::uint32_t seed = 1;
};

// Which patch lies in a square of a field, its columns and rows counted from the origin.
std::size_t variant_at(std::size_t variants, std::uint32_t seed, int column, int row);

// Throws InputError for a field without textures or an area, with textures that differ in size, and for
// numbers that are not finite or, of heights, not above 0.
void check_volume(const VolumeField& field);

// Some grid of values over the field, linear in between.
template <class Value>
struct FieldMap {
  Eigen::Vector2f low{0, 0};
  float spacing = 1;  // [m]
  int columns = 1, rows = 1;
  std::vector<Value> values;

  struct Place {
    std::size_t corner;
    float x, y;
  };
  Place place_of(const Eigen::Vector2f& at) const {
    const float x = std::clamp((at.x() - low.x()) / spacing, 0.0F, static_cast<float>(columns - 1)),
                y = std::clamp((at.y() - low.y()) / spacing, 0.0F, static_cast<float>(rows - 1));
    const int i = std::min(static_cast<int>(x), columns - 2), j = std::min(static_cast<int>(y), rows - 2);
    return {index_of(j) * index_of(columns) + index_of(i), x - static_cast<float>(i),
            y - static_cast<float>(j)};
  }
  template <class To>
  To at(const Place& p) const {
    const Value* low_row = &values[p.corner];
    const Value* high_row = low_row + columns;
    return To((1 - p.y) * ((1 - p.x) * To(low_row[0]) + p.x * To(low_row[1])) +
              p.y * ((1 - p.x) * To(high_row[0]) + p.x * To(high_row[1])));
  }
};

// Blocks of so many texels, across, of every variant: 1 where they and all blocks around them are empty.
inline constexpr int clear_block = 4;
struct ClearBlocks {
  std::array<int, 3> count = {1, 1, 1};
  std::vector<std::vector<std::uint8_t>> clear;  // (variants)
};

// The field at one time, or while a shutter is open, from 0 to 1.
struct PosedVolume {
  std::shared_ptr<const VolumeField> field;
  std::shared_ptr<const UnbentTable> unbent;
  std::shared_ptr<const FieldMap<float>> tallness;
  std::shared_ptr<const ClearBlocks> clear;
  FieldMap<Eigen::Vector4f> bend;  // tip_angle() times the unit vector in which tops go: opening, closing
  Eigen::AlignedBox3f bounds;      // of all that is there [m]
};

// What a field needs at all times.
struct VolumeGround {
  std::shared_ptr<const VolumeField> field;
  std::shared_ptr<const UnbentTable> unbent;
  std::shared_ptr<const FieldMap<float>> tallness;
  std::shared_ptr<const ClearBlocks> clear;
};
VolumeGround prepare_volume(std::shared_ptr<const VolumeField> field);
// Throws Error where the sway is not finite.
PosedVolume pose_volume(const VolumeGround& ground, double time, double shutter = 0);

// Where a place was at rest, and how space is bent there.
struct RestPlace {
  Eigen::Vector2f at{0, 0};     // [m]
  float s = 0;                  // height by that of the plants
  float angle = 0;              // [rad]
  Eigen::Vector2f along{1, 0};  // unit, in which they bend
};
// `guess`: the displacement [m] found nearby; it is put right. False above the plants.
bool unbend(const PosedVolume& volume, const Eigen::Vector3f& place, float shutter, Eigen::Vector2f& guess,
            RestPlace& rest);

// What is at a place of the posed field, with its axis turned and its density changed as the space is bent:
// a' = a |F t|/det F. `level`: of the mips. `jitter`: from where in the texture is looked up instead, in
// texels. Density 0 where there is nothing.
TexelValue value_at(const PosedVolume& volume, const RestPlace& rest, int level,
                    const Eigen::Vector3f& jitter = Eigen::Vector3f::Zero());

// How far there is nothing around a place of the finest texture [m]: a lower bound, often 0.
float clearance_at(const PosedVolume& volume, const RestPlace& rest);

// A box of the posed field as texels of its own that do not repeat: for files. `low`: of the box [m]; `count`
// texels of `cell` [m]. Throws InputError for more than most_texels.
Texels resample(const PosedVolume& volume, const Eigen::Vector3d& low, const std::array<int, 3>& count,
                double cell);

}  // namespace tremula
