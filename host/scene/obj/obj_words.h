// The words that a line of an OBJ file may begin with, beside v, vn and f.
#pragma once

#include <string>
#include <string_view>

namespace turner::obj {

enum class WordKind {
  passedOver,    // says nothing about the shape: texture, grouping, display
  material,      // belongs into a material library
  notSupported,  // changes the shape in a way that Turner does not know
  miswritten,    // v, vn or f but for capital letters: what it means to say is part of the shape
  unknown
};

WordKind kindOf(std::string_view word);

// The known word nearest to an unknown one, or empty.
std::string nearestWord(std::string_view word);

}  // namespace turner::obj
