// The three errors against pictures whose errors are known.
#include "image/error_analysis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "reference/reference.h"
#include "support/closed_form.h"
#include "support/shader_harness.h"

namespace turner {
namespace {

using closed_form::addMaterial, closed_form::lookAt, closed_form::matte;
using glm::dvec3;

constexpr int kSize = 32;

Image constantPicture(float value) {
  Image image(kSize, kSize, {0, 0, kSize, kSize});
  for (float& channel : image.rgb) channel = value;
  return image;
}

// Rounds of noise around 0.5, uniform in +-amplitude: of rms amplitude / sqrt(3).
RenderPicture noise(double amplitude) {
  return [amplitude](const RenderSettings& settings) {
    std::mt19937 engine(settings.seed);
    Image image = constantPicture(0.5f);
    for (float& channel : image.rgb) channel += float(amplitude * (double(engine()) * 0x1p-31 - 1));
    return image;
  };
}

RenderSettings settings(int samples = 1) {
  RenderSettings made = closed_form::pixels(kSize, kSize);
  made.samples = samples;
  return made;
}

// A black half-plane before white, with a slanted edge through the middle.
Scene edgeScene() {
  Scene scene;
  scene.background = dvec3(1);
  scene.camera = lookAt({0, 0, 1}, {0, 0, 0}, {0, 1, 0}, 90);
  scene.addTriangle({dvec3(-30, -9.7, 0), dvec3(30, 10.1, 0), dvec3(-30, 90, 0)}, addMaterial(scene, matte(dvec3(0))));
  return scene;
}

SamplingError samplingOf(const Scene& scene, const RenderSettings& how) {
  const auto render = [&](const RenderSettings& any) { return test::renderShader(scene, any); };
  return measureSampling(render(how), how, render, 1e-3);
}

TEST(Sampling, OfAConstantBackgroundHasNoError) {
  Scene scene;
  scene.background = {0.25, 0.5, 1};
  for (const int n : {1, 2, 3}) {
    const SamplingError error = samplingOf(scene, settings(n));
    EXPECT_EQ(error.figures.rmse, 0);
    EXPECT_EQ(error.figures.max, 0);
    EXPECT_EQ(error.ownError, 0);
    EXPECT_TRUE(error.converged);
    EXPECT_EQ(error.samples, 2u * 16 * unsigned(n * n));
  }
}

TEST(Sampling, ErrorOfAnEdgeFallsWithTheSamples) {
  const Scene scene = edgeScene();
  for (const Sampler sampler : {Sampler::grid, Sampler::jitter}) {
    double last = 1;
    for (const int n : {1, 2, 4, 8}) {
      RenderSettings how = settings(n);
      how.sampler = sampler;
      const SamplingError error = samplingOf(scene, how);
      EXPECT_TRUE(error.converged);
      EXPECT_LE(error.ownError, error.figures.rmse / 4);
      EXPECT_GT(error.ownError, 0);
      // n^-3/2 for an edge: by 2.8 at each step.
      EXPECT_LT(error.figures.rmse, last / 2) << n;
      EXPECT_GT(error.figures.rmse, 1e-4) << n;
      last = error.figures.rmse;
    }
  }
}

TEST(Sampling, ErrorIsThatAgainstTheEdgesArea) {
  // A vertical edge that leaves each pixel of its column 0.3 white: one sample at the centre is 0.3 too dark there.
  Scene scene = edgeScene();
  const double edge = (2 * 16.7 - kSize) / kSize;
  scene.positions = {dvec3(edge, -90, 0), dvec3(edge, 90, 0), dvec3(-90, 0, 0)};
  const SamplingError error = samplingOf(scene, settings());
  const double expected = 0.3 * std::sqrt(1.0 / kSize);
  EXPECT_NEAR(error.figures.rmse, expected, 0.03 * expected);
  EXPECT_NEAR(error.figures.meanSigned, -0.3 / kSize, 0.03 * 0.3 / kSize);
}

TEST(Sampling, TakesJitterOfOtherSeedsAndKeepsAllOtherSettings) {
  RenderSettings how = settings(3);
  how.seed = UINT32_MAX - 1;
  how.depth = 7;
  how.minWeight = 0.125;
  how.crop = {1, 2, 5, 6};
  std::vector<uint32_t> seeds;
  measureSampling(
      Image(kSize, kSize, how.crop), how,
      [&](const RenderSettings& finer) {
        EXPECT_EQ(finer.sampler, Sampler::jitter);
        EXPECT_EQ(finer.samples, 12);
        EXPECT_EQ(finer.depth, 7);
        EXPECT_EQ(finer.minWeight, 0.125);
        EXPECT_EQ(finer.crop, how.crop);
        EXPECT_EQ(finer.width, kSize);
        seeds.push_back(finer.seed);
        return Image(kSize, kSize, finer.crop);
      },
      1e-3);
  EXPECT_EQ(seeds, (std::vector<uint32_t>{UINT32_MAX, 0}));
}

TEST(Sampling, RoundsHaveAtMostAsManySamplesAsThereMayBe) {
  measureSampling(
      constantPicture(1), settings(100),
      [](const RenderSettings& finer) {
        EXPECT_EQ(finer.samples, kMaxSamples);
        return constantPicture(1);
      },
      1e-3);
}

TEST(Sampling, OwnErrorIsThatOfTheMeanAndIsTakenOffTheFigure) {
  // The picture is off by 0.1 everywhere, each round by a noise of rms 0.1: converged when 0.1 / sqrt(rounds) <= 0.1
  // / 4.
  const double rms = 0.1;
  const SamplingError error = measureSampling(constantPicture(0.6f), settings(), noise(rms * std::sqrt(3)), 1e-3);
  EXPECT_TRUE(error.converged);
  const double rounds = double(error.samples) / 16;
  EXPECT_NEAR(rounds, 16, 2);
  EXPECT_NEAR(error.ownError, rms / std::sqrt(rounds), 0.05 * rms / std::sqrt(rounds));
  // With the noise it would be 0.103.
  EXPECT_NEAR(error.figures.rmse, 0.1, 0.001);
}

TEST(Sampling, SaysThatItDidNotConverge) {
  int rounds = 0;
  const RenderPicture render = [&](const RenderSettings& any) {
    ++rounds;
    return noise(0.4)(any);
  };
  const SamplingError error = measureSampling(constantPicture(0.5f), settings(), render, 1e-3, {.rounds = 6});
  EXPECT_FALSE(error.converged);
  EXPECT_EQ(rounds, 6);
  EXPECT_EQ(error.samples, 6u * 16);
  EXPECT_NEAR(error.ownError, 0.4 / std::sqrt(3 * 6), 0.01);
  EXPECT_LT(error.figures.rmse, error.ownError);
}

TEST(Sampling, BeginsNoRoundWhenItsTimeIsOver) {
  int rounds = 0;
  const RenderPicture render = [&](const RenderSettings& any) {
    ++rounds;
    return noise(0.4)(any);
  };
  EXPECT_FALSE(measureSampling(constantPicture(0.5f), settings(), render, 1e-3, {.seconds = 0}).converged);
  EXPECT_EQ(rounds, 2);
}

TEST(Quantisation, OfFloatsInAFrameOfAPowerOfTwoIsNothing) {
  Scene scene;
  scene.background = {0.25, 0.5, 0.75};
  scene.camera = lookAt({0, 0, 0}, {0, 0, -4}, {0, 1, 0}, 50);
  scene.lights = {{.position = {3, 5, 1}, .color = {20, 30, 40}, .falloff = Falloff::inverseSquare}};
  const uint32_t ball =
      addMaterial(scene, {.name = "ball", .diffuse = {0.5, 0.25, 0.75}, .reflect = 0.25, .localWeight = 0.75});
  scene.spheres.push_back({{0.5, 0.25, -4}, 0.75, ball});
  closed_form::addFloor(scene, -1, 8, ball);
  const RenderSettings how = settings(2);
  EXPECT_EQ(renderReference(roundScene(scene), how).image.rgb, renderReference(scene, how).image.rgb);

  // A ball whose centre is no float moves, and with it what is seen.
  scene.spheres[0].center.x = 0.1;
  EXPECT_NE(renderReference(roundScene(scene), how).image.rgb, renderReference(scene, how).image.rgb);
}

}  // namespace
}  // namespace turner
