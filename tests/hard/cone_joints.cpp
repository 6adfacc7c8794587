// Cones that touch balls and each other: no light comes through, and none is lost. The oracle is the quadratic formula
// in 113-bit arithmetic.
#include <fmt/format.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <tuple>

#include "hard/cases.h"
#include "hard/cone_scenes.h"

namespace turner::hard {
namespace {

// --- 48: joints with balls ---

// Where a ray first meets a sphere from outside, or where it leaves it.
Wide nearestOnSphere(const Sphere& sphere, const TestRay& ray) {
  const Wide3 f = wide(sphere.center) - wide(ray.origin), d = wide(ray.direction);
  const Wide r = Wide(sphere.radius) + Wide(sphere.radiusRest), a = dot(d, d), b = dot(d, f), c = dot(f, f) - r * r;
  const Wide discriminant = b * b - a * c;
  if (discriminant < 0) return INFINITY;
  const Wide root = squareRoot(discriminant), q = b >= 0 ? b + root : b - root;
  const Wide near = std::min(c / q, q / a), far = std::max(c / q, q / a);
  return near > 0 ? near : far > 0 ? far : Wide(INFINITY);
}

struct JointCounts {
  size_t hits = 0, cracks = 0, outward = 0, shadows = 0, unavoidable = 0, inward = 0, waysOut = 0;
  double farthest = 0;
};

// A rod with a ball of its radius at each end: convex, and closed.
void measureJoints(const Bench& bench, double radius, double length, double away, size_t rays, Random& random,
                   JointCounts& counts) {
  const double size = std::hypot(length, radius);
  const dvec3 middle = away * size * randomDirection(random), way = length * randomDirection(random);
  const Cone rod{middle - 0.5 * way, radius, middle + 0.5 * way, radius, 0};
  Scene scene = coneScene({rod});
  scene.spheres = {{rod.base, radius, 0}, {rod.apex, radius, 0}};
  bench.kernels.setScene(scene);
  const Scene& local = bench.kernels.local();
  const ConeOracle oracle(local.cones[0]);
  const double unit = kUnit * oracle.scaleFrom(dvec3(0));
  std::vector<Query> queries;
  while (queries.size() < rays) {
    const Place place = placeOn(oracle, double(random() % 2), random);
    const dvec3 off = radius * halvings(random, 2, 26) * randomDirection(random);
    // From where the joint is seen, up to grazing.
    dvec3 from = randomDirection(random);
    from -= std::min(0.0, 1.999 * glm::dot(from, place.outward)) * place.outward;
    TestRay ray = rayThrough(oracle, place.point + off, -glm::normalize(from), away);
    queries.push_back({ray, 0, Next::direction, vec3(randomDirection(random))});
  }
  const std::vector<Found> found = bench.kernels.trace(queries);
  std::vector<Query> outward, inward;
  for (size_t i = 0; i < found.size(); ++i) {
    const TestRay& ray = queries[i].ray;
    Wide truth = INFINITY;
    for (const ConeMeeting& meeting : oracle.meetings(ray.origin, ray.direction)) truth = std::min(truth, meeting.t);
    for (const Sphere& sphere : local.spheres) truth = std::min(truth, nearestOnSphere(sphere, ray));
    counts.hits += found[i].hits();
    // What is hit must be on the union's outside, where the line passes more than grazing it.
    const Wide t = found[i].hits() ? Wide(found[i].t) : Wide(INFINITY);
    if (truth < t) {
      const Wide3 d = wide(ray.direction), x = wide(ray.origin) + truth * d;
      // Depth below the union's surface, halfway to what is hit, or to the back.
      Wide deepest = 0;
      for (int k = 1; k < 16; ++k) {
        const Wide step = std::min(t - truth, Wide(2 * radius)) * k / 16;
        const Wide3 p = x + step * d;
        Wide below = -INFINITY;
        for (const Sphere& sphere : local.spheres)
          below = std::max(below, Wide(sphere.radius) - turner::hard::length(p - wide(sphere.center)));
        const Wide share = dot(p - wide(local.cones[0].base), wide(oracle.axis())) / oracle.lengthOfAxis();
        if (share > 0 && share < 1) below = std::max(below, -oracle.above(p));
        deepest = std::max(deepest, below);
      }
      counts.farthest = std::max(counts.farthest, double(deepest) / unit);
      counts.cracks += double(deepest) > 8 * unit;
    }
    if (!found[i].hits()) continue;
    // Above the union's surface there: that of its nearest part.
    const Wide3 point = wide(found[i].point);
    const Wide share = dot(point - wide(local.cones[0].base), wide(oracle.axis())) / oracle.lengthOfAxis();
    const dvec3 N = share > 0 && share < 1
                        ? narrow(oracle.outwardAt(point))
                        : glm::normalize(dvec3(found[i].point) - local.spheres[share > 0.5 ? 1 : 0].center);
    const double above = glm::dot(N, dvec3(found[i].leaving.direction));
    if (!goesInward(found[i].leaving) && above > 0) outward.push_back({found[i].leaving});
    if (goesInward(found[i].leaving) && above < 0) inward.push_back({found[i].leaving});
  }
  // Places are rounded: a ray that meets the neighbour from where it starts is none of the kernel's errors.
  const std::vector<Found> shadows = bench.kernels.trace(outward);
  for (size_t i = 0; i < shadows.size(); ++i) {
    if (!shadows[i].hits()) continue;
    const TestRay& ray = outward[i].ray;
    const uint32_t neighbour = shadows[i].id;
    const bool meets = neighbour < 2 ? nearestOnSphere(local.spheres[neighbour], ray) < Wide(1e37)
                                     : !oracle.meetings(ray.origin, ray.direction).empty();
    ++(meets ? counts.unavoidable : counts.shadows);
  }
  for (const Found& hit : bench.kernels.trace(inward)) counts.waysOut += !hit.hits();
  counts.outward += outward.size();
  counts.inward += inward.size();
}

// --- seams of chains ---

// Cones that share circles: a turned body along one axis, watched from inside. Rays at the circles.
void measureSeams(const Bench& bench, size_t rays, Random& random, size_t& asked, size_t& through) {
  constexpr int kCones = 8;
  const dvec3 axis = randomDirection(random), start = 2.0 * randomDirection(random);
  std::vector<Cone> cones;
  std::vector<double> heights = {0}, radii = {uniform(random, 0.3, 1)};
  for (int i = 0; i < kCones; ++i) {
    heights.push_back(heights.back() + uniform(random, 0.3, 1));
    radii.push_back(i % 3 == 0 ? radii.back() : uniform(random, 0.3, 1));
    cones.push_back({start + heights[size_t(i)] * axis, radii[size_t(i)], start + heights[size_t(i) + 1] * axis,
                     radii[size_t(i) + 1], 0});
  }
  bench.kernels.setScene(coneScene(cones));
  std::vector<Query> queries;
  while (queries.size() < rays) {
    const int seam = 1 + int(random() % (kCones - 1));
    const ConeOracle oracle(bench.kernels.local().cones[size_t(seam)]);
    const dvec3 target = placeOn(oracle, 0, random).point + halvings(random, 16, 28) * randomDirection(random);
    // From the seam's own cone or its neighbour, so that nothing is before it.
    const dvec3 origin = oracle.centerAt(uniform(random, -0.2, 0.5));
    queries.push_back({{vec3(origin), vec3(glm::normalize(target - dvec3(vec3(origin))))}});
  }
  for (const Found& found : bench.kernels.trace(queries)) through += !found.hits();
  asked += queries.size();
}

void joints(const Bench& bench, Report& report) {
  Random random = bench.random(48);
  JointCounts counts;
  const size_t rays = bench.effort.rays(1e6, 6e4) / 15;
  for (const auto& [radius, length, away] : {std::tuple(0.07412, 0.7294, 2.0),
                                             {0.07412, 0.7294, 10.0},
                                             {0.07412, 0.07, 2.0},
                                             {0.001, 1.0, 2.0},
                                             {0.5, 1.0, 100.0}})
    for (int turn = 0; turn < 3; ++turn) measureJoints(bench, radius, length, away, rays, random, counts);
  report.atMost(fmt::format("rod with balls: rays of {} that pass more than 8 u inside", counts.hits),
                double(counts.cracks), 0, {}, fmt::format("the farthest {:.3g} u", counts.farthest));
  report.atMost(fmt::format("rod with balls: share of outward rays shadowed by the neighbour, of {}", counts.outward),
                double(counts.shadows) / double(counts.outward), 1e-4, {},
                fmt::format("{}, and {} that meet it from where they start", counts.shadows, counts.unavoidable));
  report.atMost(fmt::format("rod with balls: inward rays of {} that find a way out", counts.inward),
                double(counts.waysOut), 0);
  size_t asked = 0, through = 0;
  for (int turn = 0; turn < 20; ++turn) measureSeams(bench, bench.effort.rays(1e6, 6e4) / 20, random, asked, through);
  report.atMost(fmt::format("chains of cones: rays of {} at shared circles that go through", asked), double(through),
                0);
}

}  // namespace

std::vector<Case> coneJointCases() {
  return {{48, "Joints of cones", joints}};
}

}  // namespace turner::hard
