// Output files appear whole or not at all.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "base/errors.h"
#include "base/output_file.h"
#include "base/temporary.h"
#include "support/temporary_folder.h"

namespace turner {
namespace {

namespace fs = std::filesystem;

std::string readBack(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

template <typename Error>
std::string messageOf(void (*call)(const std::string&), const std::string& path) {
  try {
    call(path);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

std::string refusal(const std::string& path) {
  return messageOf<InputError>(checkWritable, path);
}
std::string failure(const std::string& path) {
  return messageOf<RunError>([](const std::string& p) { writeWholeFile(p, "new"); }, path);
}

// Each test works in a folder of its own, which goes away with it.
class OutputFile : public testing::Test {
 protected:
  void TearDown() override { fs::permissions(folder, fs::perms::owner_all); }
  std::string in(const std::string& name) const { return (folder / name).string(); }
  size_t countFiles() const { return size_t(std::distance(fs::directory_iterator(folder), {})); }

  test::TemporaryFolder temporary;
  const fs::path folder = temporary.path;
};

// Limits the size of files that this process may write, as a full disk would.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit now = before_;
    now.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &now);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int) = nullptr;
};

TEST_F(OutputFile, ANewFileHoldsTheBytesAndNothingElseAppears) {
  const std::string bytes("\0a\nb\xff", 5);
  checkWritable(in("new.exr"));
  EXPECT_EQ(countFiles(), 0u) << "the check leaves no file";
  writeWholeFile(in("new.exr"), bytes);
  EXPECT_EQ(readBack(in("new.exr")), bytes);
  EXPECT_EQ(countFiles(), 1u);
}

TEST_F(OutputFile, AnEmptyFileIsAFileToo) {
  writeWholeFile(in("empty"), "");
  EXPECT_TRUE(fs::exists(in("empty")));
  EXPECT_EQ(fs::file_size(in("empty")), 0u);
}

TEST_F(OutputFile, AnOldFileIsReplacedAsAWhole) {
  writeWholeFile(in("a"), "a long old text");
  std::ifstream reader(in("a"));
  checkWritable(in("a"));
  writeWholeFile(in("a"), "new");
  EXPECT_EQ(readBack(in("a")), "new");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(reader), {}), "a long old text")
      << "who has the old file open keeps reading the old file";
  EXPECT_EQ(countFiles(), 1u);
}

TEST_F(OutputFile, PermissionsFollowTheUmask) {
  const mode_t before = umask(027);
  writeWholeFile(in("a"), "x");
  umask(before);
  struct stat found {};
  ASSERT_EQ(stat(in("a").c_str(), &found), 0);
  EXPECT_EQ(found.st_mode & 07777, mode_t(0640));
}

TEST_F(OutputFile, ARelativePathWithoutAFolderGoesToTheCurrentOne) {
  const fs::path before = fs::current_path();
  fs::current_path(folder);
  checkWritable("plain");
  writeWholeFile("plain", "x");
  fs::current_path(before);
  EXPECT_EQ(readBack(in("plain")), "x");
}

TEST_F(OutputFile, AFailureInTheMiddleLeavesTheOldFileAndNoTemporary) {
  writeWholeFile(in("a"), "old");
  std::string message;
  {
    const FileSizeLimit limit(4096);
    try {
      writeWholeFile(in("a"), std::string(10000, 'x'));
    } catch (const RunError& error) {
      message = error.what();
    }
  }
  EXPECT_EQ(message, in("a") + ": error: cannot write: write: File too large");
  EXPECT_EQ(readBack(in("a")), "old");
  EXPECT_EQ(countFiles(), 1u);
}

TEST_F(OutputFile, AFailureInTheMiddleOfANewFileLeavesNothing) {
  {
    const FileSizeLimit limit(4096);
    EXPECT_THROW(writeWholeFile(in("a"), std::string(10000, 'x')), RunError);
  }
  EXPECT_EQ(countFiles(), 0u);
}

TEST_F(OutputFile, AFullDeviceBehindALinkIsARunError) {
  fs::create_symlink("/dev/full", in("full"));
  checkWritable(in("full"));
  EXPECT_EQ(failure(in("full")), in("full") + ": error: cannot write: write: No space left on device");
  EXPECT_TRUE(fs::is_symlink(in("full")));
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
  EXPECT_EQ(countFiles(), 1u);
}

TEST_F(OutputFile, ADeviceIsWrittenAndStaysADevice) {
  // A terminal of its own, not /dev/null: should the code be wrong, the superuser's machine loses nothing.
  const int master = posix_openpt(O_RDWR | O_NOCTTY);
  ASSERT_GE(master, 0);
  ASSERT_EQ(grantpt(master), 0);
  ASSERT_EQ(unlockpt(master), 0);
  const std::string device = ptsname(master);
  // Held open, so that what was written is still there to read.
  const int slave = open(device.c_str(), O_RDWR | O_NOCTTY);
  ASSERT_GE(slave, 0);
  checkWritable(device);
  writeWholeFile(device, "through");
  char received[16] = {};
  EXPECT_EQ(read(master, received, sizeof received), 7);
  EXPECT_STREQ(received, "through");
  EXPECT_TRUE(fs::is_character_file(device));
  close(slave);
  close(master);
}

TEST_F(OutputFile, APipeIsWrittenAndStaysAPipe) {
  ASSERT_EQ(mkfifo(in("pipe").c_str(), 0600), 0);
  checkWritable(in("pipe"));
  std::string received;
  std::thread reader([&] { received = readBack(in("pipe")); });
  writeWholeFile(in("pipe"), "through");
  reader.join();
  EXPECT_EQ(received, "through");
  EXPECT_TRUE(fs::is_fifo(in("pipe")));
}

TEST_F(OutputFile, ALinkStaysAndItsTargetIsReplaced) {
  fs::create_directory(in("sub"));
  writeWholeFile(in("sub/real"), "old");
  fs::create_symlink("sub/real", in("one"));
  fs::create_symlink("one", in("two"));
  checkWritable(in("two"));
  writeWholeFile(in("two"), "new");
  EXPECT_TRUE(fs::is_symlink(in("one")));
  EXPECT_TRUE(fs::is_symlink(in("two")));
  EXPECT_FALSE(fs::is_symlink(in("sub/real")));
  EXPECT_EQ(readBack(in("sub/real")), "new");
}

TEST_F(OutputFile, ADanglingLinkStaysAndItsTargetIsMade) {
  fs::create_directory(in("sub"));
  fs::create_symlink(in("sub/new"), in("absolute"));
  fs::create_symlink("sub/other", in("relative"));
  for (const char* link : {"absolute", "relative"}) {
    checkWritable(in(link));
    writeWholeFile(in(link), link);
    EXPECT_TRUE(fs::is_symlink(in(link)));
  }
  EXPECT_EQ(readBack(in("sub/new")), "absolute");
  EXPECT_EQ(readBack(in("sub/other")), "relative");
}

TEST_F(OutputFile, ALinkIntoAMissingFolderIsRefused) {
  fs::create_symlink("nowhere/file", in("link"));
  EXPECT_NE(refusal(in("link")).find("does not exist"), std::string::npos) << refusal(in("link"));
  EXPECT_NE(failure(in("link")).find("No such file or directory"), std::string::npos);
  EXPECT_TRUE(fs::is_symlink(in("link")));
}

TEST_F(OutputFile, ARingOfLinksIsRefused) {
  fs::create_symlink("b", in("a"));
  fs::create_symlink("a", in("b"));
  EXPECT_NE(refusal(in("a")).find("leads back to itself"), std::string::npos) << refusal(in("a"));
}

TEST_F(OutputFile, AMissingFolderIsNamed) {
  const std::string expected = in("no/a.exr") + ": error: the folder " + in("no") + " does not exist; make it first";
  EXPECT_EQ(refusal(in("no/a.exr")), expected);
  EXPECT_EQ(failure(in("no/a.exr")), in("no/a.exr") + ": error: cannot write: open: No such file or directory");
}

TEST_F(OutputFile, AFileInPlaceOfAFolderIsRefused) {
  writeWholeFile(in("file"), "x");
  EXPECT_NE(refusal(in("file/a.exr")).find("is not a folder"), std::string::npos) << refusal(in("file/a.exr"));
  EXPECT_NE(refusal(in("file/sub/a.exr")).find("part of the path is a file"), std::string::npos)
      << refusal(in("file/sub/a.exr"));
  EXPECT_NE(refusal(in("file/")).find("ends with '/'"), std::string::npos) << refusal(in("file/"));
}

TEST_F(OutputFile, AFolderIsNoOutputFile) {
  EXPECT_NE(refusal(folder.string()).find("is a folder; name a file in it"), std::string::npos);
  EXPECT_NE(failure(folder.string()).find("Is a directory"), std::string::npos) << failure(folder.string());
  EXPECT_NE(refusal(in("missing/")).find("ends with '/'"), std::string::npos) << refusal(in("missing/"));
}

TEST_F(OutputFile, AnEmptyPathIsRefused) {
  EXPECT_NE(refusal("").find("is empty"), std::string::npos);
  EXPECT_THROW(writeWholeFile("", "x"), RunError);
}

TEST_F(OutputFile, TheLongestNameIsWrittenAndALongerOneRefused) {
  const std::string longest(255, 'n'), longer(256, 'n');
  checkWritable(in(longest));
  writeWholeFile(in(longest), "x");
  EXPECT_EQ(readBack(in(longest)), "x");
  EXPECT_NE(refusal(in(longer)).find("too long"), std::string::npos);
  EXPECT_NE(failure(in(longer)).find("File name too long"), std::string::npos) << failure(in(longer));
  EXPECT_EQ(countFiles(), 1u) << "no temporary is left";
}

TEST_F(OutputFile, AReadOnlyFolderIsRefusedUnlessOneIsTheSuperuser) {
  writeWholeFile(in("old"), "old");
  fs::permissions(folder, fs::perms::owner_read | fs::perms::owner_exec);
  if (geteuid() == 0) {
    checkWritable(in("a"));
    writeWholeFile(in("a"), "x");
    EXPECT_EQ(readBack(in("a")), "x");
  } else {
    EXPECT_NE(refusal(in("a")).find("is not writable"), std::string::npos);
    EXPECT_NE(failure(in("old")).find("Permission denied"), std::string::npos);
    EXPECT_EQ(countFiles(), 1u);
  }
  EXPECT_EQ(readBack(in("old")), "old");
}

TEST_F(OutputFile, AWriteProtectedFileIsRefusedUnlessOneIsTheSuperuser) {
  writeWholeFile(in("a"), "old");
  fs::permissions(in("a"), fs::perms::owner_read);
  if (geteuid() == 0) {
    checkWritable(in("a"));
  } else {
    EXPECT_NE(refusal(in("a")).find("Permission denied"), std::string::npos);
  }
}

TEST_F(OutputFile, ATemporaryOfAProcessThatWasKilledIsDeleted) {
  // Of one that had this one's number, as the first process of each container has 1.
  const std::string left = in(".a.turner-" + std::to_string(getpid()));
  std::ofstream(left) << "left";
  writeWholeFile(in("a"), "x");
  EXPECT_EQ(readBack(in("a")), "x");
  EXPECT_EQ(countFiles(), 1u);
}

TEST_F(OutputFile, ATemporaryInWorkIsNotTouched) {
  Temporary file(in("a"), Temporary::Kind::file), made(in("b"), Temporary::Kind::folder);
  EXPECT_TRUE(fs::is_regular_file(file.path()));
  EXPECT_TRUE(fs::is_directory(made.path()));
  writeWholeFile(in("a"), "x");
  Temporary another(in("b"), Temporary::Kind::folder);
  EXPECT_TRUE(fs::exists(file.path()));
  EXPECT_TRUE(fs::exists(made.path()));
  file.moveIntoPlace();
  EXPECT_EQ(readBack(in("a")), "");
}

TEST_F(OutputFile, AFolderThatAKilledProcessHasLeftIsDeleted) {
  const std::string left = in(".b.turner-" + std::to_string(getpid()));
  fs::create_directories(left + "/deep");
  std::ofstream(left + "/deep/file") << "left";
  { const Temporary made(in("b"), Temporary::Kind::folder); }
  EXPECT_EQ(countFiles(), 0u);
}

TEST_F(OutputFile, ManyWritersOfOneFileLeaveOneWholeFile) {
  std::vector<std::thread> writers;
  for (int i = 0; i < 8; ++i) {
    writers.emplace_back([this, i] { writeWholeFile(in("a"), std::string(50000, char('a' + i))); });
  }
  for (std::thread& writer : writers) writer.join();
  const std::string bytes = readBack(in("a"));
  ASSERT_EQ(bytes.size(), 50000u);
  EXPECT_EQ(bytes, std::string(50000, bytes[0]));
  EXPECT_EQ(countFiles(), 1u);
}

}  // namespace
}  // namespace turner
