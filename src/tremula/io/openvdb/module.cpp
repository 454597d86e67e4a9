#include "tremula/io/openvdb/module.hpp"

#include <cstdint>
#include <exception>
#include <sstream>
#include <utility>

#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

namespace tremula {
namespace {

void set_place(openvdb::GridBase& grid, const char* name, const VdbVolume& volume) {
  openvdb::Mat4d matrix = openvdb::Mat4d::identity();
  for (int i = 0; i < 3; ++i) {
    matrix[i][i] = volume.cell[i];
    matrix[3][i] = volume.low[i] + 0.5 * volume.cell[i];
  }
  grid.setTransform(openvdb::math::Transform::createLinearTransform(matrix));
  grid.setName(name);
}

// Where a file has an identity of its own, drawn by chance, it gets one by what is in it.
void set_identity(std::string& bytes) {
  constexpr std::size_t place = 21, length = 36;  // after magic, versions and a flag
  if (bytes.size() < place + length) return;
  std::uint64_t sum = 0xcbf29ce484222325U;  // FNV-1a
  for (std::size_t i = place + length; i < bytes.size(); ++i)
    sum = (sum ^ static_cast<unsigned char>(bytes[i])) * 0x100000001b3U;
  for (std::size_t i = 0; i < length; ++i) {
    if (bytes[place + i] == '-') continue;
    bytes[place + i] = "0123456789abcdef"[(sum >> (4 * (i % 16))) & 15U];
  }
}

void encode(const VdbVolume& volume, std::string& bytes) {
  openvdb::initialize();
  const auto density = openvdb::FloatGrid::create(0);
  const auto tangent = openvdb::Vec3SGrid::create(openvdb::Vec3s(0)),
             color = openvdb::Vec3SGrid::create(openvdb::Vec3s(0));
  set_place(*density, "density", volume);
  set_place(*tangent, "tangent", volume);
  set_place(*color, "color", volume);
  density->setGridClass(openvdb::GRID_FOG_VOLUME);
  constexpr float most_half = 65504;
  density->setSaveFloatAsHalf(volume.most_density <= most_half);
  tangent->setSaveFloatAsHalf(true);
  color->setSaveFloatAsHalf(true);
  auto to_density = density->getAccessor();
  auto to_tangent = tangent->getAccessor();
  auto to_color = color->getAccessor();
  for (int z = 0; z < volume.count[2]; ++z) {
    for (int y = 0; y < volume.count[1]; ++y) {
      for (int x = 0; x < volume.count[0]; ++x) {
        const TexelValue value = volume.value_at(volume.texels, x, y, z);
        if (!(value.density > 0)) continue;
        const openvdb::Coord at(x, y, z);
        to_density.setValue(at, value.density);
        to_tangent.setValue(at, {value.axis.x(), value.axis.y(), value.axis.z()});
        to_color.setValue(at, {value.color.x(), value.color.y(), value.color.z()});
      }
    }
  }
  std::ostringstream stream(std::ios::binary);
  openvdb::io::Stream(stream).write(openvdb::GridCPtrVec{density, tangent, color});
  bytes = std::move(stream).str();
  set_identity(bytes);
}

}  // namespace

extern "C" bool tremula_encode_vdb(const VdbVolume& volume, std::string& bytes) {
  try {
    encode(volume, bytes);
    return true;
  } catch (const std::exception& error) {
    bytes = error.what();
    return false;
  }
}

}  // namespace tremula
