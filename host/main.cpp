// Turns the command line into a command, and every error into one message and an exit code.

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <string>

#include "base/errors.h"
#include "command/commands.h"
#include "command/interrupt.h"

namespace {

enum ExitCode { kDone = 0, kFailed = 1, kWrongInput = 2, kInterrupted = 130 };

// Diagnostics of a file say their place and that they are errors; everything else gets the program's name.
int printError(const char* message, ExitCode code) {
  const bool hasPlace = std::strstr(message, ": error: ") != nullptr;
  std::fprintf(stderr, hasPlace ? "%s\n" : "turner: error: %s\n", message);
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
      return copyShaders(line.copyShadersTo);
    case CommandKind::printed:
      break;
  }
  return kDone;
}

// What was printed is part of the result: a full disk behind stdout is a failure too.
int flushed(int code) {
  if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return code;
  return printError((std::string("cannot write to standard output: ") + std::strerror(errno)).c_str(), kFailed);
}

}  // namespace

int main(int argc, char** argv) {
  // A file-size limit shall be an error of the write, not the end of the process with a temporary file left over.
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    return flushed(run(argc, argv));
  } catch (const turner::InputError& error) {
    return printError(error.what(), kWrongInput);
  } catch (const turner::Interrupted& error) {
    return printError(error.what(), kInterrupted);
  } catch (const turner::RunError& error) {
    return printError(error.what(), kFailed);
  } catch (const std::bad_alloc&) {
    return printError("out of memory", kFailed);
  } catch (const std::exception& error) {
    return printError(error.what(), kFailed);
  }
}
