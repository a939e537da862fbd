#include "cli/viewer_connection.h"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>

#include <fmt/core.h>

#include "core/errors.h"
#include "core/printable.h"

namespace etendue::cli {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::chrono::seconds kConnectPatience{5};  // for one address
constexpr int kLookEvery = 50;                       // ms
constexpr int kSendBuffer = 1 << 18;                 // bytes
constexpr const char* kStopped = "stopped";

bool is_port(const std::string& text) {
  unsigned number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() && number >= 1 && number <= 65535;
}

[[noreturn]] void fail_on_address(const std::string& text, const std::string& reason) {
  throw Error(ErrorKind::usage,
              fmt::format("'--tev={}' {}; write host:port, for example 127.0.0.1:14158 or [::1]:14158.",
                          text::printable(text, 100), reason));
}

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

/// If there is none, `error` is set to the reason.
Addresses look_up(const ViewerAddress& address, std::string& error) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int code = getaddrinfo(address.host.c_str(), address.port.c_str(), &hints, &found);
  if (code != 0) error = code == EAI_SYSTEM ? std::strerror(errno) : gai_strerror(code);
  return {code == 0 ? found : nullptr, freeaddrinfo};
}

}  // namespace

ViewerAddress parse_viewer_address(const std::string& text) {
  ViewerAddress address;
  std::string host = text, port;
  if (text.starts_with("[")) {
    const std::size_t end = text.find(']');
    if (end == std::string::npos) fail_on_address(text, "has no ']' after the address");
    host = text.substr(1, end - 1);
    if (host.empty()) fail_on_address(text, "has no address between the brackets");
    const std::string rest = text.substr(end + 1);
    if (!rest.empty() && rest[0] != ':') fail_on_address(text, "continues after the ']' without a colon");
    if (rest == ":") fail_on_address(text, "has no port after the colon");
    port = rest.empty() ? "" : rest.substr(1);
  } else if (std::ranges::count(text, ':') == 1) {  // more colons mean an IPv6 address without a port
    const std::size_t colon = text.find(':');
    host = text.substr(0, colon);
    port = text.substr(colon + 1);
    if (port.empty()) fail_on_address(text, "has no port after the colon");
  }
  if (!port.empty() && !is_port(port)) {
    fail_on_address(
        text, fmt::format("has '{}' as its port, which is not a number from 1 to 65535", text::printable(port, 40)));
  }
  if (!host.empty()) address.host = host;
  if (!port.empty()) address.port = port;
  return address;
}

std::string to_text(const ViewerAddress& address) {
  const std::string host = text::printable(address.host, 100);
  return host.find(':') == std::string::npos ? fmt::format("{}:{}", host, address.port)
                                             : fmt::format("[{}]:{}", host, address.port);
}

void ViewerConnection::close() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

// False if `go_on` returns false. Errors count as ready; the next call will find them.
bool ViewerConnection::wait(short events, const GoOn& go_on) const {
  for (;;) {
    if (!go_on()) return false;
    pollfd stream{.fd = socket_, .events = events, .revents = 0};
    const int ready = poll(&stream, 1, kLookEvery);
    if (ready > 0 || (ready < 0 && errno != EINTR)) return true;
  }
}

std::string ViewerConnection::open(const ViewerAddress& address, const GoOn& go_on) {
  close();
  std::string error;
  const Addresses addresses = look_up(address, error);
  for (const addrinfo* each = addresses.get(); each != nullptr; each = each->ai_next) {
    socket_ = socket(each->ai_family, each->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, each->ai_protocol);
    if (socket_ < 0) {
      error = std::strerror(errno);
      continue;
    }
    // A small buffer, because a picture that waits in the system's memory has not been received by the viewer.
    setsockopt(socket_, SOL_SOCKET, SO_SNDBUF, &kSendBuffer, sizeof(kSendBuffer));
    if (connect(socket_, each->ai_addr, each->ai_addrlen) == 0) return "";
    int reason = errno;
    if (reason == EINPROGRESS || reason == EINTR) {
      const auto end = SteadyClock::now() + kConnectPatience;
      socklen_t size = sizeof(reason);
      if (!wait(POLLOUT, [&] { return go_on() && SteadyClock::now() < end; })) {
        reason = ETIMEDOUT;
      } else if (getsockopt(socket_, SOL_SOCKET, SO_ERROR, &reason, &size) != 0) {
        reason = errno;
      }
    }
    if (reason == 0) return "";
    error = std::strerror(reason);
    close();
  }
  return error.empty() ? "it has no address" : error;
}

std::string ViewerConnection::send(std::span<const std::byte> bytes, const GoOn& go_on,
                                   const std::function<void(std::size_t)>& taken) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(sent));
      taken(static_cast<std::size_t>(sent));
      continue;
    }
    const int reason = errno;
    if (reason == EINTR) continue;
    const bool full = reason == EAGAIN || reason == EWOULDBLOCK;
    if (full && wait(POLLOUT, go_on)) continue;
    close();
    return full ? kStopped : std::strerror(reason);
  }
  return "";
}

bool ViewerConnection::finish(std::chrono::milliseconds patience, const GoOn& go_on) {
  shutdown(socket_, SHUT_WR);
  const auto end = SteadyClock::now() + patience;
  bool kept = true;
  char nothing[256];
  while (wait(POLLIN, [&] { return go_on() && SteadyClock::now() < end; })) {
    const ssize_t got = recv(socket_, nothing, sizeof(nothing), 0);
    if (got > 0 || (got < 0 && (errno == EAGAIN || errno == EINTR))) continue;
    kept = got == 0;
    break;
  }
  close();
  return kept;
}

bool ViewerConnection::was_closed() const {
  char byte = 0;
  const ssize_t got = recv(socket_, &byte, 1, MSG_PEEK | MSG_DONTWAIT);
  return got == 0 || (got < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR);
}

}  // namespace etendue::cli
