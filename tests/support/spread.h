// What is left of the times of some runs.
#pragma once

#include <algorithm>
#include <vector>

namespace turner::test {

// The median of some runs and how far they lie apart.
struct Spread {
  double median = 0, least = 0, most = 0;
};

inline Spread spreadOf(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const size_t n = values.size();
  return {0.5 * (values[(n - 1) / 2] + values[n / 2]), values.front(), values.back()};
}

}  // namespace turner::test
