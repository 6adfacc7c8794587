// The envelope rule must excuse a pixel at an edge, and nothing that is wrong.
#include "image/envelope.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/errors.h"
#include "base/stopwatch.h"
#include "image/compare.h"
#include "reference/reference.h"
#include "support/closed_form.h"

namespace turner {
namespace {

using closed_form::addFloor, closed_form::addMaterial, closed_form::lookAt, closed_form::matte, closed_form::mirror;
using glm::dvec3;

constexpr int kSize = 9, kMiddle = 4;

RenderSettings settings(int samples = 1) {
  RenderSettings made = closed_form::pixels(kSize, kSize);
  made.samples = samples;
  return made;
}

float& channel(Image& image, int x, int y, int c) {
  return image.rgb[3 * (size_t(y) * kSize + size_t(x)) + size_t(c)];
}

// A black half-plane before white: its vertical edge goes through the centres of the pixels of this column, but for
// `past`, which is in units of the distance from the eye.
Scene halfPlane(int column, double past = 0) {
  Scene scene;
  scene.background = dvec3(1);
  scene.camera = lookAt({0, 0, 1}, {0, 0, 0}, {0, 1, 0}, 90);
  const double edge = (2 * column + 1 - kSize) / double(kSize) + past;
  scene.addTriangle({dvec3(edge, -90, 0), dvec3(edge, 90, 0), dvec3(-90, 0, 0)}, addMaterial(scene, matte(dvec3(0))));
  return scene;
}

EnvelopeRule judge(const Image& picture, const Scene& scene, const RenderSettings& how) {
  const Image reference = renderReference(scene, how).image;
  return applyEnvelope(picture, reference, [&](std::span<const Pixel> pixels, int rays) {
    return renderEnvelope(scene, how, pixels, rays);
  });
}

// A mirror ball on a floor under a light.
Scene ballOnFloor() {
  Scene scene;
  scene.background = {0.2, 0.3, 0.5};
  scene.camera = lookAt({0, 2, 6}, {0, 0.5, 0}, {0, 1, 0}, 40);
  scene.lights = {{.position = {3, 6, 4}}};
  scene.spheres.push_back({{0, 1, 0}, 1, addMaterial(scene, mirror(0.8))});
  addFloor(scene, 0, 20, addMaterial(scene, matte({0.7, 0.6, 0.5})));
  return scene;
}

TEST(Envelope, OfEqualPicturesIsNotNeeded) {
  const Scene scene = ballOnFloor();
  const EnvelopeRule rule = judge(renderReference(scene, settings()).image, scene, settings());
  EXPECT_EQ(rule.needed, 0);
  EXPECT_EQ(rule.excused, 0);
  EXPECT_EQ(rule.outside, 0u);
  EXPECT_EQ(rule.p999, 0);
}

TEST(Envelope, ExcusesAnEdgeThatHasFlipped) {
  const Scene scene = halfPlane(kMiddle);
  Image flipped = renderReference(scene, settings()).image;
  for (int y = 0; y < kSize; ++y)
    for (int c = 0; c < 3; ++c) channel(flipped, kMiddle, y, c) = 1 - channel(flipped, kMiddle, y, c);
  const EnvelopeRule rule = judge(flipped, scene, settings());
  EXPECT_DOUBLE_EQ(rule.needed, 1.0 / kSize);
  EXPECT_DOUBLE_EQ(rule.excused, 1.0 / kSize);
  EXPECT_EQ(rule.outside, 0u);
  EXPECT_EQ(rule.p999, 0);
}

TEST(Envelope, ExcusesByFourUlpAndNotByMore) {
  // In the middle column |d| is nearly all in z: a corner of the box moves the ray by 4 ulp across the edge.
  for (const double ulps : {0.3, 3.5, 4.5, 40.0}) {
    const Scene scene = halfPlane(kMiddle, ulps * 0x1p-24);
    Image flipped = renderReference(scene, settings()).image;
    for (int c = 0; c < 3; ++c) channel(flipped, kMiddle, kMiddle, c) = 1 - channel(flipped, kMiddle, kMiddle, c);
    EXPECT_EQ(judge(flipped, scene, settings()).outside, ulps < 4 ? 0u : 1u) << ulps;
  }
}

TEST(Envelope, DoesNotExcuseAnErrorOffTheEdge) {
  const Scene scene = ballOnFloor();
  Image wrong = renderReference(scene, settings()).image;
  channel(wrong, 1, 7, 1) += 1e-3f;
  const EnvelopeRule rule = judge(wrong, scene, settings());
  EXPECT_DOUBLE_EQ(rule.needed, 1.0 / (kSize * kSize));
  EXPECT_EQ(rule.excused, 0);
  EXPECT_EQ(rule.outside, 1u);
  EXPECT_NEAR(rule.p999, 1e-3, 1e-7);
  EXPECT_EQ(rule.p99, rule.p999) << "one pixel of 81";
}

TEST(Envelope, DoesNotExcuseAColourThatNeitherSideOfTheEdgeHas) {
  const Scene scene = halfPlane(kMiddle);
  Image wrong = renderReference(scene, settings()).image;
  channel(wrong, kMiddle, 2, 0) = 1.001f;
  channel(wrong, kMiddle, 3, 1) = -0.001f;
  EXPECT_EQ(judge(wrong, scene, settings()).outside, 2u);
}

TEST(Envelope, DoesNotExcuseNanAndInfinityAtAnEdge) {
  const Scene scene = halfPlane(kMiddle);
  for (const float value : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    Image wrong = renderReference(scene, settings()).image;
    channel(wrong, kMiddle, 2, 0) = value;
    const EnvelopeRule rule = judge(wrong, scene, settings());
    EXPECT_DOUBLE_EQ(rule.needed, 1.0 / (kSize * kSize));
    EXPECT_EQ(rule.outside, 1u);
  }
}

TEST(Envelope, BoundsAreTheMeansOfTheSamplesOwn) {
  // Of 3 x 3 samples the middle column of three lies on the edge: white from 3 to 6 of 9.
  const std::vector<Pixel> apart = {{kMiddle, 0}, {kMiddle, 8}, {kMiddle - 1, 4}, {kMiddle + 1, 4}};
  const std::vector<PixelBounds> bounds = renderEnvelope(halfPlane(kMiddle), settings(3), apart, kEnvelopeRays);
  ASSERT_EQ(bounds.size(), apart.size());
  for (int i = 0; i < 4; ++i) {
    const double least[] = {3, 3, 0, 9}, most[] = {6, 6, 0, 9};
    EXPECT_DOUBLE_EQ(bounds[size_t(i)].least.x, least[i] / 9) << i;
    EXPECT_DOUBLE_EQ(bounds[size_t(i)].most.z, most[i] / 9) << i;
  }
}

TEST(Envelope, HasTheReferencesOwnValuesInsideAndIsNarrowOffEdges) {
  const Scene scene = ballOnFloor();
  const Image reference = renderReference(scene, settings(2)).image;
  std::vector<Pixel> all;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) all.push_back({x, y});
  const std::vector<PixelBounds> bounds = renderEnvelope(scene, settings(2), all, kEnvelopeRays);
  size_t wide = 0;
  for (size_t i = 0; i < all.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      EXPECT_GE(reference.rgb[3 * i + size_t(c)], bounds[i].least[c] - 1e-7);
      EXPECT_LE(reference.rgb[3 * i + size_t(c)], bounds[i].most[c] + 1e-7);
      EXPECT_LT(bounds[i].least[c], bounds[i].most[c] + 1e-15);
      wide += bounds[i].most[c] - bounds[i].least[c] > 1e-4;
    }
  EXPECT_EQ(wide, 0u) << "no edge of this picture is within 4 ulp of a sample";
}

TEST(Envelope, PixelsApartAreThoseOfACropInThePicturesCoordinates) {
  Image a(20, 10, Window{5, 3, 9, 6});
  const Image b = a;
  a.rgb[3 * (2 * 4 + 1) + 2] = 2e-5f;
  a.rgb[0] = 0.9e-5f;  // within the tolerance
  const std::vector<Pixel> apart = pixelsApart(a, b);
  ASSERT_EQ(apart.size(), 1u);
  EXPECT_EQ(apart[0].x, 6);
  EXPECT_EQ(apart[0].y, 5);
}

TEST(Envelope, PercentilesAreOfWhatIsNotExcused) {
  Image a(10, 1, Window{0, 0, 10, 1});
  const Image b = a;
  a.rgb[0] = 1;
  a.rgb[3] = 0.25f;
  std::vector<std::vector<Pixel>> asked;
  const EnvelopeRule rule = applyEnvelope(a, b, [&](std::span<const Pixel> pixels, int) {
    asked.emplace_back(pixels.begin(), pixels.end());
    std::vector<PixelBounds> bounds(pixels.size());
    if (pixels.size() == 2) bounds[0] = {dvec3(0), dvec3(1)};
    return bounds;
  });
  ASSERT_EQ(asked.size(), 2u);
  ASSERT_EQ(asked[1].size(), 1u) << "what is excused is not asked for again";
  EXPECT_EQ(asked[1][0].x, 1);
  EXPECT_EQ(rule.needed, 0.2);
  EXPECT_EQ(rule.excused, 0.1);
  EXPECT_EQ(rule.outside, 1u);
  EXPECT_EQ(rule.p99, 0.25);
}

void interruptAtOnce() {
  const std::vector<Pixel> many(20000, Pixel{4, 4});
  EXPECT_THROW(renderEnvelope(ballOnFloor(), settings(64), many, kEnvelopeRays, [](double) { throw Interrupted(); }),
               Interrupted);
}

TEST(Envelope, CanBeInterrupted) {
  interruptAtOnce();
}

TEST(TimingEnvelope, EndsSoonWhereItIsInterrupted) {
  const Stopwatch watch;
  interruptAtOnce();
  EXPECT_LT(watch.seconds(), 5) << "all of it takes minutes";
}

}  // namespace
}  // namespace turner
