#version 460
#extension GL_GOOGLE_include_directive : require
#include "sampler.glsl"
#include "test_io.glsl"

TEST_BUFFERS(WordsCase, WordsAnswer)

void main() {
  if (!lane_has_work()) return;
  const WordsCase c = inputs[lane()];
  const uvec4 words = random_words(c.seed, c.pixel, c.sample_index, c.block);
  outputs[lane()] = WordsAnswer(words, vec4(to_unit(words.x), to_unit(words.yz), to_unit(words.w)));
}
