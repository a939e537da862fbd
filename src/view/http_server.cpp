#include "view/http_server.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <list>
#include <mutex>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <httplib.h>

#include "core/errors.h"
#include "core/log.h"

namespace etendue::view {
namespace {

using Clock = std::chrono::steady_clock;

/// Waits until the socket can be read or written; false if the time runs out or the socket is closed.
bool wait_for(int socket, short events, Clock::time_point deadline) {
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0) return false;
    pollfd one{.fd = socket, .events = events, .revents = 0};
    const int ready = poll(&one, 1, static_cast<int>(std::min<long long>(left, 1000)));
    if (ready > 0) return (one.revents & (events | POLLHUP)) != 0;
    if (ready < 0 && errno != EINTR) return false;
  }
}

/// The stream from which the library reads a request and to which it writes the response. It limits what the library
/// does not: the total bytes of a request, and the time until they have arrived.
class BoundedStream final : public httplib::Stream {
 public:
  BoundedStream(int socket, const ServerLimits& limits)
      : socket_(socket),
        left_(limits.head_bytes),
        send_time_(limits.send_time),
        until_(Clock::now() + limits.head_time) {}

  bool is_readable() const override { return left_ > 0; }
  // Which of these four functions is called depends on the version of the library.
  bool is_writable() const { return !broken_; }
  bool wait_readable() const { return is_readable(); }
  bool wait_writable() const { return !broken_; }
  time_t duration() const { return 0; }
  ssize_t read(char* data, std::size_t size) override {
    if (at_ == end_ && !fill()) return -1;
    const std::size_t count = std::min(size, end_ - at_);
    std::memcpy(data, buffer_ + at_, count);
    at_ += count;
    return static_cast<ssize_t>(count);
  }
  ssize_t write(const char* data, std::size_t size) override {
    if (!sending_) until_ = Clock::now() + send_time_;
    sending_ = true;
    std::size_t sent = 0;
    while (sent < size && !broken_) {
      const ssize_t count = send(socket_, data + sent, size - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
      if (count > 0) {
        sent += static_cast<std::size_t>(count);
      } else if (count < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR) {
        broken_ = true;
      } else {
        broken_ = !wait_for(socket_, POLLOUT, until_);
      }
    }
    return broken_ ? -1 : static_cast<ssize_t>(size);
  }
  // The client's address is of no use here.
  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return socket_; }

 private:
  bool fill() {
    if (left_ == 0 || !wait_for(socket_, POLLIN, until_)) return false;
    const ssize_t count = recv(socket_, buffer_, std::min(left_, sizeof buffer_), MSG_DONTWAIT);
    if (count <= 0) return false;
    left_ -= static_cast<std::size_t>(count);
    at_ = 0;
    end_ = static_cast<std::size_t>(count);
    return true;
  }

  int socket_;
  std::size_t left_;
  std::chrono::milliseconds send_time_;
  Clock::time_point until_;
  bool sending_ = false, broken_ = false;
  char buffer_[2048];
  std::size_t at_ = 0, end_ = 0;
};

/// The open connections. Strangers, which have not been admitted, make room for each other; guests stay.
class Connections {
 public:
  struct Entry {
    int socket;
    bool guest = false;
  };
  using Place = std::list<Entry>::iterator;

  explicit Connections(const ServerLimits& limits) : limits_(limits) {}

  /// Drops the oldest stranger if there are too many.
  Place enter(int socket) {
    const std::lock_guard lock(mutex_);
    if (entries_.size() - guests_ >= limits_.strangers) {
      const auto oldest =
          std::find_if(entries_.begin(), entries_.end(), [](const Entry& entry) { return !entry.guest; });
      if (oldest != entries_.end()) shutdown(oldest->socket, SHUT_RDWR);
    }
    entries_.push_back({socket});
    return std::prev(entries_.end());
  }
  /// False if there are too many guests.
  bool welcome(Place place) {
    const std::lock_guard lock(mutex_);
    if (guests_ >= limits_.guests) return false;
    place->guest = true;
    ++guests_;
    return true;
  }
  void leave(Place place) {
    const std::lock_guard lock(mutex_);
    if (place->guest) --guests_;
    entries_.erase(place);
  }
  void send_all_away() {
    const std::lock_guard lock(mutex_);
    for (const Entry& entry : entries_) shutdown(entry.socket, SHUT_RDWR);
  }

 private:
  const ServerLimits limits_;
  std::mutex mutex_;
  std::list<Entry> entries_;
  std::size_t guests_ = 0;
};

/// Runs each task in a thread of its own, with at most as many threads as there may be connections, plus a few that are
/// just ending.
class TaskThreads final : public httplib::TaskQueue {
 public:
  explicit TaskThreads(std::size_t most) : most_(most) {}

  /// Later versions of the library ask whether the task was accepted.
  using Enqueued = decltype(std::declval<httplib::TaskQueue&>().enqueue({}));
  Enqueued enqueue(std::function<void()> task) override { return static_cast<Enqueued>(start(std::move(task))); }
  void shutdown() override {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return running_ == 0; });
  }

 private:
  bool start(std::function<void()> task) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return running_ < most_; });
    ++running_;
    try {
      std::thread([this, task = std::move(task)] {
        task();
        const std::lock_guard inner(mutex_);
        --running_;
        changed_.notify_all();
      }).detach();
    } catch (const std::system_error&) {
      --running_;  // no thread available: the connection is dropped
      return false;
    }
    return true;
  }

  const std::size_t most_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t running_ = 0;
};

Request request_of(const httplib::Request& asked) {
  Request request{.method = asked.method,
                  .path = asked.path,
                  .parameters = {asked.params.begin(), asked.params.end()},
                  .host = asked.get_header_value("Host"),
                  .origin = asked.get_header_value("Origin"),
                  .site = asked.get_header_value("Sec-Fetch-Site")};
  // With two Host or Origin headers, neither can be trusted.
  if (asked.get_header_value_count("Host") > 1) request.host = "several";
  if (asked.get_header_value_count("Origin") > 1) request.origin = "several";
  return request;
}

bool has_body(const httplib::Request& asked) {
  const std::string length = asked.get_header_value("Content-Length");
  return asked.has_header("Transfer-Encoding") || (!length.empty() && length != "0") ||
         asked.get_header_value_count("Content-Length") > 1;
}

void fill(httplib::Response& out, Response answer) {
  out.status = answer.status;
  for (const auto& [name, value] : answer.headers) out.set_header(name, value);
  std::size_t size = 0;
  for (const Bytes& part : answer.parts) size += part->size();
  if (size == 0) return out.set_content("", answer.type);
  out.set_content_provider(size, answer.type,
                           [parts = std::move(answer.parts)](std::size_t offset, std::size_t, httplib::DataSink& sink) {
                             for (const Bytes& part : parts) {
                               if (offset < part->size())
                                 return sink.write(part->data() + offset, part->size() - offset);
                               offset -= part->size();
                             }
                             return false;
                           });
}

}  // namespace

const std::string* Request::find(std::string_view name) const {
  for (const auto& [key, value] : parameters) {
    if (key == name) return &value;
  }
  return nullptr;
}

Response text_response(int status, std::string text) {
  return {.status = status, .parts = {std::make_shared<const std::string>(std::move(text))}};
}

class HttpServer::Listener final : public httplib::Server {
 public:
  Listener(const std::string& address, int port, Admit admit, Serve serve, const ServerLimits& limits)
      : admit_(std::move(admit)), serve_(std::move(serve)), limits_(limits), connections_(limits) {
    new_task_queue = [this] { return new TaskThreads(limits_.strangers + limits_.guests + 16); };
    // The library's default would let two servers share a port.
    set_socket_options([](socket_t socket) {
      const int yes = 1;
      setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
    set_tcp_nodelay(true);
    port_ = port == 0 ? bind_to_any_port(address) : bind_to_port(address, port) ? port : -1;
    if (port_ < 0) {
      throw Error(ErrorKind::usage,
                  fmt::format("Cannot listen on {}, {}: the address is not one of this machine, or the port is taken; "
                              "choose others with --listen and --port.",
                              address, port == 0 ? "any port" : fmt::format("port {}", port)));
    }
    // The library's default of five would make newcomers wait behind half-open connections.
    ::listen(svr_sock_, SOMAXCONN);
    route();
    thread_ = std::thread([this] {
      listen_after_bind();
      ended_ = true;
    });
  }
  ~Listener() override {
    // stop() has no effect before the loop runs.
    while (!is_running() && !ended_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    stopping_ = true;
    connections_.send_all_away();
    stop();
    connections_.send_all_away();
    thread_.join();
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  int port() const { return port_; }

 private:
  bool process_and_close_socket(socket_t socket) override {
    const Connections::Place place = connections_.enter(socket);
    if (stopping_) shutdown(socket, SHUT_RDWR);
    BoundedStream stream(socket, limits_);
    bool closed = false;
    const bool answered = process(stream, closed, [&](httplib::Request& asked) {
      asked.ranges.clear();  // a short request could ask for the same bytes many times
      here().place = &place;
    });
    here().place = nullptr;
    if (answered) linger(socket);
    connections_.leave(place);
    shutdown(socket, SHUT_RDWR);
    close(socket);
    return answered;
  }

  /// Serves one request. Later versions of the library also take the addresses.
  template <class Stream>
  bool process(Stream& stream, bool& closed, const std::function<void(httplib::Request&)>& prepare) {
    if constexpr (requires { this->process_request(stream, true, closed, prepare); }) {
      return this->process_request(stream, true, closed, prepare);
    } else {
      return this->process_request(stream, "", 0, "", 0, true, closed, prepare);
    }
  }

  /// Reads for a moment what the client still sends, so that a reset does not overtake the response.
  static void linger(int socket) {
    shutdown(socket, SHUT_WR);
    const auto until = Clock::now() + std::chrono::milliseconds(200);
    char unread[4096];
    for (std::size_t total = 0; total < 1u << 20 && wait_for(socket, POLLIN, until);) {
      const ssize_t count = recv(socket, unread, sizeof unread, MSG_DONTWAIT);
      if (count <= 0) return;
      total += static_cast<std::size_t>(count);
    }
  }

  /// The connection that the calling thread serves: the library does not pass it on to handlers.
  struct Here {
    const Connections::Place* place = nullptr;
  };
  static Here& here() {
    thread_local Here instance;
    return instance;
  }

  Response answer(const httplib::Request& asked) {
    const Request request = request_of(asked);
    Response refusal = admit_(request);
    if (refusal.status >= 400) return refusal;
    if (has_body(asked))
      return text_response(413, "Requests with a body are refused; put the parameters into the address.\n");
    if (here().place == nullptr || !connections_.welcome(*here().place))
      return text_response(503, "Too many pages are open; close one.\n");
    try {
      return serve_(request);
    } catch (const std::exception& error) {
      return text_response(500, fmt::format("{}\n", error.what()));
    }
  }

  // Handles every request before the library looks for a file or a body.
  void route() {
    set_pre_routing_handler([this](const httplib::Request& asked, httplib::Response& out) {
      fill(out, answer(asked));
      return HandlerResponse::Handled;
    });
  }

  friend class HttpServer;
  Admit admit_;
  Serve serve_;
  ServerLimits limits_;
  Connections connections_;
  int port_ = -1;
  std::atomic<bool> stopping_{false}, ended_{false};
  std::thread thread_;
};

HttpServer::HttpServer(const std::string& address, int port, Admit admit, Serve serve, const ServerLimits& limits)
    : listener_(std::make_unique<Listener>(address, port, std::move(admit), std::move(serve), limits)) {}

HttpServer::~HttpServer() = default;

int HttpServer::port() const {
  return listener_->port();
}

}  // namespace etendue::view
