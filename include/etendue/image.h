#pragma once
/// Results: `Film` (exact sums of samples), `FilmFile` (a film with its metadata), `Image` (a picture with its standard
/// error), their files, and denoised pictures.

#include "image/denoiser.h"
#include "image/film.h"
#include "image/film_file.h"
#include "image/image.h"
#include "image/merge.h"

namespace etendue {

/// The picture of a film, with the film's metadata.
inline Image picture_of(const FilmFile& film) {
  return image_from_film(film);
}

}  // namespace etendue
