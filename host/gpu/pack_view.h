// The camera and what else all rays see, as the kernel and the eye's lists need them.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>

#include "accel/light_buffer.h"
#include "image/settings.h"
#include "layout.h"
#include "primitives/features.h"
#include "primitives/local_frame.h"
#include "scene/scene.h"

namespace turner {

// What all rays see.
struct View {
  Camera camera;     // in the local frame, its eye the origin
  LocalFrame frame;  // from the scene's coordinates to the kernel's
  glm::dvec3 background{0};
  gpu::uvec4 media{};              // that the eye is in
  gpu::uint root = gpu::kRefNone;  // of the tree
  // The picture that the eye's lists are made for: a picture of this size, and pixels of this part of it.
  int width = 0, height = 0;
  Window crop;
};

// The part of each face of the cube around the eye that the rays of the settings' crop go through.
std::array<FaceWindow, 6> viewWindows(const Camera& camera, const RenderSettings& settings);

// What the kernel needs of the view and the settings.
gpu::Frame packFrame(const View& view, const RenderSettings& settings, uint32_t deviceThreads);

}  // namespace turner
