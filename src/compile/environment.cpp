#include "compile/environment.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "compile/delta_lights.h"
#include "compile/discrete.h"
#include "core/parallel.h"
#include "image/vectors.h"
#include "scene/bounds.h"

namespace etendue {
namespace {

constexpr std::uint32_t kGradientRows = 32;  // above the horizon

// The edges of a row of cells: sin²(θ/2) from the north pole, and from the south pole.
struct RowEdges {
  double upper_north, lower_north, upper_south, lower_south;
  double solid_angle() const { return 4.0 * kPi * (lower_north - upper_north); }
};

RowEdges edges_between(double theta_upper, double theta_lower) {
  const auto square = [](double x) { return x * x; };
  return {square(std::sin(0.5 * theta_upper)), square(std::sin(0.5 * theta_lower)), square(std::cos(0.5 * theta_upper)),
          square(std::cos(0.5 * theta_lower))};
}

class Tabulator {
 public:
  Tabulator(const Scene& scene, double lights_power) : scene_(scene), sky_(scene.sky), lights_power_(lights_power) {}

  EnvironmentTables tabulate() {
    for (const std::uint32_t number : delta_light_order(scene_)) {
      const DeltaLight& light = scene_.delta_lights[number];
      if (light.type == DeltaLight::Type::directional) distant_.push_back(delta_light_power(scene_, light));
    }
    if (!is_dark(sky_)) {
      tabulate_rows();
    } else if (distant_.empty()) {
      return {};
    }
    choose_rows();
    return std::move(out_);
  }

 private:
  void tabulate_rows() {
    EnvironmentFacts& facts = out_.facts;
    facts.top = sky_.top;
    facts.horizon = sky_.horizon;
    for (int a = 0; a < 3; ++a) facts.world_from_sky[a] = glm::normalize(sky_.world_from_sky[a]);
    facts.kind = sky_.picture ? gpu::kEnvironmentPicture : gpu::kEnvironmentGradient;
    if (sky_.picture) {
      tabulate_picture();
    } else {
      tabulate_gradient();
    }
  }

  void tabulate_gradient() {
    out_.facts.cell_rows = kGradientRows + 1;
    for (std::uint32_t r = 0; r <= kGradientRows; ++r) {
      // Rows for y from 1 down to 0, and one for the lower half of all directions.
      const double upper = 1.0 - static_cast<double>(r) / kGradientRows;
      const double lower = r < kGradientRows ? 1.0 - (r + 1.0) / kGradientRows : -1.0;
      edges_.push_back({0.5 * (1.0 - upper), 0.5 * (1.0 - lower), 0.5 * (1.0 + upper), 0.5 * (1.0 + lower)});
      const auto radiance = [&](double y) {
        return luminance(glm::mix(sky_.horizon, sky_.top, std::clamp(y, 0.0, 1.0)));
      };
      weights_.push_back(0.5 * (radiance(upper) + radiance(lower)) * edges_.back().solid_angle());
      out_.rows.push_back({.column_count = 1});
    }
    out_.search.resize(search_of_row(0));
  }

  void tabulate_picture() {
    const SkyPicture& picture = *sky_.picture;
    const bool bands = picture.rows == SkyPicture::Rows::bands;
    const std::uint32_t width = picture.bitmap->width, height = picture.bitmap->height;
    EnvironmentFacts& facts = out_.facts;
    facts.columns = width;
    facts.texel_rows = height;
    facts.cell_rows = bands ? height + 1 : std::max(height - 1, 1u);
    for (std::uint32_t r = 0; r < facts.cell_rows; ++r) {
      const auto theta = [&](std::uint32_t edge) {
        if (!bands) return kPi * edge / facts.cell_rows;
        return kPi * std::clamp((edge - 0.5) / height, 0.0, 1.0);
      };
      edges_.push_back(edges_between(theta(r), theta(r + 1)));
    }
    out_.rows.resize(facts.cell_rows);
    weights_.resize(facts.cell_rows);
    out_.search.resize(search_of_row(facts.cell_rows));
    out_.texels.resize(std::size_t{width} * std::max(height, facts.cell_rows));
    parallel_for(height, 8, [&](std::uint64_t begin, std::uint64_t end) {
      for (std::uint64_t y = begin; y < end; ++y) {
        for (std::uint32_t x = 0; x < width; ++x)
          out_.texels[y * width + x].radiance = picture.radiance(x, static_cast<std::uint32_t>(y));
      }
    });
    parallel_for(facts.cell_rows, 8, [&](std::uint64_t begin, std::uint64_t end) {
      std::vector<double> weights(width);
      for (std::uint64_t r = begin; r < end; ++r) tabulate_cells(static_cast<std::uint32_t>(r), bands, weights);
    });
  }

  // The first node of the search for a row's column; these follow the search for the row.
  std::size_t search_of_row(std::uint32_t r) const {
    const EnvironmentFacts& facts = out_.facts;
    return SearchTree(facts.cell_rows).nodes + std::size_t{r} * SearchTree(facts.columns).nodes;
  }

  // Thresholds of a row's cells; `weights` is scratch memory for their weights.
  void tabulate_cells(std::uint32_t r, bool bands, std::vector<double>& weights) {
    const EnvironmentFacts& facts = out_.facts;
    const std::uint32_t last = facts.texel_rows - 1;
    const std::uint32_t upper = bands ? (r > 0 ? r - 1 : 0) : r, lower = bands ? r : r + 1;
    const auto texel = [&](std::uint32_t y, std::uint32_t x) {
      const std::size_t i = std::size_t{std::min(y, last)} * facts.columns + x % facts.columns;
      return luminance(glm::dvec3(out_.texels[i].radiance));
    };
    const double solid_angle = edges_[r].solid_angle() / facts.columns;
    double sum = 0.0;
    for (std::uint32_t c = 0; c < facts.columns; ++c) {
      weights[c] = 0.25 * (texel(upper, c) + texel(upper, c + 1) + texel(lower, c) + texel(lower, c + 1)) * solid_angle;
      sum += weights[c];
    }
    weights_[r] = sum;
    const std::vector<std::uint64_t> thresholds = integer_thresholds(weights);
    if (thresholds.empty()) return;
    std::uint32_t count = facts.columns;
    while (!(weights[count - 1] > 0.0)) --count;
    out_.rows[r].column_count = count;
    for (std::uint32_t c = 0; c < count; ++c) {
      const std::uint64_t words = thresholds[c + 1] - thresholds[c];  // 2^32 becomes 0
      out_.texels[std::size_t{r} * facts.columns + c].words = static_cast<gpu::uint>(words);
    }
    write_search_tree(std::span(thresholds).first(facts.columns), std::span(out_.search).subspan(search_of_row(r)));
  }

  // The environment's share of all light.
  double share(double sum) const {
    constexpr double kLeast = 1.0 / 4.0;
    if (!(lights_power_ > 0.0)) return 1.0;
    const double radius = typical_radius(scene_);
    const double power = radius * radius * sum;
    return std::clamp(power / (power + lights_power_), kLeast, 1.0 - kLeast);
  }

  // One discrete choice: first the rows, then the directional lights, then all other lights as one entry.
  void choose_rows() {
    EnvironmentFacts& facts = out_.facts;
    const std::size_t rows = weights_.size();
    std::vector<double> entries = weights_;
    entries.insert(entries.end(), distant_.begin(), distant_.end());
    double sum = 0.0;
    for (const double entry : entries) sum += entry;
    const bool lit = lights_power_ > 0.0;
    facts.alone = !lit && distant_.empty();
    const double outside = share(sum);
    for (double& entry : entries) entry = outside * (entry / sum);
    if (lit) entries.push_back(1.0 - outside);
    const std::vector<std::uint64_t> thresholds = integer_thresholds(entries);
    facts.row_count = static_cast<std::uint32_t>(rows);
    while (facts.row_count > 0 && !(weights_[facts.row_count - 1] > 0.0)) --facts.row_count;
    write_search_tree(std::span(thresholds).first(rows), out_.search);
    const std::uint64_t lights_from = thresholds[rows + distant_.size()];
    if (!facts.alone) facts.threshold = static_cast<std::uint32_t>(thresholds[rows]);
    facts.distant_threshold = static_cast<std::uint32_t>(lights_from);
    if (lit) facts.lights_prob = static_cast<double>((std::uint64_t{1} << 32) - lights_from) * 0x1p-32;
    out_.distant_thresholds.assign(thresholds.begin() + static_cast<std::ptrdiff_t>(rows),
                                   thresholds.begin() + static_cast<std::ptrdiff_t>(rows + distant_.size() + 1));
    for (std::uint32_t r = 0; r < rows; ++r) {
      gpu::EnvironmentRow& row = out_.rows[r];
      const bool north = 2 * r < facts.cell_rows;
      const double prob = static_cast<double>(thresholds[r + 1] - thresholds[r]) * 0x1p-32;
      row.density = static_cast<float>(prob * facts.columns / edges_[r].solid_angle());
      row.upper_edge = static_cast<float>(north ? edges_[r].upper_north : edges_[r].upper_south);
      row.lower_edge = static_cast<float>(north ? edges_[r].lower_north : edges_[r].lower_south);
    }
  }

  const Scene& scene_;
  const Sky& sky_;
  double lights_power_;
  EnvironmentTables out_;
  std::vector<RowEdges> edges_;
  std::vector<double> weights_;  // of the rows
  std::vector<double> distant_;  // of the directional lights
};

}  // namespace

EnvironmentTables compile_environment(const Scene& scene, double lights_power) {
  return Tabulator(scene, lights_power).tabulate();
}

}  // namespace etendue
