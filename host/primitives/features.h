// What a scene needs of the kernel; the rest is compiled out. The members are the features of shaders/interface.h.
#pragma once

#include <array>

#include "layout.h"

namespace turner {

struct Features {
  using uint = gpu::uint;
#define TURNER_FEATURE(Name, id, type, NAME, value, member) type member = 0;
#include "interface.h"
  bool operator==(const Features&) const = default;
};

// A kernel with nothing compiled out, for measurements.
inline Features everyFeature(gpu::uint lights) {
  Features features;
#define TURNER_FEATURE(Name, id, type, NAME, value, member) features.member = 1;
#include "interface.h"
  features.lights = lights;
  return features;
}

// Values of the specialisation constants, by their ids.
using Constants = std::array<gpu::uint, gpu::kSpecCount>;

// Those of the features; all others are 0.
inline Constants constantsOf(const Features& features) {
  Constants constants{};
#define TURNER_FEATURE(Name, id, type, NAME, value, member) constants[gpu::kSpec##Name] = features.member;
#include "interface.h"
  return constants;
}

}  // namespace turner
