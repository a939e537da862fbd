#pragma once
/// A small web server for a few people who know a secret. Everything that a client can make it store is bounded, and no
/// client waits for another.

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace etendue::view {

struct Request {
  std::string method;
  std::string path;                                             ///< decoded, without the query
  std::vector<std::pair<std::string, std::string>> parameters;  ///< of the query, decoded
  std::string host, origin, site;  ///< the headers Host, Origin and Sec-Fetch-Site; empty if absent

  /// The first parameter of that name, or nullptr.
  const std::string* find(std::string_view name) const;
};

/// Bytes that several responses may share.
using Bytes = std::shared_ptr<const std::string>;

struct Response {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::vector<Bytes> parts;  ///< the body, in this order
  std::vector<std::pair<std::string, std::string>> headers{};
};
Response text_response(int status, std::string text);

/// The limits of a server. The defaults serve a dozen open pages.
struct ServerLimits {
  std::size_t head_bytes = 16 * 1024;          ///< request line and headers; bodies are refused
  std::chrono::milliseconds head_time{5000};   ///< from the connection to the end of the headers
  std::chrono::milliseconds send_time{30000};  ///< for one response
  std::size_t strangers = 32;                  ///< connections not yet admitted; the oldest makes room for the next
  std::size_t guests = 48;                     ///< admitted connections; further ones are answered with 503
};

/// Serves one request per connection, each connection in a thread of its own.
class HttpServer {
 public:
  /// Refuses a request by returning a response with status 400 or above; a lower status admits it.
  using Admit = std::function<Response(const Request&)>;
  /// Answers an admitted request. Called by many threads at once; what it throws becomes status 500.
  using Serve = std::function<Response(const Request&)>;

  /// Listens on that address (a number or a name) and port; port 0 chooses a free one. Throws Error(usage) if that is
  /// impossible.
  HttpServer(const std::string& address, int port, Admit admit, Serve serve, const ServerLimits& limits = {});
  /// Ends all connections. From then on `serve` must return quickly.
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  int port() const;

 private:
  class Listener;
  std::unique_ptr<Listener> listener_;
};

}  // namespace etendue::view
