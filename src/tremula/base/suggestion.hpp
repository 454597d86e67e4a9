// Help for messages about names that nobody knows.
#pragma once

#include <string>
#include <vector>

namespace tremula {

// "; did you mean oak?" where one of the names is near, else nothing.
std::string suggestion(const std::string& name, const std::vector<std::string>& names);

}  // namespace tremula
