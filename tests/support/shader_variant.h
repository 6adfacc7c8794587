// A copy of the kernel's sources in which some snippets are replaced, for measuring what a part of it is worth.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "support/temporary_folder.h"

namespace turner::test {

// Exact text, which must stand in the file exactly once.
struct Replacement {
  std::string name;  // of the snippet, for the message if it does not
  std::string file;  // in the folder of shaders
  std::string from, to;
};

// shaders/ and tests/hard/kernels/ in a folder of their own, with the replacements made.
class ShaderVariant {
 public:
  // Throws RunError with the name of a snippet that is not found exactly once.
  explicit ShaderVariant(std::span<const Replacement> replacements);
  std::string folder() const { return folder_.path.string(); }

 private:
  TemporaryFolder folder_;
};

}  // namespace turner::test
