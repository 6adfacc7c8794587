// The colours that R, G and B stand for.
#pragma once

#include <array>
#include <string>

namespace turner {

// CIE xy of red, green, blue and white.
using Chromaticities = std::array<float, 8>;

// ITU-R BT.709 and the white D65; also meant where a file states none.
inline constexpr Chromaticities kRec709{0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};

// But for the digits in which programs write them.
bool areSame(const Chromaticities& a, const Chromaticities& b);

// "Rec. 709" or, where they have no name that we know, the numbers.
std::string nameOf(const Chromaticities& chromaticities);

}  // namespace turner
