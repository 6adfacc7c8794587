// Which loop of a kernel never ends: a copy of its sources that finds out. Every loop has a counter there; once one has
// made too many turns, all loops of that invocation end, and it reports the loop's number where the host looks for cut
// loops.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "kernel/shader_sources.h"

namespace turner::watch {

// More turns than this in one go end a loop: few enough for an endless one to end in a blink, on a CPU for each of its
// lanes.
inline constexpr uint32_t kMostTurns = 4096;

// For Dispatching::budget. With the first no loop of the kernel as it is shipped has too many turns: every turn of
// those that depend on the scene takes at least 1 from the budget. With the second also a loop is found that goes on
// from one dispatch to the next forever, because only the budget ends it; but the main loop of an honest, deep scene
// may be taken for one.
inline constexpr uint32_t kProbeBudget = 2048;
inline constexpr uint32_t kLongProbeBudget = 1u << 20;

struct LoopProbe {
  std::vector<ShaderSource> sources;
  std::vector<SourceLocation> loops;  // by number: where each one's keyword stands in the original sources
};

// Of sources as readShaderSources gives them. What cannot be followed in them is left as it is; the result may then not
// compile, or know fewer loops. The picture stays what it was as long as no loop has too many turns.
LoopProbe probeLoops(const std::vector<ShaderSource>& sources);

// What LoopsCut::count says of the probe's kernel: the loop that made too many turns, or where none did but a driver
// has ended loops, the one that made the most.
std::optional<SourceLocation> endlessLoop(const LoopProbe& probe, uint32_t limiterCount);

}  // namespace turner::watch
