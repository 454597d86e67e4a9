#include "tremula/io/vti.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/atomic_file.hpp"
#include "tremula/io/finite.hpp"
#include "tremula/wind/check_field.hpp"

#include <bit>
#include <cstdint>
#include <cstdio>
#include <vector>

namespace tremula {
namespace {

static_assert(std::endian::native == std::endian::little, "the file says that it is little endian");

template <class... Numbers>
std::string print(const char* format, Numbers... numbers) {
  char text[400];
  std::snprintf(text, sizeof text, format, numbers...);
  return text;
}

}  // namespace

void write_vti(AtomicFile& out, const WindField& field, const VtiOptions& options) {
  check_wind_field(field);
  for (const std::vector<float>& component : field.velocity)
    check_finite("wind field: velocities", component);
  const WindGrid& grid = field.grid;
  const int most = grid.step_count - options.first_step,
            count = options.step_count == 0 ? most : options.step_count;
  if (options.first_step < 0 || count < 1 || count > most) {
    throw InputError("steps of the box of wind",
                     std::to_string(options.step_count) + " from " + std::to_string(options.first_step),
                     "some of the " + std::to_string(grid.step_count) + " of the field");
  }
  if (!(grid.mean_speed > 0)) {
    throw InputError("mean speed of the wind field", std::to_string(grid.mean_speed),
                     "above 0 m/s, to make a box of wind of it");
  }

  // VTK wants spacings above 0 even where there is one point.
  const auto spacing = [](int points, double value) { return points > 1 ? value : 1.0; };
  const std::string extent = print("0 %d 0 %d 0 %d", count - 1, grid.y_count - 1, grid.z_count - 1);
  const auto points = static_cast<std::uint64_t>(count) * grid.point_count();
  out.write(
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
      "  <ImageData WholeExtent=\"" +
      extent + "\" Origin=\"" + print("0 %.9g %.9g", grid.y(0), grid.z(0)) + "\" Spacing=\"" +
      print("%.9g %.9g %.9g", grid.mean_speed * grid.step, spacing(grid.y_count, grid.y_spacing),
            spacing(grid.z_count, grid.z_spacing)) +
      "\">\n    <Piece Extent=\"" + extent +
      "\">\n      <PointData Vectors=\"velocity\">\n"
      "        <DataArray type=\"Float32\" Name=\"velocity\" NumberOfComponents=\"3\" format=\"appended\" "
      "offset=\"0\"/>\n"
      "      </PointData>\n    </Piece>\n  </ImageData>\n  <AppendedData encoding=\"raw\">\n_");
  const std::uint64_t size = 12 * points;
  out.write({reinterpret_cast<const char*>(&size), sizeof size});
  std::vector<float> row(3 * static_cast<std::size_t>(count) * static_cast<std::size_t>(grid.y_count));
  const std::size_t last = static_cast<std::size_t>(options.first_step + count - 1);
  for (std::size_t i = 0; i < static_cast<std::size_t>(grid.z_count); ++i) {
    for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k) {
      for (std::size_t j = 0; j < static_cast<std::size_t>(grid.y_count); ++j) {
        const std::size_t from = ((last - k) * static_cast<std::size_t>(grid.z_count) + i) *
                                     static_cast<std::size_t>(grid.y_count) +
                                 j;
        for (std::size_t c = 0; c < 3; ++c)
          row[3 * (j * static_cast<std::size_t>(count) + k) + c] = field.velocity[c][from];
      }
    }
    out.write({reinterpret_cast<const char*>(row.data()), row.size() * sizeof(float)});
  }
  out.write("\n  </AppendedData>\n</VTKFile>\n");
}

void write_vti(const std::string& path, const WindField& field, const VtiOptions& options) {
  AtomicFile out(path);
  write_vti(out, field, options);
  out.commit();
}

}  // namespace tremula
