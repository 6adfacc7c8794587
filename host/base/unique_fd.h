// A file descriptor that is closed at the end of its scope, for the ways out that report another failure.
#pragma once

#include <unistd.h>

namespace turner {

struct UniqueFd {
  int number;
  explicit UniqueFd(int opened) : number(opened) {}
  UniqueFd(const UniqueFd&) = delete;
  UniqueFd& operator=(const UniqueFd&) = delete;
  ~UniqueFd() {
    if (number >= 0) ::close(number);
  }
};

}  // namespace turner
