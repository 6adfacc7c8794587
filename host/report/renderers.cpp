// The reference and the render session behind one interface.
#include "report/renderers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "base/text_file.h"
#include "geometry/round_scene.h"
#include "gpu/session.h"
#include "reference/reference.h"

namespace turner::report {
namespace {

// The first word of a device's name, for files: "llvmpipe" of "llvmpipe (LLVM 15.0.6, 512 bits)".
std::string shortName(const DeviceInfo& device) {
  std::string word;
  for (const char c : device.name) {
    if (std::isalnum(static_cast<unsigned char>(c)))
      word += char(std::tolower(static_cast<unsigned char>(c)));
    else if (c == '(')
      break;
    else if (!word.empty() && word.back() != '-')
      word += '-';
  }
  while (!word.empty() && word.back() == '-') word.pop_back();
  return word.empty() ? "device" : word;
}

class ReferencePictures : public Renderer {
 public:
  ReferencePictures(const Scene& scene, ReferenceOf which)
      : scene_(which == ReferenceOf::scene ? scene : roundScene(scene)) {
    const bool isScene = which == ReferenceOf::scene;
    info.name = isScene ? "reference" : "rounded";
    info.device = "reference";
    info.driver = "double precision";
    info.type = "CPU";
    info.options = std::string("--backend reference") + (isScene ? "" : " --geometry rounded");
    info.origin = std::string("--backend reference --geometry ") + (isScene ? "exact" : "rounded");
  }

  TimedPicture render(const RenderSettings& settings, const Progress& progress) override {
    ReferencePicture picture = renderReference(scene_, settings, progress);
    return {std::move(picture.image), picture.traceSeconds};
  }

 private:
  Scene scene_;
};

// All settings of a sweep have one in most cases, so that their repeats need not make it again.
constexpr size_t kKeptPipelines = 100;

class ShaderPictures : public Renderer {
 public:
  ShaderPictures(const Scene& scene, const DeviceInfo& device, const std::string& shaders)
      : scene_(scene),
        session_(device, BufferAccess::automatic, {.keptPipelines = kKeptPipelines}),
        path_(shaders + "/whitted.comp"),
        kernel_(compile()),
        access_(session_.access()) {
    info.name = shortName(device);
    info.device = device.name;
    info.driver = device.driver;
    info.type = device.type;
    info.options = fmt::format("--device {}", device.index);
    info.origin = "--backend shader --geometry rounded";
    const auto* words = reinterpret_cast<const char*>(kernel_.words.data());
    info.content = sha256Hex(fmt::format("{}\n{}\n", device.name, device.driver) +
                             sha256Hex({words, kernel_.words.size() * sizeof(uint32_t)}));
  }

  TimedPicture render(const RenderSettings& settings, const Progress& progress) override {
    // The lists of what eye rays meet are made for a number of samples, as the render command makes them.
    if (settings.samples != packedSamples_) {
      session_.prepare(scene_, settings);
      // A device may fetch larger arrays in another way, which takes another kernel.
      if (session_.access() != access_) {
        kernel_ = compile();
        access_ = session_.access();
      }
      session_.upload();
      session_.addFeaturesOf(kernel_);
      packedSamples_ = settings.samples;
    }
    ShaderPicture picture =
        session_.render(kernel_, RenderSession::withParameters(settings, kernel_.parameters), progress);
    throwIfInvalid();
    return {std::move(picture.image), picture.traceSeconds};
  }

 private:
  Kernel compile() {
    Kernel kernel = session_.compile(readShaderSources(path_), KernelForm::asNeeded);
    setParameters(kernel.parameters, scene_.parameters);
    return kernel;
  }

  Scene scene_;
  RenderSession session_;
  std::string path_;
  Kernel kernel_;
  BufferAccess access_;
  int packedSamples_ = 0;
};

}  // namespace

std::unique_ptr<Renderer> referenceRenderer(const Scene& scene, ReferenceOf which) {
  return std::make_unique<ReferencePictures>(scene, which);
}

std::unique_ptr<Renderer> shaderRenderer(const Scene& scene, const DeviceInfo& device, const std::string& shaders) {
  return std::make_unique<ShaderPictures>(scene, device, shaders);
}

}  // namespace turner::report
