// The commands, each told as the way that data takes.
#pragma once

#include "command/command_line.h"

namespace turner {

// Exit codes of a command that ran to its end; errors are thrown.
int runRender(const RenderOptions& options);
int runCompare(const CompareOptions& compare, const RenderOptions& render);
int runReport(const ReportOptions& options);
int runDevices(bool asJson);

}  // namespace turner
