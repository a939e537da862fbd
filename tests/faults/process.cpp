#include "process.h"

#include <fcntl.h>
#include <linux/capability.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include <fmt/core.h>

namespace etendue::faults {
namespace {

template <typename Resource>
void limit_resource(Resource resource, std::uint64_t value) {
  const rlimit limit{value, value};
  if (value > 0 && setrlimit(resource, &limit) != 0) _exit(126);
}

// Between fork and exec: system calls only.
[[noreturn]] void become(char* const argv[], char* const envp[], const char* folder, int out, int err,
                         const ProcessOptions& options) {
  if (chdir(folder) != 0) _exit(126);
  dup2(options.out.value_or(out), STDOUT_FILENO);
  dup2(options.err.value_or(err), STDERR_FILENO);
  if (options.owns_terminal && (setsid() < 0 || ioctl(STDERR_FILENO, TIOCSCTTY, 0) != 0)) _exit(126);
  if (options.ignores_hangup) ::signal(SIGHUP, SIG_IGN);
  if (options.close_out) close(STDOUT_FILENO);
  if (options.close_err) close(STDERR_FILENO);
  limit_resource(RLIMIT_FSIZE, options.file_size_limit);
  limit_resource(RLIMIT_AS, options.memory_limit);
  limit_resource(RLIMIT_CPU, options.cpu_seconds_limit);
  if (options.bound_by_permissions && geteuid() == 0 &&
      (prctl(PR_CAPBSET_DROP, CAP_DAC_OVERRIDE) != 0 || prctl(PR_CAPBSET_DROP, CAP_DAC_READ_SEARCH) != 0))
    _exit(126);
  execve(argv[0], argv, envp);
  _exit(127);
}

std::vector<char*> pointers(std::vector<std::string>& strings) {
  std::vector<char*> result;
  result.reserve(strings.size() + 1);
  for (std::string& text : strings) result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

}  // namespace

std::vector<std::string> ProcessResult::errors() const {
  std::vector<std::string> lines;
  std::istringstream stream(err);
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with("error: ")) lines.push_back(line);
  }
  return lines;
}

Process::Process(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                 const ProcessOptions& options) {
  static std::atomic<int> serial{0};
  const std::string stem = (std::filesystem::temp_directory_path() /
                            ("etendue-faults-" + std::to_string(getpid()) + "-" + std::to_string(serial++)))
                               .string();
  out_file_ = stem + ".out";
  err_file_ = stem + ".err";
  // Another binary may be tried, above all one built with sanitizers: building only that takes minutes less.
  const char* const other = std::getenv("ETENDUE_TEST_BINARY");
  std::vector<std::string> argument_strings = {other != nullptr ? other : ETENDUE_BINARY};
  argument_strings.insert(argument_strings.end(), arguments.begin(), arguments.end());
  std::vector<std::string> environment;
  for (const auto& [name, value] : options.environment) environment.push_back(fmt::format("{}={}", name, value));
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view variable(*entry);
    if (!options.environment.contains(std::string(variable.substr(0, variable.find('=')))))
      environment.emplace_back(variable);
  }
  std::vector<char*> argv = pointers(argument_strings), envp = pointers(environment);
  const int out = open(out_file_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  const int err = open(err_file_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  pid_ = fork();
  if (pid_ == 0) become(argv.data(), envp.data(), folder.c_str(), out, err, options);
  close(out);
  close(err);
  if (pid_ < 0) throw std::runtime_error("fork failed");
}

Process::~Process() {
  if (!ended_) {
    kill(pid_, SIGKILL);
    waitpid(pid_, &status_, 0);
  }
  std::filesystem::remove(out_file_);
  std::filesystem::remove(err_file_);
}

void Process::signal(int number) const {
  if (!ended_) kill(pid_, number);
}

bool Process::is_running() {
  if (!ended_) ended_ = waitpid(pid_, &status_, WNOHANG) == pid_;
  return !ended_;
}

std::uint64_t Process::resident() const {
  std::ifstream file("/proc/" + std::to_string(pid_) + "/statm");
  std::uint64_t total = 0, pages = 0;
  file >> total >> pages;
  return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

ProcessResult Process::wait(double seconds) {
  if (!wait_until([&] { return !is_running(); }, seconds)) {
    kill(pid_, SIGKILL);
    waitpid(pid_, &status_, 0);
    ended_ = true;
  }
  return {WIFEXITED(status_) ? WEXITSTATUS(status_) : -WTERMSIG(status_), read_text(out_file_), read_text(err_file_)};
}

ProcessResult etendue(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                      const ProcessOptions& options) {
  return Process(arguments, folder, options).wait();
}

std::string read_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

const std::filesystem::path& full_device() {
  static const struct Device {
    std::filesystem::path path = "/dev/full";
    bool own = false;
    Device() {
      const dev_t full = makedev(1, 7);
      struct stat status {};
      if (stat(path.c_str(), &status) == 0 && S_ISCHR(status.st_mode) && status.st_rdev == full) return;
      path = std::filesystem::temp_directory_path() / fmt::format("etendue-full-{}", getpid());
      if (mknod(path.c_str(), S_IFCHR | 0666, full) != 0)
        throw std::runtime_error("/dev/full is not the device that is always full, and none can be made here");
      own = true;
    }
    ~Device() {
      if (own) unlink(path.c_str());
    }
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;
  } device;
  return device.path;
}

}  // namespace etendue::faults
