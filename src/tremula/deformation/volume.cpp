#include "tremula/deformation/volume.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/base/noise.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2f;
using Eigen::Vector3d;
using Eigen::Vector3f;
using Eigen::Vector4f;

// A map over the field and `beyond` it.
template <class Value>
FieldMap<Value> map_over(const VolumeField& field, double beyond, double finest, int most) {
  const Vector2d low = field.low.array() - beyond,
                 size = field.high - field.low + Vector2d::Constant(2 * beyond);
  FieldMap<Value> map;
  const double spacing = std::max(finest, size.maxCoeff() / most);
  map.low = low.cast<float>();
  map.spacing = static_cast<float>(spacing);
  map.columns = 2 + static_cast<int>(size.x() / spacing);
  map.rows = 2 + static_cast<int>(size.y() / spacing);
  map.values.resize(index_of(map.columns) * index_of(map.rows));
  return map;
}

template <class Value, class Make>
void fill(FieldMap<Value>& map, const Make& make) {
  tbb::parallel_for(0, map.rows, [&](int j) {
    for (int i = 0; i < map.columns; ++i) {
      const Vector2f place = map.low + map.spacing * Vector2f(static_cast<float>(i), static_cast<float>(j));
      map.values[index_of(j) * index_of(map.columns) + index_of(i)] = make(place.cast<double>());
    }
  });
}

// A place of the field in the square of the patch that it lies in.
struct InPatch {
  std::size_t variant;
  Vector3f within;  // [m]
};
InPatch in_patch(const VolumeField& field, const RestPlace& rest) {
  const Vector3f size = field.patches.front().front().size();
  const float column = std::floor(rest.at.x() / size.x()), row = std::floor(rest.at.y() / size.y());
  return {variant_at(field.patches.size(), field.seed, static_cast<int>(column), static_cast<int>(row)),
          {rest.at.x() - column * size.x(), rest.at.y() - row * size.y(),
           rest.s * static_cast<float>(field.height)}};
}

ClearBlocks clear_blocks(const VolumeField& field) {
  const Texels& shape = field.patches.front().front();
  ClearBlocks blocks;
  for (std::size_t i = 0; i < 3; ++i) blocks.count[i] = (shape.count[i] + clear_block - 1) / clear_block;
  const auto [nx, ny, nz] = blocks.count;
  const auto at = [&](int x, int y, int z) { return index_of((z * ny + y) * nx + x); };
  for (const std::vector<Texels>& levels : field.patches) {
    const Texels& texels = levels.front();
    std::vector<std::uint8_t> full(index_of(nx * ny * nz), 0), clear(full.size(), 1);
    for (int z = 0; z < texels.count[2]; ++z) {
      for (int y = 0; y < texels.count[1]; ++y) {
        for (int x = 0; x < texels.count[0]; ++x) {
          if (texels.values[texels.index(x, y, z)].density > 0)
            full[at(x / clear_block, y / clear_block, z / clear_block)] = 1;
        }
      }
    }
    for (int z = 0; z < nz; ++z) {
      for (int y = 0; y < ny; ++y) {
        for (int x = 0; x < nx; ++x) {
          for (int k = 0; k < 27; ++k) {
            const int above = std::clamp(z + k / 9 - 1, 0, nz - 1);
            if (full[at((x + k % 3 - 1 + nx) % nx, (y + k / 3 % 3 - 1 + ny) % ny, above)] != 0)
              clear[at(x, y, z)] = 0;
          }
        }
      }
    }
    blocks.clear.push_back(std::move(clear));
  }
  return blocks;
}

int wrapped(float place, int count) {  // place in cells, within a patch or a little beyond
  const int cell = static_cast<int>(std::floor(place)) % count;
  return cell < 0 ? cell + count : cell;
}

}  // namespace

std::size_t variant_at(std::size_t variants, std::uint32_t seed, int column, int row) {
  if (variants == 1) return 0;
  const std::uint32_t number =
      hash(hash(static_cast<std::uint32_t>(column) + seed) + 0x9e3779b9U * static_cast<std::uint32_t>(row));
  return number % variants;
}

void check_volume(const VolumeField& field) {
  if (field.patches.empty() || field.patches.front().empty())
    throw InputError("textures of the volume", "none", "one or more");
  const std::vector<Texels>& first = field.patches.front();
  for (const std::vector<Texels>& levels : field.patches) {
    check_equal("levels of a texture", static_cast<std::ptrdiff_t>(levels.size()),
                static_cast<std::ptrdiff_t>(first.size()));
    for (std::size_t i = 0; i < levels.size(); ++i) {
      const Texels& texels = levels[i];
      if (texels.count != first[i].count || texels.cell != first[i].cell)
        throw InputError("textures of the volume", "sizes that differ", "one size");
      check_equal("texels of a texture", static_cast<std::ptrdiff_t>(texels.values.size()),
                  static_cast<std::ptrdiff_t>(texels.count[0]) * texels.count[1] * texels.count[2]);
      if (texels.values.empty() || !(texels.cell.minCoeff() > 0))
        throw InputError("textures of the volume", "no texels", "one or more");
    }
  }
  check_positive("height of the volume", field.height, " m");
  if (!field.low.allFinite() || !field.high.allFinite() || !std::isfinite(field.ground))
    throw InputError("field of the volume", "a number that is not finite", "finite numbers");
  if (!((field.high - field.low).minCoeff() > 0))
    throw InputError("field of the volume", "no area", "one that ends after it begins");
  if (!(field.most_sway >= 0) || !std::isfinite(field.most_sway))
    throw InputError("sway of the volume", number_text(field.most_sway) + " m", "0 or more");
}

VolumeGround prepare_volume(std::shared_ptr<const VolumeField> field) {
  check_volume(*field);
  VolumeGround ground;
  const double finest = std::max(2 * static_cast<double>(field->patches[0][0].cell.x()),
                                 (field->high - field->low).minCoeff() / 256);
  auto map = std::make_shared<FieldMap<float>>(map_over<float>(*field, 0, finest, 4096));
  fill(*map, [&](const Vector2d& place) {
    const bool within = (place.array() <= field->high.array()).all();
    if (!within) return 0.0F;
    return field->tallness ? static_cast<float>(std::clamp(field->tallness(place), 0.0, 1.0)) : 1.0F;
  });
  ground.unbent = std::make_shared<const UnbentTable>();
  ground.tallness = std::move(map);
  ground.clear = std::make_shared<const ClearBlocks>(clear_blocks(*field));
  ground.field = std::move(field);
  return ground;
}

PosedVolume pose_volume(const VolumeGround& ground, double time, double shutter) {
  const VolumeField& field = *ground.field;
  PosedVolume posed{.field = ground.field,
                    .unbent = ground.unbent,
                    .tallness = ground.tallness,
                    .clear = ground.clear,
                    .bend = {},
                    .bounds = {}};
  const double most = field.sway ? field.most_sway : 0;
  const double finest = std::max(0.02, std::min(0.2, (field.high - field.low).minCoeff() / 32));
  posed.bend = map_over<Vector4f>(field, most, finest, 1536);
  fill(posed.bend, [&](const Vector2d& place) -> Vector4f {
    if (!field.sway) return Vector4f::Zero();
    const auto bend_at = [&](double at) -> Vector2f {
      const Vector2d top = field.sway(place, at);
      const double far = std::min(top.norm(), most);
      if (!(far > 0)) return Vector2f::Zero();
      return (tip_angle(far / field.height) / top.norm() * top).cast<float>();
    };
    const Vector2f first = bend_at(time - shutter / 2),
                   last = shutter > 0 ? bend_at(time + shutter / 2) : first;
    return {first.x(), first.y(), last.x(), last.y()};
  });
  if (!std::ranges::all_of(posed.bend.values, [](const Vector4f& bend) { return bend.allFinite(); }))
    throw Error("the sway of a volume has numbers that are not finite");
  // Tops lean out; the area at the foot of what leans in is a little smaller.
  const double out = std::min(most, field.height);
  posed.bounds.min() = Vector3d(field.low.x() - out, field.low.y() - out, field.ground).cast<float>();
  posed.bounds.max() =
      Vector3d(field.high.x() + out, field.high.y() + out, field.ground + field.height).cast<float>();
  return posed;
}

bool unbend(const PosedVolume& volume, const Vector3f& place, float shutter, Vector2f& guess,
            RestPlace& rest) {
  const VolumeField& field = *volume.field;
  const auto height = static_cast<float>(field.height);
  rest.at = place.head<2>() - guess;
  const float tall = volume.tallness->at<float>(volume.tallness->place_of(rest.at));
  if (!(tall > 0.02F)) return false;
  const float low_x = static_cast<float>(field.low.x()), low_y = static_cast<float>(field.low.y());
  const Vector4f both = volume.bend.at<Vector4f>(volume.bend.place_of(rest.at));
  const Vector2f bend = (1 - shutter) * both.head<2>() + shutter * both.tail<2>();
  const float tip = bend.norm();
  UnbentStation station;
  const float up = (place.z() - static_cast<float>(field.ground)) / (height * tall);
  if (!volume.unbent->find(tip, up, station)) return false;
  rest.along = tip > 1e-6F ? Vector2f(bend / tip) : Vector2f(1, 0);
  guess = height * tall * station.along * rest.along;
  rest.at = place.head<2>() - guess;
  rest.s = station.s;
  rest.angle = station.angle;
  return rest.at.x() >= low_x && rest.at.y() >= low_y && rest.at.x() <= static_cast<float>(field.high.x()) &&
         rest.at.y() <= static_cast<float>(field.high.y());
}

TexelValue value_at(const PosedVolume& volume, const RestPlace& rest, int level, const Vector3f& jitter) {
  const VolumeField& field = *volume.field;
  const auto [variant, within] = in_patch(field, rest);
  const Texels& texels = field.patches[variant][static_cast<std::size_t>(level)];
  const Vector3f cell = within.cwiseQuotient(texels.cell) + jitter;
  const int layer = std::clamp(static_cast<int>(std::floor(cell.z())), 0, texels.count[2] - 1);
  const Texel& texel = texels.values[texels.index(wrapped(cell.x(), texels.count[0]),
                                                  wrapped(cell.y(), texels.count[1]), layer)];
  if (texel.density == 0) return {};
  TexelValue value = value_of(texel, texels.density_step);
  if (rest.angle == 0) return value;
  const float sine = std::sin(rest.angle), cosine = std::cos(rest.angle), up = value.axis.z();
  const Vector3f turned(value.axis.x() + up * sine * rest.along.x(),
                        value.axis.y() + up * sine * rest.along.y(), up * cosine);
  const float stretch = turned.norm();
  value.axis = turned / stretch;
  value.density *= stretch / cosine;
  return value;
}

float clearance_at(const PosedVolume& volume, const RestPlace& rest) {
  const VolumeField& field = *volume.field;
  const auto [variant, within] = in_patch(field, rest);
  const Texels& texels = field.patches[variant].front();
  const ClearBlocks& blocks = *volume.clear;
  std::array<int, 3> block{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    block[i] =
        std::clamp(static_cast<int>(within[k] / (texels.cell[k] * clear_block)), 0, blocks.count[i] - 1);
  }
  const auto at = index_of((block[2] * blocks.count[1] + block[1]) * blocks.count[0] + block[0]);
  // Half a texel less, for who looks up beside the place; heights are pressed together by the cosine.
  return blocks.clear[variant][at] != 0 ? (clear_block - 1) * texels.cell.minCoeff() * std::cos(rest.angle)
                                        : 0;
}

Texels resample(const PosedVolume& volume, const Vector3d& low, const std::array<int, 3>& count,
                double cell) {
  check_positive("size of a texel", cell, " m");
  for (const int each : count) check_at_least("texels of a box", each, 1);
  const double all = static_cast<double>(count[0]) * count[1] * count[2];
  if (!(all <= most_texels))
    throw InputError("texels of a box", number_text(all), "at most " + number_text(most_texels));
  const std::vector<Texels>& levels = volume.field->patches.front();
  int level = 0;
  while (index_of(level) + 1 < levels.size() &&
         static_cast<double>(levels[index_of(level + 1)].cell.x()) <= 1.01 * cell) {
    ++level;
  }
  Texels box{.count = count,
             .cell = Vector3f::Constant(static_cast<float>(cell)),
             .repeats = false,
             .density_step = 1,
             .values = {}};
  box.values.resize(static_cast<std::size_t>(all));
  std::vector<float> densities(box.values.size(), 0.0F), most(index_of(count[2]), 0.0F);
  tbb::parallel_for(0, count[2], [&](int z) {
    for (int y = 0; y < count[1]; ++y) {
      Vector2f guess = Vector2f::Zero();
      for (int x = 0; x < count[0]; ++x) {
        const Vector3f place = (low + cell * (Vector3d(x, y, z).array() + 0.5).matrix()).cast<float>();
        RestPlace rest;
        if (x == 0) unbend(volume, place, 0.5F, guess, rest);  // for the guess
        if (!unbend(volume, place, 0.5F, guess, rest)) continue;
        const TexelValue value = value_at(volume, rest, level);
        if (!(value.density > 0)) continue;
        const std::size_t at = box.index(x, y, z);
        box.values[at] = texel_of(value, value.density);
        densities[at] = value.density;
        most[index_of(z)] = std::max(most[index_of(z)], value.density);
      }
    }
  });
  const float densest = *std::ranges::max_element(most);
  box.density_step = densest > 0 ? densest / 65535 : 1;
  tbb::parallel_for(std::size_t{0}, box.values.size(), [&](std::size_t i) {
    box.values[i].density = static_cast<std::uint16_t>(std::lround(densities[i] / box.density_step));
  });
  return box;
}

}  // namespace tremula
