// Changes of watched files are told, however an editor makes them. Every test but the last few runs twice: woken by
// inotify, and by looking alone.
#include "watch/files/file_watch.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/fsuid.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "base/stopwatch.h"
#include "base/unique_fd.h"
#include "support/temporary_folder.h"

namespace turner::watch {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;

// Far more than the kernel needs: events are in the queue before the call that caused them returns.
constexpr int kWakeMilliseconds = 100;

void write(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

void swapLink(const fs::path& target, const fs::path& link) {
  fs::create_symlink(target, link.string() + ".new");
  fs::rename(link.string() + ".new", link);
}

bool isReadable(const FileWatch& watch, int milliseconds) {
  pollfd waited{watch.descriptor(), POLLIN, 0};
  return ::poll(&waited, 1, milliseconds) == 1;
}

size_t countDescriptors() {
  return size_t(std::distance(fs::directory_iterator("/proc/self/fd"), {}));
}

size_t countWatches(const FileWatch& watch) {
  std::ifstream info("/proc/self/fdinfo/" + std::to_string(watch.descriptor()));
  size_t watches = 0;
  for (std::string line; std::getline(info, line);) watches += line.starts_with("inotify wd:");
  return watches;
}

// Each test works in a folder of its own, two levels deep, so that the parent can be moved too.
class WatchedFolder : public testing::Test {
 protected:
  WatchedFolder() { fs::create_directories(in("")); }
  std::string in(const std::string& name) const { return (temporary.path / "project" / name).string(); }
  void openToAll() const {
    for (const fs::path& folder : {temporary.path, temporary.path / "project"}) fs::permissions(folder, fs::perms::all);
  }

  test::TemporaryFolder temporary;
};

class FileWatchModes : public WatchedFolder, public testing::WithParamInterface<bool> {
 protected:
  // Forgets the events that made the files, and shows that nothing is told without a change.
  void follow(const std::vector<std::string>& files) {
    watch.follow(files);
    EXPECT_THAT(watch.takeChanges(), IsEmpty());
    if (GetParam()) {
      EXPECT_FALSE(isReadable(watch, 0)) << "woken by itself";
    }
  }
  // What is told once the descriptor woke.
  std::vector<std::string> changes() {
    if (GetParam()) {
      EXPECT_TRUE(isReadable(watch, kWakeMilliseconds)) << "not woken";
    }
    return watch.takeChanges();
  }

  FileWatch watch{GetParam()};
};

TEST_P(FileWatchModes, AFileWrittenInPlaceIsToldOnce) {
  write(in("a"), "old");
  follow({in("a")});
  write(in("a"), "newer");
  EXPECT_THAT(changes(), ElementsAre(in("a")));
  EXPECT_THAT(watch.takeChanges(), IsEmpty());
}

TEST_P(FileWatchModes, AFileWrittenBesideAndRenamedOverIsTold) {
  write(in("a"), "old");
  follow({in("a")});
  write(in("a.tmp"), "newer");
  fs::rename(in("a.tmp"), in("a"));
  EXPECT_THAT(changes(), ElementsAre(in("a")));
}

TEST_P(FileWatchModes, AFileMovedInFromAnotherFolderIsTold) {
  write(in("a"), "old");
  write(temporary.path / "new", "newer");
  follow({in("a")});
  fs::rename(temporary.path / "new", in("a"));
  EXPECT_THAT(changes(), ElementsAre(in("a")));
}

TEST_P(FileWatchModes, AFileUnlinkedAndMadeAgainIsTold) {
  write(in("a"), "old");
  follow({in("a")});
  fs::remove(in("a"));
  write(in("a"), "newer");
  EXPECT_THAT(changes(), ElementsAre(in("a")));
}

TEST_P(FileWatchModes, AFileRenamedToABackupAndMadeAgainIsTold) {
  write(in("a"), "old");
  follow({in("a")});
  fs::rename(in("a"), in("a~"));
  write(in("a"), "newer");
  fs::remove(in("a~"));
  EXPECT_THAT(changes(), ElementsAre(in("a")));
}

TEST_P(FileWatchModes, AHardLinkInPlaceOfTheFileIsTold) {
  write(in("a"), "old");
  write(temporary.path / "new", "newer");
  follow({in("a")});
  fs::remove(in("a"));
  fs::create_hard_link(temporary.path / "new", in("a"));
  EXPECT_THAT(changes(), ElementsAre(in("a")));
}

TEST_P(FileWatchModes, ATouchIsToldAndItIsTheCallerWhoComparesContents) {
  write(in("a"), "old");
  follow({in("a")});
  const timespec times[2] = {{1000, 0}, {1000, 0}};
  ASSERT_EQ(utimensat(AT_FDCWD, in("a").c_str(), times, 0), 0);
  EXPECT_THAT(changes(), ElementsAre(in("a")));
}

TEST_P(FileWatchModes, OfTwoFilesChangedAtOnceBothAreToldAndTheThirdIsNot) {
  for (const char* name : {"a", "b", "c"}) write(in(name), "old");
  follow({in("c"), in("b"), in("a")});
  write(in("c"), "newer");
  write(in("a"), "newer");
  EXPECT_THAT(changes(), ElementsAre(in("a"), in("c")));
}

TEST_P(FileWatchModes, ADeletedFileIsToldOnceAndItsReturnOnce) {
  write(in("a"), "old");
  follow({in("a")});
  fs::remove(in("a"));
  EXPECT_THAT(changes(), ElementsAre(in("a")));
  EXPECT_THAT(watch.takeChanges(), IsEmpty());
  write(in("a"), "old");
  EXPECT_THAT(changes(), ElementsAre(in("a")));
  EXPECT_THAT(watch.takeChanges(), IsEmpty());
}

TEST_P(FileWatchModes, AFolderRemovedAndMadeAgainIsWatchedAgain) {
  fs::create_directory(in("sub"));
  write(in("sub/a"), "old");
  follow({in("sub/a")});
  fs::remove_all(in("sub"));
  EXPECT_THAT(changes(), ElementsAre(in("sub/a")));
  fs::create_directory(in("sub"));
  EXPECT_THAT(changes(), IsEmpty()) << "the folder alone is no file";
  write(in("sub/a"), "old");
  EXPECT_THAT(changes(), ElementsAre(in("sub/a")));
  write(in("sub/a"), "newer");
  EXPECT_THAT(changes(), ElementsAre(in("sub/a")));
}

TEST_P(FileWatchModes, AFolderRemovedAndMadeAgainBetweenTwoLooksIsWatchedAgain) {
  fs::create_directory(in("sub"));
  write(in("sub/a"), "old");
  follow({in("sub/a")});
  fs::remove_all(in("sub"));
  fs::create_directory(in("sub"));
  write(in("sub/a"), "newer");
  EXPECT_THAT(changes(), ElementsAre(in("sub/a")));
  write(in("sub/a"), "newest of all");
  EXPECT_THAT(changes(), ElementsAre(in("sub/a")));
}

TEST_P(FileWatchModes, AFolderRemovedWhileAShellStandsInItIsWatchedAgain) {
  fs::create_directory(in("sub"));
  write(in("sub/a"), "old");
  // Whoever holds a folder open keeps it alive: then no event tells that it was deleted.
  const UniqueFd shell(::open(in("sub").c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  follow({in("sub/a")});
  fs::remove(in("sub/a"));
  EXPECT_THAT(changes(), ElementsAre(in("sub/a")));
  fs::remove(in("sub"));
  EXPECT_THAT(changes(), IsEmpty());
  fs::create_directory(in("sub"));
  EXPECT_THAT(changes(), IsEmpty());
  write(in("sub/a"), "newer");
  EXPECT_THAT(changes(), ElementsAre(in("sub/a")));
}

TEST_P(FileWatchModes, AFolderRenamedAwayAndAnotherMovedInIsWatched) {
  fs::create_directory(in("sub"));
  fs::create_directory(in("other"));
  write(in("sub/a"), "old");
  write(in("other/a"), "newer");
  follow({in("sub/a")});
  fs::rename(in("sub"), in("gone"));
  EXPECT_THAT(changes(), ElementsAre(in("sub/a")));
  fs::rename(in("other"), in("sub"));
  EXPECT_THAT(changes(), ElementsAre(in("sub/a")));
  write(in("sub/a"), "newest of all");
  EXPECT_THAT(changes(), ElementsAre(in("sub/a")));
  write(in("gone/a"), "nobody follows this one");
  EXPECT_THAT(watch.takeChanges(), IsEmpty());
}

TEST_P(FileWatchModes, AFolderFurtherUpRenamedAwayAndAnotherMovedInIsWatched) {
  fs::create_directories(in("up/sub"));
  fs::create_directories(in("other/sub"));
  write(in("up/sub/a"), "old");
  write(in("other/sub/a"), "newer");
  follow({in("up/sub/a")});
  fs::rename(in("up"), in("gone"));
  fs::rename(in("other"), in("up"));
  EXPECT_THAT(changes(), ElementsAre(in("up/sub/a")));
  write(in("up/sub/a"), "newest of all");
  EXPECT_THAT(changes(), ElementsAre(in("up/sub/a")));
}

TEST_P(FileWatchModes, ALinkToAFolderThatIsSwappedIsTold) {
  for (const char* name : {"v1", "v2"}) {
    fs::create_directory(in(name));
    write(in(name) + "/a", "the same");
  }
  fs::create_directory_symlink("v1", in("shaders"));
  follow({in("shaders/a")});
  swapLink("v2", in("shaders"));
  EXPECT_THAT(changes(), ElementsAre(in("shaders/a")));
  write(in("v2/a"), "edited");
  EXPECT_THAT(changes(), ElementsAre(in("shaders/a")));
  swapLink(in("v1"), in("shaders"));
  EXPECT_THAT(changes(), ElementsAre(in("shaders/a")));
}

TEST_P(FileWatchModes, ALinkToAFileThatIsSwappedIsToldAndSoIsItsTarget) {
  for (const char* name : {"v1", "v2"}) {
    fs::create_directory(in(name));
    write(in(name) + "/real", "old");
  }
  fs::create_symlink("v1/real", in("one"));
  fs::create_symlink(in("one"), in("two"));
  follow({in("two")});
  swapLink("v2/real", in("one"));
  EXPECT_THAT(changes(), ElementsAre(in("two")));
  write(in("v2/real"), "edited");
  EXPECT_THAT(changes(), ElementsAre(in("two")));
  write(in("v2/new"), "written beside and renamed over");
  fs::rename(in("v2/new"), in("v2/real"));
  EXPECT_THAT(changes(), ElementsAre(in("two")));
  fs::remove(in("two"));
  EXPECT_THAT(changes(), ElementsAre(in("two")));
}

TEST_P(FileWatchModes, ALinkAndItsTargetAreBothToldWhenTheTargetChanges) {
  write(in("real"), "old");
  fs::create_symlink("real", in("link"));
  follow({in("real"), in("link")});
  write(in("real"), "newer");
  EXPECT_THAT(changes(), ElementsAre(in("link"), in("real")));
}

TEST_P(FileWatchModes, ADanglingLinkIsToldWhenItsTargetAppears) {
  fs::create_symlink("sub/later", in("link"));
  follow({in("link")});
  fs::create_directory(in("sub"));
  EXPECT_THAT(changes(), IsEmpty());
  write(in("sub/later"), "there");
  EXPECT_THAT(changes(), ElementsAre(in("link")));
}

TEST_P(FileWatchModes, AFileWhoseFoldersAreYetToBeMadeIsTold) {
  follow({in("x/y/z/a")});
  fs::create_directory(in("x"));
  EXPECT_THAT(changes(), IsEmpty());
  fs::create_directories(in("x/y/z"));
  EXPECT_THAT(changes(), IsEmpty());
  write(in("x/y/z/a"), "there");
  EXPECT_THAT(changes(), ElementsAre(in("x/y/z/a")));
}

TEST_P(FileWatchModes, AFileInPlaceOfAFolderIsNoFileInAFolder) {
  write(in("sub"), "a file");
  follow({in("sub/a")});
  fs::remove(in("sub"));
  fs::create_directory(in("sub"));
  write(in("sub/a"), "there");
  EXPECT_THAT(changes(), ElementsAre(in("sub/a")));
}

TEST_P(FileWatchModes, AnUnrelatedFileInTheFolderTellsNothing) {
  write(in("a"), "old");
  follow({in("a")});
  write(in("b"), "new");
  fs::rename(in("b"), in("c"));
  EXPECT_THAT(changes(), IsEmpty());
}

TEST_P(FileWatchModes, RelativePathsWithDotsAreFollowedFromTheWorkingFolder) {
  fs::create_directory(in("sub"));
  write(in("a"), "old");
  const fs::path before = fs::current_path();
  fs::current_path(in("sub"));
  follow({".././sub//../a", "b"});
  write(in("a"), "newer");
  EXPECT_THAT(changes(), ElementsAre(".././sub//../a"));
  write(in("sub/b"), "newer");
  EXPECT_THAT(changes(), ElementsAre("b"));
  fs::current_path(before);
}

TEST_P(FileWatchModes, FollowingAgainKeepsAChangeThatWasNotToldYet) {
  for (const char* name : {"a", "b", "c"}) write(in(name), "old");
  follow({in("a"), in("b")});
  write(in("a"), "newer");
  watch.follow({in("b"), in("a"), in("a")});
  write(in("b"), "newer");
  watch.follow({in("a"), in("b"), in("c")});
  EXPECT_THAT(changes(), ElementsAre(in("a"), in("b")));
}

TEST_P(FileWatchModes, AFileNoLongerFollowedIsNotTold) {
  write(in("a"), "old");
  write(in("b"), "old");
  follow({in("a"), in("b")});
  watch.follow({in("b")});
  write(in("a"), "newer");
  write(in("b"), "newer");
  EXPECT_THAT(changes(), ElementsAre(in("b")));
  watch.follow({});
  write(in("b"), "newest of all");
  EXPECT_THAT(watch.takeChanges(), IsEmpty());
}

TEST_P(FileWatchModes, WhatIsNoFileNeitherHangsNorThrows) {
  ASSERT_EQ(mkfifo(in("pipe").c_str(), 0600), 0);
  fs::create_directory(in("folder"));
  fs::create_symlink("ring2", in("ring1"));
  fs::create_symlink("ring1", in("ring2"));
  fs::create_symlink(".", in("here"));
  std::string deep = in("");
  while (deep.size() < 5000) deep += "here/";
  const std::string loops = in("here/here/here/here/a");
  watch.follow({"", "/", ".", "..", "/..", "/dev/null", "/proc/self/fd/0", in("pipe"), in("folder"), in("ring1"),
                in("ring1/a"), in("pipe/a"), in("a/"), deep, loops, in(std::string(300, 'n')), std::string(100000, '/'),
                std::string(100000, 'n')});
  EXPECT_THAT(watch.takeChanges(), IsEmpty());
  write(in("folder/b"), "there");
  write(in("a"), "there");
  // Of "a/" it is news that it is missing no longer, but not a folder. A folder is none when a file is made in it.
  EXPECT_THAT(changes(), ElementsAre(in("a/"), loops));
}

// To the superuser every folder is open: tests that run as such look with an ordinary user's eyes.
template <class Task>
void asOrdinaryUser(const Task& task) {
  constexpr uid_t kNobody = 65534;
  const bool isSuperuser = geteuid() == 0;
  if (isSuperuser) setfsuid(kNobody);
  task();
  if (isSuperuser) setfsuid(0);
}

TEST_P(FileWatchModes, AFileIsToldOfAFolderThatWasClosedToUs) {
  openToAll();
  fs::create_directory(in("sub"));
  write(in("sub/a"), "old");
  fs::permissions(in("sub"), fs::perms::none);
  asOrdinaryUser([&] { follow({in("sub/a")}); });
  fs::permissions(in("sub"), fs::perms::all);
  asOrdinaryUser([&] { EXPECT_THAT(changes(), ElementsAre(in("sub/a"))); });
}

INSTANTIATE_TEST_SUITE_P(, FileWatchModes, testing::Bool(),
                         [](const auto& mode) { return mode.param ? "Inotify" : "Looking"; });

using FileWatchEvents = WatchedFolder;

TEST_F(FileWatchEvents, ARewriteWithinOneTickOfTheClockIsTold) {
  write(in("a"), "even");
  FileWatch watch;
  watch.follow({in("a")});
  for (int i = 0; i < 100; ++i) {
    write(in("a"), i % 2 == 0 ? "odd." : "even");
    ASSERT_TRUE(isReadable(watch, kWakeMilliseconds));
    ASSERT_THAT(watch.takeChanges(), ElementsAre(in("a"))) << i;
  }
}

TEST_F(FileWatchEvents, AnUnrelatedFileInTheFolderWakesAndOneFurtherUpDoesNot) {
  write(in("a"), "old");
  FileWatch watch;
  watch.follow({in("a")});
  write(temporary.path / "further_up", "x");
  EXPECT_FALSE(isReadable(watch, 0));
  write(in("b"), "x");
  EXPECT_TRUE(isReadable(watch, kWakeMilliseconds));
  EXPECT_THAT(watch.takeChanges(), IsEmpty());
  EXPECT_FALSE(isReadable(watch, 0)) << "a look empties the queue";
}

TEST_F(FileWatchEvents, AHalfWrittenFileDoesNotWake) {
  write(in("a"), "old");
  FileWatch watch;
  watch.follow({in("a")});
  std::ofstream file(in("a"), std::ios::app);
  file << "half" << std::flush;
  EXPECT_FALSE(isReadable(watch, 0));
  file << "whole" << std::flush;
  file.close();
  EXPECT_TRUE(isReadable(watch, kWakeMilliseconds));
  EXPECT_THAT(watch.takeChanges(), ElementsAre(in("a")));
}

TEST_F(FileWatchEvents, AnOverflowingQueueLosesNoChange) {
  int longest = 0;
  ASSERT_TRUE(std::ifstream("/proc/sys/fs/inotify/max_queued_events") >> longest);
  write(in("a"), "old");
  FileWatch watch;
  watch.follow({in("a")});
  // Alternate names, because equal events in a row are merged.
  for (int i = 0; i <= longest; ++i) fs::permissions(in(i % 2 == 0 ? "" : "a"), fs::perms::owner_all);
  EXPECT_THAT(watch.takeChanges(), ElementsAre(in("a")));
  write(in("a"), "newer");
  EXPECT_TRUE(isReadable(watch, kWakeMilliseconds));
  EXPECT_THAT(watch.takeChanges(), ElementsAre(in("a")));
}

TEST_F(FileWatchEvents, LooksAmidMovingFoldersEndWithTheRightWatches) {
  for (const char* name : {"v1/sub", "v2/sub"}) {
    fs::create_directories(in(name));
    write(in(name) + "/a", "old");
  }
  fs::create_directory_symlink("v1", in("link"));
  FileWatch watch;
  watch.follow({in("v1/sub/a"), in("link/sub/a")});
  for (int round = 0; round < 200; ++round) {
    std::atomic<bool> moved = false;
    std::thread mover([&] {
      swapLink("v2", in("link"));
      fs::rename(in("v1"), in("v3"));
      fs::rename(in("v2"), in("v1"));
      fs::rename(in("v3"), in("v2"));
      swapLink("v1", in("link"));
      fs::remove_all(in("v1/sub"));
      fs::create_directory(in("v1/sub"));
      moved = true;
    });
    while (!moved) watch.takeChanges();
    mover.join();
    // From here on only events lead to a look, and the last of them must have led to the right folders.
    while (isReadable(watch, 0)) watch.takeChanges();
    write(in("v1/sub/a"), std::to_string(round));
    ASSERT_TRUE(isReadable(watch, kWakeMilliseconds)) << round;
    ASSERT_THAT(watch.takeChanges(), ElementsAre(in("link/sub/a"), in("v1/sub/a"))) << round;
  }
}

TEST_F(FileWatchEvents, AFileClosedAfterWritingIsToldEvenIfItLooksTheSame) {
  write(in("a"), "old");
  FileWatch watch;
  watch.follow({in("a")});
  // As a write within one tick of a coarse clock looks.
  ::close(::open(in("a").c_str(), O_WRONLY | O_CLOEXEC));
  EXPECT_TRUE(isReadable(watch, kWakeMilliseconds));
  EXPECT_THAT(watch.takeChanges(), ElementsAre(in("a")));
  EXPECT_THAT(watch.takeChanges(), IsEmpty());
}

TEST_F(FileWatchEvents, AThousandFollowsLeaveNoWatchesBehind) {
  for (const char* name : {"sub1", "sub2"}) {
    fs::create_directory(in(name));
    write(in(name) + "/a", "old");
  }
  FileWatch watch;
  watch.follow({in("sub1/a")});
  const size_t watches = countWatches(watch), descriptors = countDescriptors();
  EXPECT_GE(watches, 3u) << "the folder, the project and what is above";
  for (int i = 0; i < 1000; ++i) {
    watch.follow({in("sub2/a"), in("missing" + std::to_string(i))});
    if (i % 100 == 0) watch.takeChanges();
    watch.follow({in("sub1/a")});
  }
  EXPECT_EQ(countWatches(watch), watches);
  EXPECT_EQ(countDescriptors(), descriptors);
  watch.follow({});
  EXPECT_EQ(countWatches(watch), 0u);
}

TEST_F(FileWatchEvents, AFolderReplacedAThousandTimesLeavesNoWatchesBehind) {
  write(in("sub"), "");
  FileWatch watch;
  size_t watches = 0;
  for (int i = 0; i < 1000; ++i) {
    fs::remove_all(in("sub"));
    fs::create_directory(in("sub"));
    write(in("sub/a"), std::to_string(i));
    watch.follow({in("sub/a")});
    ASSERT_THAT(watch.takeChanges().size(), i == 0 ? 0u : 1u);
    if (i == 0) watches = countWatches(watch);
  }
  EXPECT_EQ(countWatches(watch), watches);
}

using TimingFileWatch = WatchedFolder;

TEST_F(TimingFileWatch, FollowingTheSameFilesAgainCostsNothing) {
  std::vector<std::string> files;
  for (int i = 0; i < 100; ++i) files.push_back(in("a" + std::to_string(i)));
  FileWatch watch;
  watch.follow(files);
  std::reverse(files.begin(), files.end());
  files.push_back(files.front());
  const Stopwatch stopwatch;
  for (int i = 0; i < 100; ++i) watch.follow(files);
  EXPECT_LT(stopwatch.seconds(), 1);
}

TEST_F(FileWatchEvents, TheDescriptorIsClosedAtTheEndAndInPrograms) {
  const size_t descriptors = countDescriptors();
  {
    const FileWatch watch;
    EXPECT_EQ(countDescriptors(), descriptors + 1);
    EXPECT_NE(fcntl(watch.descriptor(), F_GETFD) & FD_CLOEXEC, 0);
    EXPECT_NE(fcntl(watch.descriptor(), F_GETFL) & O_NONBLOCK, 0);
  }
  EXPECT_EQ(countDescriptors(), descriptors);
}

TEST_F(FileWatchEvents, WhereInotifyWorksLookingIsOnlyASafetyNet) {
  write(in("a"), "old");
  FileWatch woken, looking(false);
  for (FileWatch* watch : {&woken, &looking}) watch->follow({in("a")});
  EXPECT_GE(woken.descriptor(), 0);
  EXPECT_EQ(woken.pollMilliseconds(), 1000);
  EXPECT_EQ(looking.descriptor(), -1);
  EXPECT_EQ(looking.pollMilliseconds(), 250);
}

TEST_F(FileWatchEvents, AFolderThatCannotBeWatchedIsLookedAtMoreOften) {
  openToAll();
  fs::create_directory(in("sub"));
  write(in("sub/a"), "old");
  fs::permissions(in("sub"),
                  fs::perms::all & ~(fs::perms::owner_read | fs::perms::group_read | fs::perms::others_read));
  FileWatch watch;
  asOrdinaryUser([&] { watch.follow({in("sub/a")}); });
  EXPECT_EQ(watch.pollMilliseconds(), 250);
  write(in("sub/a"), "newer");
  asOrdinaryUser([&] { EXPECT_THAT(watch.takeChanges(), ElementsAre(in("sub/a"))); });
  fs::permissions(in("sub"), fs::perms::all);
  asOrdinaryUser([&] { EXPECT_THAT(watch.takeChanges(), IsEmpty()); });
  EXPECT_EQ(watch.pollMilliseconds(), 1000);
}

}  // namespace
}  // namespace turner::watch
