// Shared by the tests: where the real data is, and temporary folders.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

#include <gtest/gtest.h>

namespace tremula::test {

inline std::filesystem::path data_folder() {
  const char* from_environment = std::getenv("TREMULA_DATA");
  return from_environment != nullptr ? from_environment : TREMULA_DEFAULT_DATA;
}

inline std::filesystem::path source_folder() { return TREMULA_SOURCE; }

// A fresh folder that is gone when the test ends.
struct TemporaryFolder {
  std::filesystem::path path;
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "tremula-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("cannot make a temporary folder");
    path = pattern;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string operator/(const std::string& name) const { return (path / name).string(); }
};

}  // namespace tremula::test

// Skips, and says so, where the real data is not beside the project.
#define TREMULA_NEED_DATA(relative)                                        \
  if (!std::filesystem::exists(tremula::test::data_folder() / (relative))) \
  GTEST_SKIP() << "no " << (tremula::test::data_folder() / (relative)) << ": set TREMULA_DATA"
