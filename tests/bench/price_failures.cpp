// Every measurement has its own numbers, the same for every kernel.
#include "bench/price_failures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

#include "geometry/round_scene.h"
#include "hard/cases.h"
#include "hard/icosphere.h"
#include "hard/vectors.h"

namespace turner::test {
namespace {

using glm::dvec3, glm::vec3;
using hard::anywhereAcross, hard::basisOf, hard::randomDirection, hard::uniform;
using hard::Bench, hard::Found, hard::Kernels, hard::Query, hard::Random, hard::TestRay;

// An eye in the origin and a target at a distance of 1: the kernel's frame is the scene's.
Scene emptyScene() {
  Scene scene;
  scene.camera = {.eye = {0, 0, 0}, .target = {0, 0, -1}};
  scene.materials = {Material{.diffuse = {1, 1, 1}}};
  return scene;
}

// A direction at an angle to n whose cosine is this.
dvec3 atCosine(const dvec3& n, double cosine, Random& random) {
  return cosine * n + std::sqrt(1 - cosine * cosine) * anywhereAcross(n, random);
}

dvec3 normalOf(const TriangleCorners& corners) {
  const auto& [a, b, c] = corners;
  return glm::normalize(glm::cross(b - a, c - a));
}

// Triangles of all directions in a cube of side 2, and two tiny ones far away that make room for origins: the boxes'
// padding is for origins within the scene's extent.
Scene soup(Random& random) {
  Scene scene = emptyScene();
  const auto anywhere = [&](double size) {
    return size * dvec3(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
  };
  for (int i = 0; i < 100; ++i) {
    const dvec3 at = anywhere(1);
    scene.addTriangle({at, at + anywhere(0.3), at + anywhere(0.3)});
  }
  for (const double far : {-1e5, 1e5}) {
    const dvec3 corner(far, far, far);
    scene.addTriangle({corner, corner + dvec3(1, 0, 0), corner + dvec3(0, 1, 0)});
  }
  return scene;
}

// A tree that every ray walks to its end.
Bvh treeOfEverything(std::span<const Box> boxes, const KindStarts& kinds, const BvhLimits& limits) {
  return buildMedianBvh(std::vector<Box>(boxes.size(), {vec3(-1e6f), vec3(1e6f)}), kinds, limits);
}

void setScene(const Trial& trial, const Scene& scene) {
  if (!trial.exactBoxes) return trial.kernels.setScene(scene);
  const std::vector<Box> boxes = exactBoxes(prepareGeometry(roundScene(scene)));
  trial.kernels.setScene(scene, [&](std::span<const Box>, const KindStarts& kinds, const BvhLimits& limits) {
    return buildBvh(boxes, kinds, limits);
  });
}

// The share of rays at a sphere that a kernel decides wrongly.
template <class MakeRay>
double wrongDecisions(const Trial& trial, const Sphere& sphere, const MakeRay& makeRay) {
  Scene scene = emptyScene();
  scene.spheres = {sphere};
  trial.kernels.setScene(scene);
  // 113 bits: a ray from the origin meets a sphere that it is outside of.
  const hard::Wide3 center = hard::wide(sphere.center);
  const hard::Wide power = hard::dot(center, center) - hard::Wide(sphere.radius) * sphere.radius;
  size_t wrong = 0;
  Bench::inBatches(trial.rays, [&](size_t count) {
    std::vector<Query> queries;
    for (size_t i = 0; i < count; ++i) queries.push_back({{vec3(0), vec3(makeRay())}});
    const std::vector<Found> found = trial.kernels.trace(queries);
    for (size_t i = 0; i < count; ++i) {
      const hard::Wide3 d = hard::wide(dvec3(queries[i].ray.direction));
      const hard::Wide b = hard::dot(center, d);
      wrong += found[i].hits() != (b > 0 && b * b >= hard::dot(d, d) * power);
    }
  });
  return double(wrong) / double(trial.rays);
}

// Rays that leave a surface outward, where nothing is, or into a unit sphere: how many meet it where they start.
template <class MakeRay>
size_t selfHits(const Trial& trial, const Scene& scene, bool inward, const MakeRay& makeRay) {
  trial.kernels.setScene(scene);
  Random random(40);
  size_t hits = 0;
  Bench::inBatches(trial.rays, [&](size_t count) {
    std::vector<Query> queries;
    for (size_t i = 0; i < count; ++i) queries.push_back({makeRay(trial.kernels.local(), random)});
    const std::vector<Found> seen = trial.kernels.trace(queries);
    std::vector<Query> ahead;
    std::vector<double> limits;  // a hit nearer than this is false
    for (size_t i = 0; i < count; ++i) {
      if (!seen[i].hits()) continue;
      const double cosine = std::pow(10, uniform(random, -3, 0));
      const dvec3 away = inward ? -seen[i].Ng : seen[i].Ng;
      ahead.push_back({queries[i].ray, 0, hard::Next::direction, vec3(atCosine(away, cosine, random))});
      limits.push_back(inward ? cosine : INFINITY);  // half the way through the unit sphere
    }
    std::vector<Query> leaving;
    for (const Found& found : trial.kernels.trace(ahead)) leaving.push_back({found.leaving});
    const std::vector<Found> again = trial.kernels.trace(leaving);
    for (size_t i = 0; i < again.size(); ++i) hits += again[i].hits() && again[i].t < limits[i];
  });
  return hits;
}

// A floor of 32 x 32 squares, each two triangles.
Scene tiltedFloor() {
  Scene scene = emptyScene();
  const dvec3 n = glm::normalize(dvec3(0.3, 1, 0.2));
  dvec3 a, b;
  basisOf(n, a, b);
  const auto corner = [&](int i, int j) {
    return dvec3(0.4, -1.5, -3) + (4 * (i / 32.0 - 0.5)) * a + (4 * (j / 32.0 - 0.5)) * b;
  };
  for (int i = 0; i < 32; ++i)
    for (int j = 0; j < 32; ++j) {
      scene.addTriangle({corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)});
      scene.addTriangle({corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)});
    }
  return scene;
}

// A ray that comes from outside to a triangle of a mesh.
TestRay rayAtTriangle(const Scene& local, Random& random) {
  const TriangleCorners triangle = local.cornersOf(random() % local.triangles.size());
  const dvec3 aim = hard::aimAt(triangle, int(random() % 3), random),
              from = atCosine(normalOf(triangle), uniform(random, 0.2, 1), random);
  return {vec3(aim + from), vec3(-from)};
}

TestRay rayAtSphere(const Scene& local, Random& random) {
  const Sphere& sphere = local.spheres[0];
  const dvec3 n = randomDirection(random), from = atCosine(n, uniform(random, 0.2, 1), random);
  return {vec3(sphere.center + sphere.radius * n + from), vec3(-from)};
}

// From the eye down.
TestRay rayAtGround(const Scene&, Random& random) {
  return {vec3(0), vec3(atCosine({0, -1, 0}, uniform(random, 0.05, 1), random))};
}

}  // namespace

std::vector<Box> exactBoxes(const PreparedGeometry& prepared) {
  std::vector<Box> boxes;
  for (const Sphere& sphere : prepared.scene.spheres) {
    const double radius = std::abs(sphere.radius);
    boxes.push_back({vec3(sphere.center - radius), vec3(sphere.center + radius)});
  }
  for (const TrianglePair& pair : prepared.pairs) {
    Box box{vec3(INFINITY), vec3(-INFINITY)};
    const auto add = [&](uint32_t triangle) {
      for (const dvec3& vertex : prepared.scene.cornersOf(triangle)) {
        box.lo = glm::min(box.lo, vec3(vertex));
        box.hi = glm::max(box.hi, vec3(vertex));
      }
    };
    add(pair.first);
    if (!pair.isAlone()) add(pair.second);
    boxes.push_back(box);
  }
  return boxes;
}

std::vector<Failures> leaksOfIcosphere(const Trial& trial) {
  const Scene scene = hard::icosphere(5, 1, {0, 0, 0});
  trial.kernels.setScene(scene);
  Random random(11);
  size_t misses = 0;
  Bench::inBatches(trial.rays, [&](size_t count) {
    std::vector<Query> queries;
    for (size_t i = 0; i < count; ++i)
      queries.push_back(hard::aimedRay(trial.kernels.local(), random, glm::dvec3(0), 1).query);
    for (const Found& found : trial.kernels.trace(queries)) misses += !found.hits();
  });
  return {{fmt::format("of {:.2g} rays from inside an icosphere of {} triangles get out", double(trial.rays),
                       scene.triangles.size()),
           double(misses)}};
}

std::vector<Failures> missesOfSoup(const Trial& trial) {
  Random random(20);
  const Scene scene = soup(random);
  size_t misses = 0;
  Bench::inBatches(trial.rays, [&](size_t count) {
    trial.robust.setScene(scene, treeOfEverything);
    const Scene& local = trial.robust.local();
    std::vector<Query> queries;
    for (size_t i = 0; i < count; ++i) {
      const dvec3 aim = local.cornersOf(random() % (local.triangles.size() - 2))[random() % 3];
      const vec3 origin(std::pow(10, uniform(random, 1, 5)) * randomDirection(random));
      queries.push_back({{origin, vec3(glm::normalize(aim - dvec3(origin)))}});
    }
    const std::vector<Found> all = trial.robust.trace(queries);
    setScene(trial, scene);
    const std::vector<Found> found = trial.kernels.trace(queries);
    for (size_t i = 0; i < count; ++i) misses += found[i].id != all[i].id;
  });
  return {{fmt::format("of {:.2g} rays at vertices, from 10 to 1e5 away, miss what the list of all finds",
                       double(trial.rays)),
           double(misses)}};
}

std::vector<Failures> wrongHorizon(const Trial& trial) {
  const double radius = 1e6, height = 1.5, dip = std::acos(radius / (radius + height));
  const dvec3 up = glm::normalize(dvec3(0.3, 0.8, -0.5));
  Random random(4);
  const double share = wrongDecisions(trial, {-(radius + height) * up, radius},
                                      [&] { return atCosine(up, -std::sin(dip * uniform(random, 0.9, 1.1)), random); });
  return {{"share of wrong decisions within a tenth of the horizon's dip, 1.5 above a ball of radius 1e6", share}};
}

std::vector<Failures> wrongSilhouette(const Trial& trial) {
  // A center that float has: what the kernel makes of it is measured, not its rounding.
  const Sphere sphere{dvec3(vec3(1e5 * glm::normalize(dvec3(0.4, -0.3, -1)))), 1};
  Random random(1);
  const double share = wrongDecisions(trial, sphere, [&] {
    const dvec3 across = anywhereAcross(glm::normalize(sphere.center), random);
    return glm::normalize(sphere.center + uniform(random, 0.9, 1.1) * across);
  });
  return {{"share of wrong decisions within a tenth of the radius of the silhouette, 1e5 radii away", share}};
}

std::vector<Failures> falseSelfHits(const Trial& trial) {
  const dvec3 middle(0.3, -0.4, -5);
  const auto withSphere = [](const Sphere& sphere) {
    Scene scene = emptyScene();
    scene.spheres = {sphere};
    return scene;
  };
  const Scene ball = withSphere({middle, 1}), ground = withSphere({dvec3(0, -1e6 - 1.5, 0), 1e6});
  const auto of = [&](const char* where, const Scene& scene, bool inward, const auto& makeRay) {
    return Failures{fmt::format("of {:.2g} rays {} meet it where they start", double(trial.rays), where),
                    double(selfHits(trial, scene, inward, makeRay))};
  };
  return {of("from a floor of 2048 triangles", tiltedFloor(), false, rayAtTriangle),
          of("from an icosphere of 5120 triangles", hard::icosphere(4, 1, middle), false, rayAtTriangle),
          of("from a sphere", ball, false, rayAtSphere), of("into a sphere", ball, true, rayAtSphere),
          of("from a ball of radius 1e6", ground, false, rayAtGround)};
}

std::vector<Failures> wrongRefraction(const Trial& trial) {
  // A pane whose normal float has exactly: the errors are those of Snell's law.
  const double eta = 1.5, critical = std::asin(1 / eta);
  Scene scene = emptyScene();
  scene.materials = {Material{.transmit = 1, .eta = eta}};
  scene.addTriangle({dvec3(-8, -8, -2), dvec3(8, -8, -2), dvec3(0, 12, -2)});
  trial.kernels.setScene(scene);
  Random random(29);
  size_t wrong = 0;
  double worst = 0;
  Bench::inBatches(trial.rays, [&](size_t count) {
    std::vector<Query> queries;
    for (size_t i = 0; i < count; ++i) {
      const double off = std::pow(10, uniform(random, -6, -1)) * (random() % 2 ? 1 : -1);
      const dvec3 d = atCosine({0, 0, 1}, std::cos(critical + off), random);
      queries.push_back({{vec3(dvec3(0, 0, -2) - 0.5 * d), vec3(d)}, 0, hard::Next::transmitted});
    }
    const std::vector<Found> found = trial.kernels.trace(queries);
    for (size_t i = 0; i < count; ++i) {
      const dvec3 d(queries[i].ray.direction), T(found[i].leaving.direction);
      const double sine2 = (d.x * d.x + d.y * d.y) / glm::dot(d, d), cosine2 = 1 - eta * eta * sine2;
      if (std::abs(std::asin(std::sqrt(sine2)) - critical) < 1e-6) continue;
      wrong += !found[i].hits() || found[i].leaves != (cosine2 > 0);
      if (!found[i].leaves || cosine2 <= 0) continue;
      const double error = std::abs(T.z / glm::length(T) - std::sqrt(cosine2));
      worst = error <= worst ? worst : std::isnan(error) ? INFINITY : error;
    }
  });
  return {{fmt::format("of {:.2g} rays 1e-6 to 0.1 rad from the critical angle go the wrong way", double(trial.rays)),
           double(wrong)},
          {"largest error of cos θt of those", worst}};
}

std::vector<Failures> wrongInNestedGlass(const Trial& trial) {
  // A ball of water in one of glass. By b = n r sin(angle), the same in both, the ray turns by the differences of its
  // angles (Bouguer).
  const double glass = 1.5, water = 1.25, inner = 0.5;
  const dvec3 middle(0, 0, -4);
  Scene scene = emptyScene();
  scene.materials = {Material{.transmit = 1, .eta = glass}, Material{.transmit = 1, .eta = water}};
  scene.spheres = {{middle, 1, 0}, {middle, inner, 1}};
  trial.kernels.setScene(scene);
  Random random(35);
  size_t wrong = 0;
  Bench::inBatches(trial.rays, [&](size_t count) {
    std::vector<TestRay> rays;
    for (size_t i = 0; i < count; ++i) {
      const dvec3 d = atCosine({0, 0, 1}, std::cos(uniform(random, 0.01, 0.1)), random);
      rays.push_back({vec3(0), vec3(-d)});
    }
    const std::vector<TestRay> first = rays;
    for (int wall = 0; wall < 4; ++wall) {
      std::vector<Query> queries;
      for (const TestRay& ray : rays) queries.push_back({ray, 0, hard::Next::transmitted});
      const std::vector<Found> found = trial.kernels.trace(queries);
      for (size_t i = 0; i < count; ++i) rays[i] = found[i].leaving;
    }
    for (size_t i = 0; i < count; ++i) {
      const dvec3 d = glm::normalize(dvec3(first[i].direction)), T = glm::normalize(dvec3(rays[i].direction));
      const double b = glm::length(glm::cross(middle, d));
      const double turn =
          2 * (std::asin(b) - std::asin(b / glass) + std::asin(b / (glass * inner)) - std::asin(b / (water * inner)));
      const double turned = std::atan2(glm::length(glm::cross(d, T)), glm::dot(d, T));
      wrong += !(std::abs(turned - std::abs(turn)) <= 1e-5);
    }
  });
  return {{fmt::format("of {:.2g} rays through water in glass leave it in a direction that is 1e-5 or more off",
                       double(trial.rays)),
           double(wrong)}};
}

}  // namespace turner::test
