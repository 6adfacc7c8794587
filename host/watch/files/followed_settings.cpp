// A file is read whole at each change of it, a pipe as far as it has come.
#include "watch/files/followed_settings.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <utility>

#include "base/descriptor_io.h"
#include "base/errors.h"
#include "base/text_file.h"
#include "scene/json/settings_json.h"

namespace turner::watch {
namespace {

// Seconds after which a text that cannot be read is no save that is not yet complete.
constexpr double kSaved = 0.1;
// Longest line of standard input.
constexpr size_t kLongestLine = 1 << 20;

bool isReadable(int file) {
  pollfd wait{file, POLLIN, 0};
  return ::poll(&wait, 1, 0) > 0;
}

}  // namespace

FollowedSettings::FollowedSettings(const std::string& file) : file_(file) {
  if (file_.empty() || file_ == kStandardStream) return;
  refusePipe(file_);
  watch_.follow({file_});
  settings_ = parseSettings(file_, readRegularFile(file_));
}

bool FollowedSettings::check(double now) {
  if (file_.empty()) return false;
  return file_ == kStandardStream ? readLines(now) : checkFile(now);
}

bool FollowedSettings::checkFile(double now) {
  if (watch_.takeChanges().empty() && !(isFaulty_ && now >= lookAgainAt_)) return false;
  std::string text;
  try {
    text = readRegularFile(file_);
    const bool changed = takeText(text, false, now);
    isFaulty_ = false;
    return changed;
  } catch (const InputError& error) {
    if (!isFaulty_ || text != faultyText_)
      lookAgainAt_ = now + kSaved;
    else if (now >= lookAgainAt_)
      fault_ = error.what(), lookAgainAt_ = HUGE_VAL;
    isFaulty_ = true;
    faultyText_ = text;
    return false;
  }
}

bool FollowedSettings::readLines(double now) {
  bool changed = false;
  while (isOpen_ && isReadable(STDIN_FILENO)) {
    char bytes[4096];
    const ssize_t count = ::read(STDIN_FILENO, bytes, sizeof bytes);
    if (count < 0 && (errno == EINTR || errno == EAGAIN)) break;
    isOpen_ = count > 0;
    line_.append(bytes, size_t(std::max<ssize_t>(count, 0)));
    if (count <= 0 && !line_.empty()) line_ += '\n';  // the last line may lack its end
    for (size_t end = line_.find('\n'); end != std::string::npos; end = line_.find('\n')) {
      const std::string line = line_.substr(0, end);
      line_.erase(0, end + 1);
      if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
      try {
        changed |= takeText(line, true, now);
      } catch (const InputError& error) {
        fault_ = error.what();
      }
    }
    if (line_.size() > kLongestLine) {
      fault_ = "<stdin>: error: a line of more than 1 MiB is no setting";
      line_.clear();
    }
  }
  return changed;
}

// Throws InputError.
bool FollowedSettings::takeText(const std::string& text, bool adds, double now) {
  std::vector<ParameterSetting> found = parseSettings(adds ? "<stdin>" : file_, text);
  if (adds) {
    for (const ParameterSetting& before : settings_)
      if (std::none_of(found.begin(), found.end(), [&](const ParameterSetting& f) { return f.name == before.name; }))
        found.push_back(before);
  }
  const bool same = std::equal(found.begin(), found.end(), settings_.begin(), settings_.end(),
                               [](const ParameterSetting& a, const ParameterSetting& b) {
                                 return a.name == b.name && a.values == b.values && a.isBoolean == b.isBoolean;
                               });
  settings_ = std::move(found);
  if (!same) changedAt_ = now;
  return !same;
}

std::string FollowedSettings::takeFault() {
  return std::exchange(fault_, "");
}

int FollowedSettings::descriptor() const {
  if (file_.empty()) return -1;
  return file_ != kStandardStream ? watch_.descriptor() : isOpen_ ? STDIN_FILENO : -1;
}

double FollowedSettings::nextLook() const {
  return isFaulty_ ? lookAgainAt_ : HUGE_VAL;
}

}  // namespace turner::watch
