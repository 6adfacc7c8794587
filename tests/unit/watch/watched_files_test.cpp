// Which saves are a change and which changes are one, by a clock of the test's own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <thread>

#include "base/text_file.h"
#include "support/temporary_folder.h"
#include "watch/files/watched_files.h"

namespace turner::watch {
namespace {

namespace fs = std::filesystem;

class WatchedFilesTest : public testing::Test {
 protected:
  WatchedFilesTest() {
    write("whitted.comp", "#include \"shade.glsl\"\nvoid main() {}\n");
    write("shade.glsl", "// shading\n");
    write("scene.json", "{}");
    files_ = std::make_unique<WatchedFiles>(in("scene.json"), folder_.path.string());
    files_->takeUp();
    loaded();
  }
  std::string in(const std::string& name) const { return (folder_.path / name).string(); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(in(name)) << text; }
  void loaded() {
    files_->sceneWasLoaded(files_->sceneEpoch(), {{"scene.json", sha256Hex(readTextFile(in("scene.json")))}});
  }
  // At a time, after a save: whether there is a change, when its steps are over.
  bool changedAt(double time) {
    files_->check(time);
    return files_->isDue(time + kBreath);
  }

  test::TemporaryFolder folder_;
  std::unique_ptr<WatchedFiles> files_;
};

TEST_F(WatchedFilesTest, AnEditedSourceIsAChange) {
  EXPECT_FALSE(changedAt(10));
  write("shade.glsl", "// edited\n");
  files_->check(20);
  EXPECT_FALSE(files_->isDue(20 + kBreath / 2)) << "the save may not be over";
  EXPECT_TRUE(files_->isDue(20 + kBreath));
  EXPECT_EQ(files_->lastChange(), 20);
  EXPECT_EQ(files_->takeUp().at(1).text, "// edited\n");
  EXPECT_FALSE(changedAt(21));
}

TEST_F(WatchedFilesTest, ASaveWithoutAChangeIsNone) {
  write("shade.glsl", "// shading\n");
  write("scene.json", "{}");
  EXPECT_FALSE(changedAt(10));
  EXPECT_FALSE(files_->isSceneStale());
  EXPECT_LT(files_->lastChange(), 10) << "and does not make others wait";
}

TEST_F(WatchedFilesTest, AChangeThatWasTakenBackIsNone) {
  write("shade.glsl", "// edited\n");
  files_->check(10);
  write("shade.glsl", "// shading\n");
  EXPECT_FALSE(changedAt(10.01));
}

TEST_F(WatchedFilesTest, TheTextOfAVersionThatWasGivenUpIsAChangeAgain) {
  write("shade.glsl", "// X\n");
  ASSERT_TRUE(changedAt(10));
  files_->takeUp();
  write("shade.glsl", "// Y\n");
  ASSERT_TRUE(changedAt(11));
  files_->forgetTaken();  // X is given up, and before Y is taken up ...
  write("shade.glsl", "// X\n");
  EXPECT_TRUE(changedAt(11.1));
}

TEST_F(WatchedFilesTest, SavesWithoutQuietBetweenThemAreOneBurst) {
  write("shade.glsl", "// 1\n");
  files_->check(10);
  const uint64_t burst = files_->burst();
  write("whitted.comp", "#include \"shade.glsl\"\n");
  files_->check(10.19);
  EXPECT_EQ(files_->burst(), burst);
  EXPECT_DOUBLE_EQ(files_->quietUntil(), 10.19 + kQuiet);
  write("shade.glsl", "// 2\n");
  files_->check(10.19 + kQuiet);
  EXPECT_NE(files_->burst(), burst);
}

TEST_F(WatchedFilesTest, ABurstComesToAnEnd) {
  double time = 10;
  for (int i = 0; time < 10 + kLongest; ++i, time += 0.1) {
    write("shade.glsl", "// " + std::to_string(i));
    files_->check(time);
    if (i % 2 == 0) files_->takeUp();  // work on it makes no new burst
  }
  EXPECT_DOUBLE_EQ(files_->quietUntil(), 10 + kLongest);
}

TEST_F(WatchedFilesTest, AChangedSceneIsStaleUntilItIsLoaded) {
  const uint64_t epoch = files_->sceneEpoch();
  write("scene.json", "{ }");
  EXPECT_TRUE(changedAt(10));
  EXPECT_GT(files_->sceneEpoch(), epoch);
  EXPECT_TRUE(files_->isSceneStale());
  files_->sceneWasLoaded(epoch, {{"scene.json", "of before"}});
  EXPECT_TRUE(files_->isSceneStale()) << "that was the one of before";
  loaded();
  EXPECT_FALSE(files_->isSceneStale());
}

TEST_F(WatchedFilesTest, MeshesOfASceneAreItsFiles) {
  write("cow.obj", "v 0 0 0\n");
  files_->sceneWasLoaded(files_->sceneEpoch(), {{"scene.json", ""}, {"cow.obj", sha256Hex("v 0 0 0\n")}});
  write("cow.obj", "v 1 0 0\n");
  EXPECT_TRUE(changedAt(10));
  EXPECT_TRUE(files_->isSceneStale());
}

TEST_F(WatchedFilesTest, AMeshThatChangedBeforeItWasFollowedIsAChange) {
  write("cow.obj", "v 1 0 0\n");
  files_->sceneWasLoaded(files_->sceneEpoch(), {{"scene.json", ""}, {"cow.obj", sha256Hex("v 0 0 0\n")}});
  EXPECT_TRUE(changedAt(10));
  EXPECT_TRUE(files_->isSceneStale());
}

TEST_F(WatchedFilesTest, NoEditIsLostAmongFilesThatComeAndGo) {
  // While one thread edits, includes are dropped and taken in again; the last state must be seen.
  std::atomic<bool> done = false;
  std::thread editor([&] {
    for (int i = 0; i < 300; ++i) {
      write("whitted.comp", i % 2 == 0 ? "void main() {}\n" : "#include \"shade.glsl\"\nvoid main() {}\n");
      write("shade.glsl", "// " + std::to_string(i) + '\n');
    }
    done = true;
  });
  double time = 10;
  std::string last;
  for (bool over = false; !over; time += 0.05) {
    over = done;
    if (changedAt(time)) last = files_->takeUp().back().text.value_or("");
  }
  editor.join();
  // The system's word may come a little later than the edit.
  for (int i = 0; i < 100 && last != "// 299\n"; ++i, time += 0.05) {
    if (changedAt(time)) last = files_->takeUp().back().text.value_or("");
  }
  EXPECT_EQ(last, "// 299\n");
}

TEST_F(WatchedFilesTest, AMeshThatIsMissingIsWaitedFor) {
  write("scene.json", R"({ "meshes": [ { "file" : "meshes/cow.obj" } ], "file": )");
  ASSERT_TRUE(changedAt(10));
  files_->takeUp();
  files_->sceneWasRefused();
  fs::create_directory(in("meshes"));
  EXPECT_FALSE(changedAt(11));
  write("meshes/cow.obj", "v 0 0 0\n");
  EXPECT_TRUE(changedAt(12));
}

TEST_F(WatchedFilesTest, AKernelThatIsGoneHasNoText) {
  fs::remove(in("whitted.comp"));
  ASSERT_TRUE(changedAt(10));
  EXPECT_EQ(files_->takeUp().at(0).text, std::nullopt);
  write("whitted.comp", "#include \"shade.glsl\"\nvoid main() {}\n");
  ASSERT_TRUE(changedAt(11));
  EXPECT_EQ(files_->takeUp().size(), 2u);
}

TEST_F(WatchedFilesTest, AnIncludeThatOnlyTheCompilerFindsIsFollowed) {
  write("odd.glsl", "// by a path that is put together\n");
  files_->check(9);
  files_->compilerRead({in("whitted.comp"), in("odd.glsl")});
  EXPECT_FALSE(changedAt(10));
  write("odd.glsl", "// edited\n");
  EXPECT_TRUE(changedAt(11));
}

}  // namespace
}  // namespace turner::watch
