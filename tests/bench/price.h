// What each means of robustness costs in trace time, beside the failures that it removes: the kernel with everything
// against one in which that one thing is done as a textbook does it.
#pragma once

#include <string>
#include <vector>

#include "gpu/devices.h"
#include "image/settings.h"
#include "kernel/buffer_access.h"
#include "scene/scene.h"

namespace turner::test {

struct PricedScene {
  std::string name;
  Scene scene;
};

struct PriceSettings {
  DeviceInfo device;
  BufferAccess access = BufferAccess::automatic;
  RenderSettings picture;
  int runs = 5;           // of each kernel, in turn
  size_t rays = 1000000;  // of each measurement of failures
};

// Scenes that need what others do not: a ground sphere of radius 1e6 seen from 1.5 above it, and balls that are
// thousands of radii away.
std::vector<PricedScene> extremeScenes();

// Prints the tables; returns all figures as JSON. Throws RunError where the shaders have lost a snippet that is to be
// replaced.
std::string price(const std::vector<PricedScene>& scenes, const PriceSettings& settings);

}  // namespace turner::test
