// glslang's C++ interface, which alone takes an includer; its log is turned into one line that editors know.
#include "shader/glsl.h"

#include <glslang/Public/ResourceLimits.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <regex>
#include <sstream>

#include "errors.h"
#include "scene/text_file.h"

namespace turner {
namespace {

// glslang wants to be started once in a process.
struct GlslangProcess {
  GlslangProcess() { glslang::InitializeProcess(); }
  ~GlslangProcess() { glslang::FinalizeProcess(); }
};

// Finds #include "file" beside the file that includes it.
class FileIncluder : public glslang::TShader::Includer {
 public:
  explicit FileIncluder(std::vector<std::string>& files) : files_(files) {}

  IncludeResult* includeLocal(const char* name, const char* includer, size_t depth) override {
    // glslang never ends a file that includes itself; no honest shader nests this deep.
    constexpr size_t kDeepest = 32;
    const std::string path = (std::filesystem::path(includer).parent_path() / name).string();
    auto text = std::make_unique<std::string>();
    try {
      if (depth > kDeepest) throw InputError("includes nest too deep; does the file include itself?");
      *text = readTextFile(path);
    } catch (const InputError& error) {
      // Its place is the including line, which glslang adds.
      failure_ = std::regex_replace(error.what(), std::regex(": error: "), ": ");
      return nullptr;
    }
    if (std::find(files_.begin(), files_.end(), path) == files_.end()) files_.push_back(path);
    auto* result = new IncludeResult(path, text->data(), text->size(), text.get());
    text.release();
    return result;
  }

  // Where glslang goes when includeLocal has failed: there are no other places, but this result carries the message.
  IncludeResult* includeSystem(const char* name, const char*, size_t) override {
    if (failure_.empty()) failure_ = std::string("#include <") + name + ">: write #include \"" + name + '"';
    return new IncludeResult("", failure_.data(), failure_.size(), nullptr);
  }

  void releaseInclude(IncludeResult* result) override {
    if (!result) return;
    delete static_cast<std::string*>(result->userData);
    delete result;
  }

 private:
  std::vector<std::string>& files_;
  std::string failure_;  // of the last include
};

// The first error of a log, in the form of compilers and editors: "file:12: error: ...". glslang says "ERROR: file:12:
// ..." and stops at the first error that is one; what follows are its consequences.
std::string firstError(const std::string& log, const std::string& path) {
  static const std::regex placed("^ERROR: (.*?):([0-9]+): (.*?)( for header name: .*)? *$");
  static const std::regex linked("^ERROR: Linking compute stage: (.*?) *$");
  std::istringstream lines(log);
  std::string line;
  while (std::getline(lines, line)) {
    std::smatch match;
    if (std::regex_match(line, match, placed))
      return match[1].str() + ':' + match[2].str() + ": error: " + match[3].str();
    if (std::regex_match(line, match, linked)) {
      // The name that is missing stands in the next line.
      std::string name;
      if (std::getline(lines, name)) name.erase(0, name.find_first_not_of(' '));
      return path + ": error: " + match[1].str() + (name.empty() ? "" : ' ' + name);
    }
  }
  return path + ": error: " + log;
}

}  // namespace

Spirv compileGlsl(const std::string& path, const std::string& preamble) {
  static const GlslangProcess process;
  constexpr EShMessages kRules = EShMessages(EShMsgSpvRules | EShMsgVulkanRules);

  Spirv spirv;
  spirv.files.push_back(path);
  const std::string source = readTextFile(path);
  const char* text = source.data();
  const int length = int(source.size());
  const char* name = path.c_str();

  glslang::TShader shader(EShLangCompute);
  shader.setStringsWithLengthsAndNames(&text, &length, &name, 1);
  shader.setPreamble(preamble.c_str());
  shader.setEnvInput(glslang::EShSourceGlsl, EShLangCompute, glslang::EShClientVulkan, 120);
  shader.setEnvClient(glslang::EShClientVulkan, glslang::EShTargetVulkan_1_2);
  shader.setEnvTarget(glslang::EShTargetSpv, glslang::EShTargetSpv_1_5);
  FileIncluder includer(spirv.files);
  const TBuiltInResource* limits = GetDefaultResources();
  if (!shader.parse(limits, 460, ECoreProfile, false, true, kRules, includer))
    throw InputError(firstError(shader.getInfoLog(), path));

  glslang::TProgram program;
  program.addShader(&shader);
  if (!program.link(kRules)) throw InputError(firstError(program.getInfoLog(), path));
  glslang::SpvOptions options;
  options.disableOptimizer = true;  // drivers optimise; lavapipe's and ours would do the same work twice
  glslang::GlslangToSpv(*program.getIntermediate(EShLangCompute), spirv.words, &options);
  return spirv;
}

}  // namespace turner
