// A signal handler may set a flag and nothing more.
#include "command/interrupt.h"

#include <csignal>

#include "base/errors.h"

namespace turner {
namespace {

volatile std::sig_atomic_t interrupts = 0;

extern "C" void noteInterrupt(int) {
  interrupts = 1;
}

}  // namespace

void catchInterrupts() {
  struct sigaction action = {};
  action.sa_handler = noteInterrupt;
  action.sa_flags = SA_RESETHAND | SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
}

void throwIfInterrupted() {
  if (interrupts) throw Interrupted();
}

}  // namespace turner
