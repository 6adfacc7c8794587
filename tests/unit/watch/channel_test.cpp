// Messages between the watcher and its worker: what goes in comes out, whole, in order, and an end is noticed.
#include <gtest/gtest.h>

#include <thread>

#include "watch/process/channel.h"
#include "watch/process/messages.h"

namespace turner::watch {
namespace {

struct TwoEnds : testing::Test {
  std::pair<int, int> ends = makeChannel();
  std::unique_ptr<Channel> here = std::make_unique<Channel>(ends.first), there = std::make_unique<Channel>(ends.second);
};

Job someJob() {
  Job job;
  job.number = 7;
  job.purpose = Purpose::findLoop;
  job.hung = true;
  job.sources = {{"", "a/whitted.comp", "void main() {}\n"}, {"gone.glsl", "a/gone.glsl", std::nullopt}};
  job.goodWords = {1, 2, 0x07230203};
  return job;
}

TEST(Messages, OfEveryKindComeOutAsTheyWentIn) {
  const Job job = decode<Job>(encode(someJob()));
  EXPECT_EQ(job.number, 7u);
  EXPECT_EQ(job.purpose, Purpose::findLoop);
  EXPECT_TRUE(job.hung);
  EXPECT_FALSE(job.reloadScene);
  ASSERT_EQ(job.sources.size(), 2u);
  EXPECT_EQ(job.sources[0].text, "void main() {}\n");
  EXPECT_EQ(job.sources[1].path, "a/gone.glsl");
  EXPECT_EQ(job.sources[1].text, std::nullopt);
  EXPECT_EQ(job.goodWords, (std::vector<uint32_t>{1, 2, 0x07230203}));

  SceneReady ready;
  ready.job = 3;
  ready.summary.name = "spheres";
  ready.summary.camera.fov = 33;
  ready.summary.sources = {{"spheres.json", "abc"}, {"bunny.obj", "def"}};
  ready.summary.notes = {"no lights", ""};
  ready.settings.samples = 5;
  ready.uploadSeconds = 0.25;
  const SceneReady scene = decode<SceneReady>(encode(ready));
  EXPECT_EQ(scene.summary.name, "spheres");
  EXPECT_EQ(scene.summary.camera.fov, 33);
  EXPECT_EQ(scene.summary.sources.at(1).path, "bunny.obj");
  EXPECT_EQ(scene.summary.sources.at(1).sha256, "def");
  EXPECT_EQ(scene.summary.notes, ready.summary.notes);
  EXPECT_EQ(scene.settings.samples, 5);
  EXPECT_EQ(scene.uploadSeconds, 0.25);

  Picture picture;
  picture.coarse = true;
  picture.image = Image(4, 3, {1, 1, 3, 2});
  picture.image.rgb = {1, 2, 3, 4, 5, 6};
  const Picture shown = decode<Picture>(encode(picture));
  EXPECT_TRUE(shown.coarse);
  EXPECT_EQ(shown.image.window, picture.image.window);
  EXPECT_EQ(shown.image.rgb, picture.image.rgb);

  const Counted counted = decode<Counted>(encode(Counted{9, {1, 2, 3, 4}}));
  EXPECT_EQ(counted.rays, (RayCounts{1, 2, 3, 4}));
}

TEST(Messages, ThatEndTooEarlyAreRefused) {
  Message message = encode(someJob());
  for (size_t size = 0; size < message.bytes.size(); ++size)
    EXPECT_THROW(decode<Job>({message.kind, message.bytes.substr(0, size)}), std::length_error) << size;
}

TEST_F(TwoEnds, MessagesArriveWholeAndInOrder) {
  // Larger than what the line holds: the sender waits for the receiver.
  const std::string large(5 << 20, 'x');
  std::thread sender([&] {
    EXPECT_TRUE(there->send(1, "first"));
    EXPECT_TRUE(there->send(2, large));
    EXPECT_TRUE(there->send(3, ""));
  });
  for (const auto& [kind, bytes] : std::vector<std::pair<uint32_t, std::string>>{{1, "first"}, {2, large}, {3, ""}}) {
    const std::optional<Message> message = here->wait();
    ASSERT_TRUE(message);
    EXPECT_EQ(message->kind, kind);
    EXPECT_EQ(message->bytes, bytes);
  }
  sender.join();
}

TEST_F(TwoEnds, PostingDoesNotWait) {
  const std::string large(5 << 20, 'x');
  there->post(1, large);
  there->post(2, "second");
  EXPECT_TRUE(there->hasRest());
  std::vector<Message> messages;
  while (messages.size() < 2) {
    there->sendRest();
    while (std::optional<Message> message = here->receive()) messages.push_back(std::move(*message));
  }
  EXPECT_FALSE(there->hasRest());
  EXPECT_EQ(messages[0].bytes, large);
  EXPECT_EQ(messages[1].kind, 2u);
  EXPECT_EQ(messages[1].bytes, "second");
}

TEST_F(TwoEnds, NothingIsReceivedWithoutWaiting) {
  EXPECT_FALSE(here->receive());
  EXPECT_FALSE(here->isFinished());
  // The head of a message alone is none.
  const uint64_t head[2] = {1, 10};
  ASSERT_EQ(::write(there->descriptor(), head, sizeof head), ssize_t(sizeof head));
  EXPECT_FALSE(here->receive());
  ASSERT_EQ(::write(there->descriptor(), "0123456789", 10), 10);
  const std::optional<Message> message = here->receive();
  ASSERT_TRUE(message);
  EXPECT_EQ(message->bytes, "0123456789");
}

TEST_F(TwoEnds, AnEndThatIsGoneIsNoticedAfterItsLastMessage) {
  EXPECT_TRUE(there->send(4, "last"));
  there.reset();
  EXPECT_FALSE(here->isFinished());
  const std::optional<Message> message = here->wait();
  ASSERT_TRUE(message);
  EXPECT_EQ(message->bytes, "last");
  EXPECT_FALSE(here->wait());
  EXPECT_TRUE(here->isFinished());
  EXPECT_FALSE(here->send(5, "nobody hears this")) << "and no signal ends the process";
}

}  // namespace
}  // namespace turner::watch
