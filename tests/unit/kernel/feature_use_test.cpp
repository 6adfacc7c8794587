// Which features an edit is about, by its text.
#include "kernel/edits/feature_use.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "kernel/edits/shipped_shaders.h"
#include "layout.h"

namespace turner {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

// The constants of the features that are used where one text of the kernel takes the place of another.
std::vector<uint32_t> usedBy(const std::string& name, const std::string& from, const std::string& to) {
  std::vector<ShaderSource> edited = shippedShaders();
  for (ShaderSource& source : edited) {
    if (source.path != "shipped/" + name) continue;
    const size_t at = source.text->find(from);
    EXPECT_NE(at, std::string::npos) << from;
    EXPECT_EQ(source.text->find(from, at + 1), std::string::npos) << from;
    source.text->replace(at, from.size(), to);
  }
  std::vector<uint32_t> constants;
  for (const FeatureUse& use : featuresUsed(shippedShaders(), edited)) constants.push_back(use.constant);
  return constants;
}

TEST(FeatureUse, OfUneditedSourcesThereIsNone) {
  EXPECT_THAT(featuresUsed(shippedShaders(), shippedShaders()), IsEmpty());
  EXPECT_THAT(usedBy("whitted.comp", "// A miss sees the background.", "// The sky. REFLECTION"), IsEmpty());
}

TEST(FeatureUse, WhatIsEditedElsewhereUsesNone) {
  EXPECT_THAT(usedBy("whitted.comp", "weight * frame.background", "0.5 * weight * frame.background"), IsEmpty());
  EXPECT_THAT(
      usedBy("shade.glsl", "return E * brdf * dot(surface.Ns, L);", "return 2.0 * E * brdf * dot(surface.Ns, L);"),
      IsEmpty());
}

TEST(FeatureUse, AnEditUsesWhatItNames) {
  EXPECT_THAT(usedBy("whitted.comp", "    Material material = materialAt(surface.material);",
                     "    Material material = materialAt(surface.material);\n    material.reflectance = 0.5;"),
              ElementsAre(gpu::kSpecReflection));
  EXPECT_THAT(usedBy("whitted.comp", "  Light light = lightAt(lightIndex);",
                     "  Light light = lightAt(lightIndex);\n  light.falloff = 1u;"),
              ElementsAre(gpu::kSpecFalloff));
}

TEST(FeatureUse, AnEditUsesWhatLeadsToIt) {
  EXPECT_THAT(usedBy("shade.glsl", "float q = 0.5 * dot", "float q = 0.1 * dot"), ElementsAre(gpu::kSpecHighlights));
  // By way of a variable: `reflects` is set by REFLECTION and REFRACTION.
  EXPECT_THAT(usedBy("whitted.comp", "    weight = reflectedWeight;", "    weight = 0.5 * reflectedWeight;"),
              UnorderedElementsAre(gpu::kSpecReflection, gpu::kSpecRefraction));
  // By the function that it is in.
  EXPECT_THAT(usedBy("shade.glsl", "return direction - 2.0 * dot", "return direction - 1.9 * dot"),
              ElementsAre(gpu::kSpecReflection));
}

TEST(FeatureUse, AMacroUsesWhatItNames) {
  EXPECT_THAT(usedBy("whitted.comp", "// The nearest hit of the ray in hand,",
                     "#define SHINY material.specular = vec3(1)\n// The nearest hit of the ray in hand,"),
              ElementsAre(gpu::kSpecHighlights));
}

TEST(FeatureUse, WhatWasTakenOutIsAnEditToo) {
  EXPECT_THAT(
      usedBy("shade.glsl",
             "    if (h2 > 0.0) brdf += material.specular * powOneMinus(min(q, 1.0), material.shininess);\n", ""),
      ElementsAre(gpu::kSpecHighlights));
}

TEST(FeatureUse, ANewFileIsAnEdit) {
  std::vector<ShaderSource> edited = shippedShaders();
  edited.push_back({"mine.glsl", "mine.glsl", "void mine() {\n  if (HIGHLIGHTS) sum += vec3(1);\n}\n"});
  const std::vector<FeatureUse> uses = featuresUsed(shippedShaders(), edited);
  ASSERT_EQ(uses.size(), 1u);
  EXPECT_EQ(uses[0].constant, gpu::kSpecHighlights);
  EXPECT_EQ(uses[0].location.path, "mine.glsl");
  EXPECT_EQ(uses[0].location.line, 2);
}

}  // namespace
}  // namespace turner
