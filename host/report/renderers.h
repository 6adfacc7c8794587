// Who renders for a report: the Vulkan devices and the reference, each by one function from settings to a timed
// picture.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gpu/devices.h"
#include "image/settings.h"
#include "kernel/compile.h"
#include "scene/scene.h"

namespace turner::report {

struct TimedPicture {
  Image image;
  double seconds =
      0;  // of tracing, warm: by the device's clock, of the reference by the wall's; trees are built before
};

// Who renders, in words.
struct RendererInfo {
  std::string name;     // "llvmpipe", "reference": unique within a report; of files
  std::string device;   // as the driver says
  std::string driver;   // of a device
  std::string type;     // "discrete GPU", ..., "CPU"
  std::string options;  // of the render command, to choose it
  std::string origin;   // as the render command writes it into an EXR
  std::string content;  // a hash of what its pictures depend on besides scene and settings
};

class Renderer {
 public:
  virtual ~Renderer() = default;
  virtual TimedPicture render(const RenderSettings& settings, const Progress& progress) = 0;

  RendererInfo info;
};

// The reference of the scene as it is, and of the rounded one, which is nobody's picture but tells errors apart.
enum class ReferenceOf { scene, rounded };
std::unique_ptr<Renderer> referenceRenderer(const Scene& scene, ReferenceOf which);

// The shader in `shaders` on a device. Compiles, and opens the device.
std::unique_ptr<Renderer> shaderRenderer(const Scene& scene, const DeviceInfo& device, const std::string& shaders);

}  // namespace turner::report
