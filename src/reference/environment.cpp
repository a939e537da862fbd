#include "reference/environment.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "reference/delta_light.h"
#include "reference/sampling.h"
#include "scene/bounds.h"

namespace etendue::reference {
namespace {

bool has_bands(const SkyPicture& picture) {
  return picture.rows == SkyPicture::Rows::bands;
}

Vec3 gradient(const Sky& sky, double y) {
  return glm::mix(sky.horizon, sky.top, std::clamp(y, 0.0, 1.0));
}

}  // namespace

Environment::Environment(const Scene& scene, double lights_power) : sky_(scene.sky) {
  for (int axis = 0; axis < 3; ++axis)
    world_from_sky_[axis] = sky_.world_from_sky[axis] / glm::length(sky_.world_from_sky[axis]);
  std::vector<double> weights = sky_.picture ? make_picture_rows() : make_gradient_rows();
  double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  if (!(sum > 0.0)) {
    rows_.clear();
    weights.clear();
  }
  for (std::uint32_t i = 0; i < scene.delta_lights.size(); ++i) {
    const DeltaLight& light = scene.delta_lights[i];
    const double power = choice_power(scene, light);
    if (light.type != DeltaLight::Type::directional || !(power > 0.0)) continue;
    distant_.push_back({i, -light.axis(2), light.intensity.value});
    weights.push_back(power);
    sum += power;
  }
  if (weights.empty()) return;
  double prob = 1.0;
  if (lights_power > 0.0) {
    const double r = typical_radius(scene);
    prob = std::min(std::max(r * r * sum / (r * r * sum + lights_power), 0.25), 0.75);
  }
  for (double& weight : weights) weight *= prob / sum;
  if (lights_power > 0.0) weights.push_back(1.0 - prob);
  choice_ = DiscreteChoice(weights);
  if (lights_power > 0.0) lights_prob_ = choice_.prob(rows_.size() + distant_.size());
}

std::vector<double> Environment::make_gradient_rows() {
  constexpr int kUpperRows = 32;
  std::vector<double> weights;
  for (int i = 0; i <= kUpperRows; ++i) {
    Row row;
    row.cos_upper = static_cast<double>(kUpperRows - i) / kUpperRows;
    row.cos_lower = i < kUpperRows ? static_cast<double>(kUpperRows - i - 1) / kUpperRows : -1.0;
    const double mean = 0.5 * (luminance(gradient(sky_, row.cos_upper)) + luminance(gradient(sky_, row.cos_lower)));
    weights.push_back(2.0 * kPi * (row.cos_upper - row.cos_lower) * mean);
    row.cells = DiscreteChoice({weights.back()});
    rows_.push_back(std::move(row));
  }
  return weights;
}

std::vector<double> Environment::make_picture_rows() {
  const Bitmap& bitmap = *sky_.picture->bitmap;
  columns_ = bitmap.width;
  const auto height = static_cast<std::int64_t>(bitmap.height);
  const bool bands = has_bands(*sky_.picture);
  const std::int64_t count = bands ? height + 1 : std::max<std::int64_t>(height - 1, 1);
  const auto theta_of_edge = [&](std::int64_t edge) {
    if (!bands) return kPi * static_cast<double>(edge) / static_cast<double>(count);
    return edge == 0       ? 0.0
           : edge == count ? kPi
                           : kPi * (static_cast<double>(edge) - 0.5) / static_cast<double>(height);
  };
  // Luminance of the texels in the rows above and below the current cells.
  std::vector<double> above(columns_), below(columns_), cells(columns_), weights;
  const auto read_row = [&](std::int64_t y, std::vector<double>& row) {
    for (std::uint32_t x = 0; x < columns_; ++x) row[x] = luminance(texel(y, x));
  };
  const std::int64_t first = bands ? -1 : 0;
  read_row(first, below);
  for (std::int64_t r = 0; r < count; ++r) {
    std::swap(above, below);
    read_row(first + r + 1, below);
    Row row{.cos_upper = std::cos(theta_of_edge(r)), .cos_lower = std::cos(theta_of_edge(r + 1)), .cells = {}};
    const double solid_angle = 2.0 * kPi / columns_ * (row.cos_upper - row.cos_lower);
    for (std::uint32_t c = 0; c < columns_; ++c) {
      const std::uint32_t next = (c + 1) % columns_;
      cells[c] = 0.25 * (above[c] + above[next] + below[c] + below[next]) * solid_angle;
    }
    weights.push_back(std::accumulate(cells.begin(), cells.end(), 0.0));
    row.cells = DiscreteChoice(cells);
    rows_.push_back(std::move(row));
  }
  return weights;
}

/// Rows before the first and after the last repeat these.
Vec3 Environment::texel(std::int64_t row, std::uint32_t column) const {
  const Bitmap& bitmap = *sky_.picture->bitmap;
  const auto y = static_cast<std::uint32_t>(std::clamp<std::int64_t>(row, 0, std::int64_t{bitmap.height} - 1));
  const auto component = [&](std::uint32_t channel) {
    const double stored = bitmap.stored(column, y, channel);
    const double linear = bitmap.color_space == ColorSpace::srgb ? linear_from_srgb(stored) : stored;
    return static_cast<double>(static_cast<float>(linear * sky_.picture->scale));
  };
  if (bitmap.channels <= 2) return Vec3(component(0));
  return {component(0), component(1), component(2)};
}

Environment::Place Environment::place(const Vec3& d) const {
  Place place;
  if (!sky_.picture) {
    const auto upward = [&](const Row& row) { return d.y >= row.cos_lower; };
    const auto row = std::find_if(rows_.begin(), rows_.end(), upward);
    place.row = row == rows_.end() ? static_cast<std::uint32_t>(rows_.size() - 1)
                                   : static_cast<std::uint32_t>(row - rows_.begin());
    return place;
  }
  const double width = columns_, height = sky_.picture->bitmap->height;
  const double u = std::atan2(d.x, -d.z) / (2.0 * kPi);
  double x = std::fmod(u * width - 0.5, width);
  if (x < 0.0) x += width;
  place.column = std::min(static_cast<std::uint32_t>(x), columns_ - 1);
  place.across = x - place.column;
  const double v = std::atan2(std::hypot(d.x, d.z), d.y) / kPi;
  const double y = has_bands(*sky_.picture) ? v * height + 0.5 : v * (height - 1.0);
  place.row = std::min(static_cast<std::uint32_t>(y), static_cast<std::uint32_t>(rows_.size() - 1));
  place.down = y - place.row;
  return place;
}

Vec3 Environment::radiance_at(const Place& place) const {
  const std::int64_t above = std::int64_t{place.row} - (has_bands(*sky_.picture) ? 1 : 0);
  const std::uint32_t next = (place.column + 1) % columns_;
  const double a = place.across, b = place.down;
  return (1 - b) * ((1 - a) * texel(above, place.column) + a * texel(above, next)) +
         b * ((1 - a) * texel(above + 1, place.column) + a * texel(above + 1, next));
}

Vec3 Environment::radiance(const Vec3& w) const {
  const Vec3 d = to_sky(w);
  return sky_.picture ? radiance_at(place(d)) : gradient(sky_, d.y);
}

double Environment::density(std::uint32_t row, std::uint32_t column) const {
  const double solid_angle = 2.0 * kPi / columns_ * (rows_[row].cos_upper - rows_[row].cos_lower);
  return choice_.prob(row) * rows_[row].cells.prob(column) / solid_angle;
}

double Environment::pdf_w(const Vec3& w) const {
  if (rows_.empty()) return 0.0;
  const Place at = place(to_sky(w));
  return density(at.row, at.column);
}

std::optional<EnvironmentSample> Environment::sample(const SampleRandom::Environment& random) const {
  const std::size_t entry = choice_.choose(random.row);
  if (entry == rows_.size() + distant_.size()) return std::nullopt;
  if (entry >= rows_.size()) {
    const Distant& light = distant_[entry - rows_.size()];
    return EnvironmentSample{.wi = light.wi,
                             .pdf_w = choice_.prob(entry),
                             .radiance = light.irradiance,
                             .cell = light.number,
                             .delta = true};
  }
  Place at{.row = static_cast<std::uint32_t>(entry)};
  const Row& row = rows_[entry];
  at.column = static_cast<std::uint32_t>(row.cells.choose(random.column));
  at.across = random.across;
  const double cos_theta = row.cos_upper + random.down * (row.cos_lower - row.cos_upper);
  const double sin_theta = std::sqrt(std::max(0.0, 1.0 - cos_theta * cos_theta));
  const double phi = 2.0 * kPi * (at.column + 0.5 + at.across) / columns_;
  const Vec3 d(sin_theta * std::sin(phi), cos_theta, -sin_theta * std::cos(phi));
  EnvironmentSample sample{.wi = world_from_sky_ * d,
                           .pdf_w = density(at.row, at.column),
                           .radiance = Vec3(0.0),
                           .cell = at.row * columns_ + at.column};
  if (!sky_.picture) {
    sample.radiance = gradient(sky_, cos_theta);
    return sample;
  }
  const double height = sky_.picture->bitmap->height;
  const double v = std::acos(std::clamp(cos_theta, -1.0, 1.0)) / kPi;
  const double y = has_bands(*sky_.picture) ? v * height + 0.5 : v * (height - 1.0);
  at.down = std::clamp(y - static_cast<double>(at.row), 0.0, 1.0);
  sample.radiance = radiance_at(at);
  return sample;
}

}  // namespace etendue::reference
