#include "cli/overwrite.h"

#include <charconv>
#include <filesystem>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "core/errors.h"
#include "image/files.h"
#include "image/merge.h"
#include "image/picture_header.h"
#include "render/sample_queue.h"

namespace etendue::cli {
namespace {

[[noreturn]] void refuse(const std::string& path, const std::string& reason) {
  throw Error(ErrorKind::file, fmt::format("{}: {}; give another name, or --force.", path, reason));
}

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

PictureHeader header_of_existing(const std::string& path) {
  try {
    PictureHeader header = read_picture_header(path);
    if (value_of(header.metadata, "software") == "Etendue") return header;
  } catch (const Error&) {
    refuse(path, "exists and is no picture that can be read");
  }
  refuse(path, "exists and is a picture that Etendue did not make");
}

/// "a picture of 40x30 pixels and 64 samples each".
std::string describe(const PictureHeader& old) {
  const std::uint64_t spp = samples_per_pixel(old.samples, old.metadata);
  return fmt::format("a {} of {}x{} pixels{}", old.film ? "film" : "picture", old.width, old.height,
                     spp > 0 ? fmt::format(" and {} samples each", spp) : "");
}

/// Whether a file begins like what the option writes.
bool begins_like_report(const std::string& option, std::string_view beginning) {
  if (option == "--json") return beginning.starts_with("{") || beginning.starts_with("[");
  if (option == "--html") return beginning.starts_with("<!DOCTYPE html>");
  return beginning.starts_with("<?xml") && beginning.find("<testsuites>") != std::string_view::npos;
}

}  // namespace

void OverwriteOptions::add_to(Command& command) {
  command.add_flag("--force", force, "replace existing outputs, whatever they are");
  command.add_flag("--no-clobber", no_clobber,
                   "replace no existing output; without either, only pictures with no more samples are replaced");
}

std::string check_replaceable(const std::string& path, const NewPicture& picture, const OverwriteOptions& options) {
  if (options.force && options.no_clobber)
    throw Error(ErrorKind::usage, "--force and --no-clobber exclude each other; give one of them.");
  std::error_code error;
  // What is no regular file is the business of those who write.
  if (!std::filesystem::is_regular_file(path, error) || options.force) return "";
  if (options.no_clobber) throw Error(ErrorKind::file, fmt::format("{}: exists, and --no-clobber keeps it.", path));
  if (std::filesystem::file_size(path, error) == 0 && !error) return "";

  const PictureHeader old = header_of_existing(path);
  const FilmHeader& wanted = picture.header;
  const bool same = same_samples(old.metadata, wanted.metadata) && old.width == wanted.width &&
                    old.height == wanted.height && set_size(old.metadata) == set_size(wanted.metadata);
  if (const SampleRanges lost = difference(old.samples, wanted.samples); same && !lost.empty())
    refuse(path, fmt::format("exists and holds the samples {} of this render, which would be lost", to_text(lost)));
  if (old.film && !(picture.as_film && path.ends_with(".exr")))
    refuse(path, "exists and is a film, which a picture would replace; --film writes a film");
  const std::uint64_t here = samples_per_pixel(old.samples, old.metadata);
  const std::uint64_t then = samples_per_pixel(wanted.samples, wanted.metadata);
  const std::uint64_t old_pixels = std::uint64_t{old.width} * old.height;
  const std::uint64_t new_pixels = std::uint64_t{wanted.width} * wanted.height;
  if (here * old_pixels > then * new_pixels) {
    refuse(path, fmt::format("exists and is {}, more than the {} of {}x{} that would replace it", describe(old), then,
                             wanted.width, wanted.height));
  }
  return fmt::format("{} exists, {}, and will be replaced.", path, describe(old));
}

void check_report_replaceable(const std::string& option, const std::string& path) {
  std::error_code error;
  if (path.empty() || !std::filesystem::is_regular_file(path, error)) return;
  constexpr std::uint64_t kBeginning = 256;
  const std::vector<std::byte> bytes = read_file(path, kBeginning);
  const std::string_view beginning(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (bytes.empty() || begins_like_report(option, beginning)) return;
  throw Error(ErrorKind::file,
              fmt::format("{}: exists and is no report, which '{}' would replace; give another name.", path, option));
}

}  // namespace etendue::cli
