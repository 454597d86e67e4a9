#include "tremula/render/linear_image.hpp"

#include "tremula/base/error.hpp"

#include <string>

namespace tremula {

void check_all_pixels(const LinearImage& image) {
  const bool has_size = image.width > 0 && image.height > 0;
  const std::size_t wanted =
      has_size ? 3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) : 0;
  if (has_size && image.rgb.size() == wanted) return;
  throw InputError(
      "linear image", std::to_string(image.rgb.size()) + " numbers",
      "3 for each of " + std::to_string(image.width) + " x " + std::to_string(image.height) + " pixels");
}

}  // namespace tremula
