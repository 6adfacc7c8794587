// Collects the faults of one input file, so that the user sees all of them at once, each as
// "file:line:column: error: what is wrong; what is allowed".
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace turner {

class Diagnostics {
 public:
  // `text` is the whole file; it must outlive this object. `path` is printed as given.
  Diagnostics(std::string path, std::string_view text);

  // Notes a fault at a byte offset of the text. Diagnostics may come in any order.
  void add(size_t offset, std::string message);
  // "file:line:column: error: " of a byte offset, for a message that comes later.
  std::string placeOf(size_t offset) const;
  bool empty() const { return faults_.empty(); }
  size_t count() const { return faults_.size(); }
  // Throws InputError with all faults in the order of their places, one line each; does nothing if there are none.
  void throwIfAny() const;

 private:
  struct Fault {
    size_t offset;
    std::string message;
  };
  std::string path_;
  std::string_view text_;
  std::vector<Fault> faults_;
};

// The known name nearest to a misspelt one (edit distance, case ignored), or empty when none is near enough to help.
std::string nearestName(std::string_view misspelt, std::span<const std::string> known);

}  // namespace turner
