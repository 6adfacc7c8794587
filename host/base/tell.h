// What the program says. What is only told never ends the work: where it cannot be written it is lost. What is printed
// as a result is a failure where it cannot be written.
#pragma once

#include <fmt/format.h>

#include <string_view>
#include <utility>

namespace turner {

// The standard descriptors that are closed are opened in a way in which reading and writing fail: else a file that is
// written would get such a number, and what is said would be written into it. Before anything else is opened.
void holdStandardDescriptors();

// From here on stdout has the bytes of an output and nothing else: what is told goes to stderr.
void leaveStdoutToOutput();
bool isStdoutTold();

// Returns 0, or the system's reason why nobody will read it.
int tellText(std::string_view text) noexcept;
int tellTextOnStderr(std::string_view text) noexcept;
// Where tellText() tells. Throws RunError.
void printResult(std::string_view text);

// What was loaded, on what device, what was written: to stdout.
template <class... Values>
int tell(fmt::format_string<Values...> format, Values&&... values) {
  return tellText(fmt::format(format, std::forward<Values>(values)...));
}
// Errors, diagnoses and how far the work is: to stderr.
template <class... Values>
int tellOnStderr(fmt::format_string<Values...> format, Values&&... values) {
  return tellTextOnStderr(fmt::format(format, std::forward<Values>(values)...));
}

}  // namespace turner
