#include "cli/results.h"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "core/errors.h"
#include "core/printable.h"

namespace etendue::cli {
namespace {

int g_error = 0;  // errno of the first write that failed

void write(std::string_view bytes) {
  errno = 0;
  if (std::fwrite(bytes.data(), 1, bytes.size(), stdout) != bytes.size() && g_error == 0) g_error = errno;
}

}  // namespace

void print_text(std::string_view text) {
  write(text::printable_lines(text));
}

void print_json(const Json& json) {
  write(json.dump(2) + "\n");
}

void finish_results() {
  errno = 0;
  if (std::fflush(stdout) != 0 && g_error == 0) g_error = errno;
  if (g_error == 0 && std::ferror(stdout) == 0) return;
  throw Error(ErrorKind::file,
              fmt::format("The results cannot be written to stdout: {}.", std::strerror(g_error != 0 ? g_error : EIO)));
}

}  // namespace etendue::cli
