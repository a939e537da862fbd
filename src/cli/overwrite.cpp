#include "cli/overwrite.h"

#include <charconv>
#include <filesystem>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/log.h"
#include "core/printable.h"
#include "image/files.h"
#include "image/merge.h"
#include "image/picture_header.h"
#include "render/sample_queue.h"

namespace etendue::cli {
namespace {

std::string value_of(const Metadata& metadata, const char* key) {
  const auto found = metadata.find(key);
  return found == metadata.end() ? "" : found->second;
}

/// Paths of a film sample: films of the sobol sampler count sets.
std::uint64_t set_size(const Metadata& metadata) {
  const std::string sampler = value_of(metadata, "sampler");
  constexpr std::string_view kKey = "setSize=";
  const std::size_t at = sampler.find(kKey);
  std::uint64_t size = 1;
  if (at != std::string::npos)
    std::from_chars(sampler.data() + at + kKey.size(), sampler.data() + sampler.size(), size);
  return std::max<std::uint64_t>(size, 1);
}

std::uint64_t samples_per_pixel(const SampleRanges& samples, const Metadata& metadata) {
  return sample_count(samples) * set_size(metadata);
}

/// "a picture of 40x30 pixels and 64 samples each".
std::string describe(const PictureHeader& old) {
  const std::uint64_t spp = samples_per_pixel(old.samples, old.metadata);
  return fmt::format("a {} of {}x{} pixels{}", old.film ? "film" : "picture", old.width, old.height,
                     spp > 0 ? fmt::format(" and {} samples each", spp) : "");
}

/// Texts from files must be cleaned before they are printed.
std::string clean(const std::string& value) {
  constexpr std::size_t kLongest = 60;
  return text::printable(value, kLongest);
}

/// "of seed 3": the first difference between a picture and those of the new render; "" if there is none.
std::string difference_text(const PictureHeader& old, const FilmHeader& wanted) {
  const auto differs = [&](const char* key) { return value_of(old.metadata, key) != value_of(wanted.metadata, key); };
  if (differs("scene")) return fmt::format("of another scene ('{}')", clean(value_of(old.metadata, "scene")));
  if (differs("seed")) return fmt::format("of seed {}", clean(value_of(old.metadata, "seed")));
  if (differs("sceneHash")) return "of the scene before it was changed";
  if (differs("integrator")) return fmt::format("by '{}'", clean(value_of(old.metadata, "integrator")));
  return "";
}

/// Whether this is a regular, non-empty file. Everything else is left to the code that writes.
bool holds_something(const std::string& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error) && (std::filesystem::file_size(path, error) > 0 || error);
}

/// Why the file must not be replaced by the picture; "" if it may.
std::string reason_to_keep(const std::string& path, const NewPicture& picture) {
  PictureHeader old;
  try {
    old = read_picture_header(path);
  } catch (const Error&) {
    return "exists and is not a readable picture";
  }
  if (value_of(old.metadata, "software") != "Etendue") return "exists and is a picture that Etendue did not make";
  const FilmHeader& wanted = picture.header;
  if (wanted.metadata.contains(kDenoisedKey) && !old.metadata.contains(kDenoisedKey))
    return fmt::format("exists and is {} that is not denoised, which a denoised one would replace", describe(old));
  const bool same = same_samples(old.metadata, wanted.metadata) && old.width == wanted.width &&
                    old.height == wanted.height && set_size(old.metadata) == set_size(wanted.metadata);
  if (const SampleRanges lost = difference(old.samples, wanted.samples); same && !lost.empty())
    return fmt::format("exists and holds the samples {} of this render, which would be lost", to_text(lost));
  if (old.film && !(picture.as_film && path.ends_with(".exr")))
    return "exists and is a film, which a picture would replace; --film writes a film";
  const std::string other = difference_text(old, wanted);
  if (old.film && !same)
    return fmt::format("exists and is {}{}: a film of another render", describe(old),
                       other.empty() ? "" : ", " + other);
  if (value_of(old.metadata, "scene") != value_of(wanted.metadata, "scene"))
    return fmt::format("exists and is {}, {}", describe(old), other);
  const std::uint64_t here = samples_per_pixel(old.samples, old.metadata);
  const std::uint64_t then = samples_per_pixel(wanted.samples, wanted.metadata);
  const std::uint64_t old_pixels = std::uint64_t{old.width} * old.height;
  const std::uint64_t new_pixels = std::uint64_t{wanted.width} * wanted.height;
  if (here * old_pixels <= then * new_pixels) return "";
  return fmt::format("exists and is {}, more than the {} of {}x{} that would replace it", describe(old), then,
                     wanted.width, wanted.height);
}

/// Whether a file begins like those that the option writes.
bool begins_like_report(const std::string& option, std::string_view beginning) {
  if (option == "--json") return beginning.starts_with("{") || beginning.starts_with("[");
  if (option == "--html") return beginning.starts_with("<!DOCTYPE html>");
  return beginning.starts_with("<?xml") && beginning.find("<testsuites>") != std::string_view::npos;
}

}  // namespace

void OverwriteOptions::add_to(Command& command) {
  command.add_flag("--force", force, "replace existing outputs of any kind");
  command.add_flag("--no-clobber", no_clobber,
                   "replace no existing output; with neither option, only pictures with no more samples are replaced");
}

std::string check_replaceable(const std::string& path, const NewPicture& picture, const OverwriteOptions& options) {
  if (options.force && options.no_clobber)
    throw Error(ErrorKind::usage, "--force and --no-clobber exclude each other; give one of them.");
  std::error_code error;
  if (options.no_clobber && std::filesystem::is_regular_file(path, error))
    throw Error(ErrorKind::file, fmt::format("{}: exists, and --no-clobber keeps it.", path));
  if (options.force || !holds_something(path)) return "";
  if (const std::string reason = reason_to_keep(path, picture); !reason.empty())
    throw Error(ErrorKind::file, fmt::format("{}: {}; give another name, or --force.", path, reason));
  const PictureHeader old = read_picture_header(path);
  const std::string other = difference_text(old, picture.header);
  return fmt::format("{} exists, {}{}, and will be replaced.", path, describe(old),
                     other.empty() ? "" : fmt::format(", {}", other));
}

std::string place_of(const std::string& path, const NewPicture& picture, const OverwriteOptions& options) {
  if (options.force || !holds_something(path)) return path;
  const std::string reason = reason_to_keep(path, picture);
  if (reason.empty()) return path;
  const std::filesystem::path name(path);
  constexpr int kMostNames = 99;
  for (int i = 1; i <= kMostNames; ++i) {
    const std::string number = i == 1 ? "" : fmt::format("-{}", i);
    std::filesystem::path beside = name;
    beside.replace_filename(fmt::format("{}.partial{}{}", name.stem().string(), number, name.extension().string()));
    if (holds_something(beside) && !reason_to_keep(beside, picture).empty()) continue;
    log::warning(
        fmt::format("{}: {}; it is kept, and the result of this run goes to {}.", path, reason, beside.string()));
    return beside;
  }
  throw Error(ErrorKind::file, fmt::format("{}: {}, and so are {} files next to it; nothing was written there", path,
                                           reason, kMostNames));
}

void check_report_replaceable(const std::string& option, const std::string& path) {
  std::error_code error;
  if (path.empty() || !std::filesystem::is_regular_file(path, error)) return;
  constexpr std::uint64_t kBeginning = 256;
  const std::vector<std::byte> bytes = read_file(path, kBeginning);
  const std::string_view beginning(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (bytes.empty() || begins_like_report(option, beginning)) return;
  throw Error(ErrorKind::file,
              fmt::format("{}: exists and is not a report; '{}' would replace it: give another name.", path, option));
}

}  // namespace etendue::cli
