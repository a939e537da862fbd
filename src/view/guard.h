#pragma once
/// Who may ask: those who know the token, from a page of this server.

#include <string>

#include "view/http_server.h"

namespace etendue::view {

/// 128 random bits in hexadecimal digits. Throws Error(file) when the system has none.
std::string random_token();

class Guard {
 public:
  /// `address`: what the server listens on.
  Guard(const std::string& token, std::string address);

  /// Status 200, or why not: 421 for a Host that is no name of this machine's (a page elsewhere may make its own name
  /// mean this machine), 403 for the page of another origin, 404 for an address without the token, 405 for methods
  /// other than GET, HEAD and POST. An answer says nothing about the token.
  Response admit(const Request& request) const;

  /// What follows "/token" in the path of a request that was admitted: "/view.css".
  std::string place_of(const Request& request) const;

 private:
  bool is_own_host(const std::string& host) const;

  std::string prefix_;  ///< "/token"
  std::string address_;
};

}  // namespace etendue::view
