// The comparer against differences that are known beforehand.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "base/errors.h"
#include "image/compare.h"

namespace turner {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

Image makeWhole(int width, int height, float value) {
  Image image(width, height, Window{0, 0, width, height});
  for (float& v : image.rgb) v = value;
  return image;
}

// All channels of pixel i have the error i / 1000 against black.
Image makeRamp(int pixels) {
  Image image = makeWhole(pixels, 1, 0);
  for (int i = 0; i < pixels; ++i) {
    for (int c = 0; c < 3; ++c) image.rgb[size_t(3 * i + c)] = float(i) / 1024;
  }
  return image;
}

std::string messageOf(const Image& a, const Image& b) {
  try {
    compareImages(a, b, 0);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Compare, EqualPicturesDifferByNothing) {
  const Image a = makeRamp(7);
  const Comparison c = compareImages(a, a, 0);
  EXPECT_EQ(c.rmse, 0);
  EXPECT_EQ(c.relRmse, 0);
  EXPECT_EQ(c.mae, 0);
  EXPECT_EQ(c.max, 0);
  EXPECT_EQ(c.meanSigned, 0);
  EXPECT_EQ(c.p999, 0);
  EXPECT_EQ(c.badPixels, 0);
  EXPECT_EQ(c.width, 7);
  EXPECT_EQ(c.height, 1);
}

TEST(Compare, AConstantOffsetIsEveryFigureAndItsSignIsOfAMinusB) {
  const Image a = makeWhole(5, 4, 0.75f), b = makeWhole(5, 4, 0.5f);
  const Comparison c = compareImages(a, b, 0.125);
  for (const double figure : {c.rmse, c.mae, c.max, c.meanSigned, c.p50, c.p99, c.p999}) EXPECT_EQ(figure, 0.25);
  EXPECT_EQ(c.badPixels, 1);
  EXPECT_EQ(compareImages(b, a, 0.125).meanSigned, -0.25);
}

TEST(Compare, OneChangedPixelShowsInMaxAndInItsShare) {
  const Image a = makeWhole(10, 10, 0.5f);
  Image b = a;
  b.rgb[3 * 42 + 1] = 1.5f;
  const Comparison c = compareImages(a, b, 0.01);
  EXPECT_EQ(c.max, 1);
  EXPECT_DOUBLE_EQ(c.rmse, std::sqrt(1.0 / 300));
  EXPECT_DOUBLE_EQ(c.mae, 1.0 / 300);
  EXPECT_DOUBLE_EQ(c.meanSigned, -1.0 / 300);
  EXPECT_DOUBLE_EQ(c.badPixels, 0.01);
  EXPECT_EQ(c.p50, 0);
  EXPECT_EQ(c.p99, 0);
  EXPECT_EQ(c.p999, 1);
}

TEST(Compare, ASignBalancedDifferenceHasNoBiasButAnError) {
  Image a = makeWhole(4, 4, 1);
  const Image b = a;
  for (size_t i = 0; i < a.rgb.size(); ++i) a.rgb[i] += i % 2 == 0 ? 0.25f : -0.25f;
  const Comparison c = compareImages(a, b, 0);
  EXPECT_EQ(c.meanSigned, 0);
  EXPECT_EQ(c.mae, 0.25);
  EXPECT_EQ(c.rmse, 0.25);
}

TEST(Compare, APictureShiftedByOnePixelDiffersWhereItsEdgesAre) {
  // A white bar, columns 3 to 5, against the same bar one column further right: two columns of eight differ by 1.
  Image a = makeWhole(8, 6, 0), b = a;
  for (size_t y = 0; y < 6; ++y) {
    for (size_t x = 3; x < 6; ++x) {
      for (size_t c = 0; c < 3; ++c) {
        a.rgb[3 * (8 * y + x) + c] = 1;
        b.rgb[3 * (8 * y + x + 1) + c] = 1;
      }
    }
  }
  const Comparison c = compareImages(a, b, 0.5);
  EXPECT_EQ(c.max, 1);
  EXPECT_EQ(c.badPixels, 0.25);
  EXPECT_EQ(c.mae, 0.25);
  EXPECT_EQ(c.rmse, 0.5);
  EXPECT_EQ(c.meanSigned, 0);
  EXPECT_FALSE(brokenBounds(c, {.rmse = 0.01}).empty());
}

TEST(Compare, NanIsCountedAsBadAndLeftOutOfTheRest) {
  Image a = makeWhole(2, 2, 1);
  const Image b = makeWhole(2, 2, 0.5f);
  a.rgb[4] = kNan;
  a.rgb[5] = kNan;
  const Comparison c = compareImages(a, b, 10);
  EXPECT_EQ(c.nan, 1u);
  EXPECT_EQ(c.inf, 0u);
  EXPECT_EQ(c.badPixels, 0.25);
  EXPECT_EQ(c.rmse, 0.5);
  EXPECT_EQ(c.max, 0.5);
  EXPECT_EQ(compareImages(b, a, 10).nan, 1u);
}

TEST(Compare, InfinityIsCountedEvenWhereBothPicturesAgree) {
  Image a = makeWhole(2, 2, 1), b = a;
  a.rgb[0] = b.rgb[0] = kInf;
  b.rgb[3] = -kInf;
  const Comparison c = compareImages(a, b, 10);
  EXPECT_EQ(c.inf, 2u);
  EXPECT_EQ(c.nan, 0u);
  EXPECT_EQ(c.badPixels, 0.5);
  EXPECT_EQ(c.max, 0);
}

TEST(Compare, APixelWithBothNanAndInfinityCountsInBothButIsOneBadPixel) {
  Image a = makeWhole(2, 1, 1);
  const Image b = a;
  a.rgb[0] = kNan;
  a.rgb[1] = kInf;
  const Comparison c = compareImages(a, b, 10);
  EXPECT_EQ(c.nan, 1u);
  EXPECT_EQ(c.inf, 1u);
  EXPECT_EQ(c.badPixels, 0.5);
}

TEST(Compare, WithoutAFinitePixelTheFiguresAreZeroAndTheCountsTell) {
  const Comparison c = compareImages(makeWhole(3, 2, kNan), makeWhole(3, 2, kInf), 0);
  for (const double figure : {c.rmse, c.relRmse, c.mae, c.max, c.meanSigned, c.p50, c.p99, c.p999})
    EXPECT_EQ(figure, 0);
  EXPECT_EQ(c.nan, 6u);
  EXPECT_EQ(c.inf, 6u);
  EXPECT_EQ(c.badPixels, 1);
}

TEST(Compare, NegativeZeroEqualsZero) {
  const Comparison c = compareImages(makeWhole(2, 2, -0.0f), makeWhole(2, 2, 0.0f), 0);
  EXPECT_EQ(c.max, 0);
  EXPECT_FALSE(std::signbit(c.meanSigned));
  EXPECT_EQ(c.badPixels, 0);
}

TEST(Compare, PercentilesOfARampAreItsNearestRanks) {
  // Errors 0/1024 .. 999/1024: the ranks are 500, 990 and 999, counted from 1.
  const Comparison c = compareImages(makeRamp(1000), makeWhole(1000, 1, 0), 0);
  EXPECT_EQ(c.p50, 499.0 / 1024);
  EXPECT_EQ(c.p99, 989.0 / 1024);
  EXPECT_EQ(c.p999, 998.0 / 1024);
  EXPECT_EQ(c.max, 999.0 / 1024);
}

TEST(Compare, PercentilesRoundTheRankUp) {
  const Comparison three = compareImages(makeRamp(3), makeWhole(3, 1, 0), 0);
  EXPECT_EQ(three.p50, 1.0 / 1024);
  EXPECT_EQ(three.p99, 2.0 / 1024);
  const Comparison hundredAndOne = compareImages(makeRamp(101), makeWhole(101, 1, 0), 0);
  EXPECT_EQ(hundredAndOne.p50, 50.0 / 1024);
  EXPECT_EQ(hundredAndOne.p99, 99.0 / 1024);
  EXPECT_EQ(hundredAndOne.p999, 100.0 / 1024);
}

TEST(Compare, PercentilesGoByTheLargestChannelOfAPixel) {
  Image a = makeWhole(1, 1, 0);
  a.rgb = {0.125f, -0.5f, 0.25f};
  EXPECT_EQ(compareImages(a, makeWhole(1, 1, 0), 0).p50, 0.5);
}

TEST(Compare, AnErrorEqualToTheThresholdIsNotBad) {
  const Image a = makeWhole(2, 2, 0.5f), b = makeWhole(2, 2, 0.25f);
  EXPECT_EQ(compareImages(a, b, 0.25).badPixels, 0);
  EXPECT_EQ(compareImages(a, b, std::nextafter(0.25, 0)).badPixels, 1);
}

TEST(Compare, RelativeErrorDividesByTheSecondPictureWithAFloor) {
  // (a-b)^2 / (b^2 + 0.01): 1 / 4.01, 1 / 0.01 and 0.
  Image a = makeWhole(1, 1, 0), b = a;
  a.rgb = {3, 1, 5};
  b.rgb = {2, 0, 5};
  EXPECT_DOUBLE_EQ(compareImages(a, b, 0).relRmse, std::sqrt((1 / 4.01 + 100) / 3));
}

TEST(Compare, HugeValuesDoNotOverflowTheSums) {
  const float largest = std::numeric_limits<float>::max();
  const Comparison c = compareImages(makeWhole(2, 2, largest), makeWhole(2, 2, -largest), 0);
  EXPECT_EQ(c.max, 2.0 * double(largest));
  EXPECT_DOUBLE_EQ(c.rmse, 2.0 * double(largest));
}

TEST(Compare, ManySmallErrorsBesideALargeOneAreNotLost) {
  // 3 * 2^20 - 1 errors of 2^-24 and one of 2^20: in float arithmetic the small ones vanish.
  Image a = makeWhole(1024, 1024, 0x1p-24f);
  a.rgb[0] = 0x1p20f;
  const double count = 3 * 0x1p20;
  EXPECT_DOUBLE_EQ(compareImages(a, makeWhole(1024, 1024, 0), 0).mae, (0x1p20 + (count - 1) * 0x1p-24) / count);
}

TEST(Compare, DifferentSizesAreRefusedNamingBoth) {
  const std::string message = messageOf(makeWhole(4, 3, 0), makeWhole(5, 3, 0));
  EXPECT_NE(message.find("4 x 3 pixels"), std::string::npos) << message;
  EXPECT_NE(message.find("5 x 3 pixels"), std::string::npos) << message;
  EXPECT_THROW(errorImage(makeWhole(4, 3, 0), makeWhole(5, 3, 0)), InputError);
}

TEST(Compare, DifferentCropsAreRefusedNamingBoth) {
  const std::string message = messageOf(Image(10, 8, Window{1, 2, 4, 6}), makeWhole(10, 8, 0));
  EXPECT_NE(message.find("x 1 to 3, y 2 to 5"), std::string::npos) << message;
  EXPECT_NE(message.find("all there"), std::string::npos) << message;
}

TEST(Compare, EqualCropsOfDifferentPicturesAreRefused) {
  EXPECT_THROW(compareImages(Image(10, 8, Window{1, 2, 4, 6}), Image(11, 8, Window{1, 2, 4, 6}), 0), InputError);
}

TEST(Compare, EqualCropsAreComparedAndGiveTheirOwnSize) {
  const Image crop(10, 8, Window{1, 2, 4, 6});
  const Comparison c = compareImages(crop, crop, 0);
  EXPECT_EQ(c.width, 3);
  EXPECT_EQ(c.height, 4);
}

TEST(ErrorImage, IsTheAbsoluteDifferenceOfEachChannelInTheSameWindow) {
  Image a(4, 4, Window{1, 1, 2, 2}), b = a;
  a.rgb = {1, 2, kNan};
  b.rgb = {3, 0.5f, 0};
  const Image error = errorImage(a, b);
  EXPECT_EQ(error.width, 4);
  EXPECT_EQ(error.window, a.window);
  EXPECT_EQ(error.rgb[0], 2);
  EXPECT_EQ(error.rgb[1], 1.5f);
  EXPECT_TRUE(std::isnan(error.rgb[2]));
}

TEST(Within, ABoundHoldsWhenTheErrorEqualsItAndFailsJustBelow) {
  Comparison c;
  c.rmse = 0.5;
  c.max = 2;
  c.badPixels = 0.25;
  EXPECT_TRUE(brokenBounds(c, {.rmse = 0.5, .max = 2, .badPixels = 0.25}).empty());
  EXPECT_FALSE(brokenBounds(c, {.rmse = std::nextafter(0.5, 0), .max = 2, .badPixels = 0.25}).empty());
  EXPECT_FALSE(brokenBounds(c, {.rmse = 0.5, .max = std::nextafter(2, 0), .badPixels = 0.25}).empty());
  EXPECT_FALSE(brokenBounds(c, {.rmse = 0.5, .max = 2, .badPixels = std::nextafter(0.25, 0)}).empty());
}

TEST(Within, OnlyTheBoundsThatAreSetCount) {
  Comparison c;
  c.rmse = c.max = c.badPixels = 1;
  EXPECT_TRUE(brokenBounds(c, {}).empty());
  EXPECT_TRUE(brokenBounds(c, {.max = 1}).empty());
  EXPECT_FALSE(brokenBounds(c, {.badPixels = 0}).empty());
}

TEST(Within, ANanOrAnInfinityBreaksEveryBound) {
  for (const ErrorBounds& bounds : {ErrorBounds{.rmse = 100}, ErrorBounds{.max = 100}, ErrorBounds{.badPixels = 1}}) {
    Comparison nan, inf;
    nan.nan = 1;
    inf.inf = 1;
    EXPECT_FALSE(brokenBounds(nan, bounds).empty());
    EXPECT_FALSE(brokenBounds(inf, bounds).empty());
    EXPECT_TRUE(brokenBounds(Comparison{}, bounds).empty());
  }
}

TEST(Within, ABoundThatIsNotANumberDoesNotHold) {
  EXPECT_FALSE(brokenBounds(Comparison{}, {.rmse = double(kNan)}).empty());
}

}  // namespace
}  // namespace turner
