#pragma once
/// A small web server for a few people who know a secret: everything that a client can make it keep is bounded, and no
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
  std::string host, origin, site;  ///< the headers Host, Origin and Sec-Fetch-Site; empty: not given

  /// The first parameter of that name, or nothing.
  const std::string* find(std::string_view name) const;
};

/// Bytes that several answers may share.
using Bytes = std::shared_ptr<const std::string>;

struct Response {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::vector<Bytes> parts;  ///< the body, one after the other
  std::vector<std::pair<std::string, std::string>> headers{};
};
Response text_response(int status, std::string text);

/// What a server is bounded by. The defaults serve a dozen open pages.
struct ServerLimits {
  std::size_t head_bytes = 16 * 1024;          ///< request line and headers; bodies are not taken at all
  std::chrono::milliseconds head_time{5000};   ///< from the connection to the end of the headers
  std::chrono::milliseconds send_time{30000};  ///< for an answer
  std::size_t strangers = 32;  ///< connections that have not been admitted; the oldest makes room for the next
  std::size_t guests = 48;     ///< connections that have been admitted; more are answered 503
};

/// One request a connection, each connection in a thread of its own.
class HttpServer {
 public:
  /// Refuses a request by a response with status 400 or more; anything less admits it.
  using Admit = std::function<Response(const Request&)>;
  /// Answers an admitted request. Called by many threads at once; what it throws becomes status 500.
  using Serve = std::function<Response(const Request&)>;

  /// Listens on that address, which is a number or a name, and that port; 0: one that is free. Throws Error(usage) when
  /// it cannot.
  HttpServer(const std::string& address, int port, Admit admit, Serve serve, const ServerLimits& limits = {});
  /// Ends all connections. `serve` must not wait for long any more.
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  int port() const;

 private:
  class Listener;
  std::unique_ptr<Listener> listener_;
};

}  // namespace etendue::view
