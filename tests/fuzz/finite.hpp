// No input that is taken makes a number that is none.
#pragma once

#include "tremula/pipeline.hpp"

#include <cmath>
#include <string_view>

#include <Eigen/Core>

#include "harness.hpp"

namespace tremula::fuzz {

template <class Numbers>
void require_finite(const Numbers& numbers, std::string_view what) {
  for (const auto number : numbers) {
    if (!std::isfinite(number)) throw Broken(std::string(what) + " is not finite");
  }
}

// Modes, lean, shapes and coordinates.
void require_finite(const Subject& subject, const Motion& motion);

// No "nan" and no "inf" where a number could stand.
void require_finite_text(std::string_view text);

// True where the stages take what a reader gave them, false where they refuse it: with an InputError of one
// printable line.
bool taken_by_stages(const std::function<void()>& work);

}  // namespace tremula::fuzz
