#include "tremula/io/finite.hpp"

#include "tremula/base/error.hpp"

#include <cmath>
#include <string>

namespace tremula {
namespace {

template <class Number>
void check(std::string_view what, std::span<const Number> numbers) {
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (std::isfinite(numbers[i])) continue;
    throw Error(std::string(what) + ": number " + std::to_string(i + 1) + " of " +
                std::to_string(numbers.size()) + " is " + std::to_string(numbers[i]) +
                ", and nothing is written that is not finite");
  }
}

}  // namespace

void check_finite(std::string_view what, double number) {
  if (std::isfinite(number)) return;
  throw Error(std::string(what) + ": " + std::to_string(number) +
              ", and nothing is written that is not finite");
}

void check_finite(std::string_view what, std::span<const double> numbers) { check(what, numbers); }
void check_finite(std::string_view what, std::span<const float> numbers) { check(what, numbers); }

void check_finite(std::string_view what, const std::vector<Eigen::Vector3f>& points) {
  static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));
  if (points.empty()) return;
  check(what, std::span<const float>(points.front().data(), 3 * points.size()));
}

void check_finite(std::string_view what, const Eigen::VectorXd& numbers) {
  check(what, std::span<const double>(numbers.data(), static_cast<std::size_t>(numbers.size())));
}

}  // namespace tremula
