// What becomes of versions: the state machine alone, with a clock, outputs and a worker that the test plays.
#include "watch/versions.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>

#include "base/errors.h"
#include "watch/files/watched_files.h"

namespace turner::watch {
namespace {

// Notes everything that the versions do, in order, as a word each.
class Versions : public ::testing::Test, public VersionActions, public WatchListener {
 protected:
  // --- the world

  double now() const override { return time; }
  double quietUntil(uint64_t) const override { return quiet; }
  void submit(Job job) override {
    log.push_back(job.purpose == Purpose::findLoop ? "findLoop" : "render");
    lastJob = std::move(job);
  }
  std::vector<std::string> show(const Image& image, const SceneReady&, bool coarse) override {
    log.push_back(fmt::format("show {}{}", image.rgb[0], coarse ? " coarse" : ""));
    return showFaults;
  }
  std::string keep(const GoodVersion&, const VersionReport& report) override {
    return fmt::format("{:04}", report.version);
  }
  void keepFigures(const VersionReport& report) override { log.push_back("figures " + report.kept); }
  const Image* reference(uint64_t epoch) const override {
    const auto found = references.find(epoch);
    return found == references.end() ? nullptr : &found->second;
  }
  void compilerRead(const std::vector<std::string>&) override {}
  void sceneWasRefused() override { log.push_back("sceneWasRefused"); }
  void forgetTaken() override { log.push_back("forgetTaken"); }

  // --- events

  void onScene(const SceneReady&) override { log.push_back("scene"); }
  void onCoarse(int version, double seconds) override { log.push_back(fmt::format("coarse {} {}", version, seconds)); }
  void onPicture(int version, double seconds, const std::vector<std::string>&) override {
    log.push_back(fmt::format("picture {} {}", version, seconds));
  }
  void onVersion(const VersionReport& report) override {
    log.push_back(fmt::format("version {}", report.version));
    lastReport = report;
  }
  void onReference(int version, const Comparison&) override { log.push_back(fmt::format("reference {}", version)); }
  void onRefused(const Refusal& refusal) override {
    log.push_back(fmt::format("refused {}{}", refusal.version, refusal.endless ? " endless" : ""));
    lastRefusal = refusal;
  }
  void onSuperseded(int version) override { log.push_back(fmt::format("superseded {}", version)); }
  void onTrouble(int version, const std::vector<Diagnosis>&) override {
    log.push_back(fmt::format("trouble {}", version));
  }
  void onStop(std::optional<int> version) override { log.push_back(fmt::format("stop {}", version.value_or(0))); }
  void onProgress(int, Step, double) override {}

  // --- the worker

  void begin(const std::string& text, uint64_t burst = 1) {
    versions.begin({.burst = burst,
                    .sceneEpoch = 1,
                    .savedAt = time,
                    .beganAt = time,
                    .sources = {{"", "whitted.comp", text}},
                    .unreadable = {}});
  }
  template <class Value>
  void answer(const Value& value) {
    versions.receive(encode(value));
  }
  static Image imageOf(float value) {
    Image image(1, 1, {0, 0, 1, 1});
    image.rgb = {value, value, value};
    return image;
  }
  void answerPicture(float value, bool coarse = false) {
    Picture picture;
    picture.coarse = coarse;
    picture.image = imageOf(value);
    picture.traceSeconds = 1;
    answer(picture);
  }
  // A version from its begin to its end.
  void finish(const std::string& text, float value, uint64_t burst = 1) {
    begin(text, burst);
    answer(SceneReady{});
    answer(Compiled{});
    answerPicture(value);
    answer(Finished{});
    versions.applyAnswers();
    log.clear();
  }
  using Log = std::vector<std::string>;

  double time = 10, quiet = 0;
  std::vector<std::string> showFaults;
  std::map<uint64_t, Image> references;
  Log log;
  Job lastJob;
  VersionReport lastReport;
  Refusal lastRefusal;
  watch::Versions versions{*this, *this, 4};
};

TEST_F(Versions, GoFromAChangeToAPictureAndItsReport) {
  begin("a");
  answer(SceneReady{});
  answer(Compiled{});
  time = 10.25;
  answerPicture(1, true);
  versions.applyAnswers();
  time = 11;
  answerPicture(2);
  answer(Finished{});
  versions.applyAnswers();
  EXPECT_EQ(log, (Log{"render", "scene", "show 1 coarse", "coarse 5 0.25", "show 2", "picture 5 1", "version 5"}));
  EXPECT_EQ(lastReport.kept, "0005");
  EXPECT_FALSE(versions.isWorking());
  ASSERT_TRUE(versions.good());
  EXPECT_EQ(versions.good()->version, 5);
}

TEST_F(Versions, HoldAnswersUntilTheBurstOfSavesIsOver) {
  begin("a");
  answerPicture(1);
  quiet = 10.2;
  versions.applyAnswers();
  EXPECT_EQ(log, Log{"render"});
  EXPECT_FALSE(versions.hasAnswersDue());
  EXPECT_EQ(versions.nextDecision(), 10.2);
  time = 10.2;
  EXPECT_TRUE(versions.hasAnswersDue());
}

TEST_F(Versions, ACoarsePictureIsNotShownWhereTheFullOneIsThere) {
  begin("a");
  answerPicture(1, true);
  answerPicture(2);
  versions.applyAnswers();
  EXPECT_EQ(log, (Log{"render", "show 2", "picture 5 0"}));
}

TEST_F(Versions, ARefusalBringsTheLastGoodPictureBack) {
  finish("a", 1);
  begin("b");
  answerPicture(2, true);
  versions.applyAnswers();
  answer(Refused{.step = Step::picture, .wrongInput = true, .text = "whitted.comp:1: error: wrong"});
  versions.applyAnswers();
  EXPECT_EQ(log, (Log{"render", "show 2 coarse", "coarse 6 0", "show 1", "refused 6"}));
  EXPECT_EQ(lastRefusal.lastGood, 5);
  ASSERT_EQ(lastRefusal.diagnoses.size(), 1u);
  EXPECT_EQ(lastRefusal.diagnoses[0].line, 1);
}

TEST_F(Versions, AnEndlessLoopIsLookedForBeforeTheRefusal) {
  begin("a");
  answer(Refused{.step = Step::coarse, .endless = true, .text = "cut"});
  versions.applyAnswers();
  EXPECT_EQ(log, (Log{"render", "findLoop"}));
  answer(LoopFound{.path = "whitted.comp", .line = 7, .column = 3});
  answer(Finished{});
  versions.applyAnswers();
  EXPECT_EQ(log, (Log{"render", "findLoop", "forgetTaken", "refused 5 endless"}));
  EXPECT_EQ(lastRefusal.diagnoses.at(0).line, 7);
}

TEST_F(Versions, ANewerSaveSupersedesAVersionWithoutAPicture) {
  begin("a", 1);
  EXPECT_TRUE(versions.interrupt(2));
  versions.waitForWorker(2);
  versions.waitForWorker(3);  // overtaken while it waits
  begin("c", 3);
  EXPECT_EQ(log, (Log{"render", "superseded 5", "forgetTaken", "superseded 6", "render"}));
  EXPECT_EQ(versions.version(), 7);
}

TEST_F(Versions, TheSameBurstRepeatsTheVersion) {
  begin("a", 1);
  EXPECT_TRUE(versions.interrupt(1));
  versions.waitForWorker(1);
  begin("b", 1);
  EXPECT_EQ(log, (Log{"render", "forgetTaken", "render"}));
  EXPECT_EQ(versions.version(), 5);
}

TEST_F(Versions, EndlessSavesLeaveAVersionTimeForAPicture) {
  for (uint64_t burst = 1; time < 10 + kLongest; time += 0.5) {
    begin("a", burst);
    EXPECT_TRUE(versions.interrupt(++burst)) << time;
  }
  time += 0.5;
  begin("a", 9);
  EXPECT_FALSE(versions.interrupt(10));
  time = versions.protectedUntil();
  EXPECT_TRUE(versions.interrupt(10));
}

TEST_F(Versions, AVersionWithAPictureEndsEarlyWithWhatIsKnown) {
  begin("a");
  answerPicture(1);
  versions.applyAnswers();
  answer(Counted{.rays = {.eye = 3}});
  EXPECT_TRUE(versions.interrupt(2));
  EXPECT_EQ(log, (Log{"render", "show 1", "picture 5 0", "version 5"}));
  ASSERT_TRUE(lastReport.rays);
  EXPECT_EQ(lastReport.rays->eye, 3u);
  EXPECT_FALSE(lastReport.timing);
}

TEST_F(Versions, TheSameCodeTakesTheLastGoodPicture) {
  finish("a", 1);
  begin("a ");
  answer(Compiled{.sameAsGood = true});
  answer(Finished{});
  versions.applyAnswers();
  EXPECT_EQ(log, (Log{"render", "show 1", "picture 6 0", "version 6"}));
  EXPECT_TRUE(lastReport.sameCode);
  EXPECT_EQ(lastReport.trace, 1);
}

TEST_F(Versions, AKernelThatCannotBeReadNeverComesToTheWorker) {
  versions.begin(
      {.burst = 1, .sources = {{"", "whitted.comp", std::nullopt}}, .unreadable = "whitted.comp: error: gone"});
  versions.applyAnswers();
  EXPECT_EQ(log, Log{"refused 5"});
  EXPECT_EQ(lastRefusal.step, Step::compile);
}

TEST_F(Versions, WhatNoEditCanMendIsThrown) {
  begin("a");
  answer(Refused{.step = Step::open, .wrongInput = true, .text = "no such device"});
  EXPECT_THROW(versions.applyAnswers(), InputError);
}

TEST_F(Versions, AReferenceThatComesLaterIsReportedAndKept) {
  finish("a", 1);
  references[1] = imageOf(1);
  versions.applyReference();
  EXPECT_EQ(log, (Log{"figures 0005", "reference 5"}));
}

TEST_F(Versions, OutputsThatCannotBeWrittenAreTroubleAndWrittenAgainAtTheEnd) {
  showFaults = {"full"};
  begin("a");
  answerPicture(1);
  answer(Finished{});
  versions.applyAnswers();
  showFaults.clear();
  versions.stop();
  EXPECT_EQ(log, (Log{"render", "show 1", "trouble 5", "picture 5 0", "version 5", "show 1", "stop 5"}));
}

}  // namespace
}  // namespace turner::watch
