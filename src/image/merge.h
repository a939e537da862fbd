#pragma once
/// Merging the films of one render.

#include <span>
#include <string>
#include <vector>

#include "image/film_file.h"
#include "image/image.h"

namespace etendue {

/// Throws Error(file) unless both films belong to one render: same size, film exponent and metadata "version",
/// "sceneHash", "seed" and "integrator". The sentence names the difference and both values.
void check_same_render(const FilmHeader& a, const std::string& a_name, const FilmHeader& b, const std::string& b_name);

/// Whether both metadata name the same "version", "sceneHash", "seed" and "integrator": samples of the same indices are
/// then the same samples, if the sizes are equal too.
bool same_samples(const Metadata& a, const Metadata& b);

/// The header of two films of one render put together: samples and metadata as merge_films gives them, "samples" and
/// "rejected" as film_metadata will set them. Throws like merge_films.
FilmHeader merge_headers(const FilmHeader& a, const FilmHeader& b);

/// The film of all samples of the files, in whatever order they are given; equal to one render of these samples. Gaps
/// in the sample ranges are allowed and recorded. Holds one file at a time besides the result. Metadata:
/// - "samples" and "rejected" are those of the result; "scene" is that of the file with the lowest sample index;
/// - "device" and "driver" become a list with sample ranges if files differ: "A [0:64]; B [64:128,192:256]";
/// - anything else is kept if all files agree, and left out otherwise.
/// Throws Error(file) if a file is not a film, belongs to another render or shares samples with another file;
/// Error(usage) if there are no paths.
FilmFile merge_films(const std::vector<std::string>& paths);
/// The same for films in memory, none of them null. Messages call them "film 1", "film 2", … in the given order.
FilmFile merge_loaded_films(std::span<const FilmFile* const> films);

}  // namespace etendue
