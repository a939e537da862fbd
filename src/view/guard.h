#pragma once
/// Decides which requests are answered: those with the token, from a page of this server.

#include <string>

#include "view/http_server.h"

namespace etendue::view {

/// 128 random bits as hexadecimal digits. Throws Error(file) if the system provides none.
std::string random_token();

class Guard {
 public:
  /// `address` is the one that the server listens on.
  Guard(const std::string& token, std::string address);

  /// Status 200 if the request is admitted. Otherwise 421 for a Host that is not a name of this machine (a page
  /// elsewhere may make its own name resolve to this machine), 403 for a page of another origin, 404 for an address
  /// without the token, and 405 for methods other than GET, HEAD and POST. No answer reveals anything about the token.
  Response admit(const Request& request) const;

  /// The part of an admitted request's path after "/token", such as "/view.css".
  std::string place_of(const Request& request) const;

 private:
  bool is_own_host(const std::string& host) const;

  std::string prefix_;  ///< "/token"
  std::string address_;
};

}  // namespace etendue::view
