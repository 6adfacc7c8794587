// Triangles: no ray slips between two, distances are those of the plane, and what has no area is not there.
#include <fmt/format.h>

#include <array>
#include <glm/geometric.hpp>
#include <map>

#include "hard/cases.h"
#include "hard/icosphere.h"
#include "hard/vectors.h"

namespace turner::hard {
namespace {

// A ray from inside a closed mesh, aimed at a vertex, an edge or anywhere.
struct Aimed {
  Query query;
  size_t triangle;  // that has the aim
};

Aimed aimedRay(const Scene& local, Random& random, double radius) {
  Aimed aimed;
  aimed.triangle = random() % local.triangles.size();
  const auto& v = local.triangles[aimed.triangle].vertices;
  const size_t corner = random() % 3;
  dvec3 target = v[corner];
  const int kind = int(random() % 3);
  if (kind == 1) target += uniform(random, 0, 1) * (v[(corner + 1) % 3] - v[corner]);
  if (kind == 2) {
    const double s = std::sqrt(uniform(random, 0, 1)), u = uniform(random, 0, 1);
    target = (1 - s) * v[0] + s * (1 - u) * v[1] + s * u * v[2];
  }
  aimed.query.ray.origin = vec3(uniform(random, 0, 0.7) * radius * randomDirection(random));
  aimed.query.ray.direction = vec3(glm::normalize(target - dvec3(aimed.query.ray.origin)));
  return aimed;
}

struct Misses {
  size_t rays = 0, turner = 0, naive = 0;
};

Misses countMisses(const Bench& bench, const Scene& scene, double localRadius, size_t rays, Random& random) {
  bench.kernels.setScene(scene);
  Misses misses{rays};
  Bench::inBatches(rays, [&](size_t count) {
    std::vector<Query> queries;
    for (size_t i = 0; i < count; ++i) queries.push_back(aimedRay(bench.kernels.local(), random, localRadius).query);
    for (const Found& found : bench.kernels.trace(queries)) misses.turner += !found.hits();
    for (const Found& found : bench.kernels.trace(queries, Tracer::naive)) misses.naive += !found.hits();
  });
  return misses;
}

void watertightIcosphere(const Bench& bench, Report& report) {
  Random random = bench.random(11);
  for (const int levels : {3, 5, bench.effort.full ? 8 : 6}) {
    const Scene scene = icosphere(levels, 1, {0, 0, 0});
    const Misses misses = countMisses(bench, scene, 1, bench.effort.rays(1e7, 3e5), random);
    report.atMost(fmt::format("misses of {:.2g} aimed rays, {} triangles", double(misses.rays), scene.triangles.size()),
                  double(misses.turner), 0, double(misses.naive));
  }
}

}  // namespace

std::vector<Case> triangleCases() {
  return {{11, "Watertight icosphere", watertightIcosphere}};
}

}  // namespace turner::hard
