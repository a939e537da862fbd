#include "bench/start_up.h"

#include <cstdlib>
#include <fstream>
#include <string>

namespace etendue {
namespace {

// A variable of the environment for the life of this object.
class EnvironmentVariable {
 public:
  EnvironmentVariable(const char* name, const char* value) : name_(name) {
    if (const char* before = std::getenv(name); before != nullptr) before_ = before;
    ::setenv(name, value, 1);
  }
  ~EnvironmentVariable() {
    if (before_) {
      ::setenv(name_, before_->c_str(), 1);
    } else {
      ::unsetenv(name_);
    }
  }
  EnvironmentVariable(const EnvironmentVariable&) = delete;
  EnvironmentVariable& operator=(const EnvironmentVariable&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};

// Bytes that /proc/self/status gives in KiB under `key`.
std::optional<std::uint64_t> process_bytes(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    std::uint64_t kibibytes = 0;
    if (word == key && status >> kibibytes) return kibibytes * 1024;
  }
  return std::nullopt;
}

// Makes the peak of the resident memory the present value; false where the kernel does not offer it.
bool reset_process_peak() {
  std::ofstream file("/proc/self/clear_refs");
  return static_cast<bool>(file << "5" << std::flush);
}

}  // namespace

StartUp measure_start_up(Scene scene, GpuOptions options, bool cold) {
  std::optional<EnvironmentVariable> mesa, nvidia;
  if (cold) {
    options.context.pipeline_cache = false;
    mesa.emplace("MESA_SHADER_CACHE_DISABLE", "true");
    nvidia.emplace("__GL_SHADER_DISK_CACHE", "0");
  }
  scene.camera.width = scene.camera.height = kStartUpPixels;
  const bool peak_is_known = reset_process_peak();
  const auto before = process_bytes("VmRSS:");
  const std::unique_ptr<Renderer> renderer = make_gpu_renderer(scene, {}, options);
  Film film(kStartUpPixels, kStartUpPixels, film_exponent(scene));
  std::vector<RejectedSample> rejected;
  renderer->render({0, 1}, film, {}, rejected);
  const GpuTimings timings = gpu_timings(*renderer);
  StartUp out{.compile = timings.compile, .upload = timings.upload, .pipeline = timings.pipeline};
  if (const auto peak = process_bytes("VmHWM:"); peak_is_known && before && peak && *peak >= *before)
    out.host_peak = *peak - *before;
  return out;
}

}  // namespace etendue
