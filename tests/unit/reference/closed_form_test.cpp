// Every renderer against every scene of closed_form.h and cone_closed_forms.h.
#include <gtest/gtest.h>

#include <functional>
#include <ostream>
#include <string>
#include <tuple>
#include <vector>

#include "reference/reference.h"
#include "support/closed_form.h"
#include "support/cone_closed_forms.h"
#include "support/shader_harness.h"

namespace turner {
namespace {

struct Renderer {
  std::string name;
  std::function<Image(const Scene&, const RenderSettings&)> render;
};

void PrintTo(const Renderer& renderer, std::ostream* out) {
  *out << renderer.name;
}  // for GoogleTest

std::vector<Renderer> allRenderers() {
  return {
      {"Reference",
       [](const Scene& scene, const RenderSettings& settings) { return renderReference(scene, settings).image; }},
      {"Shader",
       [](const Scene& scene, const RenderSettings& settings) { return test::renderShader(scene, settings); }},
  };
}

class ClosedForm : public testing::TestWithParam<std::tuple<Renderer, closed_form::Case>> {};

TEST_P(ClosedForm, HasTheKnownValues) {
  const auto& [renderer, known] = GetParam();
  const Image image = renderer.render(known.scene, known.settings);
  ASSERT_EQ(image.window, known.settings.crop);
  for (const auto& expected : known.expected)
    for (int k = 0; k < 3; ++k) {
      const float value = image.rgb[3 * (size_t(expected.y) * size_t(image.width) + size_t(expected.x)) + size_t(k)];
      EXPECT_NEAR(value, expected.color[k], expected.tolerance)
          << "pixel (" << expected.x << ", " << expected.y << "), channel " << k;
    }
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, ClosedForm, testing::Combine(testing::ValuesIn(allRenderers()), testing::ValuesIn(closed_form::allCases())),
    [](const auto& test) {
      return std::get<Renderer>(test.param).name + "_" + std::get<closed_form::Case>(test.param).name;
    });

INSTANTIATE_TEST_SUITE_P(
    Cones, ClosedForm, testing::Combine(testing::ValuesIn(allRenderers()), testing::ValuesIn(closed_form::coneCases())),
    [](const auto& test) {
      return std::get<Renderer>(test.param).name + "_" + std::get<closed_form::Case>(test.param).name;
    });

}  // namespace
}  // namespace turner
