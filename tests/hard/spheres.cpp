// Spheres far away, close by, tangent, kissing.
#include "hard/cases.h"
#include "hard/vectors.h"

namespace turner::hard {

std::vector<Case> sphereCases() {
  return {};
}

}  // namespace turner::hard
