// What a file has that a picture can do without, or must be guessed: told in one note for each kind, with the place of
// the first.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace turner {

// What is said behind the number, as "face crosses itself" and "faces cross themselves". Known by its address.
struct NoteKind {
  std::string_view one, many;
};

class CountedNotes {
 public:
  // `text` is the whole file; it must outlive this object. `path` is printed as given.
  CountedNotes(std::string path, std::string_view text) : path_(std::move(path)), text_(text) {}

  // Counts one at a byte offset of the text; those of a kind come in the order of their offsets. What `detail` says is
  // told of the first only.
  void add(const NoteKind& kind, size_t offset, std::string_view detail = {});

  // As "file:line:column: note: 3 faces ...; the first is here", in the order of the first of each kind.
  std::vector<std::string> lines() const;

 private:
  struct Counted {
    const NoteKind* kind;
    size_t first, count;
    std::string detail;
  };
  std::string path_;
  std::string_view text_;
  std::vector<Counted> counted_;
};

}  // namespace turner
