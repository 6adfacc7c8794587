// The number types of the reference and what their roundings amount to. Doubles, and a wider type where a small
// difference of large numbers must keep its digits.
#pragma once

#include <algorithm>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <limits>

namespace turner::reference {

using glm::dvec3;
using wide3 = glm::tvec3<long double, glm::defaultp>;  // where the last bits of double matter: 64-bit mantissa or more

constexpr double kRounding = 0x1p-53;  // largest relative error of one operation
constexpr double kWideRounding = std::numeric_limits<long double>::epsilon() / 2;
constexpr double kFarAway = std::numeric_limits<double>::max();  // the distance of what is not hit

inline double largest(const dvec3& v) {
  return std::max({v.x, v.y, v.z});
}
inline double largestSize(const dvec3& v) {
  return largest(glm::abs(v));
}

}  // namespace turner::reference
