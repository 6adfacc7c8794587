// A file descriptor that is closed at the end of its scope, for the ways out that report another failure.
#pragma once

#include <unistd.h>

namespace turner {

struct Descriptor {
  int number;
  explicit Descriptor(int opened) : number(opened) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (number >= 0) ::close(number);
  }
};

}  // namespace turner
