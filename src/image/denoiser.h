#pragma once
/// Open Image Denoise, where the machine has it: docs/denoising.md. The library is opened at run time, so nothing needs
/// it that does not denoise.

#include <memory>
#include <string>
#include <vector>

#include "image/image.h"

namespace etendue {

class Denoiser {
 public:
  /// Opens the library at `path`; if that is empty, the one that the environment variable ETENDUE_OIDN names, or the
  /// system's. Throws Error(file) that says how to get it where it is missing, older than 2.0, or has no CPU device.
  explicit Denoiser(const std::string& path = "");
  ~Denoiser();
  Denoiser(Denoiser&&) noexcept;
  Denoiser& operator=(Denoiser&&) noexcept;

  /// "Open Image Denoise 2.3.3".
  const std::string& name() const { return name_; }

  /// The picture without its noise, and without what no longer holds: standard error, number of samples. Of the other
  /// channels it has A. Guides are the channels albedo.R … and normal.X … where it has all three; the metadata tell.
  /// Throws Error(file) where `picture` is denoised already or holds values that are no finite numbers, with the
  /// `name` of the picture and the place; Error(lost) for what the library complains of.
  Image denoise(const Image& picture, const std::string& name) const;

 private:
  struct Library;
  std::unique_ptr<Library> library_;
  std::string name_;
};

/// A picture's EXR or film file with the channels that denoisers want beside its colour. Throws Error(file), also for a
/// file that is no EXR.
Image read_noisy_picture(const std::string& path);

/// "NAME: is a denoised picture (by …), which …", where the metadata say so; "" else.
std::string denoised_complaint(const std::string& name, const Metadata& metadata, const char* reason);

}  // namespace etendue
