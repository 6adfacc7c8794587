// fork, kill, wait.
#include "watch/child.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include "errors.h"

namespace turner {
namespace {

// Of the two ends of the line only the child's own stays, and nothing else but what the user sees.
void closeOthers(int mine) {
  if (mine > 3) ::close_range(3, unsigned(mine - 1), 0);
  ::close_range(unsigned(mine + 1), ~0u, 0);
}

// When memory runs out, the child shall go, not its parent, which has the last good picture.
void offerAsVictim() {
  const Descriptor file(::open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC));
  if (file.number >= 0 && ::write(file.number, "1000", 4) < 0) return;  // then the system chooses by itself
}

[[noreturn]] void beChild(pid_t parent, int line, const std::function<void(Channel&)>& work) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(0);  // it died before the line above
  ::signal(SIGINT, SIG_IGN);
  const rlimit noCore{0, 0};
  ::setrlimit(RLIMIT_CORE, &noCore);
  closeOthers(line);
  offerAsVictim();
  int code = 0;
  try {
    Channel channel(line);
    work(channel);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "turner: error: %s\n", error.what());
    code = 1;
  }
  ::_exit(code);  // what is registered for the end of the program is the parent's
}

}  // namespace

Child::Child(const std::function<void(Channel&)>& work) {
  const std::filesystem::directory_iterator threads("/proc/self/task");
  if (std::distance(std::filesystem::begin(threads), std::filesystem::end(threads)) != 1)
    throw RunError("a process with several threads cannot be forked");
  const auto [mine, its] = makeChannel();
  line_ = std::make_unique<Channel>(mine);
  const pid_t parent = ::getpid();
  std::fflush(nullptr);
  process_ = ::fork();
  if (process_ == 0) beChild(parent, its, work);
  const int error = errno;
  ::close(its);
  if (process_ < 0) throw RunError(std::string("fork: ") + std::strerror(error));
}

Child::~Child() {
  end();
}

void Child::pause() {
  if (process_ > 0 && !std::exchange(paused_, true)) ::kill(process_, SIGSTOP);
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
  int status = 0;
  while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = -1;
  if (WIFSIGNALED(status))
    return "was ended by signal " + std::to_string(WTERMSIG(status)) + " (" + ::strsignal(WTERMSIG(status)) + ")";
  return "ended with code " + std::to_string(WEXITSTATUS(status));
}

}  // namespace turner
