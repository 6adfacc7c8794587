// Directions and points for rays, and wide numbers for oracles.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <random>

namespace turner::hard {

using glm::dvec3;
using glm::vec3;
using Wide = __float128;  // 113 bits: a square root of a difference of squares keeps its digits
struct Wide3 {
  Wide x, y, z;
};

inline Wide3 wide(const dvec3& v) {
  return {v.x, v.y, v.z};
}
inline Wide dot(const Wide3& a, const Wide3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Wide3 operator-(const Wide3& a, const Wide3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}

// A square root to the last bits: Newton's step on the double one. Of 0 and less it is 0.
inline Wide squareRoot(Wide x) {
  if (!(x > 0)) return 0;
  Wide root = std::sqrt(double(x));
  if (root == 0) return 0;
  for (int i = 0; i < 2; ++i) root = (root + x / root) / 2;
  return root;
}

template <class Random>
double uniform(Random& random, double lo, double hi) {
  return std::uniform_real_distribution<double>(lo, hi)(random);
}

// Evenly distributed over the unit sphere.
template <class Random>
dvec3 randomDirection(Random& random) {
  const double z = uniform(random, -1, 1), phi = uniform(random, 0, 2 * std::numbers::pi), r = std::sqrt(1 - z * z);
  return {r * std::cos(phi), r * std::sin(phi), z};
}

// Two unit vectors that make an orthonormal basis with a unit vector.
inline void basisOf(const dvec3& n, dvec3& a, dvec3& b) {
  a = glm::normalize(glm::cross(n, std::abs(n.x) < 0.5 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
  b = glm::cross(n, a);
}

// Any unit vector at right angles to a unit vector.
template <class Random>
dvec3 anywhereAcross(const dvec3& n, Random& random) {
  dvec3 a, b;
  basisOf(n, a, b);
  const double phi = uniform(random, 0, 2 * std::numbers::pi);
  return std::cos(phi) * a + std::sin(phi) * b;
}

// The p-quantile of some values, which it sorts; nearest rank.
template <class Values>
double quantile(Values& values, double p) {
  if (values.empty()) return NAN;
  std::sort(values.begin(), values.end());
  const double rank = std::ceil(p * double(values.size()));
  return values[size_t(std::max(rank, 1.0)) - 1];
}

}  // namespace turner::hard
