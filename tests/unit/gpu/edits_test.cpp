// What users write into the kernel, each against a twin in double precision: the picture is right, or refused with the
// reason. Each edit is made the way it comes to mind, without a thought of light buffers or of what is compiled out.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <memory>
#include <string>
#include <vector>

#include "base/errors.h"
#include "geometry/round_scene.h"
#include "gpu/kernel_features.h"
#include "gpu/session.h"
#include "scene/scene_load.h"
#include "support/shader_harness.h"
#include "support/shader_variant.h"
#include "support/twin.h"

namespace turner::test {
namespace {

using glm::dvec2;
using glm::dvec3;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Scene sceneNamed(const std::string& name) {
  return loadScene(TURNER_SCENES_DIR "/" + name + ".json");
}

struct EditedPicture {
  Image image;
  bool edited = false;
  std::vector<std::string> added;  // features
};

RenderSession& session() {
  static RenderSession shared(chooseDevice(listDevices(), wantedDevice()));
  return shared;
}

EditedPicture render(const Scene& scene, const RenderSettings& settings, const std::vector<Replacement>& edits) {
  const ShaderVariant variant(edits);
  session().prepare(scene, settings);
  const Kernel kernel =
      session().compile(readShaderSources(variant.folder() + "/shaders/whitted.comp"), KernelForm::asNeeded);
  session().upload();
  session().addFeaturesOf(kernel);
  EditedPicture result;
  result.image = session().render(kernel, settings, {}).image;
  result.edited = kernel.edited;
  result.added = featureNames(session().addedFeatures());
  return result;
}

// One line in place of another, in a file of the kernel.
Replacement edit(const std::string& file, const std::string& from, const std::string& to) {
  return {from, file, from, to};
}

// Renders with an edit and compares with its twin.
template <class EditTwin>
std::vector<std::string> expectRight(const Scene& scene, const std::vector<Replacement>& edits, int depth = 0) {
  RenderSettings settings = settingsOfHeight(scene, 96);
  if (depth > 0) settings.depth = depth;
  const EditedPicture picture = render(scene, settings, edits);
  EXPECT_TRUE(picture.edited);
  const TwinComparison comparison = compareWithTwin(picture.image, EditTwin(roundScene(scene), settings));
  EXPECT_GT(comparison.offEdges, 0.8);
  EXPECT_LE(comparison.p99, 1e-5);
  return picture.added;
}
template <class EditTwin>
std::vector<std::string> expectRight(const std::string& name, const std::vector<Replacement>& edits, int depth = 0) {
  return expectRight<EditTwin>(sceneNamed(name), edits, depth);
}

std::string refusalOf(const std::string& name, const std::vector<Replacement>& edits) {
  const Scene scene = sceneNamed(name);
  try {
    render(scene, settingsOfHeight(scene, 64), edits);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

// --- the edits, and what they mean ---------------------------------------------------------------------------------

const std::string kMaterial = "    Material material = materialAt(surface.material);\n";
const std::string kShadowRay = "  Ray shadowRay = leaveToLight(surface, hitPrimitive, light.position);\n";
const std::string kJittered =
    "  light.position += 0.4 * (vec3(hash4(uvec4(pixel, lightIndex, level)).xyz >> 8u) / 16777216.0 - 0.5);\n";

struct SoftShadows : Twin {
  using Twin::Twin;
  std::vector<Light> lightsOf(const TwinHit& hit, const TwinPath& path) const override {
    std::vector<Light> lights = Twin::lightsOf(hit, path);
    for (uint32_t i = 0; i < lights.size(); ++i)
      lights[i].position += double(0.4f) * (twinRandom(path.x, path.y, i, path.level) - 0.5);
    return lights;
  }
};

TEST(Edits, softShadows) {
  EXPECT_THAT(expectRight<SoftShadows>("diffuse", {edit("whitted.comp", kShadowRay, kJittered + kShadowRay)}),
              ElementsAre("SHADOW_NODES"));
  expectRight<SoftShadows>("triangles", {edit("whitted.comp", kShadowRay, kJittered + kShadowRay)});
}

TEST(Edits, softShadowsByTheFunctionForIt) {
  expectRight<SoftShadows>("shadows",
                           {edit("whitted.comp", kShadowRay, kJittered + "  Ray shadowRay = rayToLight(light);\n")});
}

TEST(Edits, softShadowsFromTheRoot) {
  expectRight<SoftShadows>("shadows",
                           {edit("whitted.comp", kShadowRay, kJittered + kShadowRay),
                            edit("whitted.comp", "    traversal = startShadowRay(shadowRay, factors, lightIndex);\n",
                                 "    traversal = startAtRoot();\n    traversal.tMax = kToLight;\n")});
}

// A thin lens, focused at 1.5 of the kernel's units.
struct ThinLens : Twin {
  using Twin::Twin;
  TwinRay eyeRay(const dvec2& point, const TwinPath& path) const override {
    const dvec3 lens = double(0.04f) * (twinRandom(path.x, path.y, 7, 0) - 0.5);
    return {lens, glm::normalize(1.5 * cameraRay(point).direction - lens)};
  }
};
const std::string kBehindStart = "  traversal = startEyeRay(currentRay, rayFactors(currentRay.direction));\n";
const std::string kLens =
    "  vec3 lens = 0.04 * (vec3(hash4(uvec4(pixel, 7u, 0u)).xyz >> 8u) / 16777216.0 - 0.5);\n"
    "  currentRay = ray(lens, normalize(1.5 * currentRay.direction - lens));\n";

TEST(Edits, depthOfFieldWithoutMirrors) {
  EXPECT_THAT(expectRight<ThinLens>("diffuse", {edit("resume.glsl", kBehindStart, kLens + kBehindStart)}),
              ElementsAre("NEAREST_NODES"));
  // Also if the ray is moved after its traversal was begun.
  expectRight<ThinLens>("triangles", {edit("resume.glsl", kBehindStart, kBehindStart + kLens)});
}

struct Fisheye : Twin {
  using Twin::Twin;
  TwinRay eyeRay(const dvec2& point, const TwinPath&) const override {
    const dvec3 axis = cameraRay(middle()).direction, d = cameraRay(point).direction;
    return {dvec3(0), glm::normalize(d + double(0.8f) * (d - axis))};
  }
};

TEST(Edits, aPrimaryRayBentByALens) {
  expectRight<Fisheye>(
      "diffuse",
      {edit("resume.glsl", kBehindStart,
            kBehindStart + "  currentRay.direction = normalize(currentRay.direction + 0.8 * (currentRay.direction - "
                           "frame.centreHi));\n")});
}

struct RaisedShadowRays : Twin {
  using Twin::Twin;
  double visibility(const TwinHit& hit, const Light& light, const TwinPath&) const override {
    return isBlocked({hit.point + double(0.05f) * hit.Ng, light.position - hit.point}, 1) ? 0 : 1;
  }
};

TEST(Edits, aMovedOrigin) {
  for (const char* scene : {"diffuse", "triangles", "spheres"})
    expectRight<RaisedShadowRays>(
        scene, {edit("whitted.comp", kShadowRay, kShadowRay + "  shadowRay.origin += 0.05 * surface.Ng;\n")});
}

struct RoughMirrors : Twin {
  using Twin::Twin;
  dvec3 reflected(const TwinHit& hit, const dvec3& direction, const TwinPath& path) const override {
    return glm::normalize(Twin::reflected(hit, direction, path) +
                          double(1.5f) * (twinRandom(path.x, path.y, 3, path.level) - 0.5));
  }
};

// Some of these rays go into the sphere that they start on.
TEST(Edits, aBentRay) {
  const std::string R = "leaveSurface(surface, hitPrimitive, reflection(surface, currentRay.direction), true);\n";
  for (const char* scene : {"mirrors", "spheres"})
    expectRight<RoughMirrors>(
        scene,
        {edit("whitted.comp", "    currentRay = " + R,
              "    currentRay = " + R +
                  "    currentRay.direction = normalize(currentRay.direction + 1.5 * (vec3(hash4(uvec4(pixel, 3u, "
                  "level)).xyz >> 8u) / 16777216.0 - 0.5));\n")});
}

// What meets a sphere goes on half a unit higher.
struct Portal : Twin {
  using Twin::Twin;
  std::optional<TwinRay> passOn(const TwinHit& hit, const TwinRay& ray, const TwinPath&) const override {
    if (hit.primitive >= scene.spheres.size() || ray.origin.y > 0) return std::nullopt;
    return TwinRay{hit.point + dvec3(0, 2, 0), ray.direction};
  }
};

TEST(Edits, aPortal) {
  expectRight<Portal>("diffuse", {edit("whitted.comp", "    Material material = materialAt(surface.material);\n",
                                       "    Material material = materialAt(surface.material);\n"
                                       "    if (typeOf(hitPrimitive) == kSpheres && currentRay.origin.y <= 0.0) {\n"
                                       "      currentRay = ray(surface.point + vec3(0, 2, 0), currentRay.direction);\n"
                                       "      traversal = startAtRoot();\n"
                                       "      phase = kTrace;\n"
                                       "      return;\n"
                                       "    }\n")});
}

struct SecondShadowRay : Twin {
  using Twin::Twin;
  double visibility(const TwinHit& hit, const Light& light, const TwinPath& path) const override {
    const dvec3 second = hit.point + double(0.1f) * hit.Ng;
    return Twin::visibility(hit, light, path) * (isBlocked({second, light.position - second}, 1) ? 0.25 : 1);
  }
};

TEST(Edits, aSecondBounceOfShadowRays) {
  expectRight<SecondShadowRay>(
      "shadows",
      {edit(
          "whitted.comp", "    if (phase == kTraceShadow && traversal.hit == kRefNone)\n",
          "    vec3 raised = surface.point + 0.1 * surface.Ng;\n"
          "    Ray secondRay = ray(raised, light.position - raised);\n"
          "    TraversalState second = startAtRoot();\n"
          "    second.tMax = kToLight;\n"
          "    int turns = 500;\n"
          "    traverse(secondRay, rayFactors(secondRay.direction), true, SHADOW_NODES, kShadow, 1.0, second, turns);\n"
          "    if (second.hit != kRefNone) light.color *= 0.25;\n"
          "    if (phase == kTraceShadow && traversal.hit == kRefNone)\n")});
}

struct OneMoreLight : Twin {
  using Twin::Twin;
  std::vector<Light> lightsOf(const TwinHit& hit, const TwinPath& path) const override {
    std::vector<Light> lights = Twin::lightsOf(hit, path);
    lights.push_back({.position = {-0.75, 1.5, -1}, .color = {0.5, 0.25, 0.125}});
    return lights;
  }
};
const std::vector<Replacement> kOneMoreLight = {
    edit("whitted.comp",
         "(reflectsNoLight(material) || crossing.hidden)) lightIndex = LIGHTS;\n    if (lightIndex < LIGHTS && budget",
         "(reflectsNoLight(material) || crossing.hidden)) lightIndex = LIGHTS + 1u;\n    if (lightIndex <= LIGHTS && "
         "budget"),
    edit("whitted.comp", "(LOOPS_AT_HEAD && (lightIndex >= LIGHTS ||", "(LOOPS_AT_HEAD && (lightIndex > LIGHTS ||"),
    edit("whitted.comp", "LOOPS_AT_HEAD || (lightIndex < LIGHTS &&", "LOOPS_AT_HEAD || (lightIndex <= LIGHTS &&"),
    edit("whitted.comp", "phase == kNextLight && lightIndex >= LIGHTS", "phase == kNextLight && lightIndex > LIGHTS"),
};

TEST(Edits, aLightOfTheShader) {
  std::vector<Replacement> edits = kOneMoreLight;
  edits.push_back(edit("whitted.comp", "  Light light = lightAt(lightIndex);\n",
                       "  Light light = Light(vec3(-0.75, 1.5, -1), 0u, vec3(0.5, 0.25, 0.125), 0u);\n"
                       "  if (lightIndex < LIGHTS) light = lightAt(lightIndex);\n"));
  for (const char* scene : {"diffuse", "triangles"}) expectRight<OneMoreLight>(scene, edits);
}

TEST(Edits, aLightThatIsNotThere) {
  EXPECT_THAT(refusalOf("diffuse", kOneMoreLight), HasSubstr("lightAt() for a light beyond the"));
}

struct LightsMoved : Twin {
  using Twin::Twin;
  std::vector<Light> lightsOf(const TwinHit& hit, const TwinPath& path) const override {
    std::vector<Light> lights = Twin::lightsOf(hit, path);
    for (Light& light : lights) light.position.x += 0.5;
    return lights;
  }
};

// Where the scene's lights are loaded, and by a macro.
TEST(Edits, lightsMovedWhereTheyAreLoaded) {
  expectRight<LightsMoved>("diffuse", {edit("scene.h", "  return Light(xyz(a), a.w, xyz(b), 0u);",
                                            "  return Light(xyz(a) + vec3(0.5, 0, 0), a.w, xyz(b), 0u);")});
  expectRight<LightsMoved>(
      "diffuse", {edit("whitted.comp", "// Local illumination by one light,",
                       "Light movedLight(const uint i) {\n  Light light = lightAt(i);\n  light.position.x += 0.5;\n"
                       "  return light;\n}\n#define lightAt(i) movedLight(i)\n// Local illumination by one light,")});
}

struct WiderView : Twin {
  using Twin::Twin;
  TwinRay eyeRay(const dvec2& point, const TwinPath&) const override {
    return cameraRay(middle() + 1.5 * (point - middle()));
  }
};

TEST(Edits, aWiderViewByTheFrame) {
  expectRight<WiderView>("diffuse", {edit("whitted.comp", "  frame = frameInMemory;\n",
                                          "  frame = frameInMemory;\n  frame.rightHi *= 1.5;\n  frame.rightLo *= 1.5;\n"
                                          "  frame.downHi *= 1.5;\n  frame.downLo *= 1.5;\n")});
}

// Shadow where a ray straight down from above finds something nearer than the surface that it is above: nothing is.
struct NothingIsNearer : Twin {
  using Twin::Twin;
};

TEST(Edits, aNearestHitOfARayThatWasMoved) {
  const std::string down =
      "    Ray down = rayAlong(here.Ng);\n"
      "    down.origin += 0.01 * here.Ng;\n"
      "    down.direction = -here.Ng;\n"
      "    TraversalState below = @START@;\n"
      "    int turns = 500;\n"
      "    traverse(down, rayFactors(down.direction), false, NEAREST_NODES, rayKind, 1.0, below, turns);\n"
      "    if (abs(below.tMax - 0.01) > 1e-4) material.diffuse = vec3(0);\n";
  for (const std::string start : {"startAtRoot()", "startAt(frame.root, kNoHit, kNoList)"}) {
    std::string edited = down;
    edited.replace(edited.find("@START@"), 7, start);
    EXPECT_THAT(expectRight<NothingIsNearer>("diffuse", {edit("whitted.comp", kMaterial, kMaterial + edited)}),
                ElementsAre("NEAREST_NODES"));
  }
}

struct MirrorFloor : Twin {
  using Twin::Twin;
  Material materialOf(const TwinHit& hit, const TwinPath& path) const override {
    Material material = Twin::materialOf(hit, path);
    if (hit.Ng.y > 0.9) material.reflect = 0.5, material.localWeight = 0.5;
    return material;
  }
};

TEST(Edits, aMirrorInASceneWithoutAny) {
  EXPECT_THAT(
      expectRight<MirrorFloor>(
          "diffuse",
          {edit("whitted.comp", kMaterial,
                kMaterial + "    if (surface.Ng.y > 0.9) material.reflectance = material.localWeight = 0.5;\n")}),
      testing::Contains("REFLECTION"));
  // By way of data alone, which the text does not show.
  expectRight<MirrorFloor>(
      "triangles",
      {edit("whitted.comp", kMaterial,
            kMaterial + "    if (surface.Ng.y > 0.9) material = Material(material.diffuse, 0.5, vec3(0), 0.0, 1.0, "
                        "1.5, 0.5, 0u);\n")});
}

struct GlassBalls : Twin {
  using Twin::Twin;
  Material materialOf(const TwinHit& hit, const TwinPath& path) const override {
    Material material = Twin::materialOf(hit, path);
    if (hit.primitive < scene.spheres.size())
      material.reflect = 0.125, material.transmit = 0.75, material.localWeight = 0.125, material.eta = 1.25;
    return material;
  }
};

TEST(Edits, aRefractionWithoutGlass) {
  expectRight<GlassBalls>(
      "diffuse", {edit("whitted.comp", kMaterial,
                       kMaterial + "    if (typeOf(hitPrimitive) == kSpheres) material = Material(material.diffuse, "
                                   "0.125, vec3(0), 0.75, 1.0, 1.25, 0.125, 0u);\n")});
}

struct Glossy : Twin {
  using Twin::Twin;
  Material materialOf(const TwinHit& hit, const TwinPath& path) const override {
    Material material = Twin::materialOf(hit, path);
    material.specular = dvec3(0.5);
    material.shininess = 16;
    return material;
  }
};

TEST(Edits, aHighlightInASceneWithoutAny) {
  // Written where highlights are compiled out.
  EXPECT_THAT(expectRight<Glossy>(
                  "diffuse", {edit("shade.glsl", "material.specular * powOneMinus(min(q, 1.0), material.shininess)",
                                   "vec3(0.5) * powOneMinus(min(q, 1.0), 16.0)")}),
              testing::Contains("HIGHLIGHTS"));
  // Given to the material.
  expectRight<Glossy>(
      "triangles",
      {edit("whitted.comp", kMaterial,
            kMaterial + "    material = Material(material.diffuse, 0.0, vec3(0.5), 0.0, 16.0, 1.5, 1.0, 0u);\n")});
}

struct DeeperThanAsked : Twin {
  using Twin::Twin;
  bool goesDeeper(uint32_t level) const override { return level < 8; }
};
const std::vector<Replacement> kDeeper = {
    edit("whitted.comp", "bool deeper = level < DEPTH;", "bool deeper = level < 8u;")};

TEST(Edits, aChangedDepth) {
  expectRight<DeeperThanAsked>("mirrors", kDeeper, 3);
  // By a macro: the host gives another.
  EXPECT_THAT(refusalOf("glass", {edit("whitted.comp", "#include \"edited.glsl\"\n",
                                       "#undef DEPTH\n#define DEPTH 20u\n#include \"edited.glsl\"\n")}),
              HasSubstr("DEPTH is a constant that turner gives the kernel; a macro of this name hides it"));
  // Rays that wait have no room.
  EXPECT_THAT(refusalOf("glass", {edit("whitted.comp", "bool deeper = level < DEPTH;", "bool deeper = level < 40u;")}),
              HasSubstr("give a --depth beyond"));
}

TEST(Edits, anEarlyReturn) {
  EXPECT_THAT(
      refusalOf("diffuse", {edit("whitted.comp", "  bool finishedBefore = phase == kDone;\n",
                                 "  if (pixel.x % 3u == 0u) return;\n  bool finishedBefore = phase == kDone;\n")}),
      HasSubstr("without finishing"));
  EXPECT_THAT(refusalOf("shadows", {edit("whitted.comp", "  Light light = lightAt(lightIndex);\n",
                                         "  if (lightIndex == 1u) return;\n  Light light = lightAt(lightIndex);\n")}),
              HasSubstr("does not come to an end"));
}

// --- the scene's own units -------------------------------------------------------------------------------------------

// Squares of half a unit, which stand still in the scene. Frame and cell come from the test, since the twin has none.
struct Checker : Twin {
  using Twin::Twin;
  static LocalFrame frame;
  Material materialOf(const TwinHit& hit, const TwinPath& path) const override {
    Material material = Twin::materialOf(hit, path);
    const dvec3 world = frame.origin + hit.point / frame.scale;
    const double sum = std::floor(world.x / 0.5) + std::floor(world.z / 0.5);
    if (std::fmod(sum, 2) != 0) material.diffuse *= 0.25;
    return material;
  }
};
LocalFrame Checker::frame;

const std::vector<Replacement> kChecker = {
    edit("whitted.comp", kMaterial,
         kMaterial + "    vec3 within;\n"
                     "    vec3 cell = worldCell(surface, 0.5, within);\n"
                     "    if (isOdd(vec3(cell.x, 0.0, cell.z))) material.diffuse *= 0.25;\n")};

void moveBy(Scene& scene, const dvec3& way) {
  scene.camera.eye += way;
  scene.camera.target += way;
  for (Light& light : scene.lights) light.position += way;
  for (Sphere& sphere : scene.spheres) sphere.center += way;
  for (dvec3& position : scene.positions) position += way;
}

TEST(Edits, aCheckerInTheScenesUnits) {
  // At its place, and 1e6 units away, where float32 has steps of a 16th.
  for (const dvec3 way : {dvec3(0.1, 0, 0.2), dvec3(1e6, 10, -1e6)}) {
    Scene scene = sceneNamed("diffuse");
    moveBy(scene, way);
    Checker::frame = localFrame(scene.camera);
    expectRight<Checker>(scene, kChecker);
  }
}

// A student's own law of distance.
struct InverseSquare : Twin {
  using Twin::Twin;
  std::vector<Light> lightsOf(const TwinHit& hit, const TwinPath& path) const override {
    std::vector<Light> lights = Twin::lightsOf(hit, path);
    for (Light& light : lights) {
      const double distance = glm::length(light.position - hit.point) / Checker::frame.scale;
      light.color *= 30 / (distance * distance);
    }
    return lights;
  }
};

TEST(Edits, aFallOffInTheScenesUnits) {
  const Scene scene = sceneNamed("diffuse");
  Checker::frame = localFrame(scene.camera);
  ASSERT_NE(Checker::frame.scale, 1);
  expectRight<InverseSquare>(scene,
                             {edit("shade.glsl", "  // Scaled first: the square of a distance of 1e-23 would be 0.\n",
                                   "  float d = worldDistance(length(toward));\n  E *= 30.0 / (d * d);\n")});
}

TEST(Edits, pointsGoToTheScenesUnitsAndBack) {
  Scene scene = sceneNamed("diffuse");
  moveBy(scene, {1e6, 0, 0});
  const dvec3 eye = scene.camera.eye;
  const EditedPicture picture =
      render(scene, settingsOfHeight(scene, 16),
             {edit("whitted.comp", "    pixels[pixelAt] = packWord(sum / float(SAMPLES * SAMPLES), phase);\n",
                   "    vec3 rest, there = worldPoint(vec3(0), rest);\n"
                   "    sum = vec3(there.x, rest.x, localPoint(there).x + localDistance(worldDistance(2.0)));\n"
                   "    pixels[pixelAt] = packWord(sum, phase);\n")});
  const double rest = eye.x - double(float(eye.x));
  EXPECT_EQ(picture.image.rgb[0], float(eye.x));
  EXPECT_EQ(picture.image.rgb[1], float(rest));
  EXPECT_NEAR(picture.image.rgb[2], 2 - rest * localFrame(scene.camera).scale, 1e-6);
}

// --- what an edit keeps ---------------------------------------------------------------------------------------------

// A global variable of the edit lives as long as its pixel, into however many dispatches its work is cut.
TEST(Edits, aGlobalVariableIsKept) {
  const Scene scene = sceneNamed("glass");
  const RenderSettings settings = settingsOfHeight(scene, 24);
  const ShaderVariant variant(std::vector{
      edit("whitted.comp", "// The nearest hit of the ray in hand,",
           "vec3 seen = vec3(0);\nuint seed = 0u, deepest = 0u;\n// The nearest hit of the ray in hand,"),
      edit("whitted.comp", "  float r = material.reflectance, t = material.transmittance;\n",
           "  float r = material.reflectance, t = material.transmittance;\n"
           "  seen += weight * material.diffuse;\n  ++seed;\n  deepest = max(deepest, level);\n"),
      edit("whitted.comp", "    pixels[pixelAt] = packWord(sum / float(SAMPLES * SAMPLES), phase);\n",
           "    if (phase == kDone) sum = vec3(seen.x, float(seed), float(deepest));\n"
           "    pixels[pixelAt] = packWord(sum, phase);\n"),
  });
  std::vector<Image> images;
  for (const uint32_t budget : {0u, kLeastBudget}) {
    RenderSession cut(chooseDevice(listDevices(), wantedDevice()), BufferAccess::automatic, {.budget = budget});
    cut.prepare(scene, settings);
    const Kernel kernel =
        cut.compile(readShaderSources(variant.folder() + "/shaders/whitted.comp"), KernelForm::asNeeded);
    cut.upload();
    cut.addFeaturesOf(kernel);
    images.push_back(cut.render(kernel, settings, {}).image);
  }
  EXPECT_EQ(images[0].rgb, images[1].rgb);
  float most = 0;
  for (size_t i = 2; i < images[0].rgb.size(); i += 3) most = std::max(most, images[0].rgb[i]);
  EXPECT_EQ(most, float(settings.depth));
}

TEST(Edits, anArrayThatIsNotKeptIsRefused) {
  const std::string place = "// The nearest hit of the ray in hand,";
  for (const auto& [declaration, message] : {std::pair("float a[4];\n", "a is an array, which is not kept"),
                                             std::pair("vec3[2] a;\n", "a is an array, which is not kept"),
                                             std::pair("mat3 a;\n", "a is a mat3, which is not kept")})
    EXPECT_THAT(refusalOf("diffuse", {edit("whitted.comp", place, declaration + place)}), HasSubstr(message));
  EXPECT_THAT(
      refusalOf("diffuse", {edit("whitted.comp", place, "#define MINE(name) float name = 0.0\nMINE(mine);\n" + place),
                            edit("whitted.comp", "  float r = material.reflectance, t",
                                 "  mine += 1.0;\n  sum += mine;\n  float r = material.reflectance, t")}),
      HasSubstr("mine is a global variable that a macro declares"));
}

// --- what is edited, and what not ------------------------------------------------------------------------------------

TEST(Edits, commentsAndNamesAreNoEdit) {
  const Scene scene = sceneNamed("diffuse");
  const RenderSettings settings = settingsOfHeight(scene, 32);
  const EditedPicture picture =
      render(scene, settings, {edit("whitted.comp", "  // A miss sees the background.\n", "  // The sky.\n")});
  EXPECT_FALSE(picture.edited);
  EXPECT_THAT(picture.added, IsEmpty());
}

// Of an edit that needs no more than the scene, the rest has the same bits.
TEST(Edits, anEditThatChangesNothingChangesNoBit) {
  for (const char* name : {"spheres", "glass", "cones", "nested_glass", "planet", "spot"}) {
    const Scene scene = sceneNamed(name);
    const RenderSettings settings = settingsOfHeight(scene, 64);
    const EditedPicture without = render(scene, settings, {});
    const EditedPicture with = render(
        scene, settings,
        {edit("whitted.comp", "  singCanary();\n", "  if (frame.width == 0u) sum = vec3(1);\n  singCanary();\n")});
    EXPECT_FALSE(without.edited);
    EXPECT_TRUE(with.edited);
    EXPECT_THAT(with.added, IsEmpty());
    EXPECT_EQ(without.image.rgb, with.image.rgb) << name;
  }
}

}  // namespace
}  // namespace turner::test
