// Intel Open Image Denoise, 1 or 2, by the few functions of its C interface that are needed, looked up at run
// time.
#pragma once

#include "tremula/render/linear_image.hpp"

#include <memory>
#include <string>

namespace tremula {

class OpenImageDenoise {
 public:
  // Nothing where there is no such library. `library`: a path, or empty for where the system looks.
  static std::unique_ptr<OpenImageDenoise> load(const std::string& library = {});
  ~OpenImageDenoise();
  OpenImageDenoise(const OpenImageDenoise&) = delete;
  OpenImageDenoise& operator=(const OpenImageDenoise&) = delete;

  std::string version();
  LinearImage denoise(const TracedImage& traced);  // throws Error with what the library says

 private:
  struct Functions;
  explicit OpenImageDenoise(std::unique_ptr<Functions> functions);
  void* new_device();
  void check(void* device);  // releases it where it has an error, or is none, and throws
  std::unique_ptr<Functions> functions_;
};

}  // namespace tremula
