// fork, kill, wait.
#include "watch/process/child.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>
#include <utility>

#include "base/errors.h"
#include "base/interrupt.h"
#include "base/tell.h"

namespace turner::watch {
namespace {

// Of the two ends of the line only the child's own stays, and nothing else but what the user sees.
void closeOthers(int mine) {
  if (mine > 3) ::close_range(3, unsigned(mine - 1), 0);
  ::close_range(unsigned(std::max(mine, 2) + 1), ~0u, 0);
}

// When memory runs out, the child shall go, not its parent, which has the last good picture.
void offerAsVictim() {
  const UniqueFd file(::open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC));
  if (file.number >= 0 && ::write(file.number, "1000", 4) < 0) return;  // then the system chooses by itself
}

constexpr int kMostNaps = 1000;  // milliseconds

std::ptrdiff_t threadCount() {
  const std::filesystem::directory_iterator threads("/proc/self/task");
  return std::distance(std::filesystem::begin(threads), std::filesystem::end(threads));
}

[[noreturn]] void beChild(pid_t parent, int line, const std::function<void(Channel&)>& work) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(0);  // it died before the line above
  ignoreInterrupts();
  const rlimit noCore{0, 0};
  ::setrlimit(RLIMIT_CORE, &noCore);
  closeOthers(line);
  if (::write(line, "", 1) != 1) ::_exit(1);  // it is bound to its parent from here on
  offerAsVictim();
  int code = 0;
  try {
    Channel channel(line);
    work(channel);
  } catch (const std::exception& error) {
    tellOnStderr("turner: error: {}\n", error.what());
    code = 1;
  }
  ::_exit(code);  // what is registered for the end of the program is the parent's
}

}  // namespace

Child::Child(const std::function<void(Channel&)>& work) {
  // A thread that was joined is listed for a moment longer.
  for (int naps = 0; threadCount() != 1; ++naps) {
    if (naps == kMostNaps) throw RunError("a process with several threads cannot be forked");
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  const auto [mine, its] = makeChannel();
  line_ = std::make_unique<Channel>(mine);
  const pid_t parent = ::getpid();
  process_ = ::fork();
  if (process_ == 0) beChild(parent, its, work);
  const int error = errno;
  ::close(its);
  if (process_ < 0) throw RunError(std::string("fork: ") + std::strerror(error));
  // A child that was stopped before it is bound to this process would outlive it.
  char ready = 0;
  while (::read(mine, &ready, 1) < 0 && errno == EINTR) {
  }
}

Child::~Child() {
  end();
}

void Child::pause() {
  // Even if it is paused: Ctrl-Z and fg wake all.
  if (process_ > 0) ::kill(process_, SIGSTOP);
  paused_ = true;
}

void Child::goOn() {
  if (process_ > 0 && std::exchange(paused_, false)) ::kill(process_, SIGCONT);
}

size_t Child::residentBytes() const {
  std::ifstream file("/proc/" + std::to_string(process_) + "/statm");
  size_t all = 0, resident = 0;
  return process_ > 0 && file >> all >> resident ? resident * size_t(::sysconf(_SC_PAGESIZE)) : 0;
}

std::string Child::end() {
  if (process_ <= 0) return "has ended";
  ::kill(process_, SIGKILL);  // without effect on one that has ended: it has not been waited for
  const pid_t process = std::exchange(process_, -1);
  // One that a driver holds in the kernel dies when that lets it go; nobody waits so long.
  int status = 0;
  for (int naps = 0; ::waitpid(process, &status, WNOHANG) == 0; ++naps) {
    if (naps == kMostNaps) return "does not end";
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  if (WIFSIGNALED(status))
    return "was ended by signal " + std::to_string(WTERMSIG(status)) + " (" + ::strsignal(WTERMSIG(status)) + ")";
  return "ended with code " + std::to_string(WEXITSTATUS(status));
}

}  // namespace turner::watch
