#include "image/denoiser.h"

#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/printable.h"
#include "image/decode.h"
#include "image/files.h"
#include "image/film_file.h"

namespace etendue {
namespace {

constexpr const char* kVariable = "ETENDUE_OIDN";
constexpr std::array kSystemNames = {"libOpenImageDenoise.so.2", "libOpenImageDenoise.so"};
constexpr int kLeastVersion = 20000;  // 2.0.0, in the library's encoding
constexpr const char* kHowToGet =
    "Debian 13 has it as the package libopenimagedenoise2; anywhere 'pip install pyoidn' brings it, and "
    "--oidn FILE or the environment variable ETENDUE_OIDN names its libOpenImageDenoise.so.2";

// The values of the library's enumerations that are used here, from its documentation.
constexpr int kDeviceTypeCpu = 1;
constexpr int kFormatFloat3 = 3;
constexpr int kErrorNone = 0;

std::array<std::string, 3> layer_channels(const char* layer, const char* letters) {
  std::array<std::string, 3> names;
  for (std::size_t i = 0; i < 3; ++i) names[i] = fmt::format("{}.{}", layer, letters[i]);
  return names;
}

const std::array<std::string, 3> kAlbedo = layer_channels("albedo", "RGB");
const std::array<std::string, 3> kNormal = layer_channels("normal", "XYZ");

/// The three channels together; nothing if one of them is missing.
std::optional<std::vector<glm::vec3>> guide(const Image& picture, const std::array<std::string, 3>& names) {
  std::vector<glm::vec3> values(picture.pixels.size());
  for (int i = 0; i < 3; ++i) {
    const auto channel = std::ranges::find(picture.channels, names[static_cast<std::size_t>(i)], &ImageChannel::name);
    if (channel == picture.channels.end() || channel->values.size() != values.size()) return std::nullopt;
    for (std::size_t k = 0; k < values.size(); ++k) values[k][i] = channel->values[k];
  }
  return values;
}

// A NaN would spread over the picture, or be replaced silently.
void check_finite(const std::vector<glm::vec3>& values, const char* what, std::uint32_t width,
                  const std::string& name) {
  std::uint64_t count = 0;
  std::size_t first = 0;
  for (std::size_t i = values.size(); i-- > 0;) {
    const glm::vec3& v = values[i];
    if (std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z)) continue;
    ++count;
    first = i;
  }
  if (count == 0) return;
  throw Error(ErrorKind::file, fmt::format("{}: {} pixels of its {} are not finite, the first at ({}, {}); such "
                                           "a picture is not denoised",
                                           name, count, what, first % width, first / width));
}

}  // namespace

/// The functions that are called, as the library's documentation declares them.
struct Denoiser::Library {
  using Device = struct OpaqueDevice*;
  using Filter = struct OpaqueFilter*;

  void* handle = nullptr;
  Device device = nullptr;

  Device (*new_device)(int type) = nullptr;
  void (*commit_device)(Device) = nullptr;
  int (*get_device_int)(Device, const char* name) = nullptr;
  int (*get_device_error)(Device, const char** message) = nullptr;
  void (*release_device)(Device) = nullptr;
  Filter (*new_filter)(Device, const char* type) = nullptr;
  void (*set_shared_filter_image)(Filter, const char* name, void* values, int format, std::size_t width,
                                  std::size_t height, std::size_t byte_offset, std::size_t pixel_byte_stride,
                                  std::size_t row_byte_stride) = nullptr;
  void (*set_filter_bool)(Filter, const char* name, bool value) = nullptr;
  void (*commit_filter)(Filter) = nullptr;
  void (*execute_filter)(Filter) = nullptr;
  void (*release_filter)(Filter) = nullptr;

  ~Library() {
    if (device != nullptr) release_device(device);
    // The library is never unloaded, because its threads may still run.
  }

  void open(const std::string& path);
  void find_functions(const std::string& path);
  void open_device();
  [[noreturn]] void fail(const std::string& what) const;
  void check(const char* what) const;

  /// Guides may be null.
  void run(std::vector<glm::vec3>& color, std::vector<glm::vec3>* albedo, std::vector<glm::vec3>* normal,
           Image& out) const;
};

void Denoiser::Library::open(const std::string& path) {
  if (!path.empty()) {
    handle = dlopen(path.find('/') == std::string::npos ? ("./" + path).c_str() : path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) {
      const char* reason = dlerror();
      throw Error(ErrorKind::file, fmt::format("{}: Open Image Denoise cannot be opened there ({}); {}.", path,
                                               text::printable(reason == nullptr ? "" : reason, 300), kHowToGet));
    }
    find_functions(path);
    return;
  }
  for (const char* name : kSystemNames) {
    handle = dlopen(name, RTLD_NOW | RTLD_LOCAL);
    if (handle != nullptr) return find_functions(name);
  }
  throw Error(ErrorKind::file,
              fmt::format("Denoising needs the library Open Image Denoise 2, which was not found; {}.", kHowToGet));
}

void Denoiser::Library::find_functions(const std::string& path) {
  const auto find = [&](auto& function, const char* name) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(handle, name));
    if (function == nullptr)
      throw Error(ErrorKind::file,
                  fmt::format("{}: has no function {}, so it is not Open Image Denoise 2; {}.", path, name, kHowToGet));
  };
  find(new_device, "oidnNewDevice");
  find(commit_device, "oidnCommitDevice");
  find(get_device_int, "oidnGetDeviceInt");
  find(get_device_error, "oidnGetDeviceError");
  find(release_device, "oidnReleaseDevice");
  find(new_filter, "oidnNewFilter");
  find(set_shared_filter_image, "oidnSetSharedFilterImage");
  find(set_filter_bool, "oidnSetFilterBool");
  find(commit_filter, "oidnCommitFilter");
  find(execute_filter, "oidnExecuteFilter");
  find(release_filter, "oidnReleaseFilter");
}

// The CPU device: it exists everywhere and works on ordinary memory.
void Denoiser::Library::open_device() {
  device = new_device(kDeviceTypeCpu);
  if (device == nullptr) fail("it has no device for the CPU");
  commit_device(device);
  check("opening its device for the CPU");
}

void Denoiser::Library::fail(const std::string& what) const {
  const char* message = nullptr;
  get_device_error(device, &message);
  throw Error(ErrorKind::file, fmt::format("Open Image Denoise cannot be used: {} ({}).", what,
                                           text::printable(message == nullptr ? "it does not say why" : message, 300)));
}

void Denoiser::Library::check(const char* what) const {
  const char* message = nullptr;
  const int code = get_device_error(device, &message);
  if (code == kErrorNone) return;
  throw Error(ErrorKind::lost,
              fmt::format("Open Image Denoise failed in {}: {} (error {}).", what,
                          text::printable(message == nullptr ? "it does not say why" : message, 300), code));
}

void Denoiser::Library::run(std::vector<glm::vec3>& color, std::vector<glm::vec3>* albedo,
                            std::vector<glm::vec3>* normal, Image& out) const {
  const Filter filter = new_filter(device, "RT");
  if (filter == nullptr) fail("it has no filter RT");
  const auto set = [&](const char* name, std::vector<glm::vec3>* values) {
    static_assert(sizeof(glm::vec3) == 3 * sizeof(float));
    if (values != nullptr)
      set_shared_filter_image(filter, name, values->data(), kFormatFloat3, out.width, out.height, 0, sizeof(glm::vec3),
                              sizeof(glm::vec3) * out.width);
  };
  set("color", &color);
  set("albedo", albedo);
  set("normal", normal);
  set("output", &out.pixels);
  set_filter_bool(filter, "hdr", true);
  commit_filter(filter);
  execute_filter(filter);
  release_filter(filter);
  check("its filter");
}

Denoiser::Denoiser(const std::string& path) : library_(std::make_unique<Library>()) {
  const char* variable = std::getenv(kVariable);
  library_->open(path.empty() && variable != nullptr ? variable : path);
  library_->open_device();
  const int version = library_->get_device_int(library_->device, "version");
  name_ = fmt::format("Open Image Denoise {}.{}.{}", version / 10000, version / 100 % 100, version % 100);
  if (version < kLeastVersion)
    throw Error(ErrorKind::file,
                fmt::format("{} is too old; version 2.0 or a later one is needed: {}.", name_, kHowToGet));
}

Denoiser::~Denoiser() = default;
Denoiser::Denoiser(Denoiser&&) noexcept = default;
Denoiser& Denoiser::operator=(Denoiser&&) noexcept = default;

Image Denoiser::denoise(const Image& picture, const std::string& name) const {
  if (const std::string why = denoised_complaint(name, picture.metadata, "is not denoised again"); !why.empty())
    throw Error(ErrorKind::file, why);
  std::vector<glm::vec3> color = picture.pixels;
  std::optional<std::vector<glm::vec3>> albedo = guide(picture, kAlbedo), normal = guide(picture, kNormal);
  if (!albedo) normal.reset();  // the library accepts normals only together with an albedo
  check_finite(color, "colour", picture.width, name);
  if (albedo) check_finite(*albedo, "albedo", picture.width, name);
  if (normal) check_finite(*normal, "normals", picture.width, name);

  Image out{.width = picture.width, .height = picture.height, .pixels = std::vector<glm::vec3>(color.size())};
  library_->run(color, albedo ? &*albedo : nullptr, normal ? &*normal : nullptr, out);
  for (const ImageChannel& channel : picture.channels) {
    if (channel.name == "A") out.channels.push_back(channel);
  }
  out.metadata = picture.metadata;
  out.metadata[kDenoisedKey] = fmt::format("{} guides={}", name_,
                                           normal   ? "albedo,normal"
                                           : albedo ? "albedo"
                                                    : "none");
  return out;
}

Image read_noisy_picture(const std::string& path) {
  if (!is_exr(read_file(path, 8)))
    throw Error(ErrorKind::file, fmt::format("{}: is not an EXR file; only EXR pictures and films are denoised", path));
  std::vector<std::string> beside = {"A"};
  beside.insert(beside.end(), kAlbedo.begin(), kAlbedo.end());
  beside.insert(beside.end(), kNormal.begin(), kNormal.end());
  return read_image(path, beside);
}

std::string denoised_complaint(const std::string& name, const Metadata& metadata, const char* reason) {
  const auto denoised = metadata.find(kDenoisedKey);
  if (denoised == metadata.end()) return "";
  return fmt::format("{}: is a denoised picture ({}), which {}", name, text::printable(denoised->second, 100), reason);
}

}  // namespace etendue
