// Compares identities: device and inode.
#include "command/overwriting.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cstddef>
#include <optional>

#include "base/descriptor_io.h"
#include "base/errors.h"
#include "base/file_identity.h"
#include "base/output_file.h"
#include "base/text_file.h"
#include "command/data_folder.h"
#include "kernel/shader_sources.h"

namespace turner {
namespace {

using Identity = std::optional<FileIdentity>;

Identity identityOfOutput(const std::string& path) {
  const std::optional<int> open = openOutput(path);
  return open ? identityOfOpen(*open) : identityOf(path);
}

Identity identityOfInput(const std::string& path) {
  return path == kStandardStream ? identityOfOpen(STDIN_FILENO) : identityOf(path);
}

// Of what is told and printed, which a shell's >> may have sent into a file; none of a pipe or terminal.
Identity identityOfFile(int descriptor) {
  struct stat found {};
  const bool isFile = ::fstat(descriptor, &found) == 0 && S_ISREG(found.st_mode);
  return isFile ? identityOfOpen(descriptor) : std::nullopt;
}

bool areOneStream(const std::string& a, const std::string& b) {
  const auto numberOf = [](const std::string& path) {
    return path == kStandardStream ? std::optional(STDIN_FILENO) : descriptorNamed(path);
  };
  const std::optional<int> number = numberOf(a);
  if (number && number == numberOf(b)) return true;
  const Identity identity = identityOfInput(a);
  return identity && identity == identityOfInput(b);
}

void addSources(const std::string& folder, std::vector<std::string>& files) try {
  for (const ShaderSource& source : readShaderSources(folder + "/whitted.comp")) files.push_back(source.path);
} catch (const InputError&) {
  // It has no kernel; if one is needed, the compiler says so.
}

}  // namespace

void refuseRepeated(const std::vector<std::string>& outputs) {
  for (size_t i = 0; i < outputs.size(); ++i) {
    const Identity identity = identityOfOutput(outputs[i]);
    for (size_t j = 0; j < i; ++j) {
      const std::optional<int> open = openOutput(outputs[i]);
      // A device such as /dev/null has no identity: it takes all that comes.
      if (outputs[i] == outputs[j] && (identity || open))
        throw InputError("the output " + nameOfOutput(outputs[i]) + " is named twice");
      if ((open && open == openOutput(outputs[j])) || (identity && identity == identityOfOutput(outputs[j])))
        throw InputError("the outputs " + nameOfOutput(outputs[j]) + " and " + nameOfOutput(outputs[i]) +
                         " are one file; name another one");
    }
  }
}

void refuseOverwriting(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs) {
  std::vector<Identity> identities;
  for (const std::string& output : outputs) identities.push_back(identityOfOutput(output));
  const Identity told[] = {identityOfFile(STDOUT_FILENO), identityOfFile(STDERR_FILENO)};
  for (const std::string& input : inputs) {
    const Identity identity = identityOfInput(input);
    if (!identity) continue;
    const std::string name = nameOfInput(input);
    for (size_t i = 0; i < outputs.size(); ++i) {
      if (identities[i] != identity) continue;
      const std::string output = nameOfOutput(outputs[i]);
      throw InputError("the output " + output + " is an input" + (name == output ? "" : ", " + name) +
                       "; name another file");
    }
    if (identity == told[0] || identity == told[1])
      throw InputError((identity == told[0] ? "<stdout> is the input " : "<stderr> is the input ") + name +
                       "; redirect it into another file");
  }
}

void refuseSharedPipes(const std::vector<std::string>& inputs) {
  for (size_t i = 0; i < inputs.size(); ++i)
    for (size_t j = 0; j < i; ++j)
      if (isStream(inputs[i]) && isStream(inputs[j]) && areOneStream(inputs[i], inputs[j]))
        throw InputError(nameOfInput(inputs[j]) + " and " + nameOfInput(inputs[i]) +
                         " are one pipe, which can be read once; write it into a file first");
}

std::vector<std::string> shaderFiles(const std::string& wantedFolder) {
  std::vector<std::string> files;
  if (!wantedFolder.empty()) addSources(wantedFolder, files);
  try {
    addSources(dataFolder() + "/shaders", files);
  } catch (const RunError&) {
    // There are none to protect.
  }
  return files;
}

}  // namespace turner
