// The failures that the kernel's means of robustness remove, each measured on rays that need it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "geometry/prepared_geometry.h"
#include "hard/kernels.h"

namespace turner::test {

// A kernel to be measured beside the one that has everything.
struct Trial {
  hard::Kernels& kernels;
  hard::Kernels& robust;
  bool exactBoxes;  // the tree's boxes fit, without the host's padding
  size_t rays;
};

struct Failures {
  std::string what;
  double value;  // 0: none
};

using MeasureFailures = std::vector<Failures> (*)(const Trial&);

std::vector<Failures> leaksOfIcosphere(const Trial& trial);
std::vector<Failures> missesOfSoup(const Trial& trial);
std::vector<Failures> wrongHorizon(const Trial& trial);
std::vector<Failures> wrongSilhouette(const Trial& trial);
std::vector<Failures> falseSelfHits(const Trial& trial);
std::vector<Failures> wrongRefraction(const Trial& trial);
std::vector<Failures> wrongInNestedGlass(const Trial& trial);

// The boxes of shapes without padding, rounded to the nearest float.
std::vector<Box> exactBoxes(const PreparedGeometry& prepared);

}  // namespace turner::test
