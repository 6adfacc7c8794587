// Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997: a quick answer
// where rounding cannot change the sign, else a sum without rounding.
#include "scene/polygon/plane.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace turner {

namespace {

// A sum of up to kMost doubles without rounding, as parts that do not overlap, the least first (Grow-Expansion, section
// 2.4).
template <size_t kMost>
class ExactSum {
 public:
  void add(double value) {
    for (size_t i = 0; i < count_; ++i) {
      // The sum and what its rounding lost (Two-Sum).
      const double sum = value + parts_[i], moved = sum - value;
      parts_[i] = (value - (sum - moved)) + (parts_[i] - moved);
      value = sum;
    }
    parts_[count_++] = value;
  }
  void addProduct(double a, double b) {
    const double product = a * b;
    add(std::fma(a, b, -product));
    add(product);
  }
  void addProduct(double a, double b, double c) {
    const double product = a * b;
    addProduct(std::fma(a, b, -product), c);
    addProduct(product, c);
  }
  // The greatest part that is not 0 outweighs all others.
  int sign() const {
    for (size_t i = count_; i-- > 0;) {
      if (parts_[i] != 0) return parts_[i] > 0 ? 1 : -1;
    }
    return 0;
  }

 private:
  std::array<double, kMost> parts_;
  size_t count_ = 0;
};

}  // namespace

int orientation(PlanePoint a, PlanePoint b, PlanePoint c) {
  // Section 4.3: beyond this bound the sign is certain.
  const double left = (a.x - c.x) * (b.y - c.y), right = (a.y - c.y) * (b.x - c.x);
  const double determinant = left - right;
  const double bound = 3.3306690738754716e-16 * (std::abs(left) + std::abs(right));
  if (determinant > bound) return 1;
  if (determinant < -bound) return -1;
  // The same, multiplied out; c.x * c.y cancels.
  ExactSum<12> sum;
  for (const auto& [p, q] : {std::pair{a, b}, {b, c}, {c, a}}) {
    sum.addProduct(p.x, q.y);
    sum.addProduct(-p.y, q.x);
  }
  return sum.sign();
}

int orientation(const glm::dvec3& normal, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 u = a - c, v = b - c;
  double determinant = 0, magnitude = 0;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const double left = u[i] * v[j], right = u[j] * v[i];
    determinant += normal[k] * (left - right);
    magnitude += std::abs(normal[k]) * (std::abs(left) + std::abs(right));
  }
  // Of the determinant of three rows (section 4.3); the first has not been rounded here.
  const double bound = 7.7715611723761027e-16 * magnitude;
  if (determinant > bound) return 1;
  if (determinant < -bound) return -1;
  // normal . (a x b + b x c + c x a)
  ExactSum<72> sum;
  for (const auto& [p, q] : {std::pair{a, b}, {b, c}, {c, a}}) {
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      sum.addProduct(p[i], q[j], normal[k]);
      sum.addProduct(-p[j], q[i], normal[k]);
    }
  }
  return sum.sign();
}

}  // namespace turner
