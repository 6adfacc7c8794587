// Cones and cylinders of all shapes, seen from near and far. The oracle is the quadratic formula in 113-bit arithmetic,
// on the cone and the float ray that the kernel gets.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/threads.h"
#include "hard/cases.h"
#include "hard/cone_errors.h"
#include "hard/cone_scenes.h"
#include "reference/intersect.h"

namespace turner::hard {
namespace {

Units unitsOf(const ConeOracle& oracle, const Cone& local, const dvec3& origin) {
  const double unit = kUnit * oracle.scaleFrom(origin);
  return {unit, isFarFromEye(local) ? kUnit * oracle.size() : unit};
}

// Traces rays to the only cone of a scene.
void measureCone(const Bench& bench, const Cone& cone, double away, size_t rays, Random& random, ConeRayMaker makeRay,
                 Both<ConeErrors>& errors) {
  bench.kernels.setScene(coneScene({cone}));
  const Cone& local = bench.kernels.local().cones[0];
  const ConeOracle oracle(local);
  Bench::inBatches(rays, [&](size_t count) {
    std::vector<Query> queries;
    while (queries.size() < count) queries.push_back({makeRay(oracle, away, random)});
    for (const Tracer tracer : kTracers) {
      const std::vector<Found> found = bench.kernels.trace(queries, tracer);
      std::vector<ConeErrors> judged(count);
      forAll(count, [&](size_t i) {
        judged[i] = judge(oracle, queries[i].ray, found[i], unitsOf(oracle, local, queries[i].ray.origin));
      });
      for (const ConeErrors& one : judged) errors.of(tracer).add(one);
    }
  });
}

struct Bars {
  double alongRay, t, point;
};

void reportCones(Report& report, const std::string& what, const Both<ConeErrors>& errors, const Bars& bars) {
  const ConeErrors &turner = errors.turner, &naive = errors.naive;
  report.atMost(what + ": wrong hits and misses", double(turner.wrong), 0, double(naive.wrong),
                fmt::format("the farthest {:.3g} u from the border", turner.border));
  report.atMost(what + ": o + t d off the surface, u", turner.alongRay, bars.alongRay, naive.alongRay);
  report.atMost(what + ": error of t at more than 6 degrees, u", turner.t, bars.t, naive.t);
  report.atMost(what + ": surface point off the surface, u", turner.point, bars.point, naive.point);
  report.atMost(what + ": seen from the wrong side", double(turner.wrongSides), 0, double(naive.wrongSides));
}

struct Aim {
  const char* name;
  ConeRayMaker makeRay;
  Bars bars;
};

// --- 43: all shapes, near ---

void shapesNearBy(const Bench& bench, Report& report) {
  const std::array<Aim, 7> aims = {{{"anywhere", anywhere, {8, 28, 4}},
                                    {"silhouettes", atTheSilhouette, {6, 28, 4}},
                                    {"rims", atTheRims, {8, 28, 4}},
                                    {"along the axis", alongTheAxis, {8, 22, 3}},
                                    {"along a generator", alongAGenerator, {6, 24, 4}},
                                    {"tips", atTheTip, {7, 26, 3}},
                                    {"from inside", fromInside, {9, 17, 4}}}};
  std::array<Both<ConeErrors>, 7> errors;
  Random random = bench.random(43);
  const std::vector<ConeShape> shapes = allConeShapes();
  const size_t rays = bench.effort.rays(1e6, 2e4) / (2 * shapes.size());
  for (const ConeShape& shape : shapes)
    for (const double away : {1.5, 30.0}) {
      const Cone cone = coneAt(shape, away, random);
      for (size_t i = 0; i < aims.size(); ++i)
        if (aims[i].makeRay != &atTheTip || shape.radius == 0)
          measureCone(bench, cone, away, rays, random, aims[i].makeRay, errors[i]);
    }
  for (size_t i = 0; i < aims.size(); ++i) reportCones(report, aims[i].name, errors[i], aims[i].bars);
}

// --- 44: from afar ---

void shapesFromAfar(const Bench& bench, Report& report) {
  const std::array<ConeRayMaker, 6> aims = {anywhere,     atTheSilhouette, atTheRims,
                                            alongTheAxis, alongAGenerator, atTheTip};
  Random random = bench.random(44);
  const std::vector<ConeShape> shapes = allConeShapes();
  for (const double lengths : {1e3, 1e5}) {
    Both<ConeErrors> errors;
    const size_t rays = bench.effort.rays(1e6, 3e4) / shapes.size();
    for (const ConeShape& shape : shapes) {
      const double away = std::max(lengths / shape.size(), 2.0);
      const Cone cone = coneAt(shape, away, random);
      for (const ConeRayMaker aim : aims)
        if (aim != &atTheTip || shape.radius == 0) measureCone(bench, cone, away, rays / 6, random, aim, errors);
    }
    reportCones(report, fmt::format("{:g} lengths away", lengths), errors, {7, 24, 3});
  }
}

// --- 45: nearly discs ---

// The reference in the units of double.
void measureReference(const Cone& cone, double away, size_t rays, Random& random, ConeRayMaker makeRay,
                      ConeErrors& errors) {
  const ConeOracle oracle(cone);
  std::vector<TestRay> made;
  while (made.size() < rays) made.push_back(makeRay(oracle, away, random));
  std::vector<ConeErrors> judged(rays);
  forAll(rays, [&](size_t i) {
    const dvec3 origin(made[i].origin), direction = glm::normalize(dvec3(made[i].direction));
    const double t = reference::intersect(reference::makeRay(origin, direction, reference::kNoPrimitive), cone, false);
    const double unit = 0x1p-53 * oracle.scaleFrom(origin);
    judged[i] = judgeDistance(oracle, origin, direction, t < reference::kFarAway ? t : INFINITY, {unit, unit});
  });
  for (const ConeErrors& one : judged) errors.add(one);
}

void nearlyDiscs(const Bench& bench, Report& report) {
  const std::array<ConeRayMaker, 5> aims = {anywhere, atTheSilhouette, atTheRims, alongTheAxis, atTheTip};
  Random random = bench.random(45);
  for (const double flatness : {1e3, 1e4, 1e5}) {
    Both<ConeErrors> errors;
    ConeErrors reference;
    const size_t rays = bench.effort.rays(1e6, 2e4) / (2 * 3 * aims.size());
    for (const double radius : {0.0, 0.5 * flatness})
      for (const double away : {1.0, 10.0, 100.0}) {
        const Cone cone = coneAt({radius, radius + flatness}, away, random);
        for (const ConeRayMaker aim : aims) {
          if (aim == &atTheTip && radius != 0) continue;
          measureCone(bench, cone, away, rays, random, aim, errors);
          measureReference(bench.kernels.local().cones[0], away, rays, random, aim, reference);
        }
      }
    const std::string what = fmt::format("radii {:g} lengths apart", flatness);
    reportCones(report, what, errors, {10, 22, 4});
    report.atMost(what + ", the reference: wrong hits and misses", double(reference.wrong), 0, {},
                  fmt::format("the farthest {:.3g} roundings of double from the border", reference.border));
    report.atMost(what + ", the reference: o + t d off the surface, roundings of double", reference.alongRay, 6);
  }
}

}  // namespace

std::vector<Case> coneCases() {
  return {{43, "Cones of all shapes", shapesNearBy},
          {44, "Cones from afar", shapesFromAfar},
          {45, "Cones that are nearly discs", nearlyDiscs}};
}

}  // namespace turner::hard
