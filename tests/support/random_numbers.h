// Random numbers and points for scenes of tests.
#pragma once

#include <cmath>
#include <cstddef>
#include <glm/vec3.hpp>
#include <random>

namespace turner::test {

struct RandomNumbers {
  std::mt19937_64 engine;
  double between(double a, double b) { return std::uniform_real_distribution<double>(a, b)(engine); }
  double size(double a, double b) { return std::exp(between(std::log(a), std::log(b))); }
  glm::dvec3 point(double reach) { return {between(-reach, reach), between(-reach, reach), between(-reach, reach)}; }
  size_t index(size_t count) { return size_t(engine() % count); }
};

}  // namespace turner::test
