// What a kernel has compiled in beyond what its scene needs, and what it has not; in words for the user. Sets have a
// bit for each constant, by its id gpu::kSpec<Name>.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "image/settings.h"
#include "primitives/features.h"

namespace turner {

using ConstantSet = uint32_t;

// The features of `before` with those of the set that an edited kernel may have for the asking: the tree for its rays,
// highlights, mirrors, glass, fall-off.
Features withFeatures(Features before, ConstantSet set);

// What `now` has and `before` has not.
ConstantSet addedFeatures(const Features& before, const Features& now);

// "SHADOW_NODES", "REFLECTION".
std::vector<std::string> featureNames(ConstantSet set);

// What the user of an edited kernel is told: a line with what was added, if anything was; and one for each feature that
// is compiled out and that an edit may miss, "REFLECTION is compiled out: no material of this scene reflects".
std::vector<std::string> featureLines(ConstantSet added, const Features& features, const RenderSettings& settings);

// The features with all that an edited kernel lacks (Status::lacks). Throws InputError with the reason where it cannot
// have it; `narrow`: the user does not want it to.
Features withLacking(const Features& features, ConstantSet lacks, const RenderSettings& settings, bool narrow);

}  // namespace turner
