#include "hard/cases.h"

namespace turner::hard {

std::vector<Case> refractionCases() {
  return {};
}

}  // namespace turner::hard
