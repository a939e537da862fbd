#pragma once
/// A TCP connection to a viewer that may be slow, unresponsive or gone.

#include <chrono>
#include <cstddef>
#include <functional>
#include <span>
#include <string>

namespace etendue::cli {

/// The address of a viewer.
struct ViewerAddress {
  std::string host = "127.0.0.1";  ///< a name, an IPv4 or an IPv6 address
  std::string port = "14158";      ///< 1 to 65535
};

/// "host:port", "host", ":port", "[::1]:port", "::1"; missing parts have the defaults above. Throws Error(usage).
ViewerAddress parse_viewer_address(const std::string& text);
/// "127.0.0.1:14158", "[::1]:14158".
std::string to_text(const ViewerAddress& address);

/// Nothing here raises SIGPIPE or throws, except if memory runs out. Functions that may take long call `go_on` several
/// times per second and end with "stopped" if it returns false.
class ViewerConnection {
 public:
  using GoOn = std::function<bool()>;

  ViewerConnection() = default;
  ~ViewerConnection() { close(); }
  ViewerConnection(const ViewerConnection&) = delete;
  ViewerConnection& operator=(const ViewerConnection&) = delete;

  bool is_open() const { return socket_ >= 0; }
  void close();
  /// Tries all addresses of the host, some seconds each. Returns what went wrong, "" if nothing did.
  std::string open(const ViewerAddress& address, const GoOn& go_on);
  /// Sends all bytes, or returns what went wrong and closes the connection. `taken` is called for every piece.
  std::string send(std::span<const std::byte> bytes, const GoOn& go_on, const std::function<void(std::size_t)>& taken);
  /// Shuts down sending and waits, at most so long, until the other side has closed as well. False if it has discarded
  /// data.
  bool finish(std::chrono::milliseconds patience, const GoOn& go_on);
  /// Whether the other side has closed the connection.
  bool was_closed() const;

 private:
  bool wait(short events, const GoOn& go_on) const;

  int socket_ = -1;
};

}  // namespace etendue::cli
