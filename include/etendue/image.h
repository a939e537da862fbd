#pragma once
/// What comes out: `Film` (exact sums of samples), `FilmFile` (a film with what it says about itself), `Image` (a
/// picture with its standard error), their files, and pictures without noise.

#include "image/denoiser.h"
#include "image/film.h"
#include "image/film_file.h"
#include "image/image.h"
#include "image/merge.h"

namespace etendue {

/// The picture that a film shows, with the film's metadata.
inline Image picture_of(const FilmFile& film) {
  return image_from_film(film);
}

}  // namespace etendue
