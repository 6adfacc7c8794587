// Repeated measurements in three figures.
#pragma once

#include <algorithm>
#include <vector>

namespace turner {

struct Spread {
  double median = 0, least = 0, most = 0;
};

// Of at least one value; of an even number the median is the mean of the two in the middle.
inline Spread spreadOf(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const size_t n = values.size();
  return {0.5 * (values[(n - 1) / 2] + values[n / 2]), values.front(), values.back()};
}

}  // namespace turner
