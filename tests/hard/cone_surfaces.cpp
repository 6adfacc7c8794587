// Rays that leave cones: to lights and by mirrors, beside a copy in the same place. The oracle is
// that of the rays that arrive, or a closed form.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "base/threads.h"
#include "hard/cases.h"
#include "hard/cone_errors.h"
#include "hard/cone_scenes.h"

namespace turner::hard {
namespace {

// --- 46: rays that leave ---

// Places where rays from all around, and from inside, meet a cone.
std::vector<Query> arrivals(const ConeOracle& oracle, double away, size_t rays, Random& random) {
  std::vector<Query> queries;
  while (queries.size() < rays)
    queries.push_back({random() % 3 ? anywhere(oracle, away, random) : fromInside(oracle, away, random), 0,
                       Next::direction, vec3(randomDirection(random))});
  return queries;
}

// Of rays that leave a cone; `naive` by the usual least distance.
struct Departures {
  size_t outward = 0, inward = 0;
  Both<size_t> selfHits;                 // outward, by the cone itself
  Both<size_t> wrong;                    // inward
  ConeErrors errors;                     // inward, Turner's
  size_t inCopy = 0, outsideCopies = 0;  // outward, by a copy in the same place
  Both<size_t> shadowed;                 // lights inside that their inside does not see, and outside lights likewise
  size_t lit = 0;
};

void leaveCone(const Bench& bench, const Cone& cone, double away, size_t rays, Random& random, Departures& all) {
  bench.kernels.setScene(coneScene({cone}));
  const ConeOracle oracle(bench.kernels.local().cones[0]);
  // The way from the eye counts: places are rounded by it.
  const double unit = kUnit * oracle.scaleFrom(dvec3(0));
  const std::vector<Query> queries = arrivals(oracle, away, rays, random);
  for (const Tracer tracer : kTracers) {
    bench.kernels.setLeastDistance(tracer == Tracer::naive ? kUsualEpsilon : 0);
    std::vector<Query> next;
    for (const Found& found : bench.kernels.trace(queries, tracer))
      if (found.hits() && found.leaves) next.push_back({found.leaving});
    const std::vector<Found> found = bench.kernels.trace(next, tracer);
    std::vector<ConeErrors> judged(found.size());
    std::vector<int> inward(found.size());
    forAll(found.size(), [&](size_t i) {
      const TestRay& ray = next[i].ray;
      const dvec3 outward = narrow(oracle.outwardAt(wide(ray.origin)));
      inward[i] = tracer == Tracer::turner ? goesInward(ray) : glm::dot(outward, dvec3(ray.direction)) < 0;
      if (inward[i]) judged[i] = judge(oracle, ray, found[i], {unit, unit});
    });
    for (size_t i = 0; i < found.size(); ++i) {
      if (inward[i]) {
        all.wrong.of(tracer) += judged[i].wrong;
        if (tracer == Tracer::turner) all.errors.add(judged[i]);
      } else {
        all.selfHits.of(tracer) += found[i].hits();
      }
      if (tracer == Tracer::turner) ++(inward[i] ? all.inward : all.outward);
    }
  }
}

// The same cone once more, from its other end.
void leaveCopies(const Bench& bench, const Cone& cone, double away, size_t rays, Random& random, Departures& all) {
  const Cone copy{cone.apex, cone.apexRadius, cone.base, cone.baseRadius, 0};
  bench.kernels.setScene(coneScene({cone, copy}));
  const ConeOracle oracle(bench.kernels.local().cones[0]);
  std::vector<Query> next;
  for (const Found& found : bench.kernels.trace(arrivals(oracle, away, rays, random)))
    if (found.hits() && !goesInward(found.leaving) &&
        oracle.distanceFromAxis(wide(found.point)) > 8 * double(found.margin))
      next.push_back({found.leaving});
  for (const Found& found : bench.kernels.trace(next)) all.inCopy += found.hits();
  all.outsideCopies += next.size();
}

// Outside, a light that faces the surface is never behind the cone; inside, a light within it neither.
void lightCone(const Bench& bench, const Cone& cone, double away, size_t rays, Random& random, Departures& all) {
  bench.kernels.setScene(coneScene({cone}));
  const ConeOracle oracle(bench.kernels.local().cones[0]);
  std::vector<Query> queries = arrivals(oracle, away, rays, random);
  for (Query& query : queries) {
    query.next = Next::light;
    const Place place = placeOn(oracle, uniform(random, 0, 1), random);
    // Near the plane of some surface point, or inside.
    const dvec3 grazing = glm::normalize(anywhereAcross(place.outward, random) +
                                         (random() % 2 ? 1 : -1) * halvings(random, 0, 20) * place.outward);
    query.target = vec3(random() % 3 ? place.point + halvings(random, -10, 4) * grazing
                                     : dvec3(fromInside(oracle, away, random).origin));
  }
  for (const Tracer tracer : kTracers) {
    bench.kernels.setLeastDistance(tracer == Tracer::naive ? kUsualEpsilon : 0);
    std::vector<Query> shadows;
    const std::vector<Found> found = bench.kernels.trace(queries, tracer);
    for (size_t i = 0; i < found.size(); ++i) {
      if (!found[i].hits() || !found[i].leaves) continue;
      const dvec3 outward = narrow(oracle.outwardAt(wide(found[i].point)));
      const bool isOutside = glm::dot(outward, dvec3(found[i].Ng)) > 0;
      const Wide3 light = wide(queries[i].target);
      const bool lightIsInside = oracle.above(light) < -16 * kUnit * oracle.scaleFrom(dvec3(0));
      if (isOutside || lightIsInside) shadows.push_back({found[i].leaving, 1});
    }
    for (const Found& shadow : bench.kernels.trace(shadows, tracer)) all.shadowed.of(tracer) += shadow.hits();
    if (tracer == Tracer::turner) all.lit += shadows.size();
  }
}

void raysThatLeave(const Bench& bench, Report& report) {
  Random random = bench.random(46);
  Departures all;
  const std::vector<ConeShape> shapes = allConeShapes();
  const size_t rays = bench.effort.rays(1e6, 4e4) / (2 * shapes.size());
  for (const ConeShape& shape : shapes)
    for (const double away : {1.5, 30.0}) {
      const Cone cone = coneAt(shape, away, random);
      leaveCone(bench, cone, away, rays, random, all);
      leaveCopies(bench, cone, away, rays, random, all);
      lightCone(bench, cone, away, rays, random, all);
    }
  bench.kernels.setLeastDistance(0);
  report.atMost(fmt::format("outward: hits on the cone itself, of {} rays", all.outward), double(all.selfHits.turner),
                0, double(all.selfHits.naive));
  report.atMost(fmt::format("outward: hits on a copy from its other end, of {} rays", all.outsideCopies),
                double(all.inCopy), 0);
  report.atMost(fmt::format("lights that face the surface: shadowed by the cone itself, of {}", all.lit),
                double(all.shadowed.turner), 0, double(all.shadowed.naive));
  report.atMost(fmt::format("inward: wrong hits and misses of {} rays", all.inward), double(all.wrong.turner), 0,
                double(all.wrong.naive), fmt::format("the farthest {:.3g} u from the border", all.errors.border));
  report.atMost("inward: o + t d off the surface, u", all.errors.alongRay, 14);
  report.atMost("inward: error of t at more than 6 degrees, u", all.errors.t, 120);
  report.atMost("inward: surface point off the surface, u", all.errors.point, 4);
}

// --- 47: mirrors inside a cylinder ---

// Chords of a circle that turn by `angle` at each reflection, and climb a little.
void mirrorsInside(const Bench& bench, Report& report) {
  Random random = bench.random(47);
  const Cone cylinder = coneAt({1, 1}, 0.1, random);
  bench.kernels.setScene(coneScene({cylinder}));
  const ConeOracle oracle(bench.kernels.local().cones[0]);
  constexpr int reflections = 500;
  const dvec3 axis = oracle.axis();
  const double radius = oracle.widest();
  dvec3 a, b;
  basisOf(axis, a, b);
  struct Polygon {
    const char* name;
    double angle, bar;
  };
  for (const Polygon& polygon : {Polygon{"a pentagram", 4 * std::numbers::pi / 5, 350},
                                 {"a polygon of 64", 2 * std::numbers::pi / 64, 200},
                                 {"a polygon of 1000", 2 * std::numbers::pi / 1000, 2000}}) {
    constexpr size_t kRays = 64;
    std::vector<TestRay> rays;
    for (size_t i = 0; i < kRays; ++i) {
      const double from = uniform(random, 0, 2 * std::numbers::pi), to = from + polygon.angle;
      const dvec3 start = oracle.centerAt(0.1) + radius * (std::cos(from) * a + std::sin(from) * b);
      const dvec3 chord = radius * ((std::cos(to) - std::cos(from)) * a + (std::sin(to) - std::sin(from)) * b);
      const dvec3 climb = 0.5 * oracle.lengthOfAxis() / reflections * axis;
      rays.push_back({vec3(start + 0.5 * chord), vec3(glm::normalize(chord + climb))});
    }
    // Where the first hit is, and how far each reflection goes on, follow from the float ray.
    struct Path {
      dvec3 first;
      double turn, climb;
    };
    std::vector<Path> paths;
    for (const TestRay& ray : rays) {
      const std::vector<ConeMeeting> meetings = oracle.meetings(ray.origin, ray.direction);
      if (meetings.empty()) throw std::logic_error("a ray inside a cylinder meets nothing");
      const double t = double(meetings.back().t);
      const dvec3 d(ray.direction), first = dvec3(ray.origin) + t * d;
      const dvec3 y = first - oracle.centerAt(0), across = y - glm::dot(y, axis) * axis,
                  drift = d - glm::dot(d, axis) * axis;
      const double cosine = glm::dot(glm::normalize(across), drift) / glm::length(drift);
      const double chord = 2 * radius * cosine, side = glm::dot(axis, glm::cross(across, drift)) > 0 ? 1 : -1;
      paths.push_back(
          {first, side * 2 * std::asin(std::min(1.0, cosine)), chord / glm::length(drift) * glm::dot(d, axis)});
    }
    Both<size_t> lost;
    Both<Worst> drift;
    for (const Tracer tracer : kTracers) {
      bench.kernels.setLeastDistance(tracer == Tracer::naive ? kUsualEpsilon : 0);
      std::vector<TestRay> left = rays;
      for (int k = 0; k < reflections; ++k) {
        const std::vector<Found> found = stepFrom(bench.kernels, left, Next::reflected, tracer);
        for (size_t i = 0; i < left.size(); ++i) {
          left[i] = found[i].leaving;
          lost.of(tracer) += !found[i].hits();
          if (!found[i].hits()) continue;
          const Path& path = paths[i];
          const dvec3 origin = oracle.centerAt(0), y = path.first - origin, along = glm::dot(y, axis) * axis;
          const dvec3 turned = std::cos(k * path.turn) * (y - along) + std::sin(k * path.turn) * glm::cross(axis, y);
          const dvec3 expected = origin + along + turned + k * path.climb * axis;
          drift.of(tracer).add(glm::length(dvec3(found[i].point) - expected) / (k + 1) / kUnit);
        }
      }
    }
    bench.kernels.setLeastDistance(0);
    report.atMost(fmt::format("{}: rays of {} that get lost in {} reflections", polygon.name, kRays, reflections),
                  double(lost.turner), 0, double(lost.naive));
    report.atMost(fmt::format("{}: drift of the place a reflection, u", polygon.name), drift.turner.value, polygon.bar,
                  drift.naive.value);
  }
}

}  // namespace

std::vector<Case> coneSurfaceCases() {
  return {{46, "Rays that leave cones", raysThatLeave}, {47, "Mirrors inside a cylinder", mirrorsInside}};
}

}  // namespace turner::hard
