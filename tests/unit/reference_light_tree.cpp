// How well the light tree chooses: the variance that is left when light is gathered from one chosen lamp, over
// arrangements of a thousand lamps, without shadows. A factor of two lost here is nowhere else to be seen.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>

#include "reference/light_tree.h"

namespace etendue::reference {
namespace {

struct Lamp {
  Vec3 center, normal;
};
struct Receiver {
  Vec3 p, n;
};
constexpr double kArea = 1e-4, kReach = 0.006;  // of a lamp, its size for its box
constexpr std::uint32_t kLamps = 1000, kReceivers = 100;

class LightTreeChoice : public ::testing::Test {
 protected:
  double uniform(double a, double b) { return std::uniform_real_distribution<>(a, b)(random_); }
  Vec3 in_box(Vec3 lower, Vec3 upper) {
    return {uniform(lower.x, upper.x), uniform(lower.y, upper.y), uniform(lower.z, upper.z)};
  }
  Vec3 direction() {
    std::normal_distribution<> normal;
    return glm::normalize(Vec3(normal(random_), normal(random_), normal(random_)));
  }

  // Mean over receivers of the relative variance of c/prob, c what a lamp sends and prob its chance. Lamps are points
  // here, since the spread over one lamp is not the tree's business.
  double relative_variance(const std::function<Lamp()>& lamp, const std::function<Receiver()>& receiver) {
    std::vector<Lamp> lamps;
    std::vector<LightLeaf> leaves;
    for (std::uint32_t i = 0; i < kLamps; ++i) {
      lamps.push_back(lamp());
      const Vec3& c = lamps.back().center;
      leaves.push_back({.light = 0,
                        .primitive = i,
                        .power = kArea,
                        .lower = c - kReach,
                        .upper = c + kReach,
                        .normal = lamps.back().normal});
    }
    const LightTree tree(leaves);
    double mean = 0.0;
    for (std::uint32_t r = 0; r < kReceivers; ++r) {
      const auto [p, n] = receiver();
      double sum = 0.0, squares = 0.0, all_probs = 0.0;
      for (std::uint32_t i = 0; i < kLamps; ++i) {
        const double prob = tree.prob(p, n, 0, i);
        const Vec3 v = lamps[i].center - p;
        const double d2 = glm::dot(v, v);
        const double contribution =
            std::max(0.0, glm::dot(n, v)) * std::max(0.0, -glm::dot(lamps[i].normal, v)) / (d2 * d2);
        all_probs += prob;
        if (contribution == 0.0) continue;
        EXPECT_GT(prob, 0.0) << "lamp " << i << " can never be chosen";
        sum += contribution;
        squares += contribution * contribution / prob;
      }
      // Below 1 where a group that can send something turns out to be of lamps of which none can.
      EXPECT_LE(all_probs, 1.0 + 1e-9);
      if (sum > 0.0) mean += (squares / (sum * sum) - 1.0) / kReceivers;
    }
    return mean;
  }

  std::mt19937 random_{7};
};

TEST_F(LightTreeChoice, LampsOverAFloor) {
  const double variance = relative_variance(
      [&] {
        const Vec3 down(uniform(-0.5, 0.5), -1.0, uniform(-0.5, 0.5));
        return Lamp{in_box({-1, 0.06, -1}, {1, 0.34, 1}), glm::normalize(down)};
      },
      [&] {
        return Receiver{in_box({-0.9, 0, -0.9}, {0.9, 0, 0.9}), {0, 1, 0}};
      });
  EXPECT_LT(variance, 0.85) << "by power alone it is above 20";
}

TEST_F(LightTreeChoice, LampsInSpace) {
  const double variance = relative_variance(
      [&] {
        return Lamp{in_box({-1, -1, -1}, {1, 1, 1}), direction()};
      },
      [&] {
        return Receiver{in_box({-1, -1, -1}, {1, 1, 1}), direction()};
      });
  EXPECT_LT(variance, 4.0) << "by power alone it is about 80";
}

TEST_F(LightTreeChoice, LuminousCeiling) {
  const double variance = relative_variance(
      [&] {
        return Lamp{in_box({-1, 1, -1}, {1, 1, 1}), {0, -1, 0}};
      },
      [&] {
        return Receiver{in_box({-1, -1, -1}, {1, 0.95, 1}), direction()};
      });
  EXPECT_LT(variance, 0.9) << "by power alone it is above 10";
}

}  // namespace
}  // namespace etendue::reference
