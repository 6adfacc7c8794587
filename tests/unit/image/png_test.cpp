// PNG files as libpng itself reads them back.
#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "image/png.h"

namespace turner {
namespace {

struct Decoded {
  unsigned width = 0, height = 0;
  std::vector<png_byte> rgb;
};

Decoded decode(const std::string& bytes) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  Decoded decoded;
  if (!png_image_begin_read_from_memory(&png, bytes.data(), bytes.size())) {
    ADD_FAILURE() << png.message;
    return decoded;
  }
  EXPECT_EQ(png.format, png_uint_32(PNG_FORMAT_RGB)) << "not 8-bit RGB";
  png.format = PNG_FORMAT_RGB;
  decoded.width = png.width;
  decoded.height = png.height;
  decoded.rgb.resize(PNG_IMAGE_SIZE(png));
  if (!png_image_finish_read(&png, nullptr, decoded.rgb.data(), 0, nullptr)) ADD_FAILURE() << png.message;
  return decoded;
}

// The byte that one linear value becomes.
int encodeValue(float linear) {
  Image image(1, 1, Window{0, 0, 1, 1});
  image.rgb = {linear, 0, 0};
  return decode(encodePng(image)).rgb.at(0);
}

Image makePattern(int width, int height) {
  Image image(width, height, Window{0, 0, width, height});
  for (size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = float(i % 97) / 96;
  return image;
}

TEST(Png, KnownValuesOfTheTransferFunction) {
  EXPECT_EQ(encodeValue(0), 0);
  EXPECT_EQ(encodeValue(0.0031308f), 10);  // 12.92 * 0.0031308 * 255 = 10.31, where the two branches meet
  EXPECT_EQ(encodeValue(0.5f), 188);
  EXPECT_EQ(encodeValue(0.18f), 118);
  EXPECT_EQ(encodeValue(0.21404114f), 128);  // (0.5 encoded) * 255 = 127.5 rounds up
  EXPECT_EQ(encodeValue(1), 255);
}

TEST(Png, ValuesRoundToTheNearestByte) {
  // On the linear branch a byte's neighbourhood ends at (k + 0.5) / (255 * 12.92).
  const double half = 4.5 / (255 * 12.92);
  EXPECT_EQ(encodeValue(float(half * 0.999)), 4);
  EXPECT_EQ(encodeValue(float(half * 1.001)), 5);
  EXPECT_EQ(encodeValue(0.995f), 254);
  EXPECT_EQ(encodeValue(0.999f), 255);
}

TEST(Png, EveryByteIsReachedByItsOwnLinearValue) {
  Image image(256, 1, Window{0, 0, 256, 1});
  for (int k = 0; k < 256; ++k) {
    const double encoded = k / 255.0;
    const double linear = encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
    for (int c = 0; c < 3; ++c) image.rgb[size_t(3 * k + c)] = float(linear);
  }
  const Decoded decoded = decode(encodePng(image));
  ASSERT_EQ(decoded.rgb.size(), 768u);
  for (int k = 0; k < 256; ++k) EXPECT_EQ(decoded.rgb[size_t(3 * k)], k);
}

TEST(Png, ValuesOutsideTheRangeAreClampedAndNanIsBlack) {
  EXPECT_EQ(encodeValue(2), 255);
  EXPECT_EQ(encodeValue(-1), 0);
  EXPECT_EQ(encodeValue(-0.0f), 0);
  EXPECT_EQ(encodeValue(std::numeric_limits<float>::infinity()), 255);
  EXPECT_EQ(encodeValue(-std::numeric_limits<float>::infinity()), 0);
  EXPECT_EQ(encodeValue(std::numeric_limits<float>::quiet_NaN()), 0);
  EXPECT_EQ(encodeValue(std::numeric_limits<float>::denorm_min()), 0);
}

TEST(Png, ChannelsAndRowsKeepTheirOrder) {
  Image image(2, 2, Window{0, 0, 2, 2});
  image.rgb = {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 0};
  const std::vector<png_byte> expected = {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 0};
  EXPECT_EQ(decode(encodePng(image)).rgb, expected);
}

TEST(Png, ACropHasTheSizeOfItsWindow) {
  const Decoded decoded = decode(encodePng(Image(100, 80, Window{10, 20, 15, 23})));
  EXPECT_EQ(decoded.width, 5u);
  EXPECT_EQ(decoded.height, 3u);
}

TEST(Png, SaysThatItIsSrgbAndCarriesNoDate) {
  const std::string bytes = encodePng(makePattern(3, 3));
  EXPECT_NE(bytes.find("sRGB"), std::string::npos);
  EXPECT_EQ(bytes.find("tIME"), std::string::npos);
}

TEST(Png, TheSamePictureGivesTheSameBytes) {
  const Image image = makePattern(61, 47);
  EXPECT_EQ(encodePng(image), encodePng(image));
}

}  // namespace
}  // namespace turner
