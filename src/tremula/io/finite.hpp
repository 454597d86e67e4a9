// The door of every writer: whatever went wrong before it, no output says "nan" or "inf".
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace tremula {

// Throws Error that names `what` ("glTF: normals") and which of the numbers is not finite.
void check_finite(std::string_view what, double number);
void check_finite(std::string_view what, std::span<const double> numbers);
void check_finite(std::string_view what, std::span<const float> numbers);
void check_finite(std::string_view what, const std::vector<Eigen::Vector3f>& points);
void check_finite(std::string_view what, const Eigen::VectorXd& numbers);

}  // namespace tremula
