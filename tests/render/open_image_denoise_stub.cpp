// Stands in for Intel Open Image Denoise: the part of its C interface that is used, as STUB_VERSION has it.
#include <cstddef>
#include <cstring>

namespace {

struct Filter {
  float* images[4] = {};
  std::size_t width = 0, height = 0;
  bool hdr = false, committed = false;
};
const char* error = nullptr;

}  // namespace

extern "C" {
void* oidnNewDevice(int type) {
  static int device;
  return type == 1 ? &device : nullptr;
}
void oidnCommitDevice(void*) {}
void oidnReleaseDevice(void*) {}
int oidnGetDeviceError(void*, const char** message) {
  *message = error;
  const bool failed = error != nullptr;
  error = nullptr;
  return failed ? 1 : 0;
}
#if STUB_VERSION == 1
int oidnGetDevice1i(void*, const char* name) {
  return std::strcmp(name, "versionMajor") == 0 ? 1 : std::strcmp(name, "versionMinor") == 0 ? 4 : 3;
}
#else
int oidnGetDeviceInt(void*, const char* name) {
  return std::strcmp(name, "versionMajor") == 0 ? 2 : std::strcmp(name, "versionMinor") == 0 ? 3 : 1;
}
#endif
void* oidnNewFilter(void*, const char* type) { return std::strcmp(type, "RT") == 0 ? new Filter : nullptr; }
void oidnSetSharedFilterImage(void* filter, const char* name, void* data, int format, std::size_t width,
                              std::size_t height, std::size_t, std::size_t, std::size_t) {
  auto& to = *static_cast<Filter*>(filter);
  const char* names[] = {"color", "albedo", "normal", "output"};
  for (int i = 0; i < 4; ++i)
    if (std::strcmp(name, names[i]) == 0 && format == 3) to.images[i] = static_cast<float*>(data);
  to.width = width;
  to.height = height;
}
#if STUB_VERSION == 1
void oidnSetFilter1b(void* filter, const char* name, bool value) {
#else
void oidnSetFilterBool(void* filter, const char* name, bool value) {
#endif
  if (std::strcmp(name, "hdr") == 0) static_cast<Filter*>(filter)->hdr = value;
}
void oidnCommitFilter(void* filter) { static_cast<Filter*>(filter)->committed = true; }
void oidnExecuteFilter(void* filter) {
  const auto& from = *static_cast<Filter*>(filter);
  if (from.width == 13) error = "thirteen is too much";
  if (!from.committed || !from.hdr) error = "it was not set up";
  if (error != nullptr) return;
  for (std::size_t i = 0; i < 3 * from.width * from.height; ++i)
    from.images[3][i] = from.images[0][i] + from.images[1][i];
}
void oidnReleaseFilter(void* filter) { delete static_cast<Filter*>(filter); }
}
