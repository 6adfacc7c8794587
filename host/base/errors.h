// The three ways in which a command ends without its result. main() alone catches them and turns them into exit codes
// and one clear message; everything below just throws.
#pragma once

#include <stdexcept>
#include <string>

namespace turner {

// The user's mistake: command line, scene, shader, device name or path. Exit code 2. The message may have several
// lines, one for each fault, each naming its place and the remedy.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The machine's failure: no Vulkan device, disk full, lost device. Exit code 1. The message names the call that failed.
struct RunError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Ctrl-C, a termination or a hang-up. Exit code 128 and the number of the signal. Without a message: all is said.
struct Interrupted : std::runtime_error {
  explicit Interrupted(const std::string& what = "interrupted; nothing was written") : std::runtime_error(what) {}
};

}  // namespace turner
