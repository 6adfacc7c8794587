// What follows from measured points: curves, their slopes, what reaches an error first, and that in words.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "report/measure.h"

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

// Two curves at the same samples: where one has the smaller figure, by more than a tenth, without a break.
enum class Figure { rmse, seconds };
struct Lead {
  size_t from = 0, to = 0;  // the leader's points
  bool ofFirst = false;
};
std::vector<Lead> leadsOf(const SweptScene& scene, const Curve& first, const Curve& second, Figure figure);

// "llvmpipe, sobol 4x4, depth 3": a point in words.
std::string pointInWords(const SweptScene& scene, const SweepPoint& point);

// "12.3 ms", "4.56 s".
std::string timeInWords(double seconds);

// What a reader wants to know first, a sentence each.
std::vector<std::string> findings(const SweptScene& scene);

// Quoted where a shell would see more in it than one word.
std::string shellWord(const std::string& text);

// The render command that makes the point's picture of seed 0; the shaders' folder if it is not Turner's own.
std::string renderCommand(const SweptScene& scene, const SweepPoint& point, const std::string& shaders);

}  // namespace turner::report
