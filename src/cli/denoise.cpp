#include "image/denoiser.h"

#include <chrono>
#include <memory>

#include <fmt/core.h>
#include <fmt/ranges.h>

#include "cli/command.h"
#include "cli/outputs.h"
#include "cli/overwrite.h"
#include "cli/result_files.h"
#include "core/json.h"
#include "core/log.h"
#include "image/picture_header.h"

namespace etendue::cli {
namespace {

struct DenoiseArguments {
  std::string picture;
  std::vector<std::string> outputs;
  DenoiseOptions denoise;
  DisplayOptions display;
  OverwriteOptions overwrite;
  ResultOptions results;
};

void check_denoise_files(const DenoiseArguments& options) {
  std::vector<NamedFile> files = {{"IN", options.picture}};
  for (const std::string& path : options.outputs) files.emplace_back("-o", path);
  for (const NamedFile& report : options.results.named_files()) files.push_back(report);
  check_distinct(files);
  for (const std::string& path : options.outputs) check_writable(path);
}

Ending run_denoise(const DenoiseArguments& options) {
  using Clock = std::chrono::steady_clock;
  options.results.begin();
  for (const std::string& path : options.outputs) check_output_name(path);
  options.display.check(options.outputs);
  check_denoise_files(options);
  const PictureHeader header = read_picture_header(options.picture);
  if (const std::string why = denoised_complaint(options.picture, header.metadata, "is not denoised again");
      !why.empty())
    throw Error(ErrorKind::file, why + ".");
  NewPicture wanted{
      {.width = header.width, .height = header.height, .samples = header.samples, .metadata = header.metadata}, false};
  wanted.header.metadata[kDenoisedKey] = "";
  for (const std::string& path : options.outputs) {
    const std::string note = check_replaceable(path, wanted, options.overwrite);
    if (!note.empty()) log::info(note);
  }
  const Denoiser denoiser(options.denoise.library);
  const Image noisy = read_noisy_picture(options.picture);
  const auto start = Clock::now();
  const Image image = denoiser.denoise(noisy, options.picture);
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();

  OutputWriter writer;
  for (const std::string& path : options.outputs)
    writer.write(path, [&] { write_picture(path, image, options.display.display()); });
  OutputWriter json_file;
  options.results.write_json(json_file, [&] {
    return Json({{"outputs", writer.written()},
                 {"denoised", image.metadata.at(kDenoisedKey)},
                 {"seconds", seconds},
                 {"metadata", image.metadata}});
  });
  writer.add_failures(json_file);
  if (options.results.wants_text() && !writer.written().empty())
    log::info(fmt::format("Denoised {}x{} in {:.2f} s by {}; wrote {}.", image.width, image.height, seconds,
                          image.metadata.at(kDenoisedKey), fmt::join(writer.written(), " and ")));
  writer.finish();
  return Ending::ok;
}

}  // namespace

void add_denoise_command(Command& app, Action& action) {
  auto* command = app.add_subcommand("denoise", "denoise a picture with Open Image Denoise");
  const auto options = std::make_shared<DenoiseArguments>();
  command
      ->add_option("IN", options->picture,
                   "picture or film (EXR); its channels albedo and normal guide the denoiser, if present")
      ->required()
      ->file({".exr"});
  command->add_option("-o,--output,--out", options->outputs, "picture to write, .exr or .png; may be repeated")
      ->required()
      ->allow_extra_args(false)
      ->file({".exr", ".png"});
  options->denoise.add_to(*command);
  options->display.add_to(*command);
  options->overwrite.add_to(*command);
  options->results.add_to(*command);
  command->callback([&action, options] { action = [options] { return run_denoise(*options); }; });
}

}  // namespace etendue::cli
