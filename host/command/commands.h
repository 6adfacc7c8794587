// The commands; each reads as its data flow.
#pragma once

#include "command/command_line.h"

namespace turner {

// Exit codes of a command that ran to its end; errors are thrown.
int runRender(const RenderOptions& options);
int runCompare(const CompareOptions& compare, const RenderOptions& render);
// Ends by Ctrl-C only, which is thrown.
[[noreturn]] void runWatch(const WatchOptions& watch, const RenderOptions& render);
int runReport(const ReportOptions& options);
int runDevices(bool asJson);
int copyShaders(const std::string& folder);
int checkShaders(const ShaderOptions& options);

}  // namespace turner
