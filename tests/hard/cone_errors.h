// What a tracer makes of rays to a cone, against the oracle: errors are counted in u = 2^-24 of the distance from the
// ray's origin, or of the cone's size where that is more.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "hard/chain.h"
#include "hard/cone_oracle.h"

namespace turner::hard {

// A wrong decision counts where the ray is farther than this from the place where the other one is right: the ends have
// a margin of 8 u of the size, and the rest is rounding.
inline constexpr double kBorder = 12;

// A hit that is farther than this from the surface is none.
inline constexpr double kFarOff = 64;

// What a tracer made of many rays to cones.
struct ConeErrors {
  size_t wrong = 0;       // hits and misses beyond the border
  double border = 0;      // the farthest wrong decision from it
  double alongRay = 0;    // o + t d from the surface
  double t = 0;           // where ray and surface make more than 6 degrees
  double point = 0;       // the surface point from the surface
  size_t wrongSides = 0;  // back for front, or the other way round

  void add(const ConeErrors& other) {
    wrong += other.wrong;
    wrongSides += other.wrongSides;
    for (double ConeErrors::*x : {&ConeErrors::border, &ConeErrors::alongRay, &ConeErrors::t, &ConeErrors::point})
      if (!(other.*x <= this->*x)) this->*x = other.*x;
  }
};

// What errors are counted in.
struct Units {
  double error;
  double border;  // of decisions: beyond 1024 radii by the cone's own size
};

// Which of the meetings is the hit at t, or none: one of the same wall, from where to there the ray keeps to the
// surface. (At a rim the near wall may be hit by the ends' margin, and the far wall be a hair behind it.)
inline const ConeMeeting* meetingAt(const ConeOracle& oracle, const std::vector<ConeMeeting>& meetings,
                                    const dvec3& origin, const dvec3& direction, double t, double unit) {
  const Wide3 o = wide(origin), d = wide(direction), x = o + Wide(t) * d;
  const double cosine = double(dot(oracle.outwardAt(x), d));
  // Where t is not known as well as the cone is thick there, there is one wall.
  const bool wallsAreOne = std::min(oracle.distanceFromAxis(x), oracle.lengthOfAxis()) < kFarOff * unit;
  const ConeMeeting* nearest = nullptr;
  const auto apart = [&](const ConeMeeting& meeting) { return std::abs(double(meeting.t - t)); };
  for (const ConeMeeting& meeting : meetings) {
    const bool sameWall = wallsAreOne || meeting.fromOutside == (cosine < 0) || std::abs(cosine) < 0x1p-10;
    const auto above = [&](Wide at) { return std::abs(double(oracle.above(o + at * d))); };
    const bool keepsToIt = std::max(above(t), above((meeting.t + t) / 2)) <= kFarOff * unit;
    if (sameWall && keepsToIt && (!nearest || apart(meeting) < apart(*nearest))) nearest = &meeting;
  }
  return nearest;
}

// One ray's decision and distance; t: infinite where nothing was hit.
inline ConeErrors judgeDistance(const ConeOracle& oracle, const dvec3& origin, const dvec3& direction, double t,
                                const Units& units) {
  ConeErrors errors;
  errors.wrong = std::isnan(t);
  if (errors.wrong) return errors;
  const std::vector<ConeMeeting> meetings = oracle.meetings(origin, direction);
  const ConeMeeting* const hit =
      std::isfinite(t) ? meetingAt(oracle, meetings, origin, direction, t, units.error) : nullptr;
  const auto decideWrongly = [&](double distance) {
    errors.border = std::max(errors.border, distance / units.border);
    errors.wrong = errors.border > kBorder;
  };
  for (const ConeMeeting& meeting : meetings)
    if (&meeting != hit && meeting.t + Wide(16 * units.error) < Wide(t))
      decideWrongly(oracle.marginOfHit(origin, direction, meeting));
  if (!std::isfinite(t)) return errors;
  if (!hit) {
    decideWrongly(oracle.distanceNear(origin, direction, t, kFarOff * units.error));
    return errors;
  }
  errors.alongRay = std::abs(double(oracle.above(wide(origin) + Wide(t) * wide(direction)))) / units.error;
  // Not where a hair less or more decides.
  const double wrongBy = std::abs(double(hit->t - t)) / units.error;
  if (hit->angle > 0.1 && (wrongBy < kBorder || oracle.marginOfHit(origin, direction, *hit) > kFarOff * units.error))
    errors.t = wrongBy;
  return errors;
}

// The same and the surface there.
inline ConeErrors judge(const ConeOracle& oracle, const TestRay& ray, const Found& found, const Units& units) {
  const double t = found.hits() ? double(found.t) : INFINITY;
  ConeErrors errors = judgeDistance(oracle, ray.origin, ray.direction, t, units);
  const std::vector<ConeMeeting> meetings = oracle.meetings(ray.origin, ray.direction);
  const ConeMeeting* const hit =
      std::isfinite(t) ? meetingAt(oracle, meetings, ray.origin, ray.direction, t, units.error) : nullptr;
  if (!hit) return errors;
  errors.point = std::abs(double(oracle.above(wide(found.point)))) /
                 std::max(units.error, kUnit * oracle.scaleFrom(dvec3(0)));  // it is rounded in the eye's frame
  errors.wrongSides =
      found.front != hit->fromOutside && oracle.marginOfHit(ray.origin, ray.direction, *hit) > kFarOff * units.error;
  return errors;
}

}  // namespace turner::hard
