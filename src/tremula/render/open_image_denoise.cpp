#include "tremula/render/open_image_denoise.hpp"

#include "tremula/base/error.hpp"

#include <utility>

#include <dlfcn.h>

namespace tremula {
namespace {

// As in OpenImageDenoise/oidn.h, which is the same in versions 1 and 2 as far as it is used here.
constexpr int cpu_device = 1, float3_format = 3;

}  // namespace

struct OpenImageDenoise::Functions {
  void* library = nullptr;
  void* (*new_device)(int type) = nullptr;
  void (*commit_device)(void* device) = nullptr;
  void (*release_device)(void* device) = nullptr;
  int (*device_error)(void* device, const char** message) = nullptr;
  int (*device_int)(void* device, const char* name) = nullptr;
  void* (*new_filter)(void* device, const char* type) = nullptr;
  void (*set_image)(void* filter, const char* name, void* data, int format, std::size_t width,
                    std::size_t height, std::size_t offset, std::size_t pixel_stride,
                    std::size_t row_stride) = nullptr;
  void (*set_bool)(void* filter, const char* name, bool value) = nullptr;
  void (*commit_filter)(void* filter) = nullptr;
  void (*execute_filter)(void* filter) = nullptr;
  void (*release_filter)(void* filter) = nullptr;

  Functions() = default;
  Functions(const Functions&) = delete;
  Functions& operator=(const Functions&) = delete;
  ~Functions() {
    if (library != nullptr) ::dlclose(library);
  }

  // Version 2 calls oidnSetFilterBool what was oidnSetFilter1b.
  template <class Function>
  bool find(Function& function, const char* name, const char* old_name = nullptr) {
    function = reinterpret_cast<Function>(::dlsym(library, name));
    if (function == nullptr && old_name != nullptr)
      function = reinterpret_cast<Function>(::dlsym(library, old_name));
    return function != nullptr;
  }
  bool find_all() {
    return find(new_device, "oidnNewDevice") && find(commit_device, "oidnCommitDevice") &&
           find(release_device, "oidnReleaseDevice") && find(device_error, "oidnGetDeviceError") &&
           find(device_int, "oidnGetDeviceInt", "oidnGetDevice1i") && find(new_filter, "oidnNewFilter") &&
           find(set_image, "oidnSetSharedFilterImage") &&
           find(set_bool, "oidnSetFilterBool", "oidnSetFilter1b") &&
           find(commit_filter, "oidnCommitFilter") && find(execute_filter, "oidnExecuteFilter") &&
           find(release_filter, "oidnReleaseFilter");
  }
};

OpenImageDenoise::OpenImageDenoise(std::unique_ptr<Functions> functions) : functions_(std::move(functions)) {}
OpenImageDenoise::~OpenImageDenoise() = default;

std::unique_ptr<OpenImageDenoise> OpenImageDenoise::load(const std::string& library) {
  auto functions = std::make_unique<Functions>();
  const auto open = [&](const char* name) { functions->library = ::dlopen(name, RTLD_NOW | RTLD_LOCAL); };
  if (!library.empty()) open(library.c_str());
  for (const char* name : {"libOpenImageDenoise.so.2", "libOpenImageDenoise.so.1", "libOpenImageDenoise.so.0",
                           "libOpenImageDenoise.so"}) {
    if (library.empty() && functions->library == nullptr) open(name);
  }
  if (functions->library == nullptr || !functions->find_all()) return nullptr;
  return std::unique_ptr<OpenImageDenoise>(new OpenImageDenoise(std::move(functions)));
}

void* OpenImageDenoise::new_device() {
  void* device = functions_->new_device(cpu_device);
  if (device == nullptr) check(nullptr);
  functions_->commit_device(device);
  return device;
}

void OpenImageDenoise::check(void* device) {
  const char* message = nullptr;
  if (functions_->device_error(device, &message) == 0 && device != nullptr) return;
  const std::string said = message != nullptr ? message : "it does not say why";
  if (device != nullptr) functions_->release_device(device);
  throw Error("Open Image Denoise fails: " + said);
}

std::string OpenImageDenoise::version() {
  void* device = new_device();
  std::string text;
  for (const char* part : {"versionMajor", "versionMinor", "versionPatch"}) {
    if (!text.empty()) text += '.';
    text += std::to_string(functions_->device_int(device, part));
  }
  functions_->release_device(device);
  return text;
}

LinearImage OpenImageDenoise::denoise(const TracedImage& traced) {
  LinearImage result = traced.light;
  TracedImage in = traced;  // its interface takes no constant data
  void* device = new_device();
  void* filter = functions_->new_filter(device, "RT");
  if (filter == nullptr) {
    check(device);
    functions_->release_device(device);
    throw Error("Open Image Denoise fails: it has no filter for traced pictures");
  }
  const auto set = [&](const char* name, LinearImage& image) {
    functions_->set_image(filter, name, image.rgb.data(), float3_format,
                          static_cast<std::size_t>(image.width), static_cast<std::size_t>(image.height), 0, 0,
                          0);
  };
  set("color", in.light);
  set("albedo", in.albedo);
  set("normal", in.normal);
  set("output", result);
  functions_->set_bool(filter, "hdr", true);
  functions_->commit_filter(filter);
  functions_->execute_filter(filter);
  functions_->release_filter(filter);
  check(device);
  functions_->release_device(device);
  return result;
}

}  // namespace tremula
