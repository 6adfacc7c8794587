// Spheres far away, close by, tangent, kissing, and of all sizes in one scene. The oracle is the quadratic formula in
// 113-bit arithmetic, on the exact sphere and the float ray that the kernel gets.
#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>

#include "hard/cases.h"
#include "hard/vectors.h"

namespace turner::hard {
namespace {

// Where a ray meets a sphere, the nearest place before it.
struct Truth {
  bool hits;
  Wide t;
  double clearance;  // impact parameter less radius: below 0 the line passes through the sphere
};

Truth truthOf(const Sphere& sphere, const TestRay& ray) {
  const Wide3 f = wide(sphere.center) - wide(ray.origin), d = wide(ray.direction);
  const Wide r = sphere.radius, a = dot(d, d), b = dot(d, f), c = dot(f, f) - r * r, discriminant = b * b - a * c;
  const Wide impact = squareRoot(dot(f, f) - b * b / a);
  Truth truth{false, 0, double(impact - r)};
  if (discriminant < 0) return truth;
  const Wide root = squareRoot(discriminant), q = b >= 0 ? b + root : b - root;
  const Wide t0 = c / q, t1 = q / a, near = std::min(t0, t1), far = std::max(t0, t1);
  truth.t = near > 0 ? near : far;
  truth.hits = truth.t > 0;
  return truth;
}

// The eye is the origin and the view's scale 1, so that the kernel's frame is the scene's.
Scene sphereScene(const std::vector<Sphere>& spheres) {
  Scene scene;
  scene.camera = {.eye = {0, 0, 0}, .target = {0, 0, -1}};
  scene.materials = {Material{.diffuse = {1, 1, 1}}};
  scene.spheres = spheres;
  return scene;
}

// What a tracer made of many rays to one sphere.
struct Errors {
  size_t misclassified = 0, notNumbers = 0;
  std::vector<double> relative;  // of t, where both hit

  void count(const Truth& truth, const Found& found, double undecided) {
    notNumbers += std::isnan(found.t);
    if (truth.hits != found.hits()) {
      misclassified += std::abs(truth.clearance) > undecided;
    } else if (truth.hits) {
      const double error = std::abs(double((Wide(found.t) - truth.t) / truth.t));
      relative.push_back(std::isnan(error) ? INFINITY : error);
    }
  }
};

using RayMaker = std::function<TestRay(Random&)>;

// Traces rays to the only sphere of a scene. Rays that pass it as near as `undecided` may be taken either way.
void measureSphere(const Bench& bench, const Sphere& sphere, size_t rays, Random& random, const RayMaker& makeRay,
                   double undecided, Errors& turner, Errors& naive) {
  bench.kernels.setScene(sphereScene({sphere}));
  Bench::inBatches(rays, [&](size_t count) {
    std::vector<Query> queries;
    for (size_t i = 0; i < count; ++i) queries.push_back({makeRay(random)});
    const std::vector<Found> found = bench.kernels.trace(queries);
    const std::vector<Found> foundNaively = bench.kernels.trace(queries, Tracer::naive);
    for (size_t i = 0; i < count; ++i) {
      const Truth truth = truthOf(sphere, queries[i].ray);
      turner.count(truth, found[i], undecided);
      naive.count(truth, foundNaively[i], undecided);
    }
  });
}

void reportSphere(Report& report, const std::string& what, Errors& turner, Errors& naive, double p99Bar,
                  double maxBar) {
  report.atMost("misclassified rays, " + what, double(turner.misclassified + turner.notNumbers), 0,
                double(naive.misclassified + naive.notNumbers));
  if (p99Bar > 0)
    report.atMost("relative error of t, p99, " + what, quantile(turner.relative, 0.99), p99Bar,
                  quantile(naive.relative, 0.99));
  report.atMost("relative error of t, largest, " + what, quantile(turner.relative, 1), maxBar,
                quantile(naive.relative, 1));
}

// Rays from the origin into the cone around a sphere that is this much wider than it.
RayMaker raysAround(const dvec3& center, double radius, double wider) {
  return [=](Random& random) {
    dvec3 a, b;
    basisOf(glm::normalize(center), a, b);
    const double rho = wider * radius * std::sqrt(uniform(random, 0, 1)), phi = uniform(random, 0, 2 * M_PI);
    return TestRay{vec3(0), vec3(glm::normalize(center + rho * (std::cos(phi) * a + std::sin(phi) * b)))};
  };
}

// --- 1 and 2 ---

void farSphere(const Bench& bench, Report& report, double radius, double distance, double undecided, int number) {
  Random random = bench.random(number);
  Errors turner, naive;
  // From three sides: along an axis coordinates would be exact.
  for (const dvec3& toward : {dvec3(0, 0, -1), dvec3(1, 2, -3), dvec3(-5, 4, 3)}) {
    const dvec3 center = dvec3(vec3(distance * glm::normalize(toward)));
    measureSphere(bench, {center, double(float(radius))}, bench.effort.rays(1e6) / 3, random,
                  raysAround(center, radius, 1.2), undecided, turner, naive);
  }
  reportSphere(report, fmt::format("r = {:g} at a distance of {:g}", radius, distance), turner, naive, 0, 2e-7);
}

void farSphere(const Bench& bench, Report& report) {
  farSphere(bench, report, 1, 1e4, 1e-7 * 1e4, 1);
}

void tinyFarSphere(const Bench& bench, Report& report) {
  // The case asks for no ray in a million, whatever its distance from the edge; but a ray whose direction is rounded
  // passes 1e3 away where its own rounding puts it, and the truth is that of the rounded ray.
  farSphere(bench, report, 1e-3, 1e3, 1e-7 * 1e3 * 1e-3, 2);
  farSphere(bench, report, 1e-6, 1e-2, 1e-7 * 1e-2, 2);
}

// --- 3 ---

void tangentRays(const Bench& bench, Report& report) {
  const Sphere sphere{{0, 0, -10}, 1};
  bench.kernels.setScene(sphereScene({sphere}));
  // Along the axis every impact parameter 1 +- 2^-k is a float.
  std::vector<Query> queries;
  for (const double side : {-1.0, 1.0})
    for (int k = 8; k <= 24; ++k) queries.push_back({TestRay{vec3(1 + side * std::ldexp(1, -k), 0, 0), {0, 0, -1}}});
  const std::vector<Found> found = bench.kernels.trace(queries);
  const std::vector<Found> foundNaively = bench.kernels.trace(queries, Tracer::naive);
  const auto wrong = [&](const std::vector<Found>& results) {
    size_t count = 0;
    for (size_t i = 0; i < queries.size(); ++i) {
      const int k = 8 + int(i % 17);
      const bool inside = i < 17;
      count += std::isnan(results[i].t) || (k <= 20 && results[i].hits() != inside);
      // Monotone: what passes farther out is not hit if what passes nearer by is not.
      count += i % 17 > 0 && (inside ? results[i].hits() && !results[i - 1].hits() && k <= 24
                                     : !results[i].hits() && results[i - 1].hits());
    }
    return double(count);
  };
  report.atMost("wrong or non-monotone decisions, impact 1 +- 2^-8 ... 2^-24 along an axis", wrong(found), 0,
                wrong(foundNaively));

  Random random = bench.random(3);
  Errors turner, naive;
  const auto tangent = [](Random& numbers) {
    const dvec3 axis = randomDirection(numbers);
    dvec3 a, b;
    basisOf(axis, a, b);
    const double impact = 1 + (numbers() % 2 ? 1 : -1) * std::ldexp(1.0, -8 - int(numbers() % 13));
    return TestRay{vec3(dvec3(0, 0, -10) + impact * a - 10.0 * axis), vec3(axis)};
  };
  measureSphere(bench, sphere, bench.effort.rays(1e6), random, tangent, std::ldexp(1, -20), turner, naive);
  report.atMost("wrong decisions, impact 1 +- 2^-8 ... 2^-20 in all directions",
                double(turner.misclassified + turner.notNumbers), 0, double(naive.misclassified + naive.notNumbers));
}

// --- 4 and 5 ---

// The eye stands h over a sphere; rays go from straight down to the horizon and beyond, as many near the horizon as
// near by.
void measureGround(const Bench& bench, double radius, double height, const dvec3& up, int number, Errors& turner,
                   Errors& naive) {
  Random random = bench.random(number);
  const Sphere sphere{-(radius + height) * up, radius};
  dvec3 a, b;
  basisOf(up, a, b);
  // The horizon is this much below the level, an angle.
  const double dip = std::acos(radius / (radius + height));
  const auto ray = [&](Random& numbers) {
    const double kind = uniform(numbers, 0, 1);
    const double below = kind < 0.4   ? uniform(numbers, 0, M_PI / 2)
                         : kind < 0.8 ? dip * std::exp(uniform(numbers, 0, std::log(M_PI / 2 / dip)))
                                      : dip * uniform(numbers, 0.9, 1.1);
    const double phi = uniform(numbers, 0, 2 * M_PI);
    return TestRay{vec3(0), vec3(std::cos(below) * (std::cos(phi) * a + std::sin(phi) * b) - std::sin(below) * up)};
  };
  measureSphere(bench, sphere, bench.effort.rays(1e6), random, ray, 0, turner, naive);
}

void groundSphere(const Bench& bench, Report& report, double radius, double height, double p99Bar, double maxBar,
                  int number) {
  Errors turner, naive;
  // Upright, and tilted so that all three coordinates of the centre are large and rounded.
  for (const dvec3& up : {dvec3(0, 1, 0), glm::normalize(dvec3(0.3, 0.8, -0.5))})
    measureGround(bench, radius, height, up, number, turner, naive);
  reportSphere(report, fmt::format("r = {:g}, eye {:g} above it", radius, height), turner, naive, p99Bar, maxBar);
}

void groundFromAMetre(const Bench& bench, Report& report) {
  groundSphere(bench, report, 1e6, 1, 5e-7, 4e-6, 4);
}

void groundFromAHair(const Bench& bench, Report& report) {
  groundSphere(bench, report, 1e6, 1e-2, 5e-7, 4e-6, 5);
  groundSphere(bench, report, 1e6, 1e-4, 5e-7, 4e-6, 5);
  groundSphere(bench, report, 1e3, 1e-4, 5e-7, 4e-6, 5);
}

// --- 6 ---

// Whether light that comes nearly level is stopped by a bump on the unit sphere: shadow rays from around the bump.
void bumpShadows(const Bench& bench, Report& report, double height) {
  const double bump = 1e-5;
  const dvec3 bumpAt = glm::normalize(dvec3(3e-4, 1, -4e-4));
  const Sphere unit{{0, -(1 + height), 0}, 1}, ball{unit.center + bumpAt, bump};
  const dvec3 light = unit.center + dvec3(20, 4, 0);
  bench.kernels.setScene(sphereScene({unit, ball}));
  Random random = bench.random(60);
  std::vector<Query> queries;
  std::vector<bool> shadowed;
  for (size_t i = 0; i < bench.effort.rays(1e6, 1e5); ++i) {
    // A place on the unit sphere around the shadow, away from the bump's own foot.
    const dvec3 place = glm::normalize(bumpAt + dvec3(uniform(random, -6, 0) * bump, 0, uniform(random, -2, 2) * bump));
    const dvec3 x = unit.center + place, L = glm::normalize(light - x), toBall = ball.center - x;
    const double along = glm::dot(toBall, L), past = glm::length(toBall - along * L) - bump;
    // Undecided by a tenth of the bump: the surface's own point is rounded.
    if (std::abs(past) < 0.1 * bump || glm::length(toBall) < 1.5 * bump) continue;
    queries.push_back({{vec3(0), vec3(glm::normalize(x))}, 0, Next::light, vec3(light)});
    shadowed.push_back(past < 0 && along > 0);
  }
  const auto wrong = [&](Tracer tracer) {
    const std::vector<Found> seen = bench.kernels.trace(queries, tracer);
    std::vector<Query> shadows;
    std::vector<size_t> places;
    for (size_t i = 0; i < seen.size(); ++i) {
      if (seen[i].id != 0 || !seen[i].leaves) continue;
      shadows.push_back({seen[i].leaving, 1});
      places.push_back(i);
    }
    const std::vector<Found> found = bench.kernels.trace(shadows, tracer);
    size_t count = seen.size() - places.size();
    // The eye may see the bump instead of the place behind it.
    for (const Found& first : seen) count -= first.id == 1;
    for (size_t i = 0; i < found.size(); ++i) count += found[i].hits() != shadowed[places[i]];
    return double(count) / double(seen.size());
  };
  report.atMost(fmt::format("share of wrong shadows around a bump of 1e-5, eye at {:g}", height), wrong(Tracer::turner),
                0, wrong(Tracer::naive));
}

void closeToTheUnitSphere(const Bench& bench, Report& report) {
  groundSphere(bench, report, 1, 1e-4, 0, 4e-6, 6);
  groundSphere(bench, report, 1, 1e-6, 0, 4e-6, 6);
  bumpShadows(bench, report, 1e-4);
}

// --- 7 ---

void eyeAtTheCentre(const Bench& bench, Report& report) {
  for (const double radius : {1.0, 1e3}) {
    Random random = bench.random(7);
    bench.kernels.setScene(sphereScene({{{0, 0, 0}, radius}}));
    std::vector<Query> queries;
    for (size_t i = 0; i < bench.effort.rays(1e6); ++i) queries.push_back({{vec3(0), vec3(randomDirection(random))}});
    const auto worst = [&](Tracer tracer) {
      double ulps = 0;
      const std::vector<Found> found = bench.kernels.trace(queries, tracer);
      for (size_t i = 0; i < found.size(); ++i) {
        // The direction is a unit vector but for its rounding.
        const Wide3 d = wide(queries[i].ray.direction);
        const double t = double(radius / squareRoot(dot(d, d)));
        const double error = std::abs(found[i].t - t) / (std::nextafterf(float(radius), INFINITY) - radius);
        ulps = error <= ulps ? ulps : std::isnan(error) ? INFINITY : error;
      }
      return ulps;
    };
    report.atMost(fmt::format("|t - r| in ulps, r = {:g}", radius), worst(Tracer::turner), 2, worst(Tracer::naive));
  }
}

// --- 8 ---

void kissingSpheres(const Bench& bench, Report& report) {
  // The spheres touch at (0, 0, -20); the rays fall along -y.
  const std::vector<Sphere> spheres = {{{-1, 0, -20}, 1}, {{1, 0, -20}, 1}};
  bench.kernels.setScene(sphereScene(spheres));
  std::vector<Query> queries;
  std::vector<uint32_t> owners;
  for (const double z : {-20.0, -20 + 1e-3, -20 - 1e-3}) {
    for (int k = 0; k <= 20; ++k)
      for (const double side : {-1.0, 1.0}) {
        const double x = side * std::ldexp(1, -k);
        // Off the middle there is a gap between the spheres.
        const double dz = double(float(z)) + 20;
        const bool inGap = (1 - std::abs(x)) * (1 - std::abs(x)) + dz * dz > 1;
        queries.push_back({{vec3(float(x), 10, float(z)), vec3(0, -1, 0)}});
        owners.push_back(inGap ? kNothing : side < 0 ? 0 : 1);
      }
  }
  const auto wrong = [&](Tracer tracer) {
    size_t count = 0;
    const std::vector<Found> found = bench.kernels.trace(queries, tracer);
    for (size_t i = 0; i < found.size(); ++i) count += found[i].id != owners[i] || std::isnan(found[i].t);
    return double(count);
  };
  report.atMost("wrong owners beside the contact, |x| = 1 ... 2^-20", wrong(Tracer::turner), 0, wrong(Tracer::naive));

  // Light through the contact: from below up to a light above it, every line that passes inside a sphere by 2^-20 is
  // blocked.
  Random random = bench.random(8);
  const dvec3 light(0, 5, -20);
  std::vector<Query> shadows;
  while (shadows.size() < bench.effort.rays(1e6)) {
    const double x = (random() % 2 ? 1 : -1) * std::exp2(uniform(random, -24, 0));
    const TestRay ray{vec3(float(x), -3, float(-20 + uniform(random, -1, 1) * 1e-3)), {}};
    const TestRay toLight{ray.origin, vec3(light) - ray.origin};
    double clearance = INFINITY;
    for (const Sphere& sphere : spheres) clearance = std::min(clearance, truthOf(sphere, toLight).clearance);
    if (clearance < -std::ldexp(1, -20)) shadows.push_back({toLight, 1});
  }
  const auto bright = [&](Tracer tracer) {
    size_t count = 0;
    for (const Found& found : bench.kernels.trace(shadows, tracer)) count += !found.hits();
    return double(count);
  };
  report.atMost("bright rays in the shadow of the contact", bright(Tracer::turner), 0, bright(Tracer::naive));
}

// --- 9 ---

void scaleMix(const Bench& bench, Report& report) {
  // The eye stands 1.5 above a planet; a unit ball and a pearl lie on it.
  const Sphere planet{{0, -1e6 - 1.5, 0}, 1e6};
  const auto onPlanet = [&](double angle, double distance, double radius) {
    const dvec3 up = glm::normalize(dvec3(std::cos(angle) * distance, 1e6, std::sin(angle) * distance));
    return Sphere{planet.center + (1e6 + radius) * up, radius};
  };
  std::vector<Sphere> spheres = {planet, onPlanet(-1.57, 4, 1), onPlanet(-1.3, 1.2, 1e-3)};
  const dvec3 light(40, 60, 30);
  bench.kernels.setScene(sphereScene(spheres));
  // The oracle's planet is exact; the others are where the kernel has them.
  for (size_t i = 1; i < spheres.size(); ++i) spheres[i] = bench.kernels.local().spheres[i];
  bench.kernels.setLeastDistance(1e-4f);
  Random random = bench.random(9);
  size_t turner = 0, naive = 0;
  Bench::inBatches(bench.effort.rays(3e6, 3e5), [&](size_t count) {
    std::vector<Query> queries;
    for (size_t i = 0; i < count; ++i) {
      const Sphere& aim = spheres[i % 3];
      dvec3 target = aim.center + aim.radius * randomDirection(random);
      if (i % 3 == 0) target = dvec3(uniform(random, -30, 30), -1.5, uniform(random, -30, 30));
      queries.push_back({{vec3(0), vec3(glm::normalize(target))}, 0, Next::light, vec3(light)});
    }
    for (const Tracer tracer : {Tracer::turner, Tracer::naive}) {
      std::vector<Query> shadows;
      std::vector<bool> lit;
      const std::vector<Found> seen = bench.kernels.trace(queries, tracer);
      for (size_t i = 0; i < count; ++i) {
        // What the exact scene has there: the nearest sphere, and whether the light reaches the point.
        Wide nearest = 1e30;
        const Sphere* hit = nullptr;
        for (const Sphere& sphere : spheres) {
          const Truth truth = truthOf(sphere, queries[i].ray);
          if (truth.hits && truth.t < nearest) nearest = truth.t, hit = &sphere;
        }
        if (!hit || !seen[i].hits() || seen[i].id != uint32_t(hit - spheres.data())) continue;
        const Wide3 d = wide(queries[i].ray.direction);
        const dvec3 x(double(nearest * d.x), double(nearest * d.y), double(nearest * d.z));
        const dvec3 N = glm::normalize(x - hit->center), L = glm::normalize(light - x);
        if (glm::dot(N, L) < 1e-5) continue;
        bool certain = true, blocked = false;
        for (const Sphere& sphere : spheres) {
          if (&sphere == hit) continue;
          const double along = glm::dot(sphere.center - x, L);
          const double past = glm::length(sphere.center - x - along * L) - sphere.radius;
          const double gap = glm::length(sphere.center - x) - sphere.radius;
          certain = certain && std::abs(past) > 1e-6 * std::max(1.0, sphere.radius) && gap > 1e-6;
          blocked = blocked || (along > 0 && past < 0);
        }
        if (!certain) continue;
        if (!seen[i].leaves) {
          (tracer == Tracer::turner ? turner : naive) += 1;
          continue;
        }
        shadows.push_back({seen[i].leaving, 1});
        lit.push_back(!blocked);
      }
      const std::vector<Found> found = bench.kernels.trace(shadows, tracer);
      for (size_t i = 0; i < found.size(); ++i)
        (tracer == Tracer::turner ? turner : naive) += found[i].hits() == lit[i];
    }
  });
  report.atMost("wrong shadows on spheres of radius 1e-3, 1 and 1e6", double(turner), 0, double(naive));
}

}  // namespace

std::vector<Case> sphereCases() {
  return {{1, "Far sphere", farSphere},
          {2, "Tiny far sphere", tinyFarSphere},
          {3, "Tangent rays", tangentRays},
          {4, "Ground sphere from a height of 1", groundFromAMetre},
          {5, "Ground sphere from a hair above it", groundFromAHair},
          {6, "Eye close to the unit sphere", closeToTheUnitSphere},
          {7, "Eye at the centre", eyeAtTheCentre},
          {8, "Kissing spheres", kissingSpheres},
          {9, "Spheres of all sizes", scaleMix}};
}

}  // namespace turner::hard
