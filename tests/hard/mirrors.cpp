#include "hard/cases.h"

namespace turner::hard {

std::vector<Case> mirrorCases() {
  return {};
}

}  // namespace turner::hard
