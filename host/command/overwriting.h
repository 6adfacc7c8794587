// No output is written over an input, and no two outputs are one file: by links of whatever kind, by other spellings,
// whether the files are there yet or not. "-" is standard output among outputs, standard input among inputs.
#pragma once

#include <string>
#include <vector>

namespace turner {

// Throws InputError naming both.
void refuseRepeated(const std::vector<std::string>& outputs);
void refuseOverwriting(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs);
// A pipe can be read once. Throws InputError if two of the inputs are one pipe.
void refuseSharedPipes(const std::vector<std::string>& inputs);

// The kernel's sources that no output may replace: Turner's own and those in the folder that is wanted instead.
std::vector<std::string> shaderFiles(const std::string& wantedFolder);

}  // namespace turner
