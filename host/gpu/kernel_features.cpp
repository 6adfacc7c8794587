// Two tables of reasons; names and values come from shaders/interface.h.
#include "gpu/kernel_features.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/errors.h"
#include "layout.h"

namespace turner {
namespace {

constexpr ConstantSet bit(uint32_t constant) {
  return ConstantSet(1) << constant;
}

struct Reason {
  uint32_t constant;
  const char* text;
};

// Why an edited kernel needs what its scene does not.
constexpr Reason kNeeded[] = {
    {gpu::kSpecNearestNodes, "a ray that is no eye ray through its pixel looks for its nearest hit"},
    {gpu::kSpecShadowNodes, "a shadow ray does not go to its light"},
    {gpu::kSpecHighlights, "the sources are edited where highlights are, or give one to a material"},
    {gpu::kSpecReflection, "the sources are edited where mirrors are, or something reflects"},
    {gpu::kSpecRefraction, "the sources are edited where glass is, or something transmits"},
    {gpu::kSpecFalloff, "the sources are edited where lights fall off, or give a light a fall-off"},
};

// Why a scene's kernel is without.
constexpr Reason kAbsent[] = {
    {gpu::kSpecSpheres, "this scene has no spheres"},
    {gpu::kSpecTriangles, "this scene has no triangles"},
    {gpu::kSpecCones, "this scene has no cones"},
    {gpu::kSpecSmoothNormals, "no triangle of this scene has vertex normals"},
    {gpu::kSpecHighlights, "no material of this scene has a highlight"},
    {gpu::kSpecReflection, "no material of this scene reflects"},
    {gpu::kSpecRefraction, "no material of this scene transmits"},
    {gpu::kSpecFalloff, "no light of this scene falls off"},
    {gpu::kSpecNestedDielectrics, "no solids of glass overlap or touch in this scene"},
};

constexpr ConstantSet addable() {
  ConstantSet set = 0;
  for (const Reason& reason : kNeeded) set |= bit(reason.constant);
  return set;
}

const char* nameOf(uint32_t constant) {
  switch (constant) {
#define TURNER_CONSTANT(Name, id, type, NAME, value) \
  case id:                                           \
    return #NAME;
#define TURNER_FEATURE(Name, id, type, NAME, value, member) TURNER_CONSTANT(Name, id, type, NAME, value)
#include "interface.h"
    default:
      return "";
  }
}

std::string namesOf(ConstantSet set) {
  return fmt::format("{}", fmt::join(featureNames(set), ", "));
}

bool isMirrorOrGlass(uint32_t constant) {
  return constant == gpu::kSpecReflection || constant == gpu::kSpecRefraction;
}

// At a depth of 1 these are compiled out, whatever the features say (specialise).
bool isForbidden(ConstantSet set, const RenderSettings& settings) {
  return settings.depth == 1 && (set & (bit(gpu::kSpecReflection) | bit(gpu::kSpecRefraction))) != 0;
}

}  // namespace

Features withFeatures(Features before, ConstantSet set) {
#define TURNER_FEATURE(Name, id, type, NAME, value, member) \
  if (set & addable() & bit(id)) before.member = 1;
#include "interface.h"
  return before;
}

ConstantSet addedFeatures(const Features& before, const Features& now) {
  const Constants then = constantsOf(before), after = constantsOf(now);
  ConstantSet set = 0;
  for (uint32_t i = 0; i < gpu::kSpecCount; ++i)
    if (after[i] != 0 && then[i] == 0) set |= bit(i);
  return set;
}

std::vector<std::string> featureNames(ConstantSet set) {
  std::vector<std::string> names;
  for (uint32_t i = 0; i < gpu::kSpecCount; ++i)
    if (set & bit(i)) names.push_back(nameOf(i));
  return names;
}

std::vector<std::string> featureLines(ConstantSet added, const Features& features, const RenderSettings& settings) {
  std::vector<std::string> lines;
  std::string text;
  for (const Reason& reason : kNeeded)
    if (added & bit(reason.constant))
      text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", nameOf(reason.constant), reason.text);
  if (!text.empty()) lines.push_back("the edited kernel has what the scene alone does not need: " + text);
  const Constants constants = constantsOf(features);
  for (const Reason& reason : kAbsent) {
    const bool shallow = isMirrorOrGlass(reason.constant) && settings.depth == 1;
    if (constants[reason.constant] != 0 && !shallow) continue;
    lines.push_back(fmt::format("{} is compiled out: {}", nameOf(reason.constant),
                                shallow ? "the depth is 1, which has no secondary rays" : reason.text));
  }
  return lines;
}

namespace {

std::string describeLacking(ConstantSet lacks, const Features& features, const RenderSettings& settings, bool narrow) {
  const std::string wrong = "; the picture would be wrong and is not written; ";
  if (lacks & bit(gpu::kSpecDepth))
    return fmt::format("the edited kernel lets a ray of level {} or deeper wait, for which its state has no room",
                       settings.depth + 1) +
           wrong + fmt::format("give a --depth beyond {}, or keep to level < DEPTH in spawnRays()", settings.depth);
  if (lacks & bit(gpu::kSpecBudget))
    return "the edited kernel does not come to an end: a whole dispatch has left the work of a pixel as it was; look "
           "for a "
           "return, or a turn of a loop, that moves nothing on";
  if (lacks & bit(gpu::kSpecLights))
    return fmt::format("the edited kernel asks lightAt() for a light beyond the {} of this scene", features.lights) +
           wrong + "keep to indices below LIGHTS";
  if (narrow)
    return "the edited kernel needs " + namesOf(lacks) + ", which --narrow leaves out" + wrong + "do without --narrow";
  if (isForbidden(lacks, settings))
    return namesOf(lacks) + " is compiled out: the depth is 1, which has no secondary rays" + wrong +
           "give a greater --depth";
  return "the edited kernel lacks " + namesOf(lacks) + " though that is compiled in" + wrong +
         "traverse() wants NEAREST_NODES or SHADOW_NODES for visitsNodes, as whitted.comp gives them";
}

}  // namespace

Features withLacking(const Features& features, ConstantSet lacks, const RenderSettings& settings, bool narrow) {
  const Features more = withFeatures(features, lacks);
  if (narrow || addedFeatures(features, more) != lacks || isForbidden(lacks, settings))
    throw InputError(describeLacking(lacks, features, settings, narrow));
  return more;
}

}  // namespace turner
