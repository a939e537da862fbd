#version 460
#extension GL_GOOGLE_include_directive : require
// Lanes that leave a loop early must keep what they counted. Mesa's lavapipe 22.3 gets it wrong for loops that can only leave at their
// bottom, so the house rule is an exit test at the top as well; the first and last answers are held to it, the second shows
// whether the driver still has the fault.
#include "test_io.glsl"

TEST_BUFFERS(LoopCase, LoopAnswer)

void main() {
  if (!lane_has_work()) return;
  const uint rounds = inputs[lane()].rounds;

  uint top = 0u;
  bool going = true;
  while (going) {
    if (top >= rounds) break;
    ++top;
    going = top < rounds;
  }

  uint bottom = 0u;
  for (;;) {
    ++bottom;
    if (bottom >= rounds) break;
  }

  uint nested = 0u;
  bool outer = true;
  uint i = 0u;
  while (outer) {
    if (i >= rounds) break;
    uint j = 0u;
    bool inner = true;
    while (inner) {
      if (j > i % 5u) break;
      ++j;
      ++nested;
      inner = j <= i % 5u;
    }
    ++i;
    outer = i < rounds;
  }
  outputs[lane()] = LoopAnswer(top, bottom, nested, 0u);
}
