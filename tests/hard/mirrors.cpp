// Mirrors: directions that come back bit by bit, and light that is neither lost nor won.
#include <fmt/format.h>

#include <array>

#include "hard/cases.h"
#include "hard/chain.h"
#include "image/compare.h"
#include "image/envelope.h"
#include "reference/reference.h"
#include "support/closed_form.h"

namespace turner::hard {
namespace {

using closed_form::addMaterial, closed_form::addQuad, closed_form::lookAt, closed_form::matte;

// ---- 36 ----

// Mirrors at z = ±1 with k_r = 0.8; each hit sends w_local E k_d = 0.2 * 5 = 1.
Scene corridor() {
  Scene scene;
  scene.camera = lookAt({0.3, -0.2, 0.25}, {0.3, -0.2, 1.25}, {0, 1, 0}, 45);
  scene.lights = {{.position = {0.3, -0.2, -0.5}, .color = {5, 5, 5}}};
  Material wall = closed_form::mirror(0.8);
  wall.diffuse = dvec3(1);
  addMaterial(scene, wall);
  addQuad(scene, {-3, -5, -1}, {7, 0, 0}, {0, 9, 0}, 0);
  addQuad(scene, {-3, -5, 1}, {0, 9, 0}, {7, 0, 0}, 0);
  return scene;
}

void mirrorCorridor(const Bench& bench, Report& report) {
  Scene scene = corridor();
  for (const int n : {1, 4, 8, 16}) {
    scene.depth = n + 1;
    const Image image = test::renderShader(scene, test::settingsOf(scene, 1, 1));
    const double sum = (1 - std::pow(0.8, n + 1)) / 0.2;
    Worst error;
    for (const float channel : image.rgb) error.add(std::abs(channel - sum) / sum);
    report.atMost(fmt::format("picture after {} reflections: relative error", n), error.value, 1e-6);
  }

  constexpr int kReflections = 64;
  Random random = bench.random(36);
  bench.kernels.setScene(scene);
  bench.kernels.setLeastDistance(kUsualEpsilon);
  const size_t total = bench.effort.rays(1e5, 1e4);
  Both<size_t> moved;
  std::vector<TestRay> starts;
  for (size_t i = 0; i < total; ++i)
    starts.push_back({.origin = vec3(uniform(random, -2, 2), uniform(random, -3, 2), uniform(random, -1, 0.7)),
                      .direction = {0, 0, i % 2 ? 1.0f : -1.0f}});
  for (const Tracer tracer : kTracers) {
    std::vector<TestRay> rays = starts;
    std::vector<char> stays(total, true);
    for (int k = 0; k < kReflections; ++k) {
      const std::vector<Found> found = stepFrom(bench.kernels, rays, Next::reflected, tracer);
      for (size_t i = 0; i < total; ++i) {
        const vec3 &start = starts[i].origin, &point = found[i].point;
        stays[i] = stays[i] && found[i].hits() && point.x == start.x && point.y == start.y;
        rays[i] = found[i].leaving;
      }
    }
    moved.of(tracer) = size_t(std::count(stays.begin(), stays.end(), false));
  }
  report.atMost(
      fmt::format("rays of {:.2g} that end, or whose x or y changes, in {} reflections", double(total), kReflections),
      double(moved.turner), 0, double(moved.naive));
}

// ---- 37 ----

// A corner of three mirrors whose normals are the columns of an orthonormal basis.
struct Corner {
  dvec3 apex;
  std::array<dvec3, 3> axes;
  static constexpr double kReach = 64;  // how far the mirrors reach from the apex

  Scene scene() const {
    Scene made;
    made.camera = {.eye = {0, 0, 0}, .target = {0, 0, 1}};
    addMaterial(made, closed_form::mirror(1));
    for (int k = 0; k < 3; ++k) addQuad(made, apex, kReach * axes[(k + 1) % 3], kReach * axes[(k + 2) % 3], 0);
    return made;
  }

  dvec3 at(const dvec3& p) const { return apex + p.x * axes[0] + p.y * axes[1] + p.z * axes[2]; }
};

// A ray to a place on one of the mirrors, half of them 1e-9 to 1 from the edges.
TestRay rayIntoCorner(const Corner& corner, Random& random) {
  const bool nearEdge = random() % 2;
  dvec3 d, target;
  for (int k = 0; k < 3; ++k) {
    d[k] = uniform(random, 0.05, 1);
    target[k] = nearEdge ? std::pow(10, uniform(random, -9, 0)) : uniform(random, 0, 1);
  }
  d = glm::normalize(d);
  target[int(random() % 3)] = 0;
  return {.origin = vec3(corner.at(target + uniform(random, 0.2, 1) * d)),
          .direction = vec3(corner.at(-d) - corner.apex)};
}

// How near to an edge the ray meets a mirror. Unfolded, its path is straight: it crosses all three planes.
double distanceToEdges(const Corner& corner, const TestRay& ray) {
  double least = 1;
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j) {
      const auto height = [&](int axis) { return glm::dot(dvec3(ray.origin) - corner.apex, corner.axes[axis]); };
      const auto slope = [&](int axis) { return glm::dot(dvec3(ray.direction), corner.axes[axis]); };
      if (j != k) least = std::min(least, std::abs(height(j) - slope(j) * height(k) / slope(k)));
    }
  return least;
}

struct CornerErrors {
  Worst lost;          // how far from an edge a ray is that does not come back after three reflections
  size_t changed = 0;  // come back in another direction, bit by bit
  Worst error;         // |d' + d|
};

void followIntoCorner(Kernels& kernels, const Corner& corner, const std::vector<TestRay>& starts, Tracer tracer,
                      CornerErrors& errors) {
  std::vector<TestRay> rays = starts;
  std::vector<char> returns(starts.size(), true);
  for (int k = 0; k < 4; ++k) {
    const std::vector<Found> found = stepFrom(kernels, rays, Next::reflected, tracer);
    for (size_t i = 0; i < rays.size(); ++i) {
      returns[i] = returns[i] && found[i].hits() == (k < 3);
      if (returns[i] && k < 3) rays[i] = found[i].leaving;
    }
  }
  for (size_t i = 0; i < rays.size(); ++i) {
    if (!returns[i]) errors.lost.add(distanceToEdges(corner, starts[i]));
    if (!returns[i]) continue;
    errors.changed += rays[i].direction != -starts[i].direction;
    errors.error.add(glm::length(dvec3(rays[i].direction) + dvec3(starts[i].direction)));
  }
}

void cubeCorner(const Bench& bench, Report& report) {
  Random random = bench.random(37);
  bench.kernels.setLeastDistance(kUsualEpsilon);
  const dvec3 apex(-0.4, -0.7, 0.3), n = randomDirection(random);
  dvec3 a, b;
  basisOf(n, a, b);
  for (const Corner& corner :
       {Corner{apex, {dvec3(1, 0, 0), dvec3(0, 1, 0), dvec3(0, 0, 1)}}, Corner{apex, {a, b, n}}}) {
    bench.kernels.setScene(corner.scene());
    const size_t total = bench.effort.rays(1e6, 1e5);
    Both<CornerErrors> errors;
    Bench::inBatches(total, [&](size_t count) {
      std::vector<TestRay> rays;
      for (size_t i = 0; i < count; ++i) rays.push_back(rayIntoCorner(corner, random));
      for (const Tracer tracer : kTracers) followIntoCorner(bench.kernels, corner, rays, tracer, errors.of(tracer));
    });
    const bool level = corner.axes[0].x == 1;
    const std::string where = level ? "level corner" : "turned corner";
    if (level)
      report.atMost(fmt::format("{}: directions of {:.2g} that are not the opposite, bit by bit", where, double(total)),
                    double(errors.turner.changed), 0, double(errors.naive.changed));
    else
      report.atMost(where + ": |d' + d|", errors.turner.error.value, 1e-6, errors.naive.error.value);
    report.atMost(where + ": farthest from an edge that a ray does not come back", errors.turner.lost.value, 1e-6,
                  errors.naive.lost.value);
  }
}

// ---- 38 ----

struct Furnace {
  std::string name;
  Scene scene;  // all trees of rays end within its depth
};

// Two sheets of glass, half mirrors, that meet at 10 degrees: a ray between them is reflected 18 times at the most, and
// what passes a sheet never comes back.
Furnace wedge() {
  Furnace furnace{"wedge of half mirrors", {}};
  Scene& scene = furnace.scene;
  scene.background = dvec3(1);
  scene.depth = 19;
  scene.camera = lookAt({10, 0.3, 0.2}, {9, 0.31, 0.23}, {0, 1, 0}, 60);
  addMaterial(scene, closed_form::glass(1 / 3.0, 2 / 3.0, 1.5));
  addMaterial(scene, closed_form::glass(0.85, 0.15, 1.5));
  const double x = 40 * std::cos(5 * closed_form::kDegree), y = 40 * std::sin(5 * closed_form::kDegree);
  addQuad(scene, {0, 0, -90}, {x, y, 0}, {0, 0, 180}, 0);
  addQuad(scene, {0, 0, -90}, {x, -y, 0}, {0, 0, 180}, 1);
  return furnace;
}

// Three balls side by side, of which each sees the others.
Scene threeBalls(double radius, uint32_t material) {
  Scene scene;
  for (const dvec3& center : {dvec3(1, -1, 0), dvec3(0, 1, -1), dvec3(-1, 0, 1)})
    scene.spheres.push_back({center, radius, material});
  scene.camera = lookAt({-7, -7, -7}, {0, 0, 0}, {1, -0.2, -0.8}, 22);
  return scene;
}

Furnace mirrorBalls() {
  Furnace furnace{"three mirror balls", threeBalls(1, 0)};
  furnace.scene.background = dvec3(1);
  furnace.scene.depth = 16;
  addMaterial(furnace.scene, closed_form::mirror(1));
  return furnace;
}

Furnace glassBalls() {
  Furnace furnace{"three glass balls with mirrors inside", threeBalls(1, 0)};
  Scene& scene = furnace.scene;
  scene.background = dvec3(1);
  scene.depth = 16;
  addMaterial(scene, closed_form::glass(0, 1, 1.5));
  const uint32_t mirror = addMaterial(scene, closed_form::mirror(1));
  for (const Sphere& ball : std::vector<Sphere>(scene.spheres)) scene.spheres.push_back({ball.center, 0.6, mirror});
  return furnace;
}

void furnaces(const Bench& bench, Report& report) {
  const int size = bench.effort.full ? 512 : 128;
  for (const Furnace& furnace : {wedge(), mirrorBalls(), glassBalls()}) {
    const RenderSettings settings = test::settingsOf(furnace.scene, size, size);
    const Image image = test::renderShader(furnace.scene, settings);
    const Image reference = renderReference(furnace.scene, settings).image;
    Worst error, referenceError;
    for (const float channel : image.rgb) error.add(std::abs(channel - 1.0));
    for (const float channel : reference.rgb) referenceError.add(std::abs(channel - 1.0));
    report.atMost(fmt::format("furnace, {}, depth {}: error", furnace.name, furnace.scene.depth), error.value,
                  2e-7 * (furnace.scene.depth + 1), {}, fmt::format("the reference's {:.2g}", referenceError.value));
  }
}

// Balls of r = 0.9, nearly touching, over a floor. The view is along the diagonal, and so narrow that all components of
// an eye ray lie in [1/2, 1), where an ulp is the 2^-24 of renderEnvelope.
Scene mirrorBallsOnFloor() {
  Scene scene = threeBalls(1.2, 0);
  scene.background = {0.35, 0.5, 0.75};
  scene.depth = 8;
  scene.camera.fov = 10;
  scene.camera.eye = dvec3(-14);
  scene.lights = {{.position = {-9, -4, -7}, .color = {0.8, 0.8, 0.7}},
                  {.position = {2, -20, 4}, .color = {0.3, 0.3, 0.4}}};
  Material ball = closed_form::mirror(0.9);
  ball.diffuse = {0.7, 0.5, 0.2};
  addMaterial(scene, ball);
  const dvec3 down = glm::normalize(dvec3(-1, 0.2, 0.8));
  dvec3 a, b;
  basisOf(down, a, b);
  addQuad(scene, 2.5 * down - 9.0 * (a + b), 18.0 * b, 18.0 * a, addMaterial(scene, matte({0.7, 0.7, 0.6})));
  return scene;
}

void ballsAgainstReference(const Bench& bench, Report& report) {
  const Scene scene = mirrorBallsOnFloor(), local = roundScene(scene);
  const int size = bench.effort.full ? 512 : 192;
  const RenderSettings settings = test::settingsOf(scene, size, size);
  const Image image = test::renderShader(scene, settings), reference = renderReference(local, settings).image;
  const EnvelopeRule rule = applyEnvelope(image, reference, [&](std::span<const Pixel> pixels, int rays) {
    return renderEnvelope(local, settings, pixels, rays);
  });
  const Comparison comparison = compareImages(image, reference, kEnvelopeTolerance);
  report.atMost("mirror balls: mean difference to the reference", comparison.mae, 1e-4);
  report.atMost("mirror balls: pixels that differ by more than 1e-5", rule.needed, 0.02);
  report.atMost("mirror balls: pixels of those outside the envelope of 4 ulp", double(rule.outside), 0);
  report.atMost("mirror balls: pixels with a NaN or an infinity", double(comparison.nan + comparison.inf), 0);
}

void energy(const Bench& bench, Report& report) {
  furnaces(bench, report);
  ballsAgainstReference(bench, report);
}

}  // namespace

std::vector<Case> mirrorCases() {
  return {{36, "Mirror corridor", mirrorCorridor},
          {37, "Cube corner", cubeCorner},
          {38, "Furnace and mirror balls", energy}};
}

}  // namespace turner::hard
