// The steps of a job, and their names.
#pragma once

namespace turner::watch {

enum class Step { open, scene, compile, check, pipeline, coarse, picture, timing, counting, probe };

// "pipeline": for programs.
const char* stepName(Step step);
// "compiling in the driver": in words.
const char* stepWords(Step step);
// Whether the edited kernel runs in it.
bool runsKernel(Step step);

}  // namespace turner::watch
