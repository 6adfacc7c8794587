// One end of a line between two processes: whole messages, each a kind and bytes.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/unique_fd.h"

namespace turner::watch {

struct Message {
  uint32_t kind = 0;
  std::string bytes;
};

class Channel {
 public:
  // Of a socket, which it closes in the end.
  explicit Channel(int socket);

  // Waits until the other end has taken it. False: there is no other end any more.
  bool send(uint32_t kind, std::string_view bytes);
  // Sends as much as the other end takes at once; sendRest() goes on with the rest. Never waits.
  void post(uint32_t kind, std::string_view bytes);
  void sendRest();
  bool hasRest() const { return !rest_.empty(); }
  // The next message that has come whole. Never waits.
  std::optional<Message> receive();
  // Whether receive() has something to look at.
  bool hasArrivals() const;
  // The next message; waits for it. None: the other end is gone.
  std::optional<Message> wait();
  // Whether the other end is gone and all that it has sent was received.
  bool isFinished() const { return gone_ && messages_.empty(); }

  int descriptor() const { return socket_.number; }

 private:
  void readArrivals(bool wait);

  UniqueFd socket_;
  std::string rest_;     // posted and not yet sent
  std::string arrived_;  // the beginning of a message
  std::deque<Message> messages_;
  bool gone_ = false;
};

// Two ends of a line. Throws RunError.
std::pair<int, int> makeChannel();

}  // namespace turner::watch
