/// Drivers have lost lanes in loops before (lavapipe 22.3, loops that only leave at their bottom). The loops of the
/// house must keep every lane.

#include "device_test.h"

namespace etendue::test {
namespace {

class DeviceLoops : public DeviceTest {};

TEST_F(DeviceLoops, LanesThatLeaveEarlyKeepTheirValues) {
  Random random(1);
  std::vector<gpu::LoopCase> cases;
  for (gpu::uint i = 0; i < 4096; ++i) cases.push_back({i < 256 ? i + 1 : 1 + random.below(200), 0, 0, 0});
  const auto answers = run<gpu::LoopAnswer>({kernels::loops, "loops", nullptr, {}}, cases);
  std::uint32_t lost = 0;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const gpu::uint rounds = cases[i].rounds;
    EXPECT_EQ(answers[i].top_and_bottom, rounds) << "lane " << i;
    gpu::uint nested = 0;
    for (gpu::uint k = 0; k < rounds; ++k) nested += k % 5 + 1;
    EXPECT_EQ(answers[i].nested, nested) << "lane " << i;
    if (answers[i].bottom_only != rounds) ++lost;
  }
  // Not held against the driver: the shaders have no such loop. It tells when the house rule has become unnecessary.
  RecordProperty("lanes_lost_by_bottom_exit", static_cast<int>(lost));
}

}  // namespace
}  // namespace etendue::test
