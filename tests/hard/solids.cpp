// Solids of glass in one another: whose walls a ray sees, and where it goes. The smaller of two is seen where they
// overlap; walls inside other glass are hidden, and walls in one place act as one.
#include "geometry/nested_dielectrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>

#include "geometry/round_scene.h"
#include "hard/cases.h"
#include "hard/chain.h"
#include "hard/glass.h"
#include "hard/pictures.h"
#include "support/closed_form.h"

namespace turner::hard {
namespace {

using closed_form::addMaterial, closed_form::kDegree;

constexpr double kWater = 1.25;  // float32 has it exactly

uint32_t addGlass(Scene& scene, double eta) {
  return addMaterial(scene, closed_form::glass(0, 1, eta));
}

// Follows all rays to their end, or for so many walls.
std::vector<Journey> followed(Kernels& kernels, const std::vector<TestRay>& rays, int walls, Tracer tracer) {
  std::vector<Journey> journeys = journeysOf(rays);
  for (int step = 0; step < walls; ++step) advance(kernels, journeys, tracer);
  return journeys;
}

// ---- Concentric balls ----

struct Shell {
  double radius, eta;  // of what is inside it, up to the next shell
};

// On a ray b = n r sin(angle) is the same in all shells (Bouguer), and every surface turns it by the difference of its
// angles: once on the way in and once on the way out.
double deviationThrough(const std::vector<Shell>& shells, double b) {
  double deviation = 0, before = 1;
  for (const auto& [radius, eta] : shells) {
    deviation += 2 * (std::asin(b / (before * radius)) - std::asin(b / (eta * radius)));
    before = eta;
  }
  return deviation;
}

Scene concentric(const std::vector<Shell>& balls) {
  Scene scene = sceneSeenFrom({1.25, 0.75, 2.5}, kIor);
  for (const auto& [radius, eta] : balls) scene.spheres.push_back({{0, 0, 0}, radius, addGlass(scene, eta)});
  return scene;
}

// Rays through `balls`, as the file lists them, must go as through `seen`, from the outside in.
void reportConcentric(const Bench& bench, Random& random, const std::string& what, const std::vector<Shell>& balls,
                      const std::vector<Shell>& seen, double mostImpact, Report& report) {
  bench.kernels.setScene(concentric(balls));
  const dvec3 center = bench.kernels.local().spheres[0].center;
  const int walls = 2 * int(balls.size());
  Both<Worst> error;
  Both<size_t> otherPath;
  const size_t total = bench.effort.rays(1e6, 2e4);
  Bench::inBatches(total, [&](size_t count) {
    std::vector<TestRay> rays;
    for (size_t i = 0; i < count; ++i) rays.push_back(rayPast(center, uniform(random, 0.01, mostImpact), random));
    for (const Tracer tracer : kTracers) {
      const std::vector<Journey> journeys = followed(bench.kernels, rays, walls + 1, tracer);
      for (size_t i = 0; i < count; ++i) {
        const Journey& journey = journeys[i];
        otherPath.of(tracer) += !journey.ended || journey.transmitted != 2 * int(seen.size()) || journey.reflected > 0;
        const double b = impact(rays[i], {.center = center, .radius = 1});
        error.of(tracer).add(
            angleBetween(dvec3(journey.ray.direction), directionBehind(rays[i], center, deviationThrough(seen, b))));
      }
    }
  });
  report.atMost(fmt::format("{}: rays of {:.2g} on another path", what, double(total)), double(otherPath.turner), 0,
                double(otherPath.naive));
  report.atMost(what + ": error of the deviation, rad", error.turner.value, 1e-5, error.naive.value);
}

void reportConcentricBalls(const Bench& bench, Random& random, Report& report) {
  const double inner = double(0.9f);
  const Shell glass{1, kIor}, water{inner, kWater}, waterOutside{1, kWater};
  reportConcentric(bench, random, "water in glass", {glass, water}, {glass, water}, 0.8, report);
  reportConcentric(bench, random, "the same, water first in the file", {water, glass}, {glass, water}, 0.8, report);
  reportConcentric(bench, random, "a bubble of index 1 in glass", {glass, {inner, 1}}, {glass, {inner, 1}}, 0.8,
                   report);
  const std::vector<Shell> shells = {{1, 1.5},      {0.875, 1.25}, {0.75, 1.75}, {0.625, 1},
                                     {0.5, 1.3125}, {0.4375, 1.5}, {0.375, 1.0}, {0.3125, 2}};
  reportConcentric(bench, random, "eight shells", shells, shells, 0.2, report);
  reportConcentric(bench, random, "glass and water of one radius", {glass, waterOutside}, {waterOutside}, 0.8, report);
  reportConcentric(bench, random, "water and glass of one radius", {waterOutside, glass}, {glass}, 0.8, report);
  reportConcentric(bench, random, "glass in the same glass", {glass, {inner, kIor}}, {glass}, 0.8, report);
}

// ---- Balls side by side ----

// A ray in double, from wall to wall.
struct WideRay {
  dvec3 origin, direction;
  void passInto(const Sphere& ball, double before, double behind) { pass(ball, before / behind, -1); }
  void passOutOf(const Sphere& ball, double before, double behind) { pass(ball, before / behind, 1); }

 private:
  void pass(const Sphere& ball, double ratio, double root) {
    direction = glm::normalize(direction);
    const dvec3 f = origin - ball.center;
    const double b = glm::dot(f, direction);
    const dvec3 foot = f - b * direction;
    const dvec3 x = foot + root * std::sqrt(ball.radius * ball.radius - glm::dot(foot, foot)) * direction;
    origin = ball.center + x;
    direction = bent(direction, glm::normalize(x), ratio);
  }
};

// A large ball and a small one that reaches into it: the small one's glass is seen in the lens that both share. Rays go
// through the lens, from either side.
void reportOverlap(const Bench& bench, Random& random, const std::string& what, double overlap, double smallIor,
                   Report& report) {
  Scene scene = sceneSeenFrom({1.25, 0.75, 2.5}, kIor);
  const double smallRadius = 0.75;
  scene.spheres.push_back({{0, 0, 0}, 1, 0});
  scene.spheres.push_back(
      {{1 + smallRadius - overlap, 0, 0}, smallRadius, smallIor == kIor ? 0 : addGlass(scene, smallIor)});
  bench.kernels.setScene(scene);
  const Sphere large = bench.kernels.local().spheres[0], small = bench.kernels.local().spheres[1];
  const double depth = large.radius + small.radius - glm::length(small.center - large.center);  // of the lens
  const double lens = 0.7 * std::sqrt(2 * depth * large.radius * small.radius / (large.radius + small.radius));
  const bool same = smallIor == kIor;
  Both<Worst> error;
  Both<size_t> otherPath;
  const size_t total = bench.effort.rays(1e6, 2e4);
  Bench::inBatches(total, [&](size_t count) {
    std::vector<TestRay> rays;
    std::vector<dvec3> expected;
    for (size_t i = 0; i < count; ++i) {
      // From a point in the middle of the lens, in the glass that is seen there, back to where the ray comes from. That
      // only aims it: the truth starts from its float32.
      const bool toSmall = i % 2 == 0;
      const double away = lens * std::sqrt(uniform(random, 0, 1)), turn = uniform(random, 0, 2 * std::numbers::pi);
      const dvec3 point =
          large.center + dvec3(large.radius - 0.5 * depth, away * std::cos(turn), away * std::sin(turn));
      const dvec3 across = anywhereAcross({1, 0, 0}, random);
      const double slope = uniform(random, 0, 0.2);
      const dvec3 d = glm::normalize(dvec3(toSmall ? 1 : -1, 0, 0) + slope * across);
      WideRay back{point, -d};
      if (!same && toSmall) back.passOutOf(small, smallIor, kIor);
      back.passOutOf(toSmall ? large : small, same || toSmall ? kIor : smallIor, 1);
      rays.push_back(rayThrough(back.origin, -back.direction, 1));
      WideRay truth{dvec3(rays.back().origin), glm::normalize(dvec3(rays.back().direction))};
      if (same && toSmall) {
        truth.passInto(large, 1, kIor);
        truth.passOutOf(small, kIor, 1);
      } else if (same) {
        truth.passInto(small, 1, kIor);
        truth.passOutOf(large, kIor, 1);
      } else if (toSmall) {
        truth.passInto(large, 1, kIor);
        truth.passInto(small, kIor, smallIor);
        truth.passOutOf(small, smallIor, 1);
      } else {
        truth.passInto(small, 1, smallIor);
        truth.passOutOf(small, smallIor, kIor);
        truth.passOutOf(large, kIor, 1);
      }
      expected.push_back(truth.direction);
    }
    for (const Tracer tracer : kTracers) {
      const std::vector<Journey> journeys = followed(bench.kernels, rays, 5, tracer);
      for (size_t i = 0; i < count; ++i) {
        otherPath.of(tracer) +=
            !journeys[i].ended || journeys[i].transmitted != (same ? 2 : 3) || journeys[i].reflected > 0;
        error.of(tracer).add(angleBetween(dvec3(journeys[i].ray.direction), expected[i]));
      }
    }
  });
  report.atMost(fmt::format("{}: rays of {:.2g} on another path", what, double(total)), double(otherPath.turner), 0,
                double(otherPath.naive));
  report.atMost(what + ": error of the direction, rad", error.turner.value, 1e-5, error.naive.value);
}

// ---- Blocks that share a face ----

struct Touching {
  double eta, otherIor;
  double gap = 0;        // between the blocks; what float32 cannot tell from nothing, or an overlap
  double innermost = 0;  // index of a third block in the other, which shares the face; 0: there is none
};

// Two blocks, tilted, one of which has a larger face where they touch: in float32 the faces are in one plane but for
// rounding. Light goes from one to the other as if there were nothing between them but the change of index. The eye is
// in the block that it comes from, so that its solids are the rays'.
void reportTouching(const Bench& bench, Random& random, const Touching& blocks, Report& report) {
  const double eta = blocks.eta, seen = blocks.innermost > 0 ? blocks.innermost : blocks.otherIor;
  Both<Worst> error;
  Both<size_t> otherPath;
  const size_t total = bench.effort.rays(1e6, 2e4);
  Bench::inBatches(total, [&](size_t count) {
    const dvec3 n = randomDirection(random), a = anywhereAcross(n, random), b = glm::cross(n, a);
    const dvec3 middle(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
    Scene scene;
    const uint32_t from = addGlass(scene, eta), to = addGlass(scene, blocks.otherIor);
    addParallelepiped(scene, middle - 0.5 * (a + b) - (1 + blocks.gap) * n, a, b, n, from);
    addParallelepiped(scene, middle - 0.6 * (a + b), 1.2 * a, 1.2 * b, n, to);
    if (blocks.innermost > 0)
      addParallelepiped(scene, middle - 0.4 * (a + b), 0.8 * a, 0.8 * b, 0.5 * n, addGlass(scene, blocks.innermost));
    scene.camera = {.eye = middle - 0.5 * n, .target = middle + 0.75 * n, .up = a};
    bench.kernels.setScene(scene);
    std::vector<TestRay> rays;
    for (size_t i = 0; i < count; ++i) {
      const double angle = uniform(random, 0, 85) * kDegree;
      const dvec3 at = 0.5 * n + uniform(random, -0.1, 0.1) * a + uniform(random, -0.1, 0.1) * b;
      rays.push_back(rayThrough(at, std::cos(angle) * n + std::sin(angle) * anywhereAcross(n, random), 0.3));
      rays.back().dielectrics = bench.kernels.mediaAroundEye();
    }
    for (const Tracer tracer : kTracers) {
      const std::vector<Journey> journeys = followed(bench.kernels, rays, 1, tracer);
      for (size_t i = 0; i < count; ++i) {
        const dvec3 d = glm::normalize(dvec3(rays[i].direction));
        const double sine = glm::length(glm::cross(d, n)) * eta / seen;
        if (std::abs(sine - 1) < 1e-2) continue;  // the critical angle is case 29's
        const bool passes = sine < 1;
        const bool hasWall = eta != seen;  // of the same glass there is none
        otherPath.of(tracer) += journeys[i].transmitted != (passes && hasWall) || journeys[i].reflected == passes;
        const dvec3 expected = passes ? bent(d, n, eta / seen) : d - 2 * glm::dot(d, n) * n;
        error.of(tracer).add(angleBetween(dvec3(journeys[i].ray.direction), expected));
      }
    }
  });
  std::string what = fmt::format("block of index {:g} on one of {:g}", eta, blocks.otherIor);
  if (blocks.gap != 0) what += fmt::format(", {:g} apart", blocks.gap);
  if (blocks.innermost > 0) what += fmt::format(" and one of {:g} in it", seen);
  report.atMost(fmt::format("{}: rays of {:.2g} on another path", what, double(total)), double(otherPath.turner), 0,
                double(otherPath.naive));
  report.atMost(what + ": error of the direction, rad", error.turner.value, 1e-5, error.naive.value);
}

// ---- An eye in both ----

void reportEyeInside(const Bench& bench, Random& random, Report& report) {
  const std::vector<Shell> shells = {{1, kIor}, {0.5, kWater}};
  Scene scene = concentric(shells);
  scene.camera = {.eye = {0.125, 0.0625, -0.125}, .target = {0.125, 0.0625, 0.875}};
  bench.kernels.setScene(scene);
  const dvec3 center = bench.kernels.local().spheres[0].center;
  Both<Worst> error;
  Both<size_t> otherPath;
  const size_t total = bench.effort.rays(1e6, 2e4);
  Bench::inBatches(total, [&](size_t count) {
    std::vector<TestRay> rays;
    for (size_t i = 0; i < count; ++i) {
      rays.push_back({.origin = vec3(0), .direction = vec3(randomDirection(random))});
      rays.back().dielectrics = bench.kernels.mediaAroundEye();
    }
    for (const Tracer tracer : kTracers) {
      const std::vector<Journey> journeys = followed(bench.kernels, rays, 3, tracer);
      for (size_t i = 0; i < count; ++i) {
        // As much as on the way out of the whole.
        const double sine = impact(rays[i], {.center = center, .radius = 1});
        const double b = kWater * sine;
        const double deviation =
            std::asin(b / (kIor * 0.5)) - std::asin(b / (kWater * 0.5)) + std::asin(b) - std::asin(b / kIor);
        otherPath.of(tracer) += !journeys[i].ended || journeys[i].transmitted != 2 || journeys[i].reflected > 0;
        error.of(tracer).add(
            angleBetween(dvec3(journeys[i].ray.direction), directionBehind(rays[i], center, deviation)));
      }
    }
  });
  report.atMost(fmt::format("eye in water in glass: rays of {:.2g} on another path", double(total)),
                double(otherPath.turner), 0, double(otherPath.naive));
  report.atMost("eye in water in glass: error of the direction, rad", error.turner.value, 1e-5, error.naive.value);
}

// ---- Pictures ----

// Glass and water of one radius are to look like water that reaches 1e-6 beyond the glass on no side, which is like
// water alone.
void reportCoincidentPicture(const Bench& bench, Report& report) {
  const int size = bench.effort.full ? 512 : 96;
  const auto picture = [&](const std::vector<Shell>& balls) {
    Scene scene = concentric(balls);
    scene.depth = 8;
    scene.camera.target = {0, 0, 0};
    scene.background = {0.25, 0.5, 1};
    closed_form::addFloor(scene, -1.25, 8, addMaterial(scene, closed_form::matte({0.75, 0.5, 0.25})));
    scene.lights = {{.position = {3, 5, 4}}};
    return test::renderShader(scene, test::settingsOf(scene, size, size));
  };
  const Image together = picture({{1, kIor}, {1, kWater}}), water = picture({{1, kWater}});
  report.atMost("glass and water of one radius: values of a picture that differ from water alone",
                double(differingValues(together, water)), 0);
}

void solidsInSolids(const Bench& bench, Report& report) {
  Random random = bench.random(35);
  bench.kernels.setLeastDistance(kUsualEpsilon);
  reportConcentricBalls(bench, random, report);
  reportOverlap(bench, random, "water overlaps glass by 1e-3", 1e-3, kWater, report);
  reportOverlap(bench, random, "water overlaps glass by 0.25", 0.25, kWater, report);
  reportOverlap(bench, random, "glass overlaps the same glass by 1e-3", 1e-3, kIor, report);
  for (const Touching& blocks : {Touching{kIor, kWater},
                                 {kWater, kIor},
                                 {kIor, kIor},
                                 {kIor, kWater, 1e-7},
                                 {kIor, kWater, 5e-7},
                                 {kIor, kWater, -5e-7},
                                 {kIor, kWater, 0, 2}})
    reportTouching(bench, random, blocks, report);
  reportEyeInside(bench, random, report);
  reportCoincidentPicture(bench, report);
}

}  // namespace

std::vector<Case> solidCases() {
  return {{35, "Solids in solids", solidsInSolids}};
}

}  // namespace turner::hard
