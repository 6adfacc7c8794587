// On the line a message is: its kind, its size, its bytes.
#include "watch/process/channel.h"

#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "base/errors.h"

namespace turner::watch {
namespace {

struct Head {
  uint64_t kind, size;
};

constexpr size_t kPiece = 1 << 18;  // bytes that are received at once; a line holds about that much

// How many bytes were sent, fewer only if the other end is gone, or with MSG_DONTWAIT if it does not take more now.
size_t sendBytes(int socket, std::string_view bytes, int flags) {
  size_t done = 0;
  while (done < bytes.size()) {
    // A closed line is no reason to end this process.
    const ssize_t sent = ::send(socket, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL | flags);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) break;
    done += size_t(sent);
  }
  return done;
}

std::string_view bytesOf(const Head& head) {
  return {reinterpret_cast<const char*>(&head), sizeof head};
}

}  // namespace

std::pair<int, int> makeChannel() {
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    throw RunError(std::string("socketpair: ") + std::strerror(errno));
  return {ends[0], ends[1]};
}

Channel::Channel(int socket) : socket_(socket) {}

bool Channel::send(uint32_t kind, std::string_view bytes) {
  const Head head{kind, bytes.size()};
  return sendBytes(socket_.number, bytesOf(head), 0) == sizeof head &&
         sendBytes(socket_.number, bytes, 0) == bytes.size();
}

void Channel::post(uint32_t kind, std::string_view bytes) {
  rest_.append(bytesOf({kind, bytes.size()})).append(bytes);
  sendRest();
}

void Channel::sendRest() {
  rest_.erase(0, sendBytes(socket_.number, rest_, MSG_DONTWAIT));
  if (rest_.empty()) rest_ = std::string();  // without the room of a kernel
}

// Reads until there is nothing for the moment, or, where it waits, until a message is whole.
void Channel::readArrivals(bool wait) {
  while (!gone_) {
    const size_t before = arrived_.size();
    arrived_.resize(before + kPiece);
    const bool block = wait && messages_.empty();
    const ssize_t got = ::recv(socket_.number, arrived_.data() + before, kPiece, block ? 0 : MSG_DONTWAIT);
    const int error = errno;
    arrived_.resize(before + (got > 0 ? size_t(got) : 0));
    if (got < 0 && error == EINTR) continue;
    if (got < 0 && (error == EAGAIN || error == EWOULDBLOCK)) return;
    if (got <= 0) {
      gone_ = true;
      return;
    }
    size_t done = 0;
    for (Head head; arrived_.size() - done >= sizeof head;) {
      std::memcpy(&head, arrived_.data() + done, sizeof head);
      if (arrived_.size() - done - sizeof head < head.size) break;
      messages_.push_back({uint32_t(head.kind), arrived_.substr(done + sizeof head, head.size)});
      done += sizeof head + head.size;
    }
    arrived_.erase(0, done);
    if (arrived_.empty()) arrived_ = std::string();  // without the room of a picture
  }
}

std::optional<Message> Channel::receive() {
  readArrivals(false);
  if (messages_.empty()) return std::nullopt;
  Message message = std::move(messages_.front());
  messages_.pop_front();
  return message;
}

bool Channel::hasArrivals() const {
  pollfd wait{socket_.number, POLLIN, 0};
  return !messages_.empty() || (!gone_ && ::poll(&wait, 1, 0) > 0);
}

std::optional<Message> Channel::wait() {
  if (messages_.empty()) readArrivals(true);
  return receive();
}

}  // namespace turner::watch
