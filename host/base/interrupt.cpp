// A signal handler may set a flag and nothing more.
#include "base/interrupt.h"

#include <atomic>
#include <csignal>

#include "base/errors.h"

namespace turner {
namespace {

constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};

std::atomic<int> noted = 0;  // looked at by all threads
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler may not wait");

extern "C" void noteInterrupt(int signal) {
  noted = signal;
}

}  // namespace

void catchInterrupts() {
  struct sigaction action = {};
  action.sa_handler = noteInterrupt;
  action.sa_flags = SA_RESETHAND | SA_RESTART;
  for (const int signal : kSignals) {
    struct sigaction before = {};
    // A shell's background job ignores SIGINT; who sends it one by name means it.
    const bool isIgnored = sigaction(signal, nullptr, &before) == 0 && before.sa_handler == SIG_IGN;
    if (signal == SIGINT || !isIgnored) sigaction(signal, &action, nullptr);
  }
}

void ignoreInterrupts() {
  for (const int signal : kSignals) std::signal(signal, SIG_IGN);
}

void throwIfInterrupted() {
  if (noted) throw Interrupted();
}

int interruptSignal() {
  return noted;
}

}  // namespace turner
