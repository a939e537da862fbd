#pragma once
/// Open Image Denoise, if it is installed: docs/denoising.md. The library is opened at run time, so only denoising
/// needs it.

#include <memory>
#include <string>
#include <vector>

#include "image/image.h"

namespace etendue {

class Denoiser {
 public:
  /// Opens the library at `path`; if that is empty, the one that the environment variable ETENDUE_OIDN names, or the
  /// system's. Throws Error(file) saying how to get it if it is missing, older than 2.0, or without a CPU device.
  explicit Denoiser(const std::string& path = "");
  ~Denoiser();
  Denoiser(Denoiser&&) noexcept;
  Denoiser& operator=(Denoiser&&) noexcept;

  /// "Open Image Denoise 2.3.3".
  const std::string& name() const { return name_; }

  /// The denoised picture, without standard error and sample count, which no longer apply; of the other channels only A
  /// is kept. The channels albedo.R … and normal.X … are guides if all three exist; the metadata say which were used.
  /// Throws Error(file) if `picture` is denoised already or contains values that are not finite, with the `name` of the
  /// picture and the position; Error(lost) for errors of the library.
  Image denoise(const Image& picture, const std::string& name) const;

 private:
  struct Library;
  std::unique_ptr<Library> library_;
  std::string name_;
};

/// Reads an EXR or film file with the channels that denoisers need in addition to colour. Throws Error(file), also for
/// files that are not EXR.
Image read_noisy_picture(const std::string& path);

/// "NAME: is a denoised picture (by …), which …", if the metadata say so; otherwise "".
std::string denoised_complaint(const std::string& name, const Metadata& metadata, const char* reason);

}  // namespace etendue
