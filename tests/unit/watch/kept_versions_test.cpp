// Versions on disk: whole or not at all, numbers that go on.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "base/errors.h"
#include "base/text_file.h"
#include "support/temporary_folder.h"
#include "watch/output/kept_versions.h"

namespace turner::watch {
namespace {

namespace fs = std::filesystem;

KeptVersion someVersion() {
  KeptVersion version;
  version.sources = {{"", "my/whitted.comp", "the kernel"},
                     {"shade.glsl", "my/shade.glsl", "shading"},
                     {"parts/a.glsl", "my/parts/a.glsl", "a part"},
                     {"../common.glsl", "my/../common.glsl", "from beside"},
                     {"../../far.glsl", "my/../../far.glsl", "from elsewhere"},
                     {"gone.glsl", "my/gone.glsl", std::nullopt}};
  version.sceneName = "scene.json";
  version.sceneText = "{}";
  version.picture = "pixels";
  version.figures = "figures";
  return version;
}

std::vector<std::string> filesBelow(const fs::path& folder) {
  std::vector<std::string> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files.push_back(fs::relative(entry.path(), folder).string());
  return files;
}

TEST(KeptVersions, HaveAllThatOneNeedsToGoBack) {
  const test::TemporaryFolder folder;
  const std::string kept = keepVersion(folder.path.string(), 7, someVersion());
  EXPECT_EQ(kept, (folder.path / "0007").string());
  EXPECT_THAT(filesBelow(kept), testing::UnorderedElementsAre(
                                    "shaders/whitted.comp", "shaders/shade.glsl", "shaders/parts/a.glsl", "common.glsl",
                                    "outside/4/far.glsl", "scene/scene.json", "picture.exr", "figures.json"));
  EXPECT_EQ(readTextFile(kept + "/shaders/parts/a.glsl"), "a part");
  keepFigures(kept, "better figures");
  EXPECT_EQ(readTextFile(kept + "/figures.json"), "better figures");
}

TEST(KeptVersions, NumbersGoOn) {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path / "new" / "versions").string();
  EXPECT_EQ(lastKeptVersion(path), 0);
  for (const char* name : {"0002", "0011", "12", "notes", "0013x"}) fs::create_directory(fs::path(path) / name);
  EXPECT_EQ(lastKeptVersion(path), 11);
  EXPECT_EQ(fs::path(keepVersion(path, 12345, someVersion())).filename(), "12345");
  EXPECT_EQ(lastKeptVersion(path), 12345);
}

TEST(KeptVersions, LeaveNothingBehindWhereTheyCannotBe) {
  const test::TemporaryFolder folder;
  fs::create_directories(folder.path / "0003" / "in the way");
  EXPECT_THROW(keepVersion(folder.path.string(), 3, someVersion()), RunError);
  EXPECT_THAT(filesBelow(folder.path), testing::IsEmpty());
  std::ofstream(folder.path / "file") << "no folder";
  EXPECT_THROW(lastKeptVersion((folder.path / "file").string()), InputError);
}

}  // namespace
}  // namespace turner::watch
