// Where tests put what is not to stay.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

#include "base/errors.h"

namespace turner::test {

// A folder of its own, gone with everything in it at the end.
struct TemporaryFolder {
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "turner_tests_XXXXXX").string();
    if (!mkdtemp(pattern.data())) throw RunError("cannot make a temporary folder: mkdtemp failed");
    path = pattern;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;  // a folder left behind in /tmp is no failure
    std::filesystem::remove_all(path, ignored);
  }
  std::filesystem::path path;
};

}  // namespace turner::test
