// One table for all names.
#include "watch/process/steps.h"

#include <cstddef>
#include <iterator>

namespace turner::watch {
namespace {

struct StepText {
  const char *name, *words;
};

// In the order of the steps.
constexpr StepText kSteps[] = {
    {"open", "opening the device"},
    {"scene", "loading the scene"},
    {"compile", "compiling"},
    {"check", "checking the SPIR-V"},
    {"pipeline", "compiling in the driver"},
    {"coarse", "rendering"},
    {"picture", "rendering"},
    {"timing", "timing"},
    {"counting", "counting rays"},
    {"probe", "looking for the loop"},
};
static_assert(std::size(kSteps) == size_t(Step::probe) + 1);

}  // namespace

const char* stepName(Step step) {
  return kSteps[size_t(step)].name;
}

const char* stepWords(Step step) {
  return kSteps[size_t(step)].words;
}

bool runsKernel(Step step) {
  return step == Step::coarse || step == Step::picture || step == Step::timing || step == Step::counting ||
         step == Step::probe;
}

}  // namespace turner::watch
