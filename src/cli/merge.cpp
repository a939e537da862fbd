#include "image/merge.h"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include "cli/command.h"
#include "cli/outputs.h"
#include "cli/overwrite.h"
#include "cli/result_files.h"
#include "core/json.h"
#include "core/log.h"
#include "core/printable.h"

namespace etendue::cli {
namespace {

struct MergeArguments {
  std::vector<std::string> films;
  std::vector<std::string> outputs;
  bool picture = false;
  DisplayOptions display;
  OverwriteOptions overwrite;
  ResultOptions results;
};

// Films count samples; with samplers of sets of paths, a sample is a set.
std::string samples_text(const FilmFile& film, std::uint64_t count) {
  const auto sampler = film.metadata.find("sampler");
  return sampler == film.metadata.end()
             ? fmt::format("{} spp", count)
             : fmt::format("{} sets of paths per pixel ({})", count, text::printable(sampler->second, 60));
}

// Outputs must be different files, and no picture may replace a film that is read, because its sums would be lost.
void check_inputs_stay(const MergeArguments& options) {
  std::vector<NamedFile> files;
  for (const std::string& path : options.outputs) files.emplace_back("-o", path);
  for (const NamedFile& report : options.results.named_files()) files.push_back(report);
  check_distinct(files);
  for (const std::string& path : options.outputs) {
    if (path.ends_with(".exr") && !options.picture) continue;
    for (const std::string& film : options.films) check_distinct({{"FILM", film}, {"-o", path}});
  }
}

Ending merge(const MergeArguments& options) {
  options.results.begin();
  for (const std::string& path : options.outputs) check_output_name(path);
  options.display.check(options.outputs);
  for (const std::string& path : options.outputs) check_writable(path);
  check_inputs_stay(options);
  const FilmFile film = merge_films(options.films);
  if (film.samples.empty())
    throw Error(ErrorKind::file, "None of the films holds a sample; there is nothing to write.");
  for (const std::string& path : options.outputs) {
    const std::string note = check_replaceable(path, {header_of(film), !options.picture}, options.overwrite);
    if (!note.empty()) log::info(note);
  }
  OutputWriter writer;
  for (const std::string& path : options.outputs)
    writer.write(path, [&] { write_output(path, film, !options.picture, options.display.display()); });

  const std::uint64_t count = sample_count(film.samples);
  const std::uint64_t gaps = film.samples.back().second - count;
  OutputWriter json_file;
  options.results.write_json(json_file, [&] {
    return Json({{"outputs", writer.written()},
                 {"films", options.films.size()},
                 {"samples", count},
                 {"missing", gaps},
                 {"metadata", film_metadata(film)}});
  });
  writer.add_failures(json_file);
  if (options.results.wants_text() && !writer.written().empty()) {
    log::info(fmt::format("Merged {} films: {}, samples {}{}; wrote {}.", options.films.size(),
                          samples_text(film, count), text::printable(etendue::to_text(film.samples), 200),
                          gaps > 0 ? fmt::format(" ({} of 0:{} are missing)", gaps, film.samples.back().second) : "",
                          fmt::join(writer.written(), " and ")));
  }
  writer.finish();
  return Ending::ok;
}

}  // namespace

void add_merge_command(Command& app, Action& action) {
  auto* command = app.add_subcommand(
      "merge", "merge films of one render: shards from 'render --samples', checkpoints, merged films");
  const auto options = std::make_shared<MergeArguments>();
  command->add_option("FILM", options->films, "films with different samples, in any order")->required()->file({".exr"});
  command->add_option("-o,--output,--out", options->outputs, "film (.exr) or picture (.png) to write; may be repeated")
      ->required()
      ->allow_extra_args(false)
      ->file({".exr", ".png"});
  command->add_flag("--picture", options->picture,
                    "write .exr files as plain pictures, which are smaller but cannot be merged or resumed");
  options->display.add_to(*command);
  options->overwrite.add_to(*command);
  options->results.add_to(*command);
  command->callback([&action, options] { action = [options] { return merge(*options); }; });
}

}  // namespace etendue::cli
