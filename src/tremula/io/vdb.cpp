#include "tremula/io/vdb.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"

#ifdef TREMULA_HAVE_OPENVDB

#include <cstdint>
#include <exception>
#include <sstream>

#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

namespace tremula {
namespace {

void set_place(openvdb::GridBase& grid, const char* name, const Texels& texels, const Vec3& low) {
  openvdb::Mat4d matrix = openvdb::Mat4d::identity();
  for (int i = 0; i < 3; ++i) {
    const auto cell = static_cast<double>(texels.cell[i]);
    matrix[i][i] = cell;
    matrix[3][i] = low[i] + 0.5 * cell;
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

}  // namespace

bool has_vdb() { return true; }

std::string encode_vdb(const Texels& texels, const Vec3& low) {
  check_equal("texels of a texture", static_cast<std::ptrdiff_t>(texels.values.size()),
              static_cast<std::ptrdiff_t>(texels.count[0]) * texels.count[1] * texels.count[2]);
  try {
    openvdb::initialize();
    const auto density = openvdb::FloatGrid::create(0);
    const auto tangent = openvdb::Vec3SGrid::create(openvdb::Vec3s(0)),
               color = openvdb::Vec3SGrid::create(openvdb::Vec3s(0));
    set_place(*density, "density", texels, low);
    set_place(*tangent, "tangent", texels, low);
    set_place(*color, "color", texels, low);
    density->setGridClass(openvdb::GRID_FOG_VOLUME);
    constexpr float most_half = 65504;
    density->setSaveFloatAsHalf(65535 * texels.density_step <= most_half);
    tangent->setSaveFloatAsHalf(true);
    color->setSaveFloatAsHalf(true);
    auto to_density = density->getAccessor();
    auto to_tangent = tangent->getAccessor();
    auto to_color = color->getAccessor();
    for (int z = 0; z < texels.count[2]; ++z) {
      for (int y = 0; y < texels.count[1]; ++y) {
        for (int x = 0; x < texels.count[0]; ++x) {
          const TexelValue value = value_of(texels, x, y, z);
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
    std::string bytes = std::move(stream).str();
    set_identity(bytes);
    return bytes;
  } catch (const std::exception& error) {
    throw Error(std::string("cannot encode a volume as OpenVDB: ") + error.what());
  }
}

}  // namespace tremula

#else

namespace tremula {

bool has_vdb() { return false; }

std::string encode_vdb(const Texels&, const Vec3&) {
  throw Error(
      "volumes are written by OpenVDB (libopenvdb-dev), and this tremula was built without it "
      "(TREMULA_OPENVDB)");
}

}  // namespace tremula

#endif
