// Where and how a report was made.
#pragma once

#include "command/command_line.h"
#include "report/tables.h"

namespace turner {

// This machine, now, and the command that makes the report again.
report::Machine thisMachine(const ReportOptions& options, int repeats);

}  // namespace turner
