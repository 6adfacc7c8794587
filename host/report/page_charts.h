// The two charts of a scene in the page, as SVG.
#pragma once

#include <string>

#include "report/swept_scene.h"

namespace turner::report {

std::string errorOverTime(const SweptScene& scene);
std::string errorOverSamples(const SweptScene& scene);

}  // namespace turner::report
