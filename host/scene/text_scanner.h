// Cuts a text into lines and blank-separated tokens, each with its byte offset, so that a parser can name the place of
// a fault. Copies and allocates nothing; '#' at the start of a token makes the rest of its line a comment.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace turner {

struct Token {
  std::string_view text;  // empty where the line has no more tokens
  size_t offset = 0;      // of its first byte; where the line ends if there is no token
};

class TextScanner {
 public:
  enum class Continuation { none, backslash };  // backslash: at the end of a line it joins the next one to it

  // `text` must outlive this object and the tokens.
  explicit TextScanner(std::string_view text, Continuation continuation = Continuation::none);

  // Goes to the next line that holds a token, whatever is left of the current one. False at the end of the text.
  bool nextLine();
  // The next token of the line.
  Token next();
  // The same, without passing it.
  Token peek() const;
  // Bytes from here to the end of the text: bounds what may still follow.
  size_t remaining() const { return text_.size() - at_; }

 private:
  // The length of the line continuation that the backslash at `at` begins, 0 if it is a plain byte.
  size_t continuationAt(size_t at) const;
  size_t skipBlanks(size_t at) const;

  std::string_view text_;
  size_t at_ = 0;
  bool begun_ = false;
  bool joinsLines_;
};

// The largest magnitude of a number in a scene or mesh: well inside float32, so that no later difference overflows.
inline constexpr double kLargestNumber = 1e30;

// Reads a token as a number of a scene. Returns what is wrong with it and what is allowed; empty if all is well.
std::string readSceneNumber(std::string_view token, double& value);

// A token in quotes for a message: shortened where long, unprintable bytes replaced.
std::string quoted(std::string_view token);

}  // namespace turner
