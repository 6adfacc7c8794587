// Measured points in words: sentences about a scene, and commands that make a picture again.
#pragma once

#include <string>
#include <vector>

#include "report/swept_scene.h"

namespace turner::report {

// "llvmpipe, sobol 4x4, depth 3": a point in words.
std::string pointInWords(const SweptScene& scene, const SweepPoint& point);

// "12.3 ms", "4.56 s".
std::string timeInWords(double seconds);

// What a reader wants to know first, a sentence each.
std::vector<std::string> findings(const SweptScene& scene);

// Quoted where a shell would see more in it than one word.
std::string shellWord(const std::string& text);
// The same of an input's name: one that begins with a dash would be an option; a dash alone is standard input.
std::string shellInput(const std::string& path);

// The render command that makes the point's picture of seed 0; the shaders' folder if it is not Turner's own.
std::string renderCommand(const SweptScene& scene, const SweepPoint& point, const std::string& shaders);

}  // namespace turner::report
