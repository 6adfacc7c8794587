// The cache of compiled shaders: a hit is what a compilation would have given, and nothing that can be wrong with the
// cache is an error.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "base/cache_folder.h"
#include "base/errors.h"
#include "kernel/compile.h"
#include "kernel/shader_sources.h"
#include "kernel/spirv_cache.h"
#include "support/environment.h"
#include "support/temporary_folder.h"

namespace turner {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

const std::string kHead =
    "#version 460\n#extension GL_GOOGLE_include_directive : require\nlayout(local_size_x = 1) in;\n";

std::string bytesOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void setBytes(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

ino_t numberOf(const fs::path& path) {
  struct stat found {};
  EXPECT_EQ(stat(path.c_str(), &found), 0) << path;
  return found.st_ino;
}

std::string keyOf(char digit) {
  return std::string(64, digit);
}

class SpirvCache : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directory(folder / "shaders");
    home.set(folder.c_str());
    shader = write("a.comp", kHead + "#include \"b.glsl\"\n#include \"c.glsl\"\nvoid main() { b(); c(); }\n");
    write("b.glsl", "void b() {}\n");
    write("c.glsl", "#include \"d.glsl\"\nvoid c() { d(); }\n");
    write("d.glsl", "void d() {}\n");
  }
  void TearDown() override { fs::permissions(folder, fs::perms::owner_all); }

  std::string write(const std::string& name, const std::string& text) const {
    const fs::path path = folder / "shaders" / name;
    setBytes(path, text);
    return path.string();
  }
  std::string cache() const { return (folder / "turner").string(); }
  std::vector<fs::path> cached() const {
    std::vector<fs::path> paths;
    std::error_code none;
    for (fs::directory_iterator at(cache(), none), end; at != end; ++at) paths.push_back(at->path());
    std::sort(paths.begin(), paths.end());
    return paths;
  }
  // Puts other words under the key of the only shader in the cache, so that a hit is seen.
  CachedSpirv plant() const {
    const std::string key = cached().at(0).stem().string();
    const std::optional<CachedSpirv> kept = findCached(cache(), key);
    EXPECT_TRUE(kept.has_value());
    CachedSpirv planted = kept.value_or(CachedSpirv());
    planted.words.push_back(0xdecade);
    keepCached(cache(), key, planted);
    return planted;
  }

  const test::EnvironmentVariable home{"XDG_CACHE_HOME", ""};
  test::TemporaryFolder temporary;
  const fs::path folder = temporary.path;
  std::string shader;
};

// --- compiling by way of the cache ----------------------------------------------------------------------------------

TEST_F(SpirvCache, AHitGivesTheSameWordsAndFiles) {
  home.set("/dev/null");
  const Spirv without = compileGlsl(shader);
  home.set(folder.c_str());
  const Spirv first = compileGlsl(shader), second = compileGlsl(shader);
  EXPECT_THAT(cached(), SizeIs(1));
  EXPECT_EQ(first.words, without.words);
  EXPECT_EQ(second.words, without.words);
  const std::string at = (folder / "shaders").string();
  EXPECT_THAT(without.files, ElementsAre(shader, at + "/b.glsl", at + "/c.glsl", at + "/d.glsl"));
  EXPECT_EQ(first.files, without.files);
  EXPECT_EQ(second.files, without.files);
}

TEST_F(SpirvCache, AHitDoesNotCompile) {
  compileGlsl(shader);
  const CachedSpirv planted = plant();
  EXPECT_EQ(compileGlsl(shader).words, planted.words);
  EXPECT_THAT(cached(), SizeIs(1));
}

TEST_F(SpirvCache, TheFolderOfTheShaderDoesNotMatter) {
  compileGlsl(shader);
  const CachedSpirv planted = plant();
  fs::copy(folder / "shaders", folder / "elsewhere");
  fs::rename(folder / "elsewhere/a.comp", folder / "elsewhere/other.comp");
  const std::string at = (folder / "elsewhere").string();
  const Spirv found = compileGlsl(at + "/other.comp");
  EXPECT_EQ(found.words, planted.words);
  EXPECT_THAT(found.files, ElementsAre(at + "/other.comp", at + "/b.glsl", at + "/c.glsl", at + "/d.glsl"));

  const fs::path before = fs::current_path();
  fs::current_path(at);
  const Spirv here = compileGlsl("other.comp");
  fs::current_path(before);
  EXPECT_EQ(here.words, planted.words);
  EXPECT_THAT(here.files, ElementsAre("other.comp", "b.glsl", "c.glsl", "d.glsl"));
}

TEST_F(SpirvCache, AChangedFileMissesAndTheOldOneHitsAgain) {
  const std::vector<uint32_t> before = compileGlsl(shader).words;
  write("d.glsl", "shared uint x; void d() { x = 1u; }\n");
  const std::vector<uint32_t> deep = compileGlsl(shader).words;
  EXPECT_NE(deep, before);
  EXPECT_THAT(cached(), SizeIs(2));
  write("a.comp", kHead + "#include \"c.glsl\"\nvoid main() { c(); }\n");
  const std::vector<uint32_t> top = compileGlsl(shader).words;
  EXPECT_NE(top, deep);
  EXPECT_THAT(cached(), SizeIs(3));
  write("a.comp", kHead + "#include \"b.glsl\"\n#include \"c.glsl\"\nvoid main() { b(); c(); }\n");
  write("d.glsl", "void d() {}\n");
  EXPECT_EQ(compileGlsl(shader).words, before);
  EXPECT_THAT(cached(), SizeIs(3));
}

TEST_F(SpirvCache, SkippedIncludesAreNoFiles) {
  write("a.comp", kHead + "#if 0\n#include \"b.glsl\"\n#include \"none.glsl\"\n#endif\nvoid main() {}\n");
  for (int i = 0; i < 2; ++i) EXPECT_THAT(compileGlsl(shader).files, ElementsAre(shader));
  EXPECT_THAT(cached(), SizeIs(1));
}

TEST_F(SpirvCache, AnIncludeThatWasNotSeenIsNotCached) {
  // What compiles by its text here must not be found when the text has changed.
  write("a.comp", kHead + "# /**/ include \"b.glsl\"\nvoid main() { b(); }\n");
  const Spirv before = compileGlsl(shader);
  EXPECT_THAT(before.files, ElementsAre(shader, (folder / "shaders/b.glsl").string()));
  write("b.glsl", "shared uint x; void b() { x = 1u; }\n");
  EXPECT_NE(compileGlsl(shader).words, before.words);
  EXPECT_THAT(cached(), IsEmpty());
}

TEST_F(SpirvCache, ErrorsAreNotCachedAndReadTheSame) {
  write("d.glsl", "void d() { oops; }\n");
  for (int i = 0; i < 2; ++i) {
    try {
      compileGlsl(shader);
      ADD_FAILURE() << "it compiles";
    } catch (const InputError& error) {
      EXPECT_EQ(error.what(), (folder / "shaders/d.glsl").string() + ":1: error: 'oops' : undeclared identifier");
    }
  }
  EXPECT_THAT(cached(), IsEmpty());
}

TEST_F(SpirvCache, AnIncludeThatHasGoneIsAnErrorInSpiteOfTheCache) {
  compileGlsl(shader);
  fs::remove(folder / "shaders/d.glsl");
  try {
    compileGlsl(shader);
    ADD_FAILURE() << "it compiles";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("c.glsl:1: error: "));
    EXPECT_THAT(error.what(), testing::HasSubstr("d.glsl: cannot open"));
  }
}

TEST_F(SpirvCache, DamagedFilesAreIgnoredAndReplaced) {
  const std::vector<uint32_t> words = compileGlsl(shader).words;
  const fs::path path = cached().at(0);
  const std::string whole = bytesOf(path);
  std::string flipped = whole, swapped = whole;
  flipped[whole.size() / 2] ^= 1;
  swapped[whole.size() - 1] ^= 1;
  for (const std::string& damaged : {std::string(), whole.substr(0, 100), whole.substr(0, whole.size() - 1), flipped,
                                     swapped, whole + '\0', std::string(whole.size(), '\0')}) {
    setBytes(path, damaged);
    EXPECT_EQ(compileGlsl(shader).words, words);
    EXPECT_TRUE(bytesOf(path) == whole) << "replaced, after " << damaged.size() << " bytes";
  }
}

TEST_F(SpirvCache, ABitThatFlipsInAnyByteIsSeen) {
  keepCached(cache(), keyOf('a'), {{1, 2, 3}, {0}});
  const fs::path path = cached().at(0);
  const std::string whole = bytesOf(path);
  ASSERT_TRUE(findCached(cache(), keyOf('a')));
  for (size_t i = 0; i < whole.size(); ++i) {
    std::string flipped = whole;
    flipped[i] = char(flipped[i] ^ 1 << i % 8);
    setBytes(path, flipped);
    EXPECT_FALSE(findCached(cache(), keyOf('a'))) << "byte " << i;
  }
}

TEST_F(SpirvCache, AFileUnderAnotherOnesNameIsIgnored) {
  const std::vector<uint32_t> words = compileGlsl(shader).words;
  const fs::path path = cached().at(0);
  const std::string whole = bytesOf(path);
  keepCached(cache(), keyOf('a'), {{1, 2, 3}, {0}});
  fs::rename(cache() + '/' + keyOf('a') + ".spirv", path);
  EXPECT_EQ(compileGlsl(shader).words, words);
  EXPECT_TRUE(bytesOf(path) == whole);
}

TEST_F(SpirvCache, FileNumbersThatTheShaderDoesNotHaveAreIgnored) {
  const std::vector<uint32_t> words = compileGlsl(shader).words;
  keepCached(cache(), cached().at(0).stem().string(), {{1, 2, 3}, {0, 4}});
  EXPECT_EQ(compileGlsl(shader).words, words);
  EXPECT_EQ(compileGlsl(shader).files.size(), 4u);
}

TEST_F(SpirvCache, WhatIsNoFileIsLeftAlone) {
  const std::vector<uint32_t> words = compileGlsl(shader).words;
  const fs::path path = cached().at(0);
  fs::remove(path);
  fs::create_directories(path / "sub");
  EXPECT_EQ(compileGlsl(shader).words, words);
  EXPECT_THAT(cached(), ElementsAre(path)) << "no temporary file stays";
  fs::remove_all(path);
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  EXPECT_EQ(compileGlsl(shader).words, words) << "and does not wait for the pipe";
}

TEST_F(SpirvCache, NowhereToWriteIsNoFault) {
  const std::vector<uint32_t> words = compileGlsl(shader).words;
  setBytes(folder / "file", "");
  fs::create_directory(folder / "sealed");
  fs::permissions(folder / "sealed", fs::perms::none);
  for (const std::string& nowhere :
       {std::string("/proc"), (folder / "file").string(), (folder / "sealed").string(),
        (folder / "no/such/folder").string(), std::string("/dev/null"), std::string("/") + std::string(5000, 'n'),
        std::string("/") + std::string(300, 'n')}) {
    home.set(nowhere.c_str());
    EXPECT_EQ(compileGlsl(shader).words, words) << nowhere;
  }
  EXPECT_FALSE(fs::exists(folder / "no")) << "a home that is not there is not made";
  EXPECT_EQ(fs::file_size(folder / "file"), 0u);
  fs::permissions(folder / "sealed", fs::perms::owner_all);
}

TEST_F(SpirvCache, AFullDiskLeavesNothing) {
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  rlimit small = before;
  small.rlim_cur = 100;
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &small);
  const Spirv spirv = compileGlsl(shader);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_FALSE(spirv.words.empty());
  EXPECT_TRUE(fs::is_directory(cache()));
  EXPECT_THAT(cached(), IsEmpty());
}

TEST_F(SpirvCache, ReadersAndWritersInOtherProcessesSeeWholeFiles) {
  // Of very different sizes, so that a file in two writers' hands would not be whole.
  const CachedSpirv small{{7}, {0}}, large{std::vector<uint32_t>(300'000, 9), {0, 1}};
  keepCached(cache(), keyOf('a'), small);
  std::vector<pid_t> writers;
  for (const CachedSpirv* spirv : {&small, &large}) {
    writers.push_back(fork());
    ASSERT_GE(writers.back(), 0);
    if (writers.back() > 0) continue;
    for (int i = 0; i < 30; ++i) keepCached(cache(), keyOf('a'), *spirv);
    _exit(0);
  }
  size_t reads = 0;
  while (!writers.empty()) {
    const std::optional<CachedSpirv> found = findCached(cache(), keyOf('a'));
    ASSERT_TRUE(found) << "after " << reads << " reads";
    ASSERT_TRUE(found->words == small.words || found->words == large.words);
    ++reads;
    if (waitpid(writers.back(), nullptr, WNOHANG) != 0) writers.pop_back();
  }
  EXPECT_THAT(cached(), SizeIs(1)) << "no temporary file stays";
}

TEST_F(SpirvCache, TheCacheKeepsWhatWasUsedLast) {
  const auto now = fs::file_time_type::clock::now();
  fs::create_directories(cache());
  setBytes(folder / "turner/notes.txt", "not ours");
  fs::last_write_time(folder / "turner/notes.txt", now - std::chrono::hours(1000));
  const auto age = [&](size_t i, size_t hours) {
    const std::string key = std::to_string(1000 + i) + std::string(60, '0');
    fs::last_write_time(cache() + '/' + key + ".spirv", now - std::chrono::hours(hours));
    return key;
  };
  std::vector<std::string> keys;
  for (size_t i = 0; i < kMostCached; ++i) {
    keepCached(cache(), std::to_string(1000 + i) + std::string(60, '0'), {{uint32_t(i)}, {0}});
    keys.push_back(age(i, 500 - i));
  }
  setBytes(cache() + '/' + keyOf('f') + ".spirv.abcdef", "of a process that was killed");
  fs::last_write_time(cache() + '/' + keyOf('f') + ".spirv.abcdef", now - std::chrono::hours(900));
  EXPECT_TRUE(findCached(cache(), keys[0])) << "which makes it young again";

  keepCached(cache(), keyOf('a'), {{1}, {0}});
  EXPECT_THAT(cached(), SizeIs(kMostCached + 1)) << "with the notes";
  EXPECT_TRUE(findCached(cache(), keyOf('a')));
  EXPECT_TRUE(findCached(cache(), keys[0]));
  EXPECT_FALSE(findCached(cache(), keys[1])) << "the one not used for longest";
  EXPECT_TRUE(findCached(cache(), keys[2]));
  EXPECT_FALSE(fs::exists(cache() + '/' + keyOf('f') + ".spirv.abcdef"));
  EXPECT_TRUE(fs::exists(folder / "turner/notes.txt"));
}

TEST_F(SpirvCache, AHitWritesNothing) {
  compileGlsl(shader);
  const fs::path path = cached().at(0);
  const ino_t before = numberOf(path);
  compileGlsl(shader);
  EXPECT_EQ(numberOf(path), before);
}

// --- keys and places ------------------------------------------------------------------------------------------------

TEST_F(SpirvCache, TheKeyHoldsCompilerNamesAndTexts) {
  const std::vector<ShaderSource> sources = {{"", "/x/a.comp", "main"}, {"b.glsl", "/x/b.glsl", "text"}};
  const std::string key = spirvKey("compiler 1", sources);
  EXPECT_EQ(key.size(), 64u);
  std::vector<ShaderSource> changed = sources;
  for (ShaderSource& source : changed) source.path = "/y" + source.path;
  EXPECT_EQ(spirvKey("compiler 1", changed), key);
  EXPECT_NE(spirvKey("compiler 2", sources), key);

  std::vector<std::string> keys = {key};
  const auto change = [&](size_t i, const std::string& name, const std::optional<std::string>& text) {
    changed = sources;
    changed[i].name = name;
    changed[i].text = text;
    keys.push_back(spirvKey("compiler 1", changed));
  };
  change(0, "", "mai");
  change(1, "b.glsl", "texT");
  change(1, "c.glsl", "text");
  change(1, "b.glsl", "");
  change(1, "b.glsl", std::nullopt);
  keys.push_back(spirvKey("compiler 1", {sources[0]}));
  keys.push_back(spirvKey("compiler 1", {sources[0], sources[1], sources[1]}));
  std::sort(keys.begin(), keys.end());
  EXPECT_EQ(std::unique(keys.begin(), keys.end()), keys.end());
}

TEST_F(SpirvCache, TheFolderFollowsTheEnvironment) {
  const test::EnvironmentVariable user("HOME", "/home/somebody");
  home.set("/some/cache");
  EXPECT_EQ(cacheFolder(), "/some/cache/turner");
  for (const char* unusable : {"", "relative"}) {
    home.set(unusable);
    EXPECT_EQ(cacheFolder(), "/home/somebody/.cache/turner");
  }
  home.set(nullptr);
  EXPECT_EQ(cacheFolder(), "/home/somebody/.cache/turner");
  for (const char* unusable : {"relative", ""}) {
    user.set(unusable);
    EXPECT_EQ(cacheFolder(), "");
  }
  user.set(nullptr);
  EXPECT_EQ(cacheFolder(), "");
  EXPECT_FALSE(compileGlsl(shader).words.empty());
}

TEST_F(SpirvCache, TheFolderIsForItsOwnerAlone) {
  home.set((folder / "new").c_str());
  compileGlsl(shader);
  for (const char* made : {"new", "new/turner"})
    EXPECT_EQ(fs::status(folder / made).permissions(), fs::perms::owner_all) << made;
}

// --- sources --------------------------------------------------------------------------------------------------------

TEST_F(SpirvCache, SourcesAreFoundByTheLookOfTheirLines) {
  fs::create_directory(folder / "shaders/sub");
  write("sub/e.glsl", "#include \"../b.glsl\"\r#include \"f.glsl\"");
  write("a.comp",
        "#include \"b.glsl\"\r\n \t# \tinclude\"sub/e.glsl\" // why\n#include <g.glsl>\nx #include \"h.glsl\"\n"
        "#included \"i.glsl\"\n#include \"j.glsl\n#include \"\"\n#include \"b.glsl\"\n#include \"/k.glsl\"");
  std::vector<std::string> names, paths, unreadable;
  for (const ShaderSource& source : readShaderSources(shader)) {
    names.push_back(source.name);
    paths.push_back(source.path.substr((folder / "shaders/").string().size()));
    if (!source.text) unreadable.push_back(source.name);
  }
  EXPECT_THAT(names, ElementsAre("", "b.glsl", "sub/e.glsl", "sub/../b.glsl", "sub/f.glsl"));
  EXPECT_THAT(paths, ElementsAre("a.comp", "b.glsl", "sub/e.glsl", "sub/../b.glsl", "sub/f.glsl"));
  EXPECT_THAT(unreadable, ElementsAre("sub/f.glsl"));
}

TEST_F(SpirvCache, EndlessIncludesEnd) {
  write("b.glsl", "#include \"../shaders/b.glsl\"\n#include \"../shaders/../shaders/b.glsl\"\n");
  EXPECT_GT(readShaderSources(shader).size(), 30u);
  try {
    compileGlsl(shader);
    ADD_FAILURE() << "it compiles";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("nest too deep"));
  }
}

}  // namespace
}  // namespace turner
