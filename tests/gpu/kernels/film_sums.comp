#version 460
#extension GL_GOOGLE_include_directive : require
#include "film.glsl"
#include "test_io.glsl"

TEST_BUFFERS(FilmCase, FilmSlot)

void main() {
  if (!lane_has_work()) return;
  FilmSlot slot = FilmSlot(uvec4(0u), uvec4(0u), uvec4(0u), uvec4(0u), uvec4(0u), uvec4(0u), uvec4(0u), uvec4(0u));
  for (uint i = 0u; i < kFilmSequence; ++i) {
    const FilmCase c = inputs[lane() * kFilmSequence + i];
    film_add(slot, c.rgb, c.exponent);
  }
  outputs[lane()] = slot;
}
