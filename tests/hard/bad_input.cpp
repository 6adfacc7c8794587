// Bad input: nothing is believed blindly, and a refusal names its place.
#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <regex>
#include <sstream>

#include "base/errors.h"
#include "base/stopwatch.h"
#include "base/text_file.h"
#include "hard/cases.h"
#include "hard/pictures.h"
#include "hard/vectors.h"
#include "reference/reference.h"
#include "scene/scene_load.h"
#include "support/temporary_folder.h"

namespace turner::hard {
namespace {

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
  const Stopwatch watch;
  try {
    loaded.scene = loadScene(path);
  } catch (const InputError& error) {
    loaded.refusal = error.what();
  } catch (const std::exception& error) {
    loaded.refusal = error.what();
    loaded.otherException = true;
  }
  loaded.seconds = watch.seconds();
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
  fuzz.notFinite += notFiniteValues(test::renderShader(scene, test::settingsOf(scene, 16, 16))) > 0;
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

}  // namespace

std::vector<Case> badInputCases() {
  return {{40, "Bad input", badInput}};
}

}  // namespace turner::hard
