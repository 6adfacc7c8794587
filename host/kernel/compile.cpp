// glslang's C++ interface, which alone takes an includer; its log is turned into one line that editors know. Then
// SPIRV-Tools inline functions and put variables into registers.
#include "kernel/compile.h"

#include <glslang/Public/ResourceLimits.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>

#include <spirv-tools/libspirv.h>
#include <spirv-tools/optimizer.hpp>

#include <algorithm>
#include <deque>
#include <filesystem>
#include <optional>
#include <regex>
#include <sstream>
#include <utility>

#include "base/cache_folder.h"
#include "base/errors.h"
#include "base/stopwatch.h"
#include "base/text_file.h"
#include "kernel/shader_sources.h"
#include "kernel/spirv_cache.h"

namespace turner {
namespace {

// glslang wants to be started once in a process.
struct GlslangProcess {
  GlslangProcess() { glslang::InitializeProcess(); }
  ~GlslangProcess() { glslang::FinalizeProcess(); }
};

// All that the words depend on beside the sources; versionAndOptions() says it to the cache.
constexpr int kDefaultVersion = 460;  // of GLSL, where a shader names none
constexpr glslang::EShTargetClientVersion kClient = glslang::EShTargetVulkan_1_2;
constexpr glslang::EShTargetLanguageVersion kTarget = glslang::EShTargetSpv_1_5;
constexpr EShMessages kRules = EShMessages(EShMsgSpvRules | EShMsgVulkanRules);
constexpr int kPasses = 1;  // number of the list of passes in optimise()

std::string versionAndOptions() {
  const glslang::Version version = glslang::GetVersion();
  std::ostringstream text;
  text << "glslang " << version.major << '.' << version.minor << '.' << version.patch << version.flavor << ' '
       << glslang::GetSpirvGeneratorVersion() << ", compute " << kDefaultVersion << ' ' << kClient << ' ' << kTarget
       << ' ' << kRules << ", passes " << kPasses << " of " << spvSoftwareVersionString();
  return text.str();
}

// Finds #include "file" beside the file that includes it: among the sources that were read before, else on the disk.
class FileIncluder : public glslang::TShader::Includer {
 public:
  explicit FileIncluder(const std::vector<ShaderSource>& sources) : sources_(sources.begin(), sources.end()) {}

  IncludeResult* includeLocal(const char* name, const char* includer, size_t depth) override {
    // glslang never ends a file that includes itself; no honest shader nests this deep.
    constexpr size_t kDeepest = 32;
    // Only the first error is reported. Going on would take forever where a file includes itself twice.
    if (!failure_.empty()) return nullptr;
    const std::string path = (std::filesystem::path(includer).parent_path() / name).string();
    try {
      if (depth > kDeepest) throw InputError("includes nest too deep; does the file include itself?");
      const std::string& text = textOf(path);
      return new IncludeResult(path, text.data(), text.size(), nullptr);
    } catch (const InputError& error) {
      // Its location is the including line, which glslang adds.
      failure_ = std::regex_replace(error.what(), std::regex(": error: "), ": ");
      return nullptr;
    }
  }

  // Where glslang goes when includeLocal has failed: there are no other folders, but this result carries the message.
  IncludeResult* includeSystem(const char* name, const char*, size_t) override {
    if (failure_.empty()) failure_ = std::string("#include <") + name + ">: write #include \"" + name + '"';
    return new IncludeResult("", failure_.data(), failure_.size(), nullptr);
  }

  void releaseInclude(IncludeResult* result) override { delete result; }

  // What was read, the shader first, then each include once and in order, as numbers of sources. A number that the
  // sources of before do not have is a file that had to be looked for on the disk.
  const std::vector<uint32_t>& filesRead() const { return filesRead_; }
  const ShaderSource& source(uint32_t number) const { return sources_[number]; }

 private:
  const std::string& textOf(const std::string& path) {
    const auto found = std::find_if(sources_.begin(), sources_.end(),
                                    [&](const ShaderSource& source) { return source.path == path && source.text; });
    const auto number = uint32_t(found - sources_.begin());
    if (found == sources_.end()) sources_.push_back({"", path, readRegularFile(path)});
    if (std::find(filesRead_.begin(), filesRead_.end(), number) == filesRead_.end()) filesRead_.push_back(number);
    return *sources_[number].text;
  }

  std::deque<ShaderSource> sources_;  // grows without moving the texts, which glslang holds on to
  std::vector<uint32_t> filesRead_ = {0};
  std::string failure_;  // of the first include that failed
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

// The warnings of a log, each as "file:12: warning: ...".
std::string warningsOf(const std::string& log) {
  static const std::regex placed("^WARNING: (.*?):([0-9]+): (.*?) *$");
  std::istringstream lines(log);
  std::string line, warnings;
  for (std::smatch match; std::getline(lines, line);)
    if (std::regex_match(line, match, placed))
      warnings += match[1].str() + ':' + match[2].str() + ": warning: " + match[3].str() + '\n';
  return warnings;
}

// Much of what a driver does first whenever it makes a pipeline, done once and kept in the cache: for lavapipe 22.3
// half of its work on a shader whose machine code it has in its own. None of these passes touches arithmetic.
std::vector<uint32_t> optimise(const std::vector<uint32_t>& words, const std::string& path) {
  spvtools::Optimizer optimizer(SPV_ENV_VULKAN_1_2);
  std::string complaint;
  optimizer.SetMessageConsumer([&](spv_message_level_t level, const char*, const spv_position_t&, const char* message) {
    if (level <= SPV_MSG_ERROR && complaint.empty()) complaint = message;
  });
  optimizer.RegisterPass(spvtools::CreateInlineExhaustivePass())
      .RegisterPass(spvtools::CreateLocalSingleBlockLoadStoreElimPass())
      .RegisterPass(spvtools::CreateLocalSingleStoreElimPass())
      .RegisterPass(spvtools::CreateScalarReplacementPass(0))
      .RegisterPass(spvtools::CreateSSARewritePass())
      .RegisterPass(spvtools::CreateAggressiveDCEPass());
  spvtools::OptimizerOptions options;
  options.set_run_validator(false);
  std::vector<uint32_t> optimised;
  if (!optimizer.Run(words.data(), words.size(), &optimised, options))
    throw RunError(path + ": SPIRV-Tools cannot optimise what glslang made of it: " + complaint);
  return optimised;
}

// Compiles and optimises; the files are left to the caller.
Spirv compile(const std::vector<ShaderSource>& sources, FileIncluder& includer, const std::string& preamble) {
  static const GlslangProcess process;
  const std::string& path = sources[0].path;
  const char* text = sources[0].text->data();
  const int length = int(sources[0].text->size());
  const char* name = path.c_str();

  Stopwatch watch;
  glslang::TShader shader(EShLangCompute);
  shader.setStringsWithLengthsAndNames(&text, &length, &name, 1);
  shader.setPreamble(preamble.c_str());
  shader.setEnvInput(glslang::EShSourceGlsl, EShLangCompute, glslang::EShClientVulkan, 120);
  shader.setEnvClient(glslang::EShClientVulkan, kClient);
  shader.setEnvTarget(glslang::EShTargetSpv, kTarget);
  if (!shader.parse(GetDefaultResources(), kDefaultVersion, ECoreProfile, false, true, kRules, includer))
    throw InputError(firstError(shader.getInfoLog(), path));

  glslang::TProgram program;
  program.addShader(&shader);
  if (!program.link(kRules)) throw InputError(firstError(program.getInfoLog(), path));
  glslang::SpvOptions options;
  options.disableOptimizer = true;  // Debian's glslang is built without
  std::vector<uint32_t> words;
  glslang::GlslangToSpv(*program.getIntermediate(EShLangCompute), words, &options);
  Spirv spirv;
  spirv.warnings = warningsOf(std::string(shader.getInfoLog()) + program.getInfoLog());
  spirv.glslangSeconds = watch.lap();
  spirv.words = optimise(words, path);
  spirv.optimiserSeconds = watch.lap();
  return spirv;
}

}  // namespace

Spirv compileGlsl(const std::string& path, const std::string& preamble) {
  return compileGlsl(readShaderSources(path), preamble);
}

Spirv compileGlsl(const std::vector<ShaderSource>& sources, const std::string& preamble) {
  const auto areSources = [&](const std::vector<uint32_t>& numbers) {
    return std::all_of(numbers.begin(), numbers.end(), [&](uint32_t number) { return number < sources.size(); });
  };
  const std::string folder = cacheFolder();
  const std::string key = spirvKey(versionAndOptions() + '\n' + preamble, sources);
  FileIncluder includer(sources);
  Spirv spirv;
  std::vector<uint32_t> files;
  if (std::optional<CachedSpirv> found = findCached(folder, key); found && areSources(found->files)) {
    spirv.words = std::move(found->words);
    files = std::move(found->files);
  } else {
    spirv = compile(sources, includer, preamble);
    files = includer.filesRead();
    // A shader that read more than the key knows cannot be found by it. Of one with warnings these are told each time.
    if (areSources(files) && spirv.warnings.empty()) keepCached(folder, key, {spirv.words, files});
  }
  for (const uint32_t number : files) spirv.files.push_back(includer.source(number).path);
  return spirv;
}

}  // namespace turner
