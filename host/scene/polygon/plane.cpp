// Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997: a quick answer
// where rounding cannot change the sign, else a sum without rounding.
#include "scene/polygon/plane.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace turner {

namespace {

// A sum of doubles without rounding, as parts that do not overlap, the least first (Grow-Expansion, section 2.4).
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
  // The greatest part that is not 0 outweighs all others.
  int sign() const {
    for (size_t i = count_; i-- > 0;) {
      if (parts_[i] != 0) return parts_[i] > 0 ? 1 : -1;
    }
    return 0;
  }

 private:
  std::array<double, 12> parts_{};
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
  ExactSum sum;
  for (const auto& [p, q] : {std::pair{a, b}, {b, c}, {c, a}}) {
    sum.addProduct(p.x, q.y);
    sum.addProduct(-p.y, q.x);
  }
  return sum.sign();
}

}  // namespace turner
