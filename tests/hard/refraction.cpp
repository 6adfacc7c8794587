// Glass: which rays it lets through, which it turns back, and where they go. By the sign rule a hit on the front
// enters the glass, one on the back leaves it.
#include <fmt/format.h>

#include <array>

#include "hard/cases.h"
#include "hard/chain.h"
#include "hard/glass.h"
#include "support/closed_form.h"

namespace turner::hard {
namespace {

using closed_form::addMaterial, closed_form::addQuad, closed_form::kDegree;

// ---- 29 ----

// Sheets of glass in all directions, far enough from each other.
Scene scatteredSheets(Random& random) {
  Scene scene = sceneSeenFrom({0, 0, 0}, kIor);
  for (int x = -2; x <= 2; ++x)
    for (int y = -2; y <= 2; ++y)
      for (int z = -2; z <= 2; ++z) {
        const dvec3 center = 3.0 * dvec3(x, y, z), n = randomDirection(random), a = anywhereAcross(n, random);
        const dvec3 b = glm::cross(n, a);
        scene.addTriangle({center + a, center - 0.5 * a + 0.8 * b, center - 0.5 * a - 0.8 * b});
      }
  return scene;
}

// A ray that leaves glass at about this angle, and the exact square of the sine of the angle at which it does.
struct Leaving {
  TestRay ray;
  double squaredSine;
};

Leaving leavingSheet(const Scene& local, Random& random, double angle) {
  const auto& v = local.cornersOf(random() % local.triangles.size());
  const dvec3 n = glm::normalize(glm::cross(v[1] - v[0], v[2] - v[0]));
  const dvec3 middle = (v[0] + v[1] + v[2]) / 3.0, a = anywhereAcross(n, random);
  const TestRay ray = rayThrough(middle + uniform(random, 0, 0.2) * a, std::cos(angle) * n + std::sin(angle) * a, 0.5);
  const dvec3 d(ray.direction), across = glm::cross(d, n);
  return {ray, glm::dot(across, across) / glm::dot(d, d)};
}

Leaving leavingBall(const Scene& local, Random& random, double angle) {
  const dvec3 n = randomDirection(random), a = anywhereAcross(n, random);
  const TestRay ray = rayThrough(local.spheres[0].center + n, std::cos(angle) * n + std::sin(angle) * a,
                                 uniform(random, 0.1, 1.9) * std::cos(angle));
  const double sine = impact(ray, local.spheres[0]);
  return {ray, sine * sine};
}

void sweepCriticalAngle(const Bench& bench, Report& report, const std::string& where, const Scene& scene,
                        Leaving (*leavingAt)(const Scene&, Random&, double)) {
  bench.kernels.setScene(scene);
  Random random = bench.random(29);
  const double critical = std::asin(1 / kIor);
  const size_t total = bench.effort.rays(1e6, 1e5);
  Both<size_t> wrong, notANumber;
  Both<Worst> error;
  Bench::inBatches(total, [&](size_t count) {
    std::vector<TestRay> rays;
    std::vector<double> squaredSines;
    for (size_t i = 0; i < count; ++i) {
      const double off = std::pow(10, -1 - double(i % 7)) * (random() % 2 ? 1 : -1);
      const Leaving leaving = leavingAt(bench.kernels.local(), random, critical + off);
      rays.push_back(leaving.ray);
      squaredSines.push_back(leaving.squaredSine);
    }
    for (const Tracer tracer : kTracers) {
      const std::vector<Found> found = stepFrom(bench.kernels, rays, Next::transmitted, tracer);
      for (size_t i = 0; i < count; ++i) {
        // cos^2 of Snell's angle; below 0 there is none.
        const double squaredCosine = 1 - kIor * kIor * squaredSines[i];
        const double off = std::abs(std::asin(std::sqrt(squaredSines[i])) - critical);
        wrong.of(tracer) += !found[i].hits() || (off >= 1e-6 && found[i].leaves != (squaredCosine > 0));
        notANumber.of(tracer) += !isFinite(found[i].leaving.direction);
        if (!found[i].hits() || !found[i].leaves || squaredCosine <= 0) continue;
        // Against the normal of the hit, which is on the side of the ray.
        const dvec3 T(found[i].leaving.direction), N(found[i].Ng);
        const double cosine = -glm::dot(T, N) / glm::length(T) / glm::length(N);
        error.of(tracer).add(std::abs(cosine - std::sqrt(squaredCosine)) * std::sqrt(squaredCosine));
      }
    }
  });
  report.atMost(
      fmt::format("{}: wrong decisions of {:.2g}, 1e-6 rad and more from the critical angle", where, double(total)),
      double(wrong.turner), 0, double(wrong.naive));
  report.atMost(where + ": error of cos θt, times cos θt", error.turner.value, 4e-7, error.naive.value);
  report.atMost(where + ": rays with a NaN", double(notANumber.turner), 0, double(notANumber.naive));
}

void criticalAngle(const Bench& bench, Report& report) {
  Random random = bench.random(2900);
  sweepCriticalAngle(bench, report, "sheets", scatteredSheets(random), leavingSheet);
  Scene ball = sceneSeenFrom({0.25, 0.5, -1.5}, kIor);
  ball.spheres.push_back({{0, 0, 0}, 1});
  sweepCriticalAngle(bench, report, "inside a ball", ball, leavingBall);
}

// ---- 30 ----

// A slab whose corners float32 has exactly: its faces are parallel.
struct Slab {
  std::string name;
  dvec3 normal;
  double thickness;
  dvec3 middle, edge1, edge2;  // of its upper face
};

// How far a slab of thickness 1 shifts a ray at this angle.
double shiftAt(double angle) {
  const double sine = std::sin(angle);
  return sine * (1 - std::cos(angle) / std::sqrt(kIor * kIor - sine * sine));
}

struct SlabErrors {
  size_t lost = 0;                      // do not go through both faces
  Worst direction, timesCosine, shift;  // of all rays
  Worst shiftAt60, shiftAt89;
};

void followThroughSlab(Kernels& kernels, const Slab& slab, const std::vector<TestRay>& rays, Tracer tracer,
                       SlabErrors& errors) {
  std::vector<Journey> journeys = journeysOf(rays);
  for (int step = 0; step < 2; ++step) advance(kernels, journeys, tracer);
  for (size_t i = 0; i < rays.size(); ++i) {
    const dvec3 d(rays[i].direction), out(journeys[i].ray.direction);
    const double angle = angleBetween(-d, slab.normal);
    errors.lost += journeys[i].transmitted != 2;
    errors.direction.add(angleBetween(out, d));
    errors.timesCosine.add(angleBetween(out, d) * std::cos(angle));
    const dvec3 way = dvec3(journeys[i].ray.origin) - dvec3(rays[i].origin);
    const double shift = glm::length(glm::cross(way, d)) / glm::length(d) / slab.thickness;
    errors.shift.add(std::abs(shift - shiftAt(angle)));
    if (std::abs(angle - 60 * kDegree) < 2e-7) errors.shiftAt60.add(std::abs(shift - 0.5124720));
    if (std::abs(angle - 89 * kDegree) < 2e-7) errors.shiftAt89.add(std::abs(shift - 0.9842421));
  }
}

void slabs(const Bench& bench, Report& report) {
  Random random = bench.random(30);
  bench.kernels.setLeastDistance(kUsualEpsilon);
  // (2, 3, 6) / 7 is a unit vector; the tilted faces are 7/8 apart.
  for (const Slab& slab :
       {Slab{"level slab", {0, 1, 0}, 1, {0.25, -0.5, 0.75}, {8, 0, 0}, {0, 0, -8}},
        Slab{"tilted slab", dvec3(2, 3, 6) / 7.0, 0.875, {0.25, -0.5, -0.75}, {6, -4, 0}, {0, 8, -4}}}) {
    Scene scene = sceneSeenFrom({0, 0, 0}, kIor);
    const dvec3 corner = slab.middle - 0.5 * (slab.edge1 + slab.edge2);
    addQuad(scene, corner, slab.edge1, slab.edge2, 0);
    addQuad(scene, corner - slab.thickness * slab.normal, slab.edge2, slab.edge1, 0);
    bench.kernels.setScene(scene);

    Both<SlabErrors> errors;
    Worst rounded;  // the turn of exit where only the direction inside is rounded to float32
    const size_t total = bench.effort.rays(1e6, 1e5);
    Bench::inBatches(total, [&](size_t count) {
      std::vector<TestRay> rays;
      for (size_t i = 0; i < count; ++i) {
        const std::array<double, 4> chosen = {0, 60, 89, 89.9};
        const double angle = (i % 8 < 4 ? chosen[i % 8] : uniform(random, 0, 89.9)) * kDegree;
        const dvec3 a = anywhereAcross(slab.normal, random);
        const dvec3 at =
            slab.middle + uniform(random, -0.1, 0.1) * slab.edge1 + uniform(random, -0.1, 0.1) * slab.edge2;
        rays.push_back(rayThrough(at, std::sin(angle) * a - std::cos(angle) * slab.normal, 0.5));
        const dvec3 d(rays.back().direction), inside(vec3(bent(d, slab.normal, 1 / kIor)));
        rounded.add(angleBetween(bent(inside, slab.normal, kIor), d));
      }
      for (const Tracer tracer : kTracers) followThroughSlab(bench.kernels, slab, rays, tracer, errors.of(tracer));
    });
    const SlabErrors &turner = errors.turner, &naive = errors.naive;
    report.atMost(fmt::format("{}: rays of {:.2g} that do not go through", slab.name, double(total)),
                  double(turner.lost), 0, double(naive.lost));
    report.knownMiss(slab.name + ": turn of the ray, 0 to 89.9°, rad", turner.direction.value, 5e-7,
                     {8e-5, fmt::format("it leaves near the critical angle: rounding the direction inside to float32 "
                                        "alone makes {:.2g}",
                                        rounded.value)},
                     naive.direction.value);
    report.atMost(slab.name + ": the same, times cos θ", turner.timesCosine.value, 5e-7, naive.timesCosine.value);
    report.atMost(slab.name + ": error of the shift", turner.shift.value, 1e-6, naive.shift.value);
    report.atMost(slab.name + ": shift at 60° against 0.5124720", turner.shiftAt60.value, 1e-6, naive.shiftAt60.value);
    report.atMost(slab.name + ": shift at 89° against 0.9842421", turner.shiftAt89.value, 1e-6, naive.shiftAt89.value);
  }
}

// ---- 31, 32, 33: balls ----

void glassSphere(const Bench& bench, Report& report) {
  struct Known {
    double impact, degrees, bar;
  };
  const auto deviationAt = [](double sine) { return 2 * (std::asin(sine) - std::asin(sine / kIor)); };
  bench.kernels.setLeastDistance(kUsualEpsilon);
  Scene scene = sceneSeenFrom({0.25, 0.5, -2.5}, kIor);
  scene.spheres.push_back({{0, 0, 0}, 1});
  bench.kernels.setScene(scene);
  const Sphere& ball = bench.kernels.local().spheres[0];
  Random random = bench.random(10);
  for (const Known& known :
       {Known{0.1, 3.83323, 2e-6}, {0.5, 21.05756, 2e-6}, {0.9, 54.57634, 2e-6}, {0.999, 91.35671, 5e-5}}) {
    std::vector<TestRay> rays;
    for (size_t i = 0; i < bench.effort.rays(1e5, 2e4); ++i) rays.push_back(rayPast(ball.center, known.impact, random));
    Both<Worst> error;
    // The formula gives the catalogue's figure, to its digits.
    if (std::abs(deviationAt(known.impact) / kDegree - known.degrees) > 6e-6) error.turner.add(NAN);
    for (const Tracer tracer : kTracers) {
      std::vector<Journey> journeys = journeysOf(rays);
      for (int step = 0; step < 2; ++step) advance(bench.kernels, journeys, tracer);
      for (size_t i = 0; i < rays.size(); ++i) {
        // Snell's law twice: the ray is turned by 2 (i - t), with sin i the impact parameter of the float ray.
        const double deviation = deviationAt(impact(rays[i], ball));
        const double turned = angleBetween(dvec3(rays[i].direction), dvec3(journeys[i].ray.direction));
        error.of(tracer).add(journeys[i].transmitted == 2 ? std::abs(turned - deviation) : NAN);
      }
    }
    report.atMost(fmt::format("impact {:g}: deviation against {:g} degrees, rad", known.impact, known.degrees),
                  error.turner.value, known.bar, error.naive.value);
  }
}

void indexOne(const Bench& bench, Report& report) {
  Random random = bench.random(31);
  bench.kernels.setLeastDistance(kUsualEpsilon);
  for (const double eta : {1.0, 1 + 1e-6, 1 - 1e-6}) {
    Scene scene = sceneSeenFrom({0.25, 0.5, -2.5}, eta);
    scene.spheres.push_back({{0, 0, 0}, 1});
    bench.kernels.setScene(scene);
    const Sphere& ball = bench.kernels.local().spheres[0];
    const size_t total = bench.effort.rays(1e6, 5e4);
    Both<size_t> wrong;
    Bench::inBatches(total, [&](size_t count) {
      std::vector<TestRay> rays;
      for (size_t i = 0; i < count; ++i)
        rays.push_back(rayPast(ball.center, i % 2 ? 0.999 : uniform(random, 0, 0.999), random));
      for (const Tracer tracer : kTracers) {
        std::vector<Journey> journeys = journeysOf(rays);
        for (int step = 0; step < 3; ++step) advance(bench.kernels, journeys, tracer);
        for (const Journey& journey : journeys)
          wrong.of(tracer) += !journey.ended || journey.transmitted != 2 || journey.reflected != 0;
      }
    });
    report.atMost(
        fmt::format("index {}: rays of {:.2g} that do not go straight through, impact ≤ 0.999", eta, double(total)),
        double(wrong.turner), 0, double(wrong.naive));
  }

  // A ball and a box. What is seen through them is the background.
  Scene scene = sceneSeenFrom({0.25, 0.5, -4.5}, 1);
  scene.background = {0.25, 0.5, 1};
  scene.depth = 6;
  scene.spheres.push_back({{-0.7, 0, 0}, 1});
  addParallelepiped(scene, {0.6, -0.3, 0.2}, {0.8, 0.1, 0}, {-0.1, 0.8, 0}, {0, 0, 0.9}, 0);
  const int size = bench.effort.full ? 1024 : 256;
  const Image image = test::renderShader(scene, test::settingsOf(scene, size, size, 2));
  Worst error;
  for (size_t i = 0; i < image.rgb.size(); ++i) error.add(std::abs(image.rgb[i] - scene.background[int(i % 3)]));
  report.atMost("picture of a ball and a box: largest difference to the background", error.value, 1e-6);
}

constexpr int kChain = 64;  // reflections: as deep as a ray tree can be

void trappedLight(const Bench& bench, Report& report) {
  Random random = bench.random(32);
  bench.kernels.setLeastDistance(kUsualEpsilon);
  Scene scene = sceneSeenFrom({0.5, 0.25, 0.5}, kIor);
  scene.spheres.push_back({{0, 0, 0}, 1});
  bench.kernels.setScene(scene);
  const Sphere& ball = bench.kernels.local().spheres[0];
  const size_t total = bench.effort.rays(1e6, 1e4);
  Both<size_t> escaped;
  Both<Worst> drift;
  Bench::inBatches(total, [&](size_t count) {
    std::vector<TestRay> rays;
    for (size_t i = 0; i < count; ++i) {
      const dvec3 n = randomDirection(random);
      rays.push_back(rayThrough(ball.center + 0.8 * n, anywhereAcross(n, random), 0));
    }
    for (const Tracer tracer : kTracers) {
      std::vector<Journey> journeys = journeysOf(rays);
      for (int step = 0; step < kChain; ++step) {
        advance(bench.kernels, journeys, tracer);
        for (size_t i = 0; i < count; ++i) {
          if (journeys[i].ended || journeys[i].transmitted > 0) continue;
          const dvec3 n = (dvec3(journeys[i].last.point) - ball.center) / ball.radius;
          const double sine = impact(rays[i], ball);
          drift.of(tracer).add(std::abs(-glm::dot(dvec3(journeys[i].ray.direction), n) - std::sqrt(1 - sine * sine)));
        }
      }
      for (const Journey& journey : journeys) escaped.of(tracer) += journey.reflected != kChain;
    }
  });
  report.atMost(fmt::format("rays of {:.2g} that escape within {} reflections", double(total), kChain),
                double(escaped.turner), 0, double(escaped.naive));
  report.atMost("drift of d·n of those that do not", drift.turner.value, 2e-5, drift.naive.value);

  // A picture of nothing but trapped rays: 20 degrees off the tangent they still meet the surface at 0.8 cos 20°.
  scene.background = {1, 1, 1};
  scene.depth = kMaxDepth;
  scene.camera = {.eye = {0.8, 0, 0}, .target = {0.8, 0.6, 0.8}, .up = {1, 0, 0}, .fov = 27};
  const int size = bench.effort.full ? 256 : 32;
  const RenderSettings settings = test::settingsOf(scene, size, size);
  const Image image = test::renderShader(scene, settings);
  report.atMost(fmt::format("picture of depth {}: channels that are not black", kMaxDepth),
                double(std::count_if(image.rgb.begin(), image.rgb.end(), [](float c) { return c != 0; })), 0);
  const RayCounts rays = test::countShaderRays(scene, settings);
  const double expected = double(kMaxDepth - 1) * double(size * size);
  report.atMost("picture: reflected rays beside one for each level below the eye's",
                std::abs(double(rays.reflected) - expected) + double(rays.refracted + rays.shadow), 0);
}

// A glass ball with a bubble, which leaves a wall of this thickness. The bubble's surface faces inward: the glass is
// behind it. The naive tracer knows no such surface; for it the bubble is a ball of the inverse index.
Scene ballWithBubble(double wall, Tracer tracer) {
  Scene scene = sceneSeenFrom({1.25, 0.75, 2.5}, kIor);
  scene.spheres.push_back({{0, 0, 0}, 1});
  if (tracer == Tracer::turner)
    scene.spheres.push_back({{0, 0, 0}, wall - 1});
  else
    scene.spheres.push_back({{0, 0, 0}, 1 - wall, addMaterial(scene, closed_form::glass(0, 1, 1 / kIor))});
  return scene;
}

// Bouguer: n r sin(angle) is the same all along a ray, so that the impact b says everything. Where the bubble lets the
// ray in the deviation toward the axis is that of four refractions, otherwise that of two and a reflection.
double deviationByWall(double b, double bubble) {
  const double turnOutside = std::asin(b) - std::asin(b / kIor), inGlass = std::asin(b / (kIor * bubble));
  return 2 * turnOutside - (b < bubble ? 2 * (std::asin(b / bubble) - inGlass) : std::numbers::pi - 2 * inGlass);
}

struct BubbleErrors {
  size_t otherPath = 0;
  Worst deviation;    // of rays that meet the ball at up to 64 degrees
  Worst timesCosine;  // of all rays: times the cosine where they graze most
};

void followThroughBubble(const Bench& bench, const std::vector<TestRay>& rays, Tracer tracer, BubbleErrors& errors) {
  const Sphere ball = bench.kernels.local().spheres[0];
  const double inner = std::abs(bench.kernels.local().spheres[1].radius);
  std::vector<Journey> journeys = journeysOf(rays);
  for (int step = 0; step < 6; ++step) advance(bench.kernels, journeys, tracer);
  for (size_t i = 0; i < rays.size(); ++i) {
    const double b = impact(rays[i], ball);
    const bool passes = b < inner;  // else: total internal reflection on the bubble
    const int transmitted = passes ? 4 : 2, reflected = passes ? 0 : 1;
    if (std::abs(b - inner) < 2e-6 || b > 1 - 2e-6) continue;  // rounding decides
    const Journey& journey = journeys[i];
    errors.otherPath += !journey.ended || journey.transmitted != transmitted || journey.reflected != reflected;
    const dvec3 expected = directionBehind(rays[i], ball.center, deviationByWall(b, inner));
    const double error = angleBetween(dvec3(journey.ray.direction), expected);
    if (b <= 0.9) errors.deviation.add(error);
    const double closest = std::max(b, passes ? b / inner : 0);  // the sine at which it grazes most
    errors.timesCosine.add(error * std::sqrt(1 - closest * closest));
  }
}

void bubble(const Bench& bench, Report& report) {
  Random random = bench.random(33);
  bench.kernels.setLeastDistance(kUsualEpsilon);
  Both<size_t> otherPath;
  Both<Worst> timesCosine;
  const size_t total = bench.effort.rays(1e6, 3e4);
  for (const double wall : {1e-2, 1e-3, 1e-4, 4e-5, 1e-5, 1e-6}) {
    Both<BubbleErrors> errors;
    for (const Tracer tracer : kTracers) {
      bench.kernels.setScene(ballWithBubble(wall, tracer));
      const dvec3 center = bench.kernels.local().spheres[0].center;
      Bench::inBatches(total, [&](size_t count) {
        std::vector<TestRay> rays;
        for (size_t i = 0; i < count; ++i) {
          // Half of them graze the bubble, inside its rim or beyond it.
          const double impact = i % 2 ? uniform(random, 1 - 2 * wall, 1) : uniform(random, 1e-3, 1);
          rays.push_back(rayPast(center, impact, random));
        }
        followThroughBubble(bench, rays, tracer, errors.of(tracer));
      });
      otherPath.of(tracer) += errors.of(tracer).otherPath;
      timesCosine.of(tracer).add(errors.of(tracer).timesCosine.value);
    }
    report.atMost(fmt::format("wall {:g}: error of the deviation, impact ≤ 0.9, rad", wall),
                  errors.turner.deviation.value, 1e-5, errors.naive.deviation.value);
  }
  report.atMost(
      fmt::format("all walls: rays of {:.2g} on another path, 2e-6 and more from the rims", 6.0 * double(total)),
      double(otherPath.turner), 0, double(otherPath.naive));
  report.atMost("all walls and rays: error of the deviation, times the smallest cos θ, rad", timesCosine.turner.value,
                1e-5, timesCosine.naive.value);
}

// ---- 34 ----

// Glass around the eye, with a bubble: rays from inside the wall or the bubble go out, and others that come in the
// opposite way along them must end as they began.
void viewerInside(const Bench& bench, Report& report) {
  Random random = bench.random(34);
  bench.kernels.setLeastDistance(kUsualEpsilon);
  for (const bool inBubble : {false, true}) {
    Both<Worst> turned;
    Both<size_t> lost;
    const size_t total = bench.effort.rays(1e6, 5e4);
    for (const Tracer tracer : kTracers) {
      bench.kernels.setScene(ballWithBubble(0.3, tracer));
      const dvec3 center = bench.kernels.local().spheres[0].center;
      Bench::inBatches(total, [&](size_t count) {
        std::vector<TestRay> rays;
        while (rays.size() < count) {
          const dvec3 d = randomDirection(random), from = randomDirection(random);
          const double distance = inBubble ? uniform(random, 0.1, 0.6) : uniform(random, 0.75, 0.95);
          const TestRay ray{vec3(center + distance * from), vec3(d)};
          // n r sin(angle), the same all along: rays that are far from grazing. Those from the wall go outward.
          const double b = (inBubble ? 1 : kIor) * glm::length(glm::cross(dvec3(ray.origin) - center, d));
          if (b < 0.6 && (inBubble || glm::dot(from, d) > 0.3)) rays.push_back(ray);
        }
        std::vector<Journey> out = journeysOf(rays);
        for (int step = 0; step < 3; ++step) advance(bench.kernels, out, tracer);
        std::vector<TestRay> back;
        for (const Journey& journey : out)
          back.push_back({journey.ray.origin + journey.ray.direction, -journey.ray.direction});
        std::vector<Journey> in = journeysOf(back);
        for (int step = 0; step < (inBubble ? 2 : 1); ++step) advance(bench.kernels, in, tracer);
        for (size_t i = 0; i < count; ++i) {
          lost.of(tracer) += !out[i].ended || out[i].transmitted != in[i].transmitted || out[i].reflected > 0;
          turned.of(tracer).add(angleBetween(-dvec3(in[i].ray.direction), dvec3(rays[i].direction)));
        }
      });
    }
    const std::string where = inBubble ? "in the bubble" : "in the glass";
    report.atMost(fmt::format("eye {}: rays of {:.2g} on another way back", where, double(total)), double(lost.turner),
                  0, double(lost.naive));
    report.atMost("eye " + where + ": turn of the ray that comes back, rad", turned.turner.value, 1e-5,
                  turned.naive.value);
  }
}

}  // namespace

std::vector<Case> refractionCases() {
  return {{10, "Glass sphere", glassSphere},  {29, "Critical angle", criticalAngle}, {30, "Slab", slabs},
          {31, "Index 1", indexOne},          {32, "Trapped light", trappedLight},   {33, "Bubble", bubble},
          {34, "Viewer inside", viewerInside}};
}

}  // namespace turner::hard
