// Where a kernel was edited, for a kernel that hangs or brings its driver down without a word.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kernel/shader_sources.h"

namespace turner::watch {

// Where in the edited sources the fault is to be looked for, given the last ones that worked: the first loop whose head
// was changed, else the first that has a change in its body, of nested ones the innermost; else the first change. Of
// blanks and comments nothing is said. None where there are no good sources, or nothing but these was changed.
std::optional<SourceLocation> likelyLocation(const std::vector<ShaderSource>& good,
                                             const std::vector<ShaderSource>& edited);

// The files, without their folders, that differ, were added or are gone.
std::vector<std::string> changedFiles(const std::vector<ShaderSource>& good, const std::vector<ShaderSource>& edited);

}  // namespace turner::watch
