#pragma once
/// Running the etendue binary as a user does.

#include <sys/types.h>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace etendue::faults {

struct ProcessResult {
  int code = -1;         ///< exit code, or -signal
  std::string out, err;  ///< what it wrote
  /// Lines of stderr that begin with "error: ".
  std::vector<std::string> errors() const;
};

struct ProcessOptions {
  std::map<std::string, std::string> environment;  ///< added to our own, or in its place
  std::uint64_t file_size_limit = 0;               ///< RLIMIT_FSIZE in bytes; 0: none
  std::uint64_t memory_limit = 0;                  ///< RLIMIT_AS in bytes; 0: none
  std::uint64_t cpu_seconds_limit = 0;             ///< RLIMIT_CPU; 0: none
  std::optional<int> out, err;                     ///< descriptors for stdout and stderr instead of files
  bool close_out = false, close_err = false;       ///< started without the stream
  bool owns_terminal = false;                      ///< stderr is a terminal, and the controlling one of the process
  bool ignores_hangup = false;                     ///< as under nohup
  bool bound_by_permissions = false;               ///< even root may only do what the permissions of files allow
};

class Process {
 public:
  Process(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
          const ProcessOptions& options = {});
  ~Process();  ///< kills what still runs
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void signal(int number) const;
  bool is_running();
  /// Resident memory in bytes.
  std::uint64_t resident() const;
  /// Waits for the end; a process that takes longer than `seconds` is killed (code -9).
  ProcessResult wait(double seconds = 120.0);

 private:
  pid_t pid_ = -1;
  int status_ = 0;
  bool ended_ = false;
  std::string out_file_, err_file_;
};

/// Runs etendue to its end.
ProcessResult etendue(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                      const ProcessOptions& options = {});

std::string read_text(const std::filesystem::path& path);
void write_text(const std::filesystem::path& path, const std::string& text);

/// Where every write fails with ENOSPC: /dev/full, or a device of the test's own where somebody put a file in its place
/// (root's programs can, and /dev is often shared with containers). Lives as long as the process.
const std::filesystem::path& full_device();

/// Waits until `condition()`; false after `seconds`.
template <typename Condition>
bool wait_until(Condition condition, double seconds = 60.0);

}  // namespace etendue::faults

#include <chrono>
#include <thread>

template <typename Condition>
bool etendue::faults::wait_until(Condition condition, double seconds) {
  const auto start = std::chrono::steady_clock::now();
  while (!condition()) {
    if (std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() > seconds) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}
