// Shading: no number is not a number.
#include <fmt/format.h>

#include <array>
#include <cfloat>
#include <cmath>
#include <glm/geometric.hpp>

#include "hard/cases.h"
#include "hard/formulas.h"
#include "hard/pictures.h"
#include "hard/vectors.h"

namespace turner::hard {
namespace {

constexpr std::array<float, 8> kExponents = {0, 1, 3.0827f, 4.81884f, 20, 101.148f, 1000, 1e4f};

// The catalogue's bar for a highlight's relative error.
double highlightBar(float n) {
  return 1e-6 + 3e-7 * double(n);
}

// max(0, N.H)^n and its condition, from the float32 numbers that the kernel gets; N is taken for its direction, V as it
// is: its length, a rounding from 1, turns H.
struct Highlight {
  long double value;
  double ofOneRounding;  // how much an error of 2^-23 in L, V, N and H, relative, moves it, relative
};

Highlight highlightOf(const Lit& lit) {
  const auto unit = [](const Wide3& v) {
    const Wide length = squareRoot(dot(v, v));
    return Wide3{v.x / length, v.y / length, v.z / length};
  };
  const Wide3 L = unit(wide(dvec3(lit.light)) - wide(dvec3(lit.point))), V = wide(dvec3(lit.V));
  const Wide3 sum = {L.x + V.x, L.y + V.y, L.z + V.z};
  const Wide length = squareRoot(dot(sum, sum)), cosine = dot(unit(wide(dvec3(lit.N))), unit(sum));
  const double tangent = double(squareRoot(1 - cosine * cosine) / cosine);
  return {std::pow(std::max((long double)cosine, 0.0L), (long double)lit.shininess),
          std::expm1(lit.shininess * tangent * (1 + 1 / double(length)) * 0x1p-23)};
}

// From where N and H are one down to where the light and the eye both graze the surface.
Lit randomHighlight(Random& random, float n) {
  for (;;) {
    const dvec3 N = randomDirection(random), V = randomDirection(random);
    dvec3 a, b;
    basisOf(N, a, b);
    const double tilt = std::exp(uniform(random, std::log(1e-5), std::log(1.57)));
    const double turn = uniform(random, 0, 2 * std::numbers::pi);
    const dvec3 H = std::cos(tilt) * N + std::sin(tilt) * (std::cos(turn) * a + std::sin(turn) * b);
    const dvec3 L = 2 * glm::dot(V, H) * H - V;
    if (glm::dot(N, V) <= 0 || glm::dot(N, L) <= 0) continue;
    Lit lit;
    lit.point = vec3(uniform(random, 0, 2) * randomDirection(random));
    lit.light = vec3(dvec3(lit.point) + std::exp(uniform(random, -4, 4)) * L);
    lit.N = vec3(N);
    lit.V = vec3(V);
    lit.shininess = n;
    lit.q = random() % 2 ? float(uniform(random, 0, 1)) : float(std::exp2(-uniform(random, 0, 30)));
    return lit;
  }
}

// The same surface, once matte and once glossy: the quotient is the highlight without N.L.
std::vector<Lit> matteAndGlossy(size_t count, float n, Random& random) {
  std::vector<Lit> lits;
  for (size_t i = 0; i < count; ++i) {
    Lit lit = randomHighlight(random, n);
    lit.diffuse = vec3(1);
    lits.push_back(lit);
    std::swap(lit.diffuse, lit.specular);
    lits.push_back(lit);
  }
  return lits;
}

struct HighlightErrors {
  double power = 0;      // of (1 - q)^n, relative
  double highlight = 0;  // of max(0, N.H)^n, relative, beyond that of the input's last bits
};

HighlightErrors highlightErrors(const std::vector<Lit>& lits, const std::vector<Reflected>& found) {
  HighlightErrors errors;
  for (size_t i = 0; i < lits.size(); i += 2) {
    // Below the least normal float32 nothing is seen, nor promised.
    const long double power = std::pow(1 - (long double)lits[i].q, (long double)lits[i].shininess);
    if (power >= FLT_MIN) errors.power = worse(std::abs(double(found[i].power / power - 1)), errors.power);
    const Highlight exact = highlightOf(lits[i]);
    if (exact.value < FLT_MIN) continue;
    const double highlight = double(found[i + 1].radiance.x) / double(found[i].radiance.x);
    const double relative = std::abs(double(highlight / exact.value - 1));
    errors.highlight = worse(relative - exact.ofOneRounding, errors.highlight);
  }
  return errors;
}

void measureHighlights(const Formulas& formulas, const Bench& bench, Report& report) {
  Random random = bench.random(39);
  for (const float n : kExponents) {
    HighlightErrors turner, naive;
    Bench::inBatches(bench.effort.rays(3e5, 2e4), [&](size_t count) {
      const std::vector<Lit> lits = matteAndGlossy(count, n, random);
      const auto add = [&](HighlightErrors& all, Tracer tracer) {
        const HighlightErrors errors = highlightErrors(lits, formulas.evaluate(lits, tracer));
        all = {worse(errors.power, all.power), worse(errors.highlight, all.highlight)};
      };
      add(turner, Tracer::turner);
      add(naive, Tracer::naive);
    });
    report.atMost(fmt::format("relative error of (1 - q)^n, n = {:g}", n), turner.power, highlightBar(n), naive.power);
    report.atMost(fmt::format("relative error of (N.H)^n, n = {:g}, beyond what 2^-23 in L, V and N does", n),
                  turner.highlight, highlightBar(n), naive.highlight);
  }
}

// Every formula's poles: H = 0 (V = -L), N.H < 0, N = 0, a light on the surface, exponents and intensities out of
// range.
std::vector<Lit> singularLits() {
  std::vector<Lit> lits;
  const vec3 up(0, 0, 1), slanted(0.6f, 0, 0.8f);
  for (const vec3& N : {up, slanted, vec3(0)})
    for (const vec3& V : {up, -up, slanted, vec3(1, 0, 0), vec3(-0.8f, 0, 0.6f), vec3(0)})
      for (const float distance : {0.0f, 1e-30f, 1e-15f, 1e-6f, 1.0f, 1e15f})
        for (const float shininess : {0.0f, 1.0f, 0.5f, 1e4f, 1e30f})
          for (const float E : {0.0f, 1.0f, 1e30f})
            for (const bool fallsOff : {false, true}) {
              // Where 1/d^2 itself takes the light beyond float32 there is no number to give.
              if (fallsOff && distance > 0 && E / double(distance) / double(distance) > FLT_MAX) continue;
              lits.push_back({{}, N, V, distance * up, fallsOff, vec3(E), vec3(0.5f), vec3(0.5f), shininess, 1});
            }
  return lits;
}

// Of the lights whose H is 0 or not above the surface, those whose radiance is not k_d E N.L (with n = 0 a highlight is
// 1 wherever there is an H).
size_t wrongWithoutHighlight(const std::vector<Lit>& lits, const std::vector<Reflected>& found) {
  size_t wrong = 0;
  for (size_t i = 0; i < lits.size(); ++i) {
    const Lit& lit = lits[i];
    const dvec3 L(0, 0, 1), H = dvec3(lit.V) + L;
    const double NL = lit.N.z, distance = lit.light.z;
    if (distance == 0 || (H != dvec3(0) && glm::dot(dvec3(lit.N), H) > 0)) continue;
    const double highlight = H != dvec3(0) && lit.shininess == 0 ? 1 : 0;
    const double E = lit.E.x / (lit.fallsOff ? distance * distance : 1);
    const double exact = E * (lit.diffuse.x + lit.specular.x * highlight) * NL;
    wrong += !(std::abs(found[i].radiance.x - exact) <= 1e-6 * exact);
  }
  return wrong;
}

size_t countNotFinite(const std::vector<Reflected>& found) {
  return size_t(std::count_if(found.begin(), found.end(), [](const Reflected& reflected) {
    return !std::isfinite(reflected.radiance.x) || !std::isfinite(reflected.power);
  }));
}

// Spheres and a floor under lights at the eye, on the floor, on a sphere, behind the eye and far away; over the floor a
// sheet whose vertex normals cancel out along a line.
Scene singularScene(double shininess, double intensity, Falloff falloff) {
  Scene scene;
  scene.background = {0.1, 0.1, 0.1};
  scene.camera = {.eye = {0, 1, 4}, .target = {0, 0.5, 0}};
  scene.materials = {{.diffuse = dvec3(0.3), .specular = dvec3(0.4), .shininess = shininess, .localWeight = 1},
                     {.diffuse = dvec3(0.3),
                      .specular = dvec3(0.4),
                      .shininess = shininess,
                      .reflect = 0.3,
                      .transmit = 0.3,
                      .localWeight = 0.4}};
  scene.spheres = {{{-0.7, 0.5, 0}, 0.5, 0}, {{0.7, 0.5, 0}, 0.5, 1}};
  scene.addTriangle({dvec3(-3, 0, 3), dvec3(3, 0, 3), dvec3(3, 0, -3)});
  scene.addTriangle({dvec3(-3, 0, 3), dvec3(3, 0, -3), dvec3(-3, 0, -3)});
  scene.addTriangle({dvec3(-2, 1.2, -1), dvec3(2, 1.2, -1), dvec3(0, 2.5, -1)},
                    {dvec3(0, 0, 1), dvec3(0, 0, -1), dvec3(0, 0, 1)});
  for (const dvec3& position : {dvec3(0, 1, 4), dvec3(0, 0, 0.5), dvec3(-0.7, 1, 0), dvec3(0, 3, 9), dvec3(0, 1e9, 0)})
    scene.lights.push_back({position, dvec3(intensity), falloff});
  return scene;
}

void singularShading(const Bench& bench, Report& report) {
  const Formulas formulas;
  measureHighlights(formulas, bench, report);

  const std::vector<Lit> lits = singularLits();
  report.atMost(fmt::format("not finite, of {} singular lights and surfaces", lits.size()),
                double(countNotFinite(formulas.evaluate(lits))), 0,
                double(countNotFinite(formulas.evaluate(lits, Tracer::naive))));
  report.atMost("wrong where H is 0 or below the surface, of the same",
                double(wrongWithoutHighlight(lits, formulas.evaluate(lits))), 0,
                double(wrongWithoutHighlight(lits, formulas.evaluate(lits, Tracer::naive))));
  size_t notFinite = 0, values = 0;
  const int size = bench.effort.full ? 400 : 60;
  for (const double shininess : {0.0, 1.0, 1e4})
    for (const double intensity : {1.0, 1e30})
      for (const Falloff falloff : {Falloff::none, Falloff::inverseSquare}) {
        const Scene scene = singularScene(shininess, intensity, falloff);
        const Image image = test::renderShader(scene, test::settingsOf(scene, size, size, 2));
        notFinite += notFiniteValues(image);
        values += image.rgb.size();
      }
  report.atMost(fmt::format("not finite, of {} values in 12 pictures", values), double(notFinite), 0);

  // A sheet right before the eye, where the light is: the square of their distance is 0 in float32.
  Scene near = singularScene(1, 1, Falloff::none);
  near.spheres.clear();
  near.triangles.clear();
  near.camera = {.eye = {0, 0, 0}, .target = {0, 0, -1}};
  near.lights = {{near.camera.eye}};
  near.addTriangle({dvec3(-1, -1, -1e-25), dvec3(1, -1, -1e-25), dvec3(0, 2, -1e-25)});
  report.atMost("not finite, in a picture with a light 1e-25 from a surface",
                double(notFiniteValues(test::renderShader(near, test::settingsOf(near, 16, 16)))), 0);
}

}  // namespace

std::vector<Case> shadingCases() {
  return {{39, "Singular shading", singularShading}};
}

}  // namespace turner::hard
