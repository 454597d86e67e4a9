#include "tremula/io/vdb.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/io/openvdb/module.hpp"

#include <filesystem>
#include <vector>

#include <dlfcn.h>

namespace tremula {
namespace {

namespace fs = std::filesystem;

// Beside the program or the shared library that this is in, or where it was to be installed.
std::string path_of_module() {
#ifdef TREMULA_HAVE_OPENVDB
  const fs::path name = fs::path("tremula") / "openvdb.so";
  std::vector<fs::path> places;
  Dl_info here{};
  std::error_code error;
  if (::dladdr(reinterpret_cast<const void*>(&encode_vdb), &here) != 0 && here.dli_fname != nullptr) {
    const fs::path folder = fs::canonical(here.dli_fname, error).parent_path();
    if (!error) places = {folder / name, folder / ".." / TREMULA_LIBRARY_FOLDER / name};
  }
  const fs::path program = fs::read_symlink("/proc/self/exe", error).parent_path();
  if (!error) places.push_back(program / ".." / TREMULA_LIBRARY_FOLDER / name);
  places.push_back(fs::path(TREMULA_INSTALLED_LIBRARIES) / name);
  for (const fs::path& place : places) {
    if (fs::is_regular_file(place, error)) return place.string();
  }
#endif
  return {};
}

// Opened once and never closed: OpenVDB does not end its threads.
EncodeVdb* encoder() {
  const std::string path = path_of_module();
  if (path.empty()) {
    throw Error(
        "volumes are written by OpenVDB (libopenvdb-dev), and this tremula was built without it "
        "(TREMULA_OPENVDB), or has lost its tremula/openvdb.so");
  }
  void* const module = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* const symbol = module != nullptr ? ::dlsym(module, encode_vdb_name) : nullptr;
  if (symbol == nullptr) {
    const char* const reason = ::dlerror();
    throw Error("cannot open OpenVDB: " + (reason != nullptr ? std::string(reason) : path));
  }
  return reinterpret_cast<EncodeVdb*>(symbol);
}

}  // namespace

bool has_vdb() { return !path_of_module().empty(); }

std::string encode_vdb(const Texels& texels, const Vec3& low) {
  check_equal("texels of a texture", static_cast<std::ptrdiff_t>(texels.values.size()),
              static_cast<std::ptrdiff_t>(texels.count[0]) * texels.count[1] * texels.count[2]);
  static EncodeVdb* const encode = encoder();
  VdbVolume volume;
  volume.count = texels.count;
  volume.cell = texels.cell.cast<double>();
  volume.low = low;
  volume.most_density = 65535 * texels.density_step;
  volume.texels = &texels;
  volume.value_at = [](const void* of, int x, int y, int z) {
    return value_of(*static_cast<const Texels*>(of), x, y, z);
  };
  std::string bytes;
  if (!encode(volume, bytes)) throw Error("cannot encode a volume as OpenVDB: " + bytes);
  return bytes;
}

}  // namespace tremula
