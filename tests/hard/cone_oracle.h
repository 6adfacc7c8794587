// An oracle for cones: the quadratic formula by the cone's own ends in 113-bit arithmetic, on the cone and the float
// ray that the kernel gets; and how far from being right a wrong answer is.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>
#include <vector>

#include "hard/vectors.h"
#include "scene/scene.h"

namespace turner::hard {

// Where a function is least that falls and then rises between two places.
template <class Function>
long double leastBetween(long double from, long double to, const Function& function) {
  for (int i = 0; i < 60; ++i) {
    const long double third = (to - from) / 3, a = from + third, b = to - third;
    if (function(a) < function(b))
      to = b;
    else
      from = a;
  }
  return from;
}

inline constexpr double kUnit = 0x1p-24;  // a rounding of float32

inline Wide3 operator+(const Wide3& a, const Wide3& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Wide3 operator*(Wide a, const Wide3& b) {
  return {a * b.x, a * b.y, a * b.z};
}
inline Wide length(const Wide3& a) {
  return squareRoot(dot(a, a));
}
inline dvec3 narrow(const Wide3& a) {
  return {double(a.x), double(a.y), double(a.z)};
}

using Long3 = glm::tvec3<long double, glm::defaultp>;

// A place where a ray meets a cone.
struct ConeMeeting {
  Wide t;
  bool fromOutside;
  double angle;  // sine of the one between ray and surface
};

class ConeOracle {
 public:
  explicit ConeOracle(const Cone& cone)
      : base_(wide(cone.base)),
        way_(wide(cone.apex) - base_),
        baseRadius_(std::abs(cone.baseRadius)),
        apexRadius_(std::abs(cone.apexRadius)),
        squared_(dot(way_, way_)),
        length_(squareRoot(squared_)),
        slant_(squareRoot(squared_ + (apexRadius_ - baseRadius_) * (apexRadius_ - baseRadius_))) {
    const auto toLong = [](const Wide3& v) {
      return Long3((long double)(v.x), (long double)(v.y), (long double)(v.z));
    };
    long_ = {toLong(base_), toLong((1 / length_) * way_), (long double)(length_), (long double)(baseRadius_),
             (long double)(apexRadius_ - baseRadius_)};
  }

  double size() const { return double(std::max(slant_, std::max(baseRadius_, apexRadius_))); }
  double widest() const { return double(std::max(baseRadius_, apexRadius_)); }
  double lengthOfAxis() const { return double(length_); }
  double slant() const { return double(slant_); }
  dvec3 axis() const { return narrow((1 / length_) * way_); }
  // Sine and cosine of the angle between axis and surface.
  double sine() const { return double((apexRadius_ - baseRadius_) / slant_); }
  double cosine() const { return double(length_ / slant_); }
  double radiusAt(double share) const { return double(baseRadius_ + Wide(share) * (apexRadius_ - baseRadius_)); }
  dvec3 centerAt(double share) const { return narrow(base_ + Wide(share) * way_); }

  // What a scale of errors is taken by: the way from a ray's origin to the cone, or the cone where that is larger.
  double scaleFrom(const dvec3& origin) const {
    const Wide3 o = wide(origin);
    const Wide away = std::max(length(base_ - o), length(base_ + way_ - o));
    return std::max(double(away), size());
  }

  // Where the ray meets the cone beyond `least`, nearest first.
  std::vector<ConeMeeting> meetings(const dvec3& origin, const dvec3& direction, Wide least = 0) const {
    // |q - s e|^2 = (r_b + (r_a - r_b) s)^2, with s = q.e / e.e and q = o - base + t d.
    const Wide3 d = wide(direction), q = wide(origin) - base_;
    const Wide s0 = dot(q, way_) / squared_, s1 = dot(d, way_) / squared_, growth = apexRadius_ - baseRadius_;
    const Wide3 y0 = q - s0 * way_, y1 = d - s1 * way_;
    const Wide r0 = baseRadius_ + growth * s0, r1 = growth * s1;
    const Wide a = dot(y1, y1) - r1 * r1, b = dot(y0, y1) - r1 * r0, c = dot(y0, y0) - r0 * r0;
    const Wide discriminant = b * b - a * c;
    std::vector<ConeMeeting> found;
    if (discriminant < 0) return found;
    const Wide root = squareRoot(discriminant), sum = b <= 0 ? root - b : -root - b;
    const auto quotient = [](Wide x, Wide y) { return y == 0 ? Wide(INFINITY) : x / y; };
    const Wide enter = b <= 0 ? quotient(c, sum) : quotient(sum, a),
               leave = b <= 0 ? quotient(sum, a) : quotient(c, sum);
    for (const auto& [t, fromOutside] : {std::pair(enter, true), {leave, false}}) {
      const Wide s = s0 + t * s1;
      if (!(t > least && s >= 0 && s <= 1 && t < Wide(1e37))) continue;
      const double across = std::abs(double(dot(outwardAt(wide(origin) + t * d), d) / length(d)));
      found.push_back({t, fromOutside, across});
    }
    if (found.size() == 2 && found[1].t < found[0].t) std::swap(found[0], found[1]);
    return found;
  }

  // Signed distance of a point from the whole cone, which has no ends but the tip.
  Wide above(const Wide3& x) const {
    const Wide3 q = x - base_;
    const Wide s = dot(q, way_) / squared_;
    return (length(q - s * way_) - (baseRadius_ + s * (apexRadius_ - baseRadius_))) * length_ / slant_;
  }

  double distanceFromAxis(const Wide3& x) const {
    const Wide3 q = x - base_;
    return double(length(q - (dot(q, way_) / squared_) * way_));
  }

  // Unit, away from the axis; 0 on it.
  Wide3 outwardAt(const Wide3& x) const {
    const Wide3 q = x - base_;
    const Wide s = dot(q, way_) / squared_;
    const Wide3 y = q - s * way_;
    const Wide size = length(y);
    if (size == 0) return {0, 0, 0};
    return (length_ / slant_ / size) * y - ((apexRadius_ - baseRadius_) / slant_ / length_) * way_;
  }

  // Distance of a point from the surface between the ends: in its half-plane, from the segment between them.
  double distance(const Long3& x) const {
    const Long3 q = x - long_.base;
    const long double height = glm::dot(q, long_.axis), rho = glm::length(q - height * long_.axis);
    const long double share = std::clamp((height * long_.length + (rho - long_.radius) * long_.growth) /
                                             (long_.length * long_.length + long_.growth * long_.growth),
                                         0.0L, 1.0L);
    return double(std::hypot(height - share * long_.length, rho - long_.radius - share * long_.growth));
  }

  // The same of a ray's line near t: for hits where there is none. Both walls of a hair may be within reach.
  double distanceNear(const dvec3& origin, const dvec3& direction, double t, double within) const {
    constexpr int kSteps = 16;
    const long double step = (long double)(within) / kSteps;
    const auto distanceAt = [&](long double at) { return distance(Long3(origin) + at * Long3(direction)); };
    long double best = t;
    for (int i = -kSteps; i <= kSteps; ++i)
      if (distanceAt(t + i * step) < distanceAt(best)) best = t + i * step;
    long double from = best - step, to = best + step;
    from = leastBetween(from, to, distanceAt);
    return distanceAt(from);
  }

  // A ray that hits: by how little it would have to be shifted to miss. The surface as a plane at an end, and the depth
  // that the ray reaches below the surface.
  double marginOfHit(const dvec3& origin, const dvec3& direction, const ConeMeeting& hit) const {
    const Wide3 o = wide(origin), d = (1 / length(wide(direction))) * wide(direction), x = o + hit.t * wide(direction);
    const Wide s = dot(x - base_, way_) / squared_;
    // At an end: the shift that moves the hit along the generator beyond it, the part along the ray left out.
    const Wide3 N = outwardAt(x), y = (x - base_) - s * way_;
    const Wide rho = length(y);
    double least = double(rho);
    if (rho > 0) {
      const Wide3 axis = (1 / length_) * way_;
      const dvec3 around = glm::cross(narrow(axis), narrow((1 / rho) * y));
      const double turn = glm::dot(around, narrow(d)), cosine = std::abs(double(dot(N, d)));
      const double side = std::sqrt(std::max(1 - turn * turn, 1e-300));
      for (const Wide end : {s, 1 - s})
        least = std::min(least, std::abs(double(end * slant_)) * std::min(cosine / side, 1.0));
    }
    return std::min(least, depth(origin, direction));
  }

  // How far below the surface the ray comes where it is between the ends: a convex function's minimum.
  double depth(const dvec3& origin, const dvec3& direction) const {
    const Long3 o = Long3(origin) - long_.base, d = glm::normalize(Long3(direction));
    const auto above = [&](long double t) {
      const Long3 x = o + t * d;
      const long double height = glm::dot(x, long_.axis);
      return glm::length(x - height * long_.axis) - long_.radius - height / long_.length * long_.growth;
    };
    const long double height = glm::dot(o, long_.axis), climb = glm::dot(d, long_.axis);
    long double from = 0, to = glm::length(o) + long_.length + long_.radius + std::abs(long_.growth);
    if (climb != 0) {
      const auto [lo, hi] = std::minmax({-height / climb, (long_.length - height) / climb});
      from = std::max(from, lo);
      to = std::min(to, hi);
    }
    if (!(from < to)) return 0;
    from = leastBetween(from, to, above);
    return double(std::max(0.0L, -above(from)) * long_.length / std::hypot(long_.length, long_.growth));
  }

 private:
  Wide3 base_, way_;
  Wide baseRadius_, apexRadius_, squared_, length_, slant_;
  // The same for searches, where 64 bits do.
  struct {
    Long3 base, axis;
    long double length, radius, growth;
  } long_;
};

}  // namespace turner::hard
