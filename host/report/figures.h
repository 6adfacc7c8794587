// What follows from measured points: curves, their slopes, and what reaches an error first.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "report/swept_scene.h"

namespace turner::report {

// The errors that "time to reach" is asked of.
inline constexpr double kTargets[] = {1e-2, 1e-3};

// Samples in each pixel and seconds at which a curve comes down to an error.
struct Reach {
  double samples = 0, seconds = 0;
  bool extrapolated = false;  // beyond the measured points, along the curve's slope
};

// A sampler on a renderer: its points over the number of samples, in their order.
struct Curve {
  size_t renderer = 0;
  Sampler sampler = Sampler::grid;
  std::vector<size_t> points;                 // in SweptScene::points, without those that have no rmse
  std::optional<double> slope;                // of log rmse over log samples, by least squares, from 2x2 samples on
  std::vector<std::optional<Reach>> targets;  // one for each of kTargets
};

std::vector<Curve> curvesOf(const SweptScene& scene);

// The slope of the straight line nearest to the points (log x, log y); none with fewer than two different x.
std::optional<double> logSlope(const std::vector<double>& x, const std::vector<double>& y);

// The points than which none is both faster and less wrong, by time. Each is less wrong by a hundredth than the one
// before.
std::vector<size_t> paretoFront(const SweptScene& scene);
// Of each point, whether it is one of them.
std::vector<bool> isOnFront(const SweptScene& scene);

// The point with the same samples on the same renderer from which nothing is cut off: every sweep has it.
const SweepPoint& uncutPoint(const SweptScene& scene, const SweepPoint& point);

// Errors that differ by less than this share are called alike: times are measured, and errors are of some draws.
inline constexpr double kAlike = 0.1;

// The points of two curves that have the same numbers of samples.
std::vector<std::pair<size_t, size_t>> sameSamples(const SweptScene& scene, const Curve& first, const Curve& second);

// Two curves at the same samples: where one has the smaller figure, by more than a tenth, without a break.
enum class Figure { rmse, seconds };
struct Lead {
  size_t from = 0, to = 0;  // the leader's points
  bool ofFirst = false;
};
std::vector<Lead> leadsOf(const SweptScene& scene, const Curve& first, const Curve& second, Figure figure);

}  // namespace turner::report
