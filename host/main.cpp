// Turns the command line into a command, and every error into one message and an exit code.

#include <csignal>
#include <cstring>
#include <exception>
#include <new>
#include <string>
#include <system_error>

#include "base/errors.h"
#include "base/interrupt.h"
#include "base/memory_limit.h"
#include "base/tell.h"
#include "command/commands.h"

namespace {

enum ExitCode { kDone = 0, kFailed = 1, kWrongInput = 2, kInterrupted = 128 };  // the last plus the signal's number

// Diagnostics of a file say their place and that they are errors; everything else gets the program's name.
int printError(const char* message, int code) {
  const bool hasPlace = std::strstr(message, ": error: ") != nullptr;
  turner::tellOnStderr("{}{}\n", hasPlace ? "" : "turner: error: ", message);
  return code;
}

int run(int argc, char** argv) {
  using namespace turner;
  const CommandLine line = parseCommandLine(argc, argv);
  catchInterrupts();
  switch (line.kind) {
    case CommandKind::render:
      return runRender(line.render);
    case CommandKind::compare:
      return runCompare(line.compare, line.render);
    case CommandKind::watch:
      runWatch(line.watch, line.render);
    case CommandKind::report:
      return runReport(line.report);
    case CommandKind::devices:
      return runDevices(line.devicesAsJson);
    case CommandKind::shaders:
      return line.shaders.check.empty() ? copyShaders(line.shaders.copyTo) : checkShaders(line.shaders);
    case CommandKind::printed:
      break;
  }
  return kDone;
}

}  // namespace

int main(int argc, char** argv) {
  turner::holdStandardDescriptors();
  // Shall be errors of the write, not the end of the process with a temporary file left over: a limit on the size of
  // files, and a pipe from which nobody reads any more.
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
  try {
    return run(argc, argv);
  } catch (const turner::InputError& error) {
    return printError(error.what(), kWrongInput);
  } catch (const turner::Interrupted& error) {
    const int code = kInterrupted + turner::interruptSignal();
    return *error.what() ? printError(error.what(), code) : code;
  } catch (const turner::RunError& error) {
    return printError(error.what(), kFailed);
  } catch (const std::bad_alloc&) {
    return printError(("out of memory" + turner::memoryLimitHint()).c_str(), kFailed);
  } catch (const std::system_error& error) {
    const bool isLimit = error.code() == std::errc::resource_unavailable_try_again;
    const std::string message = error.what();
    return printError(
        (isLimit ? "cannot start a thread: " + message + " (a limit of processes: ulimit -u, or a cgroup's)" : message)
            .c_str(),
        kFailed);
  } catch (const std::exception& error) {
    return printError(error.what(), kFailed);
  }
}
