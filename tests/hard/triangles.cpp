// Triangles: no ray slips between two, distances are those of the plane, and what has no area is not there. Oracles: a
// closed mesh is hit by every ray from inside; planes in 113-bit arithmetic through the float vertices that the kernel
// gets.
#include <fmt/format.h>

#include <array>
#include <glm/geometric.hpp>

#include "hard/cases.h"
#include "hard/chain.h"
#include "hard/icosphere.h"
#include "hard/pictures.h"
#include "hard/vectors.h"
#include "support/closed_form.h"

namespace turner::hard {
namespace {

// --- 11 and 12 ---

bool shareAVertex(const TriangleCorners& a, const TriangleCorners& b) {
  for (const dvec3& v : a)
    for (const dvec3& w : b)
      if (v == w) return true;
  return false;
}

struct MeshErrors {
  size_t misses = 0, elsewhere = 0;  // hit nothing; hit a triangle that does not touch the one aimed at
};

Both<MeshErrors> traceMesh(const Bench& bench, const Scene& scene, const dvec3& localCentre, double localRadius,
                           size_t rays, Random& random) {
  bench.kernels.setScene(scene);
  const Scene& local = bench.kernels.local();
  Both<MeshErrors> errors;
  Bench::inBatches(rays, [&](size_t count) {
    std::vector<Query> queries;
    std::vector<size_t> aims;
    for (size_t i = 0; i < count; ++i) {
      const Aimed aimed = aimedRay(local, random, localCentre, localRadius);
      queries.push_back(aimed.query);
      aims.push_back(aimed.triangle);
    }
    for (const Tracer tracer : kTracers) {
      const std::vector<Found> found = bench.kernels.trace(queries, tracer);
      for (size_t i = 0; i < count; ++i) {
        errors.of(tracer).misses += !found[i].hits();
        errors.of(tracer).elsewhere +=
            found[i].hits() && !shareAVertex(local.cornersOf(found[i].id), local.cornersOf(aims[i]));
      }
    }
  });
  return errors;
}

void watertightIcosphere(const Bench& bench, Report& report) {
  Random random = bench.random(11);
  for (const int levels : {3, 5, bench.effort.full ? 8 : 6}) {
    const Scene scene = icosphere(levels, 1, {0, 0, 0});
    const size_t rays = bench.effort.rays(1e7, 3e5);
    const Both<MeshErrors> errors = traceMesh(bench, scene, {0, 0, 0}, 1, rays, random);
    const std::string which = fmt::format("of {:.2g} aimed rays, {} triangles", double(rays), scene.triangles.size());
    report.atMost("misses " + which, double(errors.turner.misses), 0, double(errors.naive.misses));
    report.atMost("hits away from the aim " + which, double(errors.turner.elsewhere), 0,
                  double(errors.naive.elsewhere));
  }
}

void watertightElsewhere(const Bench& bench, Report& report) {
  struct Place {
    const char* name;
    dvec3 centre;
    double radius;
  };
  const Place places[] = {{"at (148376, 1234, -223423), R = 2", {148376, 1234, -223423}, 2},
                          {"at (1e6, 1e6, 1e6), R = 2", {1e6, 1e6, 1e6}, 2},
                          {"R = 1e-3", {0, 0, 0}, 1e-3},
                          {"R = 1e6", {0, 0, 0}, 1e6},
                          {"R = 1e-12", {0, 0, 0}, 1e-12}};
  Random random = bench.random(12);
  const size_t rays = bench.effort.rays(1e7, 1e5);
  for (const Place& place : places) {
    Scene scene = icosphere(bench.effort.full ? 5 : 4, place.radius, place.centre);
    // The frame has its target at a distance in [1, 2): the radius there is this.
    const double radius = std::ldexp(place.radius, -std::ilogb(place.radius));
    const Both<MeshErrors> rebased = traceMesh(bench, scene, {0, 0, 0}, radius, rays, random);
    report.atMost(fmt::format("{}: misses of {:.2g} aimed rays", place.name, double(rays)),
                  double(rebased.turner.misses), 0, double(rebased.naive.misses));

    // Without rebasing: the eye stays at the origin, and the float vertices are those of the world.
    if (place.radius > 1e3) continue;  // R = 1e6 around the eye is the same but for its scale
    scene = icosphere(3, place.radius, place.centre);
    scene.camera = {.eye = {0, 0, 0}, .target = {0, 0, 1}};
    const Both<MeshErrors> raw = traceMesh(bench, scene, place.centre, place.radius, rays, random);
    report.atMost(fmt::format("{}: misses, coordinates as they are, 1280 triangles", place.name),
                  double(raw.turner.misses), 0, double(raw.naive.misses));
  }
}

// --- distances to planes ---

// Where a ray meets the plane of a triangle.
Wide planeDistance(const TriangleCorners& corners, const TestRay& ray) {
  const Wide3 v0 = wide(corners[0]), a = wide(corners[1]) - v0, b = wide(corners[2]) - v0;
  const Wide3 n{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  return dot(n, v0 - wide(ray.origin)) / dot(n, wide(ray.direction));
}

double relativeError(const Found& found, const TriangleCorners& corners, const TestRay& ray) {
  const Wide t = planeDistance(corners, ray);
  return std::abs(double((Wide(found.t) - t) / t));
}

// The eye is the origin, and the scale 1.
Scene trianglesSeenFromOrigin() {
  Scene scene;
  scene.camera = {.eye = {0, 0, 0}, .target = {0, 0, -1}};
  scene.materials = {closed_form::matte({1, 1, 1})};
  return scene;
}

// Traces rays that must hit something, and compares distances with those of the planes.
struct PlaneErrors {
  size_t misses = 0;
  Worst relative;
};

void tracePlanes(const Bench& bench, const std::vector<Query>& queries, Both<PlaneErrors>& errors) {
  for (const Tracer tracer : kTracers) {
    const std::vector<Found> found = bench.kernels.trace(queries, tracer);
    for (size_t i = 0; i < found.size(); ++i) {
      errors.of(tracer).misses += !found[i].hits();
      if (found[i].hits())
        errors.of(tracer).relative.add(
            relativeError(found[i], bench.kernels.local().cornersOf(found[i].id), queries[i].ray));
    }
  }
}

// --- 13 ---

void quadDiagonal(const Bench& bench, Report& report) {
  constexpr double kUlp = 0x1p-23;  // of 1: at most as large as that of t, relative to it
  Both<PlaneErrors> errors;
  // The ray of the catalogue, in the frame of its eye (0, 0, 10).
  Scene scene = trianglesSeenFromOrigin();
  closed_form::addQuad(scene, {-5, -5, -10}, {10, 0, 0}, {0, 10, 0}, 0);
  bench.kernels.setScene(scene);
  tracePlanes(bench, {{TestRay{vec3(0), {0.30458447f, 0.30458447f, -0.9024725f}}}}, errors);

  // A quad turned by 90 degrees about (1, 1, 1) and a grid of rays on it, the diagonal among them.
  scene = trianglesSeenFromOrigin();
  closed_form::addQuad(scene, {-1, -4, -1}, {0, 0, 2}, {2, 0, 0}, 0);
  bench.kernels.setScene(scene);
  std::vector<Query> grid;
  for (int i = 0; i < 32; ++i)
    for (int j = 0; j < 32; ++j)
      grid.push_back({TestRay{vec3(0), vec3(glm::normalize(dvec3(-1 + (i + 0.5) / 16, -4, -1 + (j + 0.5) / 16)))}});
  tracePlanes(bench, grid, errors);

  // Any quad, and rays at its diagonal.
  Random random = bench.random(13);
  const size_t quads = bench.effort.full ? 200 : 20;
  for (size_t quad = 0; quad < quads; ++quad) {
    scene = trianglesSeenFromOrigin();
    const dvec3 toward = randomDirection(random);
    dvec3 normal = randomDirection(random), a, b;
    while (std::abs(glm::dot(normal, toward)) < 0.5) normal = randomDirection(random);
    basisOf(normal, a, b);
    const double size = std::exp2(uniform(random, -4, 2));
    closed_form::addQuad(scene, 3.0 * toward - 0.5 * size * (a + b), size * a, uniform(random, 0.3, 1) * size * b, 0);
    bench.kernels.setScene(scene);
    const auto& v = bench.kernels.local().cornersOf(0);  // of which v0 and v2 are on the diagonal
    std::vector<Query> queries;
    for (size_t i = 0; i < bench.effort.rays(1e6, 1e5) / quads; ++i)
      queries.push_back({TestRay{vec3(0), vec3(glm::normalize(glm::mix(v[0], v[2], uniform(random, 0.001, 0.999))))}});
    tracePlanes(bench, queries, errors);
  }
  report.atMost("misses on diagonals of quads", double(errors.turner.misses), 0, double(errors.naive.misses));
  report.atMost("largest error of t, in ulps", errors.turner.relative.value / kUlp, 4,
                errors.naive.relative.value / kUlp);
}

// --- 14 ---

void needles(const Bench& bench, Report& report) {
  for (const double aspect : {1e2, 1e4, 1e6}) {
    // A strip of needles with ragged ends, a little tilted. Their thickness is across y, where floats are fine.
    constexpr int kNeedles = 64;
    Scene scene = trianglesSeenFromOrigin();
    Random random = bench.random(14);
    std::vector<dvec3> corners;
    for (int i = 0; i < kNeedles + 2; ++i) {
      const double x = (i % 2 ? 1 : -1) * uniform(random, 0.4, 0.6);
      corners.push_back({x, (i - kNeedles / 2) / aspect, -2 + 0.25 * x});
    }
    for (size_t i = 0; i < kNeedles; ++i)
      scene.addTriangle({corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]});
    bench.kernels.setScene(scene);
    const Scene& local = bench.kernels.local();
    Both<PlaneErrors> errors;
    Bench::inBatches(bench.effort.rays(1e6, 1e5), [&](size_t count) {
      std::vector<Query> queries;
      for (size_t i = 0; i < count; ++i) {
        // Inside the strip: neighbours on both sides, away from the ragged ends.
        const TriangleCorners triangle = local.cornersOf(16 + random() % (kNeedles - 32));
        dvec3 target = aimAt(triangle, 1 + int(i % 2), random);
        while (std::abs(target.x) > 0.3) target = aimAt(triangle, 1 + int(i % 2), random);
        const vec3 origin(uniform(random, -0.3, 0.3), uniform(random, -4, 4) / aspect, uniform(random, -0.3, 0.3));
        queries.push_back({TestRay{origin, vec3(glm::normalize(target - dvec3(origin)))}});
      }
      tracePlanes(bench, queries, errors);
    });
    report.atMost(fmt::format("aspect {:g}: misses", aspect), double(errors.turner.misses), 0,
                  double(errors.naive.misses));
    report.atMost(fmt::format("aspect {:g}: largest relative error of t", aspect), errors.turner.relative.value, 1e-6,
                  errors.naive.relative.value);
  }
}

// --- 15 and 16: pictures ---

void zeroArea(const Bench& bench, Report& report) {
  Random random = bench.random(15);
  Scene scene = trianglesSeenFromOrigin();
  scene.background = {0.25, 0.5, 0.75};
  scene.lights = {{.position = {3, 4, 2}}};
  scene.materials.push_back(closed_form::mirror(0.5));
  for (int i = 0; i < 1000; ++i) {
    const dvec3 at = 4.0 * randomDirection(random);
    scene.addTriangle(
        {at + 0.3 * randomDirection(random), at + 0.3 * randomDirection(random), at + 0.3 * randomDirection(random)},
        uint32_t(i % 2));
  }
  Scene with = scene;
  const uint32_t bright = closed_form::addMaterial(with, closed_form::matte({100, 100, 100}));
  for (int i = 0; i < 400; ++i) {
    const dvec3 a = 3.0 * randomDirection(random), b = 3.0 * randomDirection(random);
    const std::array<std::array<dvec3, 3>, 4> flat = {std::array{a, a, a}, std::array{a, b, a},
                                                      std::array{a, b, 0.5 * (a + b)},
                                                      std::array{a, a + dvec3(1e-20, 0, 0), a + dvec3(0, 1e-20, 0)}};
    with.addTriangle(flat[size_t(i % 4)], bright);
  }
  // Halves of float sums are not always on the line: only those that have no area after rounding are to vanish.
  const Scene rounded = roundScene(with);
  std::vector<Triangle> kept(with.triangles.begin(), with.triangles.begin() + 1000);
  for (size_t i = 1000; i < with.triangles.size(); ++i) {
    const auto& v = rounded.cornersOf(i);
    if (glm::cross(v[1] - v[0], v[2] - v[0]) == dvec3(0)) kept.push_back(with.triangles[i]);
  }
  with.triangles = kept;
  const RenderSettings settings = test::settingsOf(scene, 256, 256);
  const Image without = test::renderShader(scene, settings), all = test::renderShader(with, settings);
  report.atMost(fmt::format("differing values by {} triangles without area", kept.size() - 1000),
                double(differingValues(without, all)), 0);
  size_t notFinite = 0;
  for (const float value : all.rgb) notFinite += !std::isfinite(value);
  report.atMost("NaN or infinities", double(notFinite), 0);
}

Image renderWith(const Scene& scene, const RenderSettings& settings, bool medians, TraversalStart cubes,
                 const Dispatching& dispatching) {
  const PreparedGeometry prepared = prepareGeometry(roundScene(scene));
  const Bvh bvh =
      medians ? buildMedianBvh(prepared.boxes, prepared.typeStarts()) : buildBvh(prepared.boxes, prepared.typeStarts());
  test::renderer().upload(packScene(prepared, bvh, settings, cubes));
  return test::renderer().render(test::kernel(), settings, {}, dispatching).image;
}

// A scene of coplanar and coinciding triangles, seen directly and in a mirror.
Scene coplanarScene(bool copies) {
  Scene scene = trianglesSeenFromOrigin();
  scene.background = {0.1, 0.2, 0.3};
  scene.lights = {{.position = {1, 2, 1}}};
  const uint32_t red = closed_form::addMaterial(scene, closed_form::matte({1, 0, 0}));
  const uint32_t green = closed_form::addMaterial(scene, closed_form::matte({0, 1, 0}));
  const uint32_t mirror = closed_form::addMaterial(scene, closed_form::mirror(1));
  const dvec3 a(-1.1, -0.7, -2.3), b(1.3, -0.9, -2.9), c(0.2, 1.1, -3.1);
  if (copies) {
    for (uint32_t i = 0; i < 1000; ++i) scene.addTriangle({a, b, c}, i % 2 ? green : red);
  } else {
    scene.addTriangle({a, b, c}, red);
    scene.addTriangle({glm::mix(a, b, 0.2), glm::mix(b, c, 0.3), glm::mix(c, a, 0.1)}, green);
  }
  closed_form::addQuad(scene, {-4, -4, 1.5}, {0, 8, 0}, {8, 0, 0.5}, mirror);
  return scene;
}

void coplanarOverlap(const Bench&, Report& report) {
  // Copies: what is lit is red alone.
  const Scene copies = coplanarScene(true);
  const Image picture = test::renderShader(copies, test::settingsOf(copies, 128, 128));
  size_t red = 0, green = 0;
  for (size_t i = 0; i < picture.rgb.size(); i += 3) {
    const bool isBackground = picture.rgb[i + 2] > 0.05f;
    red += !isBackground && picture.rgb[i] > 0;
    green += !isBackground && picture.rgb[i + 1] > 0;
  }
  report.atMost(fmt::format("1000 copies: pixels of another than the first, of {}", red + green),
                red > 1000 ? double(green) : NAN, 0);

  for (const bool copied : {true, false}) {
    const Scene scene = coplanarScene(copied);
    const RenderSettings settings = test::settingsOf(scene, copied ? 40 : 256, copied ? 40 : 256);
    const Image first = renderWith(scene, settings, false, TraversalStart::lists, {});
    size_t differing = 0;
    int pictures = 0;
    for (const bool medians : {false, true})
      for (const TraversalStart cubes : {TraversalStart::lists, TraversalStart::mixedLists, TraversalStart::wholeTree})
        for (const int workGroup : {16, 64, 128, 256}) {
          Dispatching dispatching;
          dispatching.workGroup = workGroup;
          dispatching.tile = workGroup;
          differing += differingValues(first, renderWith(scene, settings, medians, cubes, dispatching));
          ++pictures;
        }
    report.atMost(fmt::format("{}: differing values of {} pictures, by builder, lists, work-group and tile",
                              copied ? "copies" : "overlap in one plane", pictures),
                  double(differing), 0);
  }
}

// --- 17 ---

void edgeOn(const Bench& bench, Report& report) {
  Random random = bench.random(17);
  // A fan of large triangles with float vertices; rays from off their planes by a small angle, aimed at their insides.
  Scene scene = trianglesSeenFromOrigin();
  for (int i = 0; i < 64; ++i) {
    const dvec3 at = 300.0 * randomDirection(random);
    scene.addTriangle({at + 300.0 * randomDirection(random), at + 300.0 * randomDirection(random),
                       at + 300.0 * randomDirection(random)});
  }
  Both<Worst> excess;
  Both<size_t> notNumbers;
  size_t hits = 0;
  for (const double degrees : {0.52, 1e-3, 1e-5}) {
    for (const Triangle& triangle : scene.triangles) {
      Scene one = trianglesSeenFromOrigin();
      one.addTriangle(scene.cornersOf(triangle));
      bench.kernels.setScene(one);
      const auto& v = bench.kernels.local().cornersOf(0);
      const dvec3 normal = glm::normalize(glm::cross(v[1] - v[0], v[2] - v[0]));
      std::vector<Query> queries;
      for (size_t i = 0; i < bench.effort.rays(1e6, 1e5) / 192; ++i) {
        const dvec3 target = aimAt(v, 2, random);
        dvec3 a, b;
        basisOf(normal, a, b);
        const double phi = uniform(random, 0, 2 * std::numbers::pi), angle = degrees * closed_form::kDegree;
        const dvec3 d = std::cos(angle) * (std::cos(phi) * a + std::sin(phi) * b) + std::sin(angle) * normal;
        const vec3 origin(target - uniform(random, 10, 600) * d);
        queries.push_back({TestRay{origin, vec3(d)}});
      }
      for (const Tracer tracer : kTracers) {
        const std::vector<Found> found = bench.kernels.trace(queries, tracer);
        for (size_t i = 0; i < found.size(); ++i) {
          notNumbers.of(tracer) += std::isnan(found[i].t);
          if (!found[i].hits()) continue;
          hits += tracer == Tracer::turner;
          // Depths along the ray's largest component.
          double least = INFINITY, most = -INFINITY;
          const dvec3 d(queries[i].ray.direction), size = glm::abs(d);
          const int axis = size.x > size.y ? (size.x > size.z ? 0 : 2) : size.y > size.z ? 1 : 2;
          for (const dvec3& vertex : v) {
            const double depth = (vertex[axis] - double(queries[i].ray.origin[axis])) / d[axis];
            least = std::min(least, depth), most = std::max(most, depth);
          }
          excess.of(tracer).add(std::max({0.0, least - found[i].t, found[i].t - most}) / std::max(1.0, most));
        }
      }
    }
  }
  report.atMost(fmt::format("0.52, 1e-3 and 1e-5 degrees: t beyond the vertices' depths, relative, {} hits", hits),
                hits > 0 ? excess.turner.value : NAN, 4e-7, excess.naive.value, "four roundings");

  // Exactly in the plane: coordinates and directions that float32 has.
  scene = trianglesSeenFromOrigin();
  scene.addTriangle({dvec3(1, 0, -4), dvec3(3, 0, -5), dvec3(2, 0, -7)});
  scene.addTriangle({dvec3(1, 1, -4), dvec3(3, 3, -5), dvec3(2, 2, -7)});
  bench.kernels.setScene(scene);
  std::vector<Query> inPlane;
  for (int i = -8; i <= 8; ++i)
    for (int k = -8; k <= 8; ++k) {
      if (i == 0 && k == 0) continue;
      inPlane.push_back({TestRay{vec3(2 - 4 * i, 0, -5 - 4 * k), vec3(i, 0, k)}});
      inPlane.push_back({TestRay{vec3(2 - 4 * i, 2 - 4 * i, -5 - 4 * k), vec3(i, i, k)}});
    }
  // Rays of the one plane may cross the other triangle: they are asked for their own only.
  const auto hitsOwn = [&](Tracer tracer) {
    size_t count = 0;
    const std::vector<Found> found = bench.kernels.trace(inPlane, tracer);
    for (size_t i = 0; i < found.size(); ++i) {
      notNumbers.of(tracer) += std::isnan(found[i].t);
      count += found[i].hits() && found[i].id == i % 2;
    }
    return double(count);
  };
  const double own = hitsOwn(Tracer::turner), ownNaively = hitsOwn(Tracer::naive);
  report.atMost(fmt::format("hits of {} rays exactly in the plane", inPlane.size()), own, 0, ownNaively);
  report.atMost("distances that are NaN", double(notNumbers.turner), 0, double(notNumbers.naive));
}

// --- 18 ---

// A floor of cells whose corners float32 has exactly, so that all its triangles are in one plane.
Scene tessellatedFloor(const dvec3& corner, const dvec3& edge1, const dvec3& edge2, int cells) {
  Scene scene = trianglesSeenFromOrigin();
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j)
      closed_form::addQuad(scene, corner + double(i) * edge1 + double(j) * edge2, edge1, edge2, 0);
  return scene;
}

void tessellatedFloors(const Bench& bench, Report& report) {
  struct Floor {
    const char* name;
    dvec3 edge1, edge2, below;  // of a cell; from the eye to the middle of the floor
  };
  const double cm = 0x1p-7;
  const Floor floors[] = {
      {"level, cells 2^-7", {0, 0, cm}, {cm, 0, 0}, {3 * cm, -5 * cm, cm}},
      {"level, cells 1", {0, 0, 1}, {1, 0, 0}, {2, -5, 3}},
      {"level, cells 1000", {0, 0, 1000}, {1000, 0, 0}, {300, -1.5, 200}},
      // (2, 3, 6) / 7 is their normal.
      {"tilted, cells of 7", {-3, -6, 4}, {6, -4, 0}, {-8, -15, -28}},
      {"tilted, cells of 7/1024", dvec3(-3, -6, 4) / 1024.0, dvec3(6, -4, 0) / 1024.0, dvec3(-0.5, -3.25, -4.125)},
  };
  bench.kernels.setLeastDistance(kUsualEpsilon);
  Both<size_t> shadowed;
  size_t samples = 0;
  for (const Floor& floor : floors) {
    constexpr int kCells = 64;
    bench.kernels.setScene(
        tessellatedFloor(floor.below - 0.5 * kCells * (floor.edge1 + floor.edge2), floor.edge1, floor.edge2, kCells));
    const dvec3 up = glm::normalize(glm::cross(floor.edge1, floor.edge2));
    Random random = bench.random(18);
    Bench::inBatches(bench.effort.rays(1e7, 5e5) / 5, [&](size_t count) {
      std::vector<Query> queries;
      for (size_t i = 0; i < count; ++i) {
        // A third of the rays on lines between cells, a third on diagonals.
        double u = uniform(random, -20, 20), v = uniform(random, -20, 20);
        if (i % 3 == 0) u = std::round(u);
        if (i % 3 == 1) v = std::round(v) + (u - std::floor(u));
        const dvec3 target = floor.below + u * floor.edge1 + v * floor.edge2;
        const double phi = uniform(random, 0, 2 * std::numbers::pi), angle = 0.01 * closed_form::kDegree;
        const double far = 1000 * glm::length(floor.edge1);
        const dvec3 along =
            std::cos(phi) * glm::normalize(floor.edge1) + std::sin(phi) * glm::cross(up, glm::normalize(floor.edge1));
        const dvec3 light = target + far * (std::cos(angle) * along + std::sin(angle) * up);
        queries.push_back({TestRay{vec3(0), vec3(glm::normalize(target))}, 0, Next::light, vec3(light)});
      }
      for (const Tracer tracer : kTracers) {
        const std::vector<Found> seen = bench.kernels.trace(queries, tracer);
        std::vector<Query> shadows;
        for (const Found& found : seen) {
          shadowed.of(tracer) += !found.leaves;
          if (found.leaves) shadows.push_back({found.leaving, 1});
        }
        for (const Found& found : bench.kernels.trace(shadows, tracer)) shadowed.of(tracer) += found.hits();
      }
      samples += count;
    });
  }
  report.atMost(fmt::format("shadowed of {:.2g} samples on floors, light at 0.01 degrees", double(samples)),
                double(shadowed.turner), 0, double(shadowed.naive));
}

}  // namespace

std::vector<Case> triangleCases() {
  return {{11, "Watertight icosphere", watertightIcosphere},
          {12, "Watertight elsewhere", watertightElsewhere},
          {13, "Diagonals of quads", quadDiagonal},
          {14, "Needles", needles},
          {15, "Triangles without area", zeroArea},
          {16, "Copies and overlap in a plane", coplanarOverlap},
          {17, "Seen edge-on", edgeOn},
          {18, "Tessellated floors", tessellatedFloors}};
}

}  // namespace turner::hard
