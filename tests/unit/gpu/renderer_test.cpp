// The shader's renderer: the same picture however the work is cut, the reference's picture, bounded work.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>

#include "base/errors.h"
#include "image/compare.h"
#include "image/exr.h"
#include "reference/reference.h"
#include "scene/scene_load.h"
#include "support/closed_form.h"
#include "support/our_scenes.h"
#include "support/shader_harness.h"

namespace turner {
namespace {

using test::countShaderRays;
using test::ours;
using test::renderShader;
using test::settingsOf;

class RendererEndsWithTheTests : public testing::Environment {
  void TearDown() override { test::endRenderer(); }
};
const testing::Environment* const rendererEnd = testing::AddGlobalTestEnvironment(new RendererEndsWithTheTests);

bool sameBits(const Image& a, const Image& b) {
  return a.window == b.window && a.rgb.size() == b.rgb.size() &&
         std::memcmp(a.rgb.data(), b.rgb.data(), a.rgb.size() * sizeof(float)) == 0;
}

// --- the same picture -----------------------------------------------------------------------------------------------

TEST(Render, IsTheSameTwice) {
  const Scene scene = ours("spheres");
  const RenderSettings settings = settingsOf(scene, 96, 54, 2);
  EXPECT_TRUE(sameBits(renderShader(scene, settings), renderShader(scene, settings)));
}

TEST(Render, DoesNotDependOnTilesOrWorkGroups) {
  const Scene scene = ours("spheres");
  const RenderSettings settings = settingsOf(scene, 101, 59, 2);
  const Image expected = renderShader(scene, settings);
  for (const int tile : {8, 24, 128, 512})
    for (const int workGroup : {1, 8, 48, 100, 256})
      EXPECT_TRUE(sameBits(renderShader(scene, settings, {.tile = tile, .workGroup = workGroup}), expected))
          << "tile " << tile << ", work-group " << workGroup;
}

TEST(Render, DoesNotDependOnWhereItIsInterrupted) {
  // spot's rays meet nodes, those of glass have waiting rays, those of nested_glass carry solids, those of cones have
  // lists in three parts.
  for (const char* name : {"spot", "glass", "nested_glass", "cones"}) {
    const Scene scene = ours(name);
    RenderSettings settings = settingsOf(scene, 64, 64);
    settings.crop = {24, 24, 48, 48};
    const Image expected = renderShader(scene, settings);
    // The least one is taken for 1.
    for (const uint32_t budget : {1u, kLeastBudget + 1, 300u})
      EXPECT_TRUE(sameBits(renderShader(scene, settings, {.budget = budget}), expected))
          << name << " in pieces of " << budget << " iterations";
  }
}

TEST(Render, CropIsThatPartOfThePicture) {
  const Scene scene = ours("glass");
  for (const Sampler sampler : {Sampler::grid, Sampler::jitter, Sampler::sobol}) {
    RenderSettings settings = settingsOf(scene, 90, 70, 2);
    settings.sampler = sampler;
    const Image whole = renderShader(scene, settings);
    settings.crop = {13, 21, 60, 50};
    const Image part = renderShader(scene, settings);
    for (int y = 21; y < 50; ++y)
      EXPECT_EQ(0, std::memcmp(&part.rgb[3 * size_t(y - 21) * 47], &whole.rgb[3 * (size_t(y) * 90 + 13)],
                               47 * 3 * sizeof(float)))
          << "row " << y;
  }
}

TEST(Render, CoarsePictureHasPixelsOfTheFullOne) {
  const Scene scene = ours("spheres");
  RenderSettings settings = settingsOf(scene, 101, 59, 2);
  settings.sampler = Sampler::jitter;
  settings.crop = {3, 5, 98, 58};
  const Image full = renderShader(scene, settings);
  const auto pixel = [&](const Image& image, int x, int y) {
    const size_t at = 3 * (size_t(y) * size_t(full.window.width()) + size_t(x));
    return std::vector<float>(image.rgb.begin() + std::ptrdiff_t(at), image.rgb.begin() + std::ptrdiff_t(at + 3));
  };
  for (const int stride : {1, 8, 7, 200}) {
    const Image coarse = test::renderer().renderCoarse(test::kernel(), settings, stride, {}, {.tile = 8}).image;
    ASSERT_EQ(coarse.window, full.window);
    ASSERT_EQ(coarse.width, full.width);
    const auto nearest = [&](int at, int size) {
      return std::min((at + stride / 2) / stride, (size - 1) / stride) * stride;
    };
    int wrong = 0;
    for (int y = 0; y < full.window.height(); ++y)
      for (int x = 0; x < full.window.width(); ++x)
        wrong += pixel(coarse, x, y) != pixel(full, nearest(x, full.window.width()), nearest(y, full.window.height()));
    EXPECT_EQ(wrong, 0) << "stride " << stride;
  }
}

TEST(Render, KernelsInTurnKeepTheirOwnPictures) {
  const Scene scene = ours("spheres");
  const RenderSettings settings = settingsOf(scene, 48, 27);
  const Image expected = renderShader(scene, settings);
  std::vector<ShaderSource> sources = readShaderSources(TURNER_SHADERS_DIR "/whitted.comp");
  std::string& text = *sources[0].text;
  const std::string factor = "weight * material.localWeight";
  ASSERT_NE(text.find(factor), std::string::npos);
  text.replace(text.find(factor), factor.size(), "0.0 * " + factor);
  const Spirv dark = compileGlsl(sources, accessPreamble(test::renderer().access()));
  for (int turn = 0; turn < 3; ++turn) {
    EXPECT_FALSE(sameBits(test::renderer().render(dark, settings).image, expected)) << turn;
    EXPECT_TRUE(sameBits(test::renderer().render(test::kernel(), settings).image, expected)) << turn;
  }
}

TEST(Render, DoesNotDependOnTheTree) {
  for (const char* name : {"spot", "nested_glass"}) {
    const Scene scene = ours(name);
    const RenderSettings settings = settingsOf(scene, 80, 60);
    const Image expected = renderShader(scene, settings);
    const PreparedGeometry prepared = prepareGeometry(roundScene(scene));
    test::renderer().upload(packScene(prepared, buildMedianBvh(prepared.boxes, prepared.typeStarts()), settings));
    EXPECT_TRUE(sameBits(test::renderer().render(test::kernel(), settings).image, expected)) << name;
  }
}

class AllScenes : public testing::TestWithParam<std::string> {};

// The lists of eye and lights against walks from the root, every way to fetch, loops that end at their head: the same
// bits.
TEST_P(AllScenes, DoNotDependOnListsFetchingOrLoops) {
  Scene scene = ours(GetParam());
  RenderSettings settings = settingsOf(scene, 120, 80);
  settings.depth = std::min(settings.depth, 5);
  const Image expected = renderShader(scene, settings);
  EXPECT_TRUE(sameBits(test::renderer().render(test::kernel(), settings, {}, {.loopsAtHead = true}).image, expected))
      << "loops that end at their head";
  test::renderer().upload(test::packed(scene, settings, TraversalStart::wholeTree));
  EXPECT_TRUE(sameBits(test::renderer().render(test::kernel(), settings).image, expected)) << "without lists";
  for (const BufferAccess access :
       {BufferAccess::texelBuffer, BufferAccess::storageBuffer, BufferAccess::deviceAddress}) {
    ShaderRenderer other(chooseDevice(listDevices(), test::wantedDevice()), access);
    other.upload(test::packed(scene, settings));
    EXPECT_TRUE(sameBits(other.render(test::compileKernel(access), settings).image, expected)) << accessName(access);
  }
}

INSTANTIATE_TEST_SUITE_P(Render, AllScenes, testing::ValuesIn(test::ourScenes()),
                         [](const auto& test) { return test.param; });

// Of two coincident primitives the one that stands first in the scene is seen, wherever the tree puts them.
TEST(Render, LowestIdWinsAmongCoincidentTriangles) {
  Scene scene;
  scene.camera = {.eye = {0, 0, 3}, .target = {0, 0, 0}};
  scene.lights.push_back({.position = {0, 0, 5}});
  scene.materials = {closed_form::matte({1, 0, 0}), closed_form::matte({0, 1, 0})};
  for (int i = 0; i < 1000; ++i) scene.addTriangle({glm::dvec3(-9, -9, 0), {9, -9, 0}, {0, 9, 0}}, uint32_t(i > 0));
  const Image image = renderShader(scene, settingsOf(scene, 32, 32));
  for (size_t i = 0; i < image.rgb.size(); i += 3) {
    EXPECT_GT(image.rgb[i], 0.1f);
    EXPECT_EQ(image.rgb[i + 1], 0.0f);
  }
}

// Whatever the order of their vertices: the plane and its distance are the same.
TEST(Render, LowestIdWinsAmongRotatedCopies) {
  Scene scene;
  scene.camera = {.eye = {0, 0, 5}, .target = {0, 0, 0}};
  scene.lights.push_back({.position = {3, 5, 9}});
  scene.materials = {closed_form::matte({1, 0, 0}), closed_form::matte({0, 1, 0})};
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(-1.5, 1.5);
  const auto point = [&] { return glm::dvec3(place(random), place(random), place(random)); };
  for (int i = 0; i < 20; ++i) scene.addTriangle({point(), point(), point()}, 0);
  for (int i = 0; i < 20; ++i) {
    const auto [a, b, c] = scene.cornersOf(size_t(i));
    scene.addTriangle({b, c, a}, 1);
    scene.addTriangle({c, b, a}, 1);
  }
  const Image image = renderShader(scene, settingsOf(scene, 160, 160));
  for (size_t i = 1; i < image.rgb.size(); i += 3) EXPECT_EQ(image.rgb[i], 0.0f) << "a copy is seen";
}

// Folded pairs, of which a ray may pass both triangles, against the same triangles alone: the same bits. Out of each
// other's reach in the scene, triangles find no partners.
TEST(Render, PairsGiveThePictureOfTheirTriangles) {
  Scene paired;
  paired.camera = {.eye = {0, 0.5, 6}, .target = {0, 0, 0}, .fov = 40};
  paired.lights = {{.position = {3, 5, 4}}, {.position = {-4, 2, 1}, .color = {0.5, 0.4, 0.3}}};
  paired.background = {0.1, 0.2, 0.3};
  paired.materials = {closed_form::matte({0.8, 0.6, 0.4}), closed_form::mirror(0.5), closed_form::glass(0.1, 0.8, 1.3)};
  std::mt19937 random(21);
  std::uniform_real_distribution<double> place(-2, 2), near(-0.7, 0.7);
  const auto point = [&](auto& range) { return glm::dvec3(range(random), range(random), range(random)); };
  for (uint32_t i = 0; i < 300; ++i) {
    const glm::dvec3 a = point(place), b = a + point(near), c = a + point(near), d = a + point(near);
    paired.addTriangle({a, b, c}, i % 3);
    paired.addTriangle({c, b, d}, i % 3);
  }
  Scene alone = paired;
  for (size_t i = 0; i < 300; ++i) {
    alone.triangles[i] = paired.triangles[2 * i];
    alone.triangles[300 + i] = paired.triangles[2 * i + 1];
  }
  ASSERT_LT(prepareGeometry(roundScene(paired)).pairs.size(), 400u);
  ASSERT_EQ(prepareGeometry(roundScene(alone)).pairs.size(), 600u);
  const RenderSettings settings = settingsOf(paired, 160, 120);
  const Image expected = renderShader(alone, settings);
  EXPECT_TRUE(sameBits(renderShader(paired, settings), expected));
  EXPECT_TRUE(sameBits(renderShader(paired, settings, {.budget = 16}), expected)) << "interrupted at every step";
  test::renderer().upload(test::packed(paired, settings, TraversalStart::wholeTree));
  EXPECT_TRUE(sameBits(test::renderer().render(test::kernel(), settings).image, expected)) << "without lists";
}

// --- the reference's picture ----------------------------------------------------------------------------------------

struct Bar {
  double p50 = 1, p99 = 1e-5, badPixels = 0.003, meanSigned = 1;
};

// On failure leaves both pictures and their difference in tests/failed.
void expectAgreement(const std::string& name, const Scene& scene, const RenderSettings& settings, const Bar& bar) {
  SCOPED_TRACE(name + ", " + std::to_string(settings.samples) + " samples a side");
  const Image shader = renderShader(scene, settings);
  const ReferencePicture reference = renderReference(scene, settings);
  const Comparison c = compareImages(shader, reference.image, 1e-3);
  EXPECT_EQ(c.nan, 0u);
  EXPECT_EQ(c.inf, 0u);
  EXPECT_LE(c.p50, bar.p50);
  EXPECT_LE(c.p99, bar.p99);
  EXPECT_LE(c.badPixels, bar.badPixels);
  EXPECT_LE(std::abs(c.meanSigned), bar.meanSigned);

  const RayCounts counts = countShaderRays(scene, settings);
  EXPECT_EQ(counts.eye, reference.rays.eye);
  const auto near = [](uint64_t a, uint64_t b) { return std::abs(double(a) - double(b)) <= 0.0005 * double(b); };
  EXPECT_PRED2(near, counts.reflected, reference.rays.reflected);
  EXPECT_PRED2(near, counts.refracted, reference.rays.refracted);
  EXPECT_PRED2(near, counts.shadow, reference.rays.shadow);

  if (testing::Test::HasFailure()) {
    const std::string folder = std::string(TURNER_TESTS_DIR) + "/failed";
    std::filesystem::create_directories(folder);
    const auto leave = [&](const std::string& what, const Image& image) {
      std::ofstream(folder + "/" + name + "_" + what + ".exr", std::ios::binary) << encodeExr(image, {});
    };
    leave("shader", shader);
    leave("reference", reference.image);
    leave("error", errorImage(shader, reference.image));
  }
}

class OurScenes : public testing::TestWithParam<std::string> {};

TEST_P(OurScenes, AgreeWithTheReference) {
  const Scene scene = ours(GetParam());
  const int width = 320, height = width * scene.height / scene.width;
  for (const int samples : {1, 3}) expectAgreement(GetParam(), scene, settingsOf(scene, width, height, samples), {});
}

INSTANTIATE_TEST_SUITE_P(Render, OurScenes, testing::ValuesIn(test::ourScenesBut({"deep_glass"})),  // which follows
                         [](const auto& test) { return test.param; });

// Twenty touching glass spheres, sixteen levels deep: at most 2^16 rays for a pixel, and nothing is cut.
TEST(Render, DeepGlassAgreesWithTheReference) {
  Scene scene = ours("deep_glass");
  scene.depth = 16;
  Bar bar;
  bar.badPixels = 1;
  expectAgreement("deep_glass", scene, settingsOf(scene, 64, 64), bar);
}

class SpdScenes : public testing::TestWithParam<std::string> {};

// Small pictures here; the full-size bars are in docs/accuracy.md with the commands that measure them.
TEST_P(SpdScenes, AgreeWithTheReference) {
  const std::string path = std::string(TURNER_SCENES_DIR) + "/spd/" + GetParam() + ".nff";
  const Scene scene = loadScene(path);
  const bool mirrorBalls = GetParam() == "balls" || GetParam() == "rings";
  const Bar bar = mirrorBalls ? Bar{1e-6, 1, 0.025, 1e-4} : Bar{};
  // Rays that mirrors have driven apart spawn other shadow rays, a few more or fewer each: their number agrees in a
  // picture of some size.
  const int size = mirrorBalls ? 384 : 192;
  expectAgreement(GetParam(), scene, settingsOf(scene, size, size), bar);
}

INSTANTIATE_TEST_SUITE_P(Render, SpdScenes, testing::Values("balls", "gears", "mount", "rings", "teapot"),
                         [](const auto& test) { return test.param; });

// A second sphere in the place of the first: its surface must not shadow the first one's, nor take its rays.
TEST(Render, CoincidentSpheresAgreeWithTheReference) {
  Scene scene = ours("diffuse");
  const std::vector<Sphere> spheres = scene.spheres;
  scene.materials.push_back(closed_form::mirror(0.5));
  for (Sphere sphere : spheres) {
    sphere.material = uint32_t(scene.materials.size() - 1);
    scene.spheres.push_back(sphere);
  }
  expectAgreement("coincident", scene, settingsOf(scene, 160, 120), {});
}

// 0.1 is not a float and 0.7 * 0.7 not 0.49: equal is not below, in both renderers.
TEST(Render, WeightsEqualToTheLeastAreKept) {
  for (const auto& [reflect, least] : {std::pair{0.1, 0.1}, {0.7, 0.49}, {0.3, 0.09}, {0.2, 0.04}}) {
    Scene scene = ours("mirrors");
    for (Material& material : scene.materials) {
      material.reflect = reflect;
      material.localWeight = 1 - reflect;
    }
    RenderSettings settings = settingsOf(scene, 80, 40);
    settings.minWeight = least;
    expectAgreement("least_weight", scene, settings, {});
    EXPECT_GT(countShaderRays(scene, settings).reflected, 0u);
  }
}

// Products of weights underflow in float32 long before the rays end; they still are rays.
TEST(Render, CountsRaysOfWeightsThatUnderflow) {
  Scene scene;  // a corridor of mirrors without end
  scene.camera = {.eye = {0, 0, 0}, .target = {0, 0, -1}};
  scene.materials = {closed_form::mirror(0.001)};
  for (const double z : {-1.0, 1.0}) closed_form::addQuad(scene, {-1e4, -1e4, z}, {2e4, 0, 0}, {0, 2e4, 0}, 0);
  RenderSettings settings = settingsOf(scene, 32, 16);
  settings.depth = 30;
  EXPECT_EQ(countShaderRays(scene, settings).reflected, 32u * 16u * 29u);
  EXPECT_EQ(renderReference(scene, settings).rays.reflected, 32u * 16u * 29u);
}

TEST(Render, AgreesWithTheReferenceUnderEverySetting) {
  Scene scene = ours("spheres");
  scene.lights.push_back({.position = {0, 6, 2}, .color = {9, 9, 9}, .falloff = Falloff::inverseSquare});
  RenderSettings settings = settingsOf(scene, 100, 60, 2);
  settings.sampler = Sampler::jitter;
  settings.seed = 4'000'000'000u;
  settings.depth = 7;
  settings.minWeight = 0.05;
  expectAgreement("settings", scene, settings, {});
}

// --- edges of the input ---------------------------------------------------------------------------------------------

TEST(Render, EmptySceneIsItsBackground) {
  Scene scene;
  scene.background = {0.25, 0.5, 0.75};
  const RenderSettings settings = settingsOf(scene, 9, 7, 3);
  const Image image = renderShader(scene, settings);
  for (size_t i = 0; i < image.rgb.size(); ++i) EXPECT_EQ(image.rgb[i], (i % 3 + 1) * 0.25f);
  EXPECT_EQ(countShaderRays(scene, settings), (RayCounts{9 * 7 * 9, 0, 0, 0}));
}

TEST(Render, ObjectsWithoutLightsAreBlack) {
  Scene scene = ours("diffuse");
  scene.lights.clear();
  scene.background = {0, 0, 0};
  for (const float value : renderShader(scene, settingsOf(scene, 32, 32)).rgb) EXPECT_EQ(value, 0.0f);
}

TEST(Render, ManyLightsAreAllSeen) {
  Scene scene;
  scene.camera = {.eye = {0, 3, 3}, .target = {0, 0, 0}};
  scene.materials = {closed_form::matte({1, 1, 1})};
  closed_form::addFloor(scene, 0, 50, 0);
  // A hundred lights in one place, and as many below the floor that never count: more than one search can look at.
  for (int i = 0; i < 200; ++i)
    scene.lights.push_back({.position = {0, i % 2 ? 5.0 : -5.0, 0}, .color = glm::dvec3(0.01)});
  RenderSettings settings = settingsOf(scene, 3, 3);
  const Image image = renderShader(scene, settings);
  const Image expected = renderReference(scene, settings).image;
  for (size_t i = 0; i < image.rgb.size(); ++i) EXPECT_NEAR(image.rgb[i], expected.rgb[i], 2e-6);
  EXPECT_EQ(countShaderRays(scene, settings).shadow, 9u * 100u);
}

TEST(Render, DeepestRayTreeEnds) {
  Scene scene = ours("mirrors");
  RenderSettings settings = settingsOf(scene, 40, 24);
  settings.depth = kMaxDepth;
  const ReferencePicture reference = renderReference(scene, settings);
  EXPECT_LE(compareImages(renderShader(scene, settings), reference.image, 1e-3).badPixels, 0.01);
}

TEST(Render, WorkGroupBeyondTheDeviceIsRefused) {
  const Scene scene = ours("diffuse");
  EXPECT_THROW(renderShader(scene, settingsOf(scene, 8, 8), {.workGroup = 1 << 20}), InputError);
  EXPECT_THROW(renderShader(scene, settingsOf(scene, 8, 8), {.workGroup = 0}), InputError);
}

// The eye's lists cover the pixels that they were made for, and no others.
TEST(Render, RefusesAnotherPictureThanTheScenesLists) {
  const Scene scene = ours("diffuse");
  RenderSettings settings = settingsOf(scene, 32, 32);
  settings.crop = {8, 8, 24, 24};
  test::renderer().upload(test::packed(scene, settings));
  EXPECT_NO_THROW(test::renderer().render(test::kernel(), settings));
  RenderSettings other = settings;
  other.crop = {8, 8, 25, 24};
  EXPECT_THROW(test::renderer().render(test::kernel(), other), RunError);
  other = settings;
  other.width = 33;
  EXPECT_THROW(test::renderer().render(test::kernel(), other), RunError);
}

TEST(Render, TearsDownWithoutComplaints) {
  {
    const Scene scene = ours("diffuse");
    ShaderRenderer own(chooseDevice(listDevices(), ""));
    const RenderSettings settings = settingsOf(scene, 16, 16);
    own.upload(test::packed(scene, settings));
    own.render(test::kernel(), settings);
  }
  EXPECT_NO_THROW(throwIfInvalid());
}

TEST(Render, ProgressGrowsAndMayEndTheRender) {
  const Scene scene = ours("diffuse");
  const RenderSettings settings = settingsOf(scene, 64, 64, 5);
  test::renderer().upload(test::packed(scene, settings));
  double last = 0;
  test::renderer().render(test::kernel(), settings,
                          [&](double share) {
                            EXPECT_GE(share, last);
                            EXPECT_LE(share, 1);
                            last = share;
                          },
                          {.tile = 16});
  EXPECT_EQ(last, 1);
  struct Stop {};
  EXPECT_THROW(test::renderer().render(test::kernel(), settings, [](double) { throw Stop(); }), Stop);
}

// --- leaving a surface ----------------------------------------------------------------------------------------------

// A flat floor of many triangles under a light a hundredth of a degree above it: no triangle may shadow its neighbour.
TEST(Render, TessellatedFloorDoesNotShadowItself) {
  // Floors along the axes have exact normals, tilted ones do not.
  const double tilt = 0.7, turn = 0.4;
  const auto tilted = [&](const glm::dvec3& p) {
    const glm::dvec3 q(p.x, p.y * std::cos(tilt) - p.z * std::sin(tilt), p.y * std::sin(tilt) + p.z * std::cos(tilt));
    return glm::dvec3(q.x * std::cos(turn) - q.y * std::sin(turn), q.x * std::sin(turn) + q.y * std::cos(turn), q.z);
  };
  for (const double cell : {0.01, 1.0, 1000.0}) {
    for (const double away : {0.0, 1e4}) {
      for (const bool flat : {true, false}) {
        SCOPED_TRACE(std::to_string(cell) + ", moved by " + std::to_string(away) + (flat ? "" : ", tilted"));
        const auto place = [&](double x, double y, double z) {
          const glm::dvec3 p = cell * glm::dvec3(x, y, z);
          return glm::dvec3(away, 0, away / 3) + (flat ? p : tilted(p));
        };
        Scene scene;
        scene.camera = {
            .eye = place(0, 8, 12), .target = place(0, 0, 0), .up = place(0, 1, 0) - place(0, 0, 0), .fov = 30};
        scene.materials = {closed_form::matte({1, 1, 1})};
        scene.lights = {{.position = place(1e4, 1e4 * std::tan(0.01 * closed_form::kDegree), 3e3)}};
        for (int i = -24; i < 24; ++i)
          for (int j = -24; j < 24; ++j) {
            const glm::dvec3 corner = place(i, 0, j + 1);
            closed_form::addQuad(scene, corner, place(i + 1, 0, j + 1) - corner, place(i, 0, j) - corner, 0);
          }
        const Image image = renderShader(scene, settingsOf(scene, 200, 200));
        size_t lit = 0;
        for (size_t i = 0; i < image.rgb.size(); i += 3) lit += image.rgb[i] > 0;
        EXPECT_EQ(lit, image.window.area());
      }
    }
  }
}

// --- bounded work ---------------------------------------------------------------------------------------------------

// Dots that few lanes of a unit hit at a time, above many lights that light none of them: loops turn mostly for one
// lane, and the walks in them for none. All of that must be within the bounds too.
TEST(Render, LoopsOfFewLanesAreBounded) {
  Scene scene;
  scene.camera = {.eye = {0, 0, 3}, .target = {0, 0, 0}, .fov = 1};
  scene.materials = {closed_form::matte({1, 1, 1})};
  scene.spheres = {{{0, 0, -9}, 0.01, 0}};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-0.0262, 0.0262), anywhere(-1, 1);
  for (int i = 0; i < 2700; ++i) {
    const glm::dvec3 corner(place(random), place(random), 0);
    scene.addTriangle({corner, corner + glm::dvec3(5e-4, 0, 0), corner + glm::dvec3(0, 5e-4, 0)}, 0);
  }
  for (int i = 0; i < 300; ++i) scene.lights.push_back({.position = {anywhere(random), anywhere(random), -2}});
  const RenderSettings settings = settingsOf(scene, 8, 8, 16);
  for (const TraversalStart lightBuffers : {TraversalStart::lists, TraversalStart::wholeTree}) {
    test::renderer().upload(test::packed(scene, settings, lightBuffers));
    EXPECT_NO_THROW(test::renderer().render(test::kernel(), settings));
  }
}

// lavapipe up to some version ends all loops of an invocation after 65,535 iterations (22.3.6 does, 26.2.6 does not).
// Without the kernel's bounds this scene needs more: where loops are ended the canary must see it, and the render must
// fail; else the picture is that of the bounded kernel, which DeepGlassAgreesWithTheReference checks.
TEST(Render, FiredLoopLimiterIsReported) {
  Scene scene = ours("deep_glass");
  scene.depth = 16;
  const RenderSettings settings = settingsOf(scene, 64, 64);
  const Image expected = renderShader(scene, settings);
  try {
    EXPECT_TRUE(sameBits(renderShader(scene, settings, {.budget = 1u << 30}), expected))
        << "loops were cut, and the canary did not see it";
  } catch (const RunError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("loop limiter"));
  }
}

}  // namespace
}  // namespace turner
