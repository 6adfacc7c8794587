// The benchmark's judge must find each kind of difference, and only those that are too large.
#include <gmock/gmock.h>

#include <cmath>

#include "base/errors.h"
#include "support/agreement.h"

namespace turner::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr RayCounts kRays{10'000, 2000, 400, 30'000};

Image greyPicture() {
  Image image(100, 100, {0, 0, 100, 100});
  std::fill(image.rgb.begin(), image.rgb.end(), 0.5f);
  return image;
}

std::vector<std::string> judge(const Image& image, const RayCounts& rays) {
  const Image grey = greyPicture();
  return disagreements({grey, kRays}, {image, rays});
}

// Changes one channel of this many pixels.
Image perturbed(size_t pixels, float by) {
  Image image = greyPicture();
  for (size_t i = 0; i < pixels; ++i) image.rgb[3 * i + i % 3] += by;
  return image;
}

TEST(Agreement, IsFoundInEqualPictures) {
  EXPECT_THAT(judge(greyPicture(), kRays), IsEmpty());
}

TEST(Agreement, AllowsDifferencesInThreePixelsOfAHundred) {
  EXPECT_THAT(judge(perturbed(300, 0.25f), kRays), IsEmpty());
  EXPECT_THAT(judge(perturbed(301, 0.25f), kRays), ElementsAre(HasSubstr("pixels")));
}

TEST(Agreement, AllowsAThousandthInEveryChannel) {
  EXPECT_THAT(judge(perturbed(10'000, 0.0009f), kRays), IsEmpty());
  EXPECT_THAT(judge(perturbed(10'000, -0.0011f), kRays), ElementsAre(HasSubstr("pixels")));
}

TEST(Agreement, FindsNaN) {
  EXPECT_THAT(judge(perturbed(301, NAN), kRays), ElementsAre(HasSubstr("pixels")));
}

TEST(Agreement, FindsEveryKindOfRayThatIsMissing) {
  for (const auto& [name, count] :
       {std::pair{"eye", &RayCounts::eye}, {"reflected", &RayCounts::reflected}, {"shadow", &RayCounts::shadow}}) {
    for (const double factor : {0.994, 1.006}) {
      RayCounts rays = kRays;
      rays.*count = uint64_t(double(kRays.*count) * factor);
      EXPECT_THAT(judge(greyPicture(), rays), ElementsAre(HasSubstr(name))) << factor;
    }
    for (const double factor : {0.996, 1.004}) {
      RayCounts rays = kRays;
      rays.*count = uint64_t(double(kRays.*count) * factor);
      EXPECT_THAT(judge(greyPicture(), rays), IsEmpty()) << name << factor;
    }
  }
}

TEST(Agreement, PassesOverKindsWithFewRaysInBothPictures) {
  RayCounts rays = kRays;
  rays.refracted = 300;
  EXPECT_THAT(judge(greyPicture(), rays), IsEmpty());
  rays.refracted = 1200;
  EXPECT_THAT(judge(greyPicture(), rays), ElementsAre(HasSubstr("refracted")));
}

TEST(Agreement, RefusesPicturesOfUnequalSize) {
  const Image smaller(99, 100, {0, 0, 99, 100});
  EXPECT_THROW(judge(smaller, kRays), InputError);
}

}  // namespace
}  // namespace turner::test
