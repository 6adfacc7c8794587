// Shading, input and sampling: no number is not a number, no input is believed blindly, and the picture depends on the
// scene alone.
#include <fmt/format.h>

#include <array>
#include <bit>
#include <cfloat>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <optional>
#include <regex>
#include <sstream>

#include "base/errors.h"
#include "base/text_file.h"
#include "hard/cases.h"
#include "hard/formulas.h"
#include "hard/pictures.h"
#include "hard/vectors.h"
#include "reference/reference.h"
#include "scene/scene_load.h"
#include "support/temporary_folder.h"

namespace turner::hard {
namespace {

size_t countNotFinite(const Image& image) {
  return size_t(std::count_if(image.rgb.begin(), image.rgb.end(), [](float value) { return !std::isfinite(value); }));
}

// The larger of two errors; a NaN stays.
double worse(double a, double b) {
  return a >= b || std::isnan(a) ? a : b;
}

// --- 39 ---

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
        notFinite += countNotFinite(image);
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
                double(countNotFinite(test::renderShader(near, test::settingsOf(near, 16, 16)))), 0);
}

// --- 40 ---

// A folder for scene files.
class Folder {
 public:
  std::string write(const std::string& name, const std::string& text) const {
    const std::string path = (folder_.path / name).string();
    std::filesystem::remove(path);  // writing over a file makes some file systems wait for the disk
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }
  std::string path() const { return folder_.path.string(); }

 private:
  test::TemporaryFolder folder_;
};

// What becomes of a scene file.
struct Loaded {
  std::optional<Scene> scene;  // none: refused
  std::string refusal;         // what the user is told
  bool otherException = false;
  double seconds = 0;
};

Loaded load(const std::string& path) {
  Loaded loaded;
  const auto start = std::chrono::steady_clock::now();
  try {
    loaded.scene = loadScene(path);
  } catch (const InputError& error) {
    loaded.refusal = error.what();
  } catch (const std::exception& error) {
    loaded.refusal = error.what();
    loaded.otherException = true;
  }
  loaded.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return loaded;
}

const std::string kSoundJson = R"({
  "background": [0.1, 0.2, 0.3], "depth": 4, "width": 8, "height": 6,
  "camera": { "eye": [0, 1, 5], "target": [0, 0, 0], "up": [0, 1, 0], "fov": 40 },
  "lights": [{ "position": [0, 5, 5], "color": [1, 1, 1], "falloff": "inverse-square" }],
  "materials": {
    "matte": { "diffuse": [0.5, 0.5, 0.5], "shininess": 3 },
    "glass": { "specular": [1, 1, 1], "reflect": 0.2, "transmit": 0.7, "ior": 1.5 } },
  "spheres": [{ "center": [0, 0, 0], "radius": 1, "material": "glass" }],
  "triangles": [{ "vertices": [[-2, -1, 2], [2, -1, 2], [0, -1, -2]],
                  "normals": [[0, 1, 0], [0, 1, 0], [0, 1, 0]], "material": "matte" }],
  "meshes": [{ "file": "mesh.obj", "material": "matte", "scale": 1, "rotate": [0, 90, 0], "translate": [1, 0, 0] }]
}
)";
const std::string kSoundObj =
    "# a square\nv -1 0 0\nv 1 0 0\nv 1 1 0\nv -1 1 0\nvn 0 0 1\nf 1 2 3 4\nf -4//1 -3//1 -2//1\nf 1//1 2//1 3//1\n";
const std::string kSoundNff =
    "b 0.1 0.2 0.3\nv\nfrom 0 1 5\nat 0 0 0\nup 0 1 0\nangle 45\nhither 1\nresolution 8 6\nl 1 2 3\nl 4 5 6 1 1 1\n"
    "f 1 0.5 0.25 0.8 0.5 3 0.25 1.5\ns 0 0 0 1\nc\n0 -1 0 0.5\n0 0 0 0\np 4\n-2 -1 2\n2 -1 2\n2 -1 -2\n-2 -1 -2\n"
    "f 1 1 1 1 0 0 0 0\npp 3\n0 0 0 0 0 1\n1 0 0 0 0 2\n0 1 0 0 1 1\n";

// A sound file in which one thing is wrong, and the words that must be in the refusal.
struct Fault {
  std::string file;  // "json", "nff" or "obj"
  std::string sound, wrong;
  std::string named;
};

std::vector<Fault> listedFaults() {
  std::vector<Fault> faults;
  for (const std::string number : {"NaN", "Infinity", "-Infinity", "1e39", "-1e39", "1e400"}) {
    faults.push_back({"json", "\"radius\": 1", "\"radius\": " + number, "radius"});
    faults.push_back({"json", "\"center\": [0,", "\"center\": [" + number + ",", "center"});
    faults.push_back({"json", "[[-2,", "[[" + number + ",", "vertices"});
    faults.push_back({"json", "\"eye\": [0,", "\"eye\": [" + number + ",", "eye"});
    faults.push_back({"json", "\"scale\": 1", "\"scale\": " + number, "scale"});
    faults.push_back({"nff", "s 0 0 0 1", "s 0 0 0 " + number, number});
    faults.push_back({"obj", "v -1 0 0", "v " + number + " 0 0", number});
  }
  for (const std::string radius : {"0", "-1", "-0.0", "1e-400"})
    faults.push_back({"json", "\"radius\": 1", "\"radius\": " + radius, "spheres[0].radius"});
  for (const std::string eta : {"0", "-1.5"})
    faults.push_back({"json", "\"ior\": 1.5", "\"ior\": " + eta, "materials.glass.ior"});
  for (const std::string fov : {"0", "180", "-40", "1e9"})
    faults.push_back({"json", "\"fov\": 40", "\"fov\": " + fov, "camera.fov"});
  for (const std::string size : {"0", "-8", "7.5", "65537", "1e12", "\"8\""}) {
    faults.push_back({"json", "\"width\": 8", "\"width\": " + size, "width"});
    faults.push_back({"json", "\"height\": 6", "\"height\": " + size, "height"});
  }
  for (const std::string depth : {"0", "-1", "65", "2.5"})
    faults.push_back({"json", "\"depth\": 4", "\"depth\": " + depth, "depth"});
  for (const std::string index : {"0", "5", "-5", "99999999999999999999", "1.5", "x"})
    faults.push_back({"obj", "f 1 2 3 4", "f " + index + " 2 3 4", index});
  const std::vector<Fault> others = {
      {"json", "\"reflect\": 0.2", "\"reflect\": 0.31", "materials.glass: reflect and transmit"},
      {"json", "\"reflect\": 0.2", "\"reflect\": -0.2", "materials.glass.reflect"},
      {"json", "\"transmit\": 0.7", "\"transmit\": 1.7", "materials.glass.transmit"},
      {"json", "\"up\": [0, 1, 0]", "\"up\": [0, 1, 5]", "camera: up is parallel"},
      {"json", "\"up\": [0, 1, 0]", "\"up\": [0, -2, -10]", "camera: up is parallel"},
      {"json", "\"up\": [0, 1, 0]", "\"up\": [0, 0, 0]", "camera: up is"},
      {"json", "\"target\": [0, 0, 0]", "\"target\": [0, 1, 5]", "camera: eye and target"},
      {"json", "[[0, 1, 0], [0", "[[0, 0, 0], [0", "triangles[0].normals[0]"},
      {"json", "\"color\": [1,", "\"color\": [-1,", "lights[0].color"},
      {"json", "\"diffuse\": [0.5,", "\"diffuse\": [-0.5,", "materials.matte.diffuse"},
      {"json", "\"shininess\": 3", "\"shininess\": -3", "materials.matte.shininess"},
      {"json", "\"material\": \"glass\"", "\"material\": \"glas\"", "spheres[0].material"},
      {"json", "\"scale\": 1", "\"scale\": 0", "meshes[0].scale"},
      {"json", "mesh.obj", "none.obj", "meshes[0].file"},
      {"json", "[0, -1, -2]]", "[0, -1]]", "triangles[0].vertices[2]"},
      {"json", ", [0, -1, -2]]", "]", "triangles[0].vertices"},
      {"json", "\"falloff\": \"inverse-square\"", "\"falloff\": \"cubic\"", "lights[0].falloff"},
      {"json", "}\n", "", "the file ends"},
      {"nff", "s 0 0 0 1\n", "s 0 0 0 0\n", "radius"},
      {"nff", "angle 45", "angle 0", "angle"},
      {"nff", "angle 45", "angle 180", "angle"},
      {"nff", "up 0 1 0", "up 0 1 5", "up"},
      {"nff", "resolution 8 6", "resolution 0 6", "size in pixels"},
      {"nff", "0.25 1.5\n", "0.25 0\n", "index"},
      {"nff", "f 1 0.5", "f -1 0.5", "colour"},
      {"nff", "1 0 0 0 0 2\n0 1 0 0 1 1\n", "1 0 0 0 0 2\n", "polygon"},
      {"nff", "s 0 0 0 1\n", "s 0 0 0\n", "radius"},
  };
  faults.insert(faults.end(), others.begin(), others.end());
  return faults;
}

// Whether every line of a refusal begins with a file of the folder and ends in words; it tells the line of the file
// unless the file cannot be read at all.
bool namesItsPlace(const std::string& refusal, const Folder& folder) {
  static const std::regex line(".*/[a-z]+\\.(json|nff|obj):[0-9]+:[0-9]+: error: .+");
  std::istringstream lines(refusal);
  bool names = !refusal.empty();
  for (std::string text; std::getline(lines, text);)
    names = names && text.starts_with(folder.path()) && std::regex_match(text, line);
  return names;
}

Loaded loadText(const Folder& folder, const std::string& kind, const std::string& text) {
  folder.write("mesh.obj", kind == "obj" ? text : kSoundObj);
  return load(kind == "nff" ? folder.write("scene.nff", text)
                            : folder.write("scene.json", kind == "json" ? text : kSoundJson));
}

const std::string& soundText(const std::string& kind) {
  return kind == "json" ? kSoundJson : kind == "nff" ? kSoundNff : kSoundObj;
}

struct Missed {
  size_t taken = 0;    // or refused without file and line
  size_t unnamed = 0;  // refused without the name of what is wrong
  std::string first;
};

Missed faultsMissed(const Folder& folder) {
  Missed missed;
  for (const Fault& fault : listedFaults()) {
    std::string text = soundText(fault.file);
    const size_t at = text.rfind(fault.sound);
    if (at == std::string::npos) throw RunError("the sound file lacks " + fault.sound);
    text.replace(at, fault.sound.size(), fault.wrong);
    const Loaded loaded = loadText(folder, fault.file, text);
    const bool isRefused = !loaded.scene && !loaded.otherException && namesItsPlace(loaded.refusal, folder);
    const bool isNamed = loaded.refusal.find(fault.named) != std::string::npos;
    missed.taken += !isRefused;
    missed.unnamed += isRefused && !isNamed;
    if ((!isRefused || !isNamed) && missed.first.empty()) missed.first = "the first: " + fault.wrong;
  }
  return missed;
}

// One or two small damages: bytes changed, pieces cut out, doubled or exchanged for a number that nobody expects.
std::string damaged(std::string text, Random& random) {
  static const std::vector<std::string> kHostile = {
      "NaN",    "inf",  "-inf", "1e39", "-1e39",      "1e400",
      "1e-400", "0",    "-0",   "-1",   "4294967296", "99999999999999999999",
      "0x10",   "1e",   "1.",   "null", "true",       "[]",
      "{}",     "\"\"", "\xff", "1e30"};
  const auto place = [&] { return text.empty() ? 0 : size_t(random() % text.size()); };
  for (uint64_t k = 1 + random() % 2; k > 0; --k) {
    const size_t at = place(), length = 1 + random() % 20;
    switch (random() % 6) {
      case 0:
        if (!text.empty()) text[at] = char(random());
        break;
      case 1:
        text.erase(at, length);
        break;
      case 2:
        text.insert(at, text.substr(place(), length));
        break;
      case 3:
        if (random() % 8 == 0) text.resize(at);  // cut off
        break;
      default: {  // the next number becomes another
        const size_t begin = text.find_first_of("0123456789", at);
        if (begin == std::string::npos) break;
        const size_t end = text.find_first_not_of("0123456789.eE", begin);
        text.replace(begin, end == std::string::npos ? end : end - begin, kHostile[random() % kHostile.size()]);
      }
    }
  }
  return text;
}

// Whether all that the loader vouches for holds.
bool isSound(const Scene& scene) {
  const auto finite = [](const dvec3& v) { return std::isfinite(v.x + v.y + v.z); };
  bool sound = finite(scene.background) && scene.depth >= 1 && scene.depth <= kMaxDepth && scene.width >= 1 &&
               scene.width <= kMaxSize && scene.height >= 1 && scene.height <= kMaxSize;
  const Camera& camera = scene.camera;
  sound = sound && finite(camera.eye) && finite(camera.target) && camera.fov > 0 && camera.fov < 180 &&
          glm::length(glm::cross(glm::normalize(camera.target - camera.eye), glm::normalize(camera.up))) > 1e-10;
  for (const Light& light : scene.lights) sound = sound && finite(light.position) && finite(light.color);
  for (const Material& m : scene.materials)
    sound = sound && finite(m.diffuse) && finite(m.specular) && m.shininess >= 0 && std::isfinite(m.shininess) &&
            m.reflect >= 0 && m.transmit >= 0 && (m.transmit == 0 || (m.eta > 0 && std::isfinite(m.eta)));
  for (const Sphere& sphere : scene.spheres)
    sound = sound && finite(sphere.center) && sphere.radius != 0 && std::isfinite(sphere.radius) &&
            sphere.material < scene.materials.size();
  for (const Triangle& triangle : scene.triangles) {
    for (const uint32_t i : triangle.positions)
      sound = sound && i < scene.positions.size() && finite(scene.positions[i]);
    for (const uint32_t i : triangle.normals)
      sound = sound && (triangle.isSmooth() ? i < scene.normals.size() : i == kNoNormals);
    sound = sound && triangle.material < scene.materials.size();
  }
  return sound;
}

// Files to be damaged: the small sound ones, and the beginnings of real ones.
std::vector<std::pair<std::string, std::string>> textsToDamage() {
  std::vector<std::pair<std::string, std::string>> texts;
  for (const std::string kind : {"json", "nff", "obj"}) texts.emplace_back(kind, soundText(kind));
  constexpr size_t kMost = 20'000, kBeginning = 4'000;
  for (const std::string folder : {TURNER_SCENES_DIR, TURNER_SCENES_DIR "/spd"}) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".json" && extension != ".nff" && extension != ".obj") continue;
      const std::string text = readTextFile(entry.path().string());
      if (text.size() <= kMost) texts.emplace_back(extension.substr(1), text);
      if (extension == ".nff") texts.emplace_back("nff", text.substr(0, text.rfind('\n', kBeginning) + 1));
    }
  }
  std::sort(texts.begin(), texts.end());  // folders list their files in any order
  return texts;
}

struct Fuzz {
  size_t files = 0, taken = 0, otherExceptions = 0, withoutPlace = 0, unsound = 0, pictures = 0, notFinite = 0;
  double slowest = 0;
};

// Renders what was taken: at most refused by checkReach, else every value is a number.
void renderSmall(Scene scene, Fuzz& fuzz) {
  scene.depth = std::min(scene.depth, 5);  // deep trees of glass are right, and slow
  try {
    checkReach(roundScene(scene));
  } catch (const InputError&) {
    return;
  }
  ++fuzz.pictures;
  fuzz.notFinite += countNotFinite(test::renderShader(scene, test::settingsOf(scene, 16, 16))) > 0;
}

Fuzz fuzzed(const Folder& folder, size_t files, size_t pictures, Random& random) {
  const auto texts = textsToDamage();
  Fuzz fuzz;
  for (; fuzz.files < files; ++fuzz.files) {
    const auto& [kind, text] = texts[random() % texts.size()];
    const Loaded loaded = loadText(folder, kind, damaged(text, random));
    fuzz.slowest = std::max(fuzz.slowest, loaded.seconds);
    fuzz.otherExceptions += loaded.otherException;
    fuzz.withoutPlace += !loaded.scene && !namesItsPlace(loaded.refusal, folder);
    if (!loaded.scene) continue;
    ++fuzz.taken;
    fuzz.unsound += !isSound(*loaded.scene);
    if (fuzz.pictures < pictures) renderSmall(*loaded.scene, fuzz);
  }
  return fuzz;
}

// Values that are wrong in the picture of nothing, and in that of a matte sphere without light before the background.
size_t wrongWithoutLight(const Folder& folder) {
  const std::string background = "{ \"background\": [0.25, 0.5, 0.75]";
  const Loaded empty = load(folder.write("empty.json", background + "}")), noText = load(folder.write("no.json", "{}"));
  const Loaded dark = load(folder.write(
      "dark.json", background + R"(, "materials": { "clay": { "diffuse": [1, 1, 1], "specular": [1, 1, 1] } },
      "camera": { "eye": [0, 0, 4], "target": [0, 0, 0] },
      "spheres": [{ "center": [0, 0, 0], "material": "clay" }] })"));
  if (!empty.scene || !noText.scene || !dark.scene) return SIZE_MAX;
  size_t wrong = 0;
  const RenderSettings settings = test::settingsOf(*empty.scene, 64, 64);
  for (const float value : test::renderShader(*noText.scene, settings).rgb) wrong += value != 0;
  const Image sky = test::renderShader(*empty.scene, settings), silhouette = test::renderShader(*dark.scene, settings);
  const double halfSize = std::tan(22.5 * std::numbers::pi / 180);
  for (size_t i = 0; i < sky.rgb.size(); ++i) {
    const float expected = 0.25f * float(i % 3 + 1);
    wrong += sky.rgb[i] != expected;
    // Of the pixel's centre the ray passes the sphere's centre at sin(angle) times the distance.
    const double x = ((double(i / 3 % 64) + 0.5) / 32 - 1) * halfSize,
                 y = ((double(i / 192) + 0.5) / 32 - 1) * halfSize;
    const bool isHit = 16 * (x * x + y * y) < 1 + x * x + y * y;
    wrong += silhouette.rgb[i] != (isHit ? 0 : expected);
  }
  return wrong;
}

void badInput(const Bench& bench, Report& report) {
  const Folder folder;
  for (const std::string kind : {"json", "nff", "obj"})
    if (!loadText(folder, kind, soundText(kind)).scene) throw RunError("the sound " + kind + " file is refused");
  const Missed missed = faultsMissed(folder);
  const std::string listed = fmt::format("of {} listed faults, those ", listedFaults().size());
  report.atMost(listed + "taken, or refused without file and line", double(missed.taken), 0, {}, missed.first);
  report.atMost(listed + "refused without the name of the field", double(missed.unnamed), 0, {}, missed.first);
  Random random = bench.random(40);
  const Fuzz fuzz = fuzzed(folder, bench.effort.rays(1e5, 4000), bench.effort.rays(1000, 25), random);
  const std::string all = fmt::format("{} damaged files, {} of them taken: ", fuzz.files, fuzz.taken);
  report.atMost(all + "exceptions that no user's mistake explains", double(fuzz.otherExceptions), 0);
  report.atMost(all + "refusals without file and line", double(fuzz.withoutPlace), 0);
  report.atMost(all + "scenes with values that are not allowed", double(fuzz.unsound), 0);
  report.atMostSeconds(all + "seconds for the slowest", fuzz.slowest, 10);
  report.atMost(fmt::format("with NaN or Inf, of {} pictures of damaged scenes", fuzz.pictures), double(fuzz.notFinite),
                0);
  report.atMost("wrong values in pictures without objects or without lights", double(wrongWithoutLight(folder)), 0);
}

// --- 41 ---

Scene ours(const std::string& name) {
  return loadScene(std::string(TURNER_SCENES_DIR "/") + name + ".json");
}

const std::vector<std::string> kOurs = {"blinn_phong", "cliff_hanger", "cones",   "deep_glass", "diffuse",  "glass",
                                        "mirrors",     "shadows",      "spheres", "spot",       "triangles"};

// The same scene in another unit of length, or elsewhere: in double.
Scene changed(Scene scene, double scale, const dvec3& shift) {
  const auto change = [&](dvec3& point) { point = scale * point + shift; };
  change(scene.camera.eye);
  change(scene.camera.target);
  for (Light& light : scene.lights) {
    change(light.position);
    if (light.falloff == Falloff::inverseSquare) light.color *= scale * scale;
  }
  for (Sphere& sphere : scene.spheres) {
    change(sphere.center);
    sphere.radius *= scale;
  }
  for (Cone& cone : scene.cones) {
    change(cone.base);
    change(cone.apex);
    cone.baseRadius *= scale;
    cone.apexRadius *= scale;
  }
  for (dvec3& position : scene.positions) change(position);
  return scene;
}

RenderSettings settingsOfHeight(const Scene& scene, int height) {
  return test::settingsOf(scene, height * scene.width / scene.height, height);
}

// Whether a pixel lies off all edges, those in mirrors and shadows too: the double-precision picture stays as it is,
// within 1e-5, when all rays are turned by four roundings of float32, in eight directions.
std::vector<bool> pixelsOffEdges(const Scene& scene, const RenderSettings& settings) {
  const Image still = renderReference(scene, settings).image;
  std::vector<bool> isOff(still.rgb.size() / 3, true);
  const dvec3 view = scene.camera.target - scene.camera.eye;
  dvec3 a, b;
  basisOf(glm::normalize(view), a, b);
  for (int k = 0; k < 8; ++k) {
    const double turn = k * std::numbers::pi / 4;
    Scene turned = scene;
    turned.camera.target += 4 * 0x1p-24 * glm::length(view) * (std::cos(turn) * a + std::sin(turn) * b);
    const Image image = renderReference(turned, settings).image;
    for (size_t i = 0; i < image.rgb.size(); ++i)
      if (std::abs(image.rgb[i] - still.rgb[i]) > 1e-5f) isOff[i / 3] = false;
  }
  return isOff;
}

// What is left of a scene where its coordinates are float32 in its own unit, from its own origin.
Scene roundedWhereItIs(Scene scene) {
  const auto round = [](dvec3& point) { point = dvec3(vec3(point)); };
  round(scene.camera.eye);
  round(scene.camera.target);
  for (Light& light : scene.lights) round(light.position);
  for (Sphere& sphere : scene.spheres) round(sphere.center);
  for (Cone& cone : scene.cones) round(cone.base), round(cone.apex);
  for (dvec3& position : scene.positions) round(position);
  return scene;
}

// How a picture changes when its scene is moved or scaled.
struct Changes {
  double offEdges = 0;  // largest difference off edges
  double rmse = 0;      // over all pixels, of the worst picture
  std::string worst;    // the scene of the largest difference

  void add(const Image& a, const Image& b, const std::vector<bool>& isOff, const std::string& name) {
    double squares = 0;
    for (size_t i = 0; i < a.rgb.size(); ++i) {
      const double difference = std::abs(double(a.rgb[i]) - double(b.rgb[i]));
      squares += difference * difference;
      if (!isOff[i / 3] || difference <= offEdges || std::isnan(offEdges)) continue;
      offEdges = difference;
      worst = name;
    }
    rmse = worse(std::sqrt(squares / double(a.rgb.size())), rmse);
  }
};

// The changes of Turner's picture, of the double-precision one of what Turner's kernel gets, and of the naive one.
struct AllChanges {
  Changes turner, rounded, naive;

  // `reached`: what float32 leaves of a difference where coordinates are not the same but for a power of two.
  void report(const std::string& how, const std::optional<double>& reached, Report& report) const {
    const std::string offEdges = how + ": largest difference off edges";
    const std::string where =
        fmt::format("in {}; of it {:.2g} by rounding coordinates to float32", turner.worst, rounded.offEdges);
    if (reached) {
      report.knownMiss(offEdges, turner.offEdges, 1e-5,
                       {*reached, where + "; at full counts a ray of deep_glass decides otherwise at its eighth level"},
                       naive.offEdges);
      report.knownMiss(how + ": RMSE of the worst picture", turner.rmse, 1e-4, {2e-4, "likewise"}, naive.rmse);
    } else {
      report.atMost(offEdges, turner.offEdges, 1e-5, naive.offEdges, where);
      report.atMost(how + ": RMSE of the worst picture", turner.rmse, 1e-4, naive.rmse);
    }
  }
};

void invariance(const Bench& bench, Report& report) {
  const bool full = bench.effort.full;
  AllChanges moved, scaled;
  size_t differing = 0, pictures = 0, edgePixels = 0, pixels = 0;
  for (const std::string& name : kOurs) {
    const Scene scene = ours(name);
    RenderSettings settings = settingsOfHeight(scene, full ? 270 : 36);
    settings.depth = std::min(settings.depth, full ? 8 : 4);
    const std::vector<bool> isOff = pixelsOffEdges(scene, settings);
    pixels += isOff.size();
    edgePixels += size_t(std::count(isOff.begin(), isOff.end(), false));
    const Image original = test::renderShader(scene, settings);
    for (int k = -20; k <= 20; k += full ? 1 : 10) {
      differing += differingValues(original, test::renderShader(changed(scene, std::ldexp(1, k), {}), settings));
      ++pictures;
    }

    const Image exact = renderReference(scene, settings).image;
    const Image rounded = renderReference(roundScene(scene), settings).image;
    const auto change = [&](double scale, const dvec3& shift, AllChanges& changes) {
      const Scene other = changed(scene, scale, shift);
      changes.turner.add(original, test::renderShader(other, settings), isOff, name);
      changes.rounded.add(rounded, renderReference(roundScene(other), settings).image, isOff, name);
      changes.naive.add(exact, renderReference(roundedWhereItIs(other), settings).image, isOff, name);
    };
    for (const double distance : {1e4, 1e5, 1e6}) change(1, {distance, -distance, distance}, moved);
    for (const double scale : {1e-3, 1e-1, 1e1, 1e3, 1e6})
      if (full || scale != 1e-1) change(scale, {}, scaled);
  }
  report.atMost(fmt::format("values that differ in {} pictures of scenes scaled by 2^-20 to 2^20", pictures),
                double(differing), 0);
  moved.report("moved by 1e4, 1e5, 1e6", {}, report);
  scaled.report("scaled by 1e-3 to 1e6", full ? 0.05 : 5e-5, report);
  report.atMost(fmt::format("share of {} pixels that are on an edge", pixels), double(edgePixels) / double(pixels),
                0.005);
}

// --- 42 ---

// A tree that knows nothing of where its boxes are: halves of a shuffled order. Rays meet it in an order that no other
// tree has.
class ShuffledTree {
 public:
  ShuffledTree(std::span<const Box> boxes, const KindStarts& kinds, Random& random) : boxes_(boxes), kinds_(kinds) {
    for (uint32_t i = 0; i < boxes.size(); ++i) bvh_.order.push_back(i);
    size_t begin = 0;
    kinds_.push_back(boxes.size());
    for (const size_t end : kinds_) {
      std::shuffle(bvh_.order.begin() + std::ptrdiff_t(begin), bvh_.order.begin() + std::ptrdiff_t(end), random);
      begin = end;
    }
    if (!boxes.empty()) bvh_.root = build(0, boxes.size(), 0);
  }
  const Bvh& bvh() const { return bvh_; }

 private:
  BvhChild build(size_t begin, size_t end, int depth) {
    BvhChild child;
    child.box = boxes_[bvh_.order[begin]];
    for (size_t i = begin; i < end; ++i) {
      const Box& box = boxes_[bvh_.order[i]];
      child.box = {glm::min(child.box.lo, box.lo), glm::max(child.box.hi, box.hi)};
    }
    const size_t start = *std::upper_bound(kinds_.begin(), kinds_.end() - 1, begin);
    const bool isMixed = start < end;
    if (!isMixed && end - begin <= BvhLimits{}.maxLeafSize) {
      std::sort(bvh_.order.begin() + std::ptrdiff_t(begin), bvh_.order.begin() + std::ptrdiff_t(end));
      child.first = uint32_t(begin);
      child.count = uint32_t(end - begin);
      return child;
    }
    child.first = uint32_t(bvh_.nodes.size());
    bvh_.nodes.emplace_back();
    bvh_.depth = std::max(bvh_.depth, depth + 1);
    const size_t middle = isMixed ? start : begin + (end - begin) / 2;
    const BvhChild first = build(begin, middle, depth + 1), second = build(middle, end, depth + 1);
    bvh_.nodes[child.first] = {{first, second}};
    return child;
  }

  std::span<const Box> boxes_;
  KindStarts kinds_;  // and where the last one ends
  Bvh bvh_;
};

// Values of a scene's picture that depend on anything but the scene.
struct Differing {
  size_t pictures = 0, byDispatching = 0, byTree = 0, byRepeating = 0;
};

void addDiffering(const Scene& scene, const RenderSettings& settings, int repeats, Random& random,
                  Differing& differing) {
  const Image expected = test::renderShader(scene, settings);
  const auto render = [&](const Dispatching& dispatching) {
    ++differing.pictures;
    return differingValues(expected, test::renderer().render(test::kernel(), settings, {}, dispatching).image);
  };
  for (const Dispatching& dispatching :
       {Dispatching{.tile = 16}, Dispatching{.tile = 64}, Dispatching{.tile = 4096}, Dispatching{.workGroup = 8},
        Dispatching{.workGroup = 32}, Dispatching{.workGroup = 128}, Dispatching{.workGroup = 256},
        Dispatching{.tile = 24, .workGroup = 16, .budget = 100}})
    differing.byDispatching += render(dispatching);
  for (int i = 0; i < repeats; ++i) differing.byRepeating += render({});

  const PreparedGeometry prepared = prepareGeometry(roundScene(scene));
  const ShuffledTree shuffled(prepared.boxes, prepared.typeStarts(), random);
  for (const Bvh& bvh : {buildBvh(prepared.boxes, prepared.typeStarts()),
                         buildMedianBvh(prepared.boxes, prepared.typeStarts()), shuffled.bvh()})
    for (const TraversalStart cubes : {TraversalStart::lists, TraversalStart::wholeTree}) {
      test::renderer().upload(packScene(prepared, bvh, settings, cubes));
      differing.byTree += render({});
    }
}

// Squares and spheres that lie in the same place, in two colors: only the rule of ties tells which is seen.
Scene coincidentScene() {
  Scene scene;
  scene.background = {0.2, 0.3, 0.4};
  scene.camera = {.eye = {0.3, 0.4, 5}, .target = {0, 0, 0}};
  scene.lights = {{{1, 2, 9}}};
  scene.materials = {{.diffuse = {0.9, 0.1, 0.1}}, {.diffuse = {0.1, 0.1, 0.9}, .reflect = 0.5, .localWeight = 0.5}};
  for (uint32_t i = 0; i < 20; ++i) {
    scene.spheres.push_back({{-0.8, 0, 0}, 0.7, i % 3 == 0});
    scene.addTriangle({dvec3(0, -1, 0), dvec3(1.6, -1, 0.2), dvec3(0.1, 1, 0.4)}, i % 3 == 0);
  }
  return scene;
}

void measureDeterminism(const Bench& bench, Report& report) {
  Random random = bench.random(42);
  const bool full = bench.effort.full;
  Differing differing;
  std::vector<Scene> scenes = {coincidentScene(), ours("glass"), ours("mirrors")};
  if (full) scenes.push_back(ours("spot"));
  for (const Scene& scene : scenes) {
    RenderSettings settings = settingsOfHeight(scene, full ? 150 : 45);
    settings.samples = 2;
    settings.sampler = Sampler::jitter;
    settings.depth = std::min(settings.depth, 5);
    addDiffering(scene, settings, full ? 10 : 2, random, differing);
  }
  const std::string of = fmt::format("values that differ, of {} pictures: ", differing.pictures);
  report.atMost(of + "by tiles, work-groups and budgets", double(differing.byDispatching), 0);
  report.atMost(of + "by the tree: Embree's, medians, shuffled; with lists and without", double(differing.byTree), 0);
  report.atMost(of + "when repeated", double(differing.byRepeating), 0);
}

// The largest relative error of a constant picture's mean of 65,536 samples; naive: of a plain sum and a running mean.
void measureSums(Report& report) {
  double turner = 0, naive = 0;
  for (const float value : {0.1f, 0.3f, 0.7f}) {
    Scene scene;
    scene.background = dvec3(value);
    for (const float mean : test::renderShader(scene, test::settingsOf(scene, 4, 4, kMaxSamples)).rgb)
      turner = worse(std::abs(double(mean) / value - 1), turner);
    float sum = 0, running = 0;
    constexpr int kSamples = kMaxSamples * kMaxSamples;
    for (int i = 1; i <= kSamples; ++i) {
      sum += value;
      running += (value - running) / float(i);
    }
    naive = worse(std::abs(double(sum) / kSamples / value - 1), naive);
    naive = worse(std::abs(double(running) / value - 1), naive);
  }
  report.atMost("relative error of the mean of 65536 samples of 0.1, 0.3, 0.7", turner, 2e-7, naive);
}

// A straight edge across a picture of 48 x 48 pixels: dark below it, 1 above.
struct Edge {
  static constexpr int kSize = 48;
  dvec3 point, normal;  // in pixels from the picture's top left; the normal points to the bright side
  double unit = 2 * std::tan(22.5 * std::numbers::pi / 180) / kSize;  // of a pixel at the distance of 1

  explicit Edge(Random& random) : point(uniform(random, 18, 30), uniform(random, 18, 30), 0) {
    const double turn = uniform(random, 0, 2 * std::numbers::pi);
    normal = {std::cos(turn), std::sin(turn), 0};
  }
  bool isBright(double x, double y) const { return glm::dot(dvec3(x, y, 0) - point, normal) > 0; }

  // One large triangle in the plane z = -1.
  Scene scene() const {
    const auto place = [&](const dvec3& p) { return dvec3((p.x - kSize / 2) * unit, -(p.y - kSize / 2) * unit, -1); };
    const dvec3 along(-normal.y, normal.x, 0);
    const double far = 4 / unit;
    Scene scene;
    scene.background = dvec3(1);
    scene.camera = {.eye = {0, 0, 0}, .target = {0, 0, -1}};
    scene.materials = {Material{}};
    scene.addTriangle({place(point + far * along), place(point - far * along), place(point - far * normal)});
    return scene;
  }

  // The bright share of a pixel: the square clipped by the edge (Sutherland and Hodgman 1974), by the shoelace formula.
  double coverage(int px, int py) const {
    const dvec3 square[] = {{px, py, 0}, {px + 1, py, 0}, {px + 1, py + 1, 0}, {px, py + 1, 0}};
    std::vector<dvec3> clipped;
    for (int i = 0; i < 4; ++i) {
      const dvec3 &a = square[i], &b = square[(i + 1) % 4];
      const double da = glm::dot(a - point, normal), db = glm::dot(b - point, normal);
      if (da > 0) clipped.push_back(a);
      if ((da > 0) != (db > 0)) clipped.push_back(a + da / (da - db) * (b - a));
    }
    double area = 0;
    for (size_t i = 0; i < clipped.size(); ++i) area += glm::cross(clipped[i], clipped[(i + 1) % clipped.size()]).z / 2;
    return area;
  }
};

// The slope of a straight line through points, by least squares.
double slopeOf(const std::vector<double>& x, const std::vector<double>& y) {
  double meanX = 0, meanY = 0, xy = 0, xx = 0;
  for (size_t i = 0; i < x.size(); ++i) meanX += x[i] / double(x.size()), meanY += y[i] / double(x.size());
  for (size_t i = 0; i < x.size(); ++i) xy += (x[i] - meanX) * (y[i] - meanY), xx += (x[i] - meanX) * (x[i] - meanX);
  return xy / xx;
}

// How fast the error of pixels on a straight edge falls with the number of samples N: RMSE ~ N^slope. Jitter has -3/4
// (Mitchell 1996); samples anywhere in the pixel, in double, are the naive ones.
void measureEdgeSlope(const Bench& bench, Report& report) {
  Random random = bench.random(142);
  std::vector<double> logN, jittered, anywhere;
  std::vector<Edge> edges;
  for (int k = 0; k < (bench.effort.full ? 100 : 12); ++k) edges.emplace_back(random);
  for (int n = 2; n <= (bench.effort.full ? 32 : 16); n *= 2) {
    double squares = 0, naiveSquares = 0;
    size_t pixels = 0;
    for (const Edge& edge : edges) {
      RenderSettings settings = test::settingsOf(edge.scene(), Edge::kSize, Edge::kSize, n);
      settings.sampler = Sampler::jitter;
      settings.seed = uint32_t(random());
      const Image image = test::renderShader(edge.scene(), settings);
      for (int i = 0; i < Edge::kSize * Edge::kSize; ++i) {
        const int px = i % Edge::kSize, py = i / Edge::kSize;
        const double exact = edge.coverage(px, py);
        if (exact <= 0 || exact >= 1) continue;
        ++pixels;
        squares += std::pow(image.rgb[3 * size_t(i)] - exact, 2);
        int bright = 0;
        for (int s = 0; s < n * n; ++s) bright += edge.isBright(px + uniform(random, 0, 1), py + uniform(random, 0, 1));
        naiveSquares += std::pow(double(bright) / (n * n) - exact, 2);
      }
    }
    logN.push_back(std::log(n * n));
    jittered.push_back(std::log(squares / double(pixels)) / 2);
    anywhere.push_back(std::log(naiveSquares / double(pixels)) / 2);
  }
  const double slope = slopeOf(logN, jittered), naive = slopeOf(logN, anywhere);
  report.atMost("error on a straight edge ~ N^s, jittered: |s + 0.75|", std::abs(slope + 0.75), 0.05,
                std::abs(naive + 0.75), fmt::format("s = {:.3f}; of random samples {:.3f}", slope, naive));
}

void determinismAndSums(const Bench& bench, Report& report) {
  measureDeterminism(bench, report);
  measureSums(report);
  measureEdgeSlope(bench, report);
}

}  // namespace

std::vector<Case> shadingCases() {
  return {{39, "Singular shading", singularShading},
          {40, "Bad input", badInput},
          {41, "Moved and scaled scenes", invariance},
          {42, "Determinism and sums", determinismAndSums}};
}

}  // namespace turner::hard
