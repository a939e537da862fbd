#include "view/guard.h"

#include <arpa/inet.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>

#include <fmt/format.h>

#include "core/errors.h"

namespace etendue::view {
namespace {

/// "localhost:80" without the port, "[::1]:80" without the brackets. The port must be a number, so that nothing else
/// can hide behind a colon.
std::string without_port(const std::string& host) {
  const bool brackets = host.starts_with('[');
  const std::size_t end = brackets ? host.find(']') : host.find(':');
  if (end == std::string::npos) return brackets ? "" : host;
  const std::string rest = host.substr(end + (brackets ? 1 : 0));
  const bool digits = std::all_of(rest.begin() + (rest.empty() ? 0 : 1), rest.end(),
                                  [](unsigned char c) { return std::isdigit(c) != 0; });
  if ((!rest.empty() && rest[0] != ':') || !digits) return "";
  return host.substr(brackets ? 1 : 0, end - (brackets ? 1 : 0));
}

bool is_number(const std::string& address) {
  std::array<unsigned char, 16> parsed{};
  return inet_pton(AF_INET, address.c_str(), parsed.data()) == 1 ||
         inet_pton(AF_INET6, address.c_str(), parsed.data()) == 1;
}

bool is_loopback(const std::string& address) {
  return address == "localhost" || address == "::1" || (address.starts_with("127.") && is_number(address));
}

/// The time taken depends only on the lengths of the texts, not on their contents.
bool same(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  return difference == 0;
}

}  // namespace

std::string random_token() {
  std::array<unsigned char, 16> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw Error(ErrorKind::file, fmt::format("The system provides no random numbers: {}.", std::strerror(errno)));
  std::string token;
  for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

Guard::Guard(const std::string& token, std::string address)
    : prefix_(fmt::format("/{}", token)), address_(std::move(address)) {}

// A tunnel may end at any port, so the port does not matter; what matters is that the Host is not a name that someone
// else controls. Numeric addresses cannot be made to resolve to another machine.
bool Guard::is_own_host(const std::string& host) const {
  const std::string name = without_port(host);
  if (name.empty()) return false;
  if (is_loopback(name)) return true;
  if (is_loopback(address_)) return false;
  std::array<char, 256> own{};
  if (gethostname(own.data(), own.size() - 1) != 0) own[0] = '\0';
  return is_number(name) || name == address_ || name == own.data();
}

Response Guard::admit(const Request& request) const {
  if (!is_own_host(request.host))
    return text_response(421,
                         "The Host of the request is not a name of this machine; use the address that was printed.\n");
  if ((!request.origin.empty() && request.origin != "http://" + request.host) || request.site == "cross-site" ||
      request.site == "same-site")
    return text_response(403, "Only the viewer's own page may send requests.\n");
  const std::string_view path = request.path;
  if (path.size() <= prefix_.size() || !same(path.substr(0, prefix_.size()), prefix_) || path[prefix_.size()] != '/')
    return text_response(404, "Nothing was found here; use the address that was printed, with its token.\n");
  if (request.method != "GET" && request.method != "HEAD" && request.method != "POST")
    return text_response(405, "Only GET, HEAD and POST are understood.\n");
  return {};
}

std::string Guard::place_of(const Request& request) const {
  return request.path.substr(prefix_.size());
}

}  // namespace etendue::view
