/// The team of devices against renderers that fail on purpose: every sample is delivered once, whatever is lost.

#include "render/device_team.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <limits>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/errors.h"
#include "render/stopping.h"

namespace etendue {
namespace {

/// Adds the value (index + 1) for each sample, three indices a pass. Before each pass it asks `fault`, which may throw.
class FakeRenderer final : public Renderer {
 public:
  using Fault = std::function<void()>;
  FakeRenderer(std::string name, Fault fault) : name_(std::move(name)), fault_(std::move(fault)) {}
  std::string device_name() const override { return name_; }
  std::string driver_name() const override { return "fake"; }
  void set_view(const View&, const RenderSettings&) override {}
  void set_materials(const std::vector<Material>&) override {}
  void set_scene(const SharedScene&, const RenderSettings&) override {}
  std::uint32_t render(SampleRange range, Film& film, const Progress& progress, std::vector<RejectedSample>&) override {
    std::uint32_t next = range.begin;
    bool go_on = true;
    while (next < range.end && go_on) {
      // The film is spoilt by a failed call, as a read back that breaks off may leave it.
      for (FilmPixel& pixel : film.pixels()) pixel.add(glm::vec3(1.0f), film.exponent());
      fault_();
      const std::uint32_t end = std::min(next + 3, range.end);
      for (FilmPixel& pixel : film.pixels()) {
        pixel.add(glm::vec3(-1.0f), film.exponent());
        for (std::uint32_t i = next; i < end; ++i) pixel.add(glm::vec3(static_cast<float>(i + 1)), film.exponent());
        pixel.count -= 2;
      }
      next = end;
      go_on = progress((next - range.begin) * film.pixels().size(), range.count() * film.pixels().size());
    }
    return next;
  }
  std::vector<SampleRecord> trace_samples(std::span<const SampleId>) override { return {}; }
  std::vector<PathVertex> trace_path(SampleId) override { return {}; }

 private:
  std::string name_;
  Fault fault_;
};

struct Delivered {
  Film film{2, 2, 20};
  SampleRanges samples;
  std::vector<std::string> names;

  void add(const FinishedSamples& finished) {
    film.merge(*finished.film);
    for (const auto& range : samples)
      EXPECT_TRUE(finished.range.end <= range.first || range.second <= finished.range.begin) << "delivered twice";
    samples.emplace_back(finished.range.begin, finished.range.end);
    samples = canonical(samples);
    names.push_back(finished.renderer->device_name());
  }
};

OpenRenderer opener(const std::string& name, const FakeRenderer::Fault& fault) {
  return [=] { return std::make_unique<FakeRenderer>(name, fault); };
}

const auto always = [](std::uint64_t) { return true; };

void render(DeviceTeam& team, SampleQueue& queue, Delivered& out,
            const std::function<bool(std::uint64_t)>& go_on = always) {
  team.render(
      queue, 2, 2, 20, [&](const FinishedSamples& finished) { out.add(finished); }, go_on);
}

void expect_whole(const Delivered& out, std::uint32_t end) {
  EXPECT_EQ(out.samples, (SampleRanges{{0, end}}));
  Film expected(2, 2, 20);
  for (FilmPixel& pixel : expected.pixels()) {
    for (std::uint32_t i = 0; i < end; ++i) pixel.add(glm::vec3(static_cast<float>(i + 1)), 20);
  }
  for (std::size_t p = 0; p < 4; ++p) {
    EXPECT_EQ(out.film.pixels()[p].sum, expected.pixels()[p].sum);
    EXPECT_EQ(out.film.pixels()[p].count, end);
  }
}

TEST(DeviceTeam, OneDeviceRendersEverything) {
  DeviceTeam team({opener("a", [] {})});
  SampleQueue queue({{0, 100}});
  Delivered out;
  render(team, queue, out);
  expect_whole(out, 100);
}

TEST(DeviceTeam, SeveralDevicesShareTheQueue) {
  const auto slow = [] { std::this_thread::sleep_for(std::chrono::milliseconds(1)); };
  DeviceTeam team({opener("a", slow), opener("b", slow), opener("c", slow)});
  SampleQueue queue({{0, 300}});
  Delivered out;
  render(team, queue, out);
  expect_whole(out, 300);
  for (const char* name : {"a", "b", "c"}) EXPECT_THAT(out.names, testing::Contains(name));
}

// Six sample indices of four pixels.
TEST(DeviceTeam, StopsAfterThePassAndGivesTheRestBack) {
  DeviceTeam team({opener("a", [] {})});
  SampleQueue queue({{0, 100}});
  Delivered out;
  render(team, queue, out, [](std::uint64_t done) { return done < 24; });
  expect_whole(out, 6);
  EXPECT_EQ(queue.left(), 94u);
  render(team, queue, out);
  expect_whole(out, 100);
}

TEST(DeviceTeam, LostSamplesAreRenderedAgain) {
  std::atomic<int> calls{0};
  DeviceTeam team({opener("a", [&] {
    if (++calls == 4) throw DeviceLost("lost.");
  })});
  SampleQueue queue({{0, 30}});
  Delivered out;
  render(team, queue, out);
  expect_whole(out, 30);
}

TEST(DeviceTeam, TriesAreCountedBetweenDeliveries) {
  // Ten losses in all, never more than two without a delivery between them.
  int calls = 0, losses = 0;
  DeviceTeam team({opener("a", [&] {
    if (++calls % 3 != 0 && losses < 10) {
      ++losses;
      throw DeviceLost("lost.");
    }
  })});
  SampleQueue queue({{0, 60}});
  Delivered out;
  while (queue.left() > 0) render(team, queue, out, [](std::uint64_t) { return false; });
  expect_whole(out, 60);
  EXPECT_EQ(losses, 10);
}

TEST(DeviceTeam, GivesUpAfterThreeFreshDevices) {
  int opened = 0;
  DeviceTeam team({[&] {
    ++opened;
    return std::make_unique<FakeRenderer>("a", [] { throw DeviceLost("The device is lost."); });
  }});
  SampleQueue queue({{0, 30}});
  Delivered out;
  EXPECT_THROW(render(team, queue, out), DeviceLost);
  EXPECT_EQ(opened, 1 + DeviceTeam::kRetries);
  EXPECT_EQ(queue.left(), 30u);
  EXPECT_TRUE(out.samples.empty());
}

TEST(DeviceTeam, OthersTakeOverTheWorkOfALostDevice) {
  DeviceTeam team({opener("bad", [] { throw DeviceLost("lost."); }), opener("good", [] {})});
  SampleQueue queue({{0, 90}});
  Delivered out;
  while (queue.left() > 0) render(team, queue, out);
  expect_whole(out, 90);
  EXPECT_THAT(out.names, testing::Each("good"));
}

TEST(DeviceTeam, OtherErrorsEndTheRunAndKeepWhatWasDelivered) {
  DeviceTeam team({opener("a", [] { std::this_thread::sleep_for(std::chrono::milliseconds(1)); }),
                   opener("b", [calls = std::make_shared<int>(0)] {
                     std::this_thread::sleep_for(std::chrono::milliseconds(1));
                     if (++*calls == 5) throw Error(ErrorKind::lost, "out of memory.");
                   })});
  SampleQueue queue({{0, 100000}});
  Delivered out;
  EXPECT_THROW(render(team, queue, out), Error);
  EXPECT_EQ(sample_count(out.samples) + queue.left(), 100000u);
}

TEST(SampleQueue, RangesAreSetsOfIndices) {
  EXPECT_EQ(difference({{0, 100}}, {{10, 20}, {90, 120}}), (SampleRanges{{0, 10}, {20, 90}}));
  EXPECT_EQ(difference({{0, 10}, {20, 30}}, {{5, 25}}), (SampleRanges{{0, 5}, {25, 30}}));
  EXPECT_EQ(difference({{0, 10}}, {{0, 10}}), SampleRanges{});
  EXPECT_EQ(difference({{3, 7}}, {}), (SampleRanges{{3, 7}}));
  EXPECT_EQ(first_samples({{0, 4}, {8, 20}}, 6), (SampleRanges{{0, 4}, {8, 10}}));
  EXPECT_EQ(first_samples({{0, 4}}, 9), (SampleRanges{{0, 4}}));
}

TEST(Stopping, LooksAtFixedSampleCounts) {
  std::vector<std::uint64_t> checks;
  for (std::uint64_t n = 0; n < 200; n = checks.back()) checks.push_back(next_error_check(n));
  EXPECT_THAT(checks, testing::ElementsAre(16, 24, 32, 48, 64, 96, 128, 192, 256));
  for (std::uint64_t n = 0; n < 200; ++n) EXPECT_EQ(is_error_check(n), testing::Value(checks, testing::Contains(n)));
}

TEST(Stopping, RelativeErrorIsThatOfTheMeans) {
  // Every channel of every pixel sees 1 and 3: mean 2, standard error 1.
  Film film(3, 1, 2);
  EXPECT_EQ(relative_standard_error(film), std::numeric_limits<double>::infinity());
  for (FilmPixel& pixel : film.pixels()) {
    pixel.add(glm::vec3(1.0f), 2);
    pixel.add(glm::vec3(3.0f), 2);
  }
  EXPECT_DOUBLE_EQ(relative_standard_error(film), 0.5);
  Film dark(2, 2, 0);
  for (FilmPixel& pixel : dark.pixels()) {
    for (int i = 0; i < 2; ++i) pixel.add(glm::vec3(0.0f), 0);
  }
  EXPECT_EQ(relative_standard_error(dark), std::numeric_limits<double>::infinity());
}

TEST(Stopping, AStartThatHasNotSeenTheLightIsNotGoodEnough) {
  const auto picture = [](std::uint32_t side, int samples, float left, float right) {
    Film film(side, side, 4);
    for (std::uint32_t i = 0; i < side * side; ++i) {
      for (int s = 0; s < samples; ++s) film.pixels()[i].add(glm::vec3(i % side < side / 2 ? left : right), 4);
    }
    return film;
  };
  // All black: nothing is known, however many samples there are.
  EXPECT_EQ(stopping_error(picture(16, 4096, 0.0f, 0.0f)), std::numeric_limits<double>::infinity());
  // A sky, and under it what no light has reached yet: no sample differs from another, which is no proof.
  EXPECT_GT(stopping_error(picture(16, 16, 1.0f, 0.0f)), 0.5);
  // Many samples are one in the end.
  EXPECT_LT(stopping_error(picture(16, 2048, 1.0f, 0.0f)), 0.01);
  EXPECT_LT(stopping_error(picture(256, 64, 1.0f, 0.0f)), 0.015);
  // Fewer than two samples have no error.
  EXPECT_EQ(stopping_error(picture(16, 1, 1.0f, 1.0f)), std::numeric_limits<double>::infinity());
}

TEST(Stopping, SeenNoiseIsWhatCountsInAPictureOfUsualSize) {
  Film film(320, 240, 2);
  for (FilmPixel& pixel : film.pixels()) {
    for (int s = 0; s < 64; ++s) pixel.add(glm::vec3(s % 2 == 0 ? 1.0f : 3.0f), 2);
  }
  EXPECT_NEAR(stopping_error(film), relative_standard_error(film), 0.02 * relative_standard_error(film));
}

}  // namespace
}  // namespace etendue
