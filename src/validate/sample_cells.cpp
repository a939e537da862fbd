#include "validate/sample_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "validate/closed_form.h"

namespace etendue {

using glm::dvec3;

std::vector<DeltaLobe> delta_lobes(const Bsdf& bsdf, const dvec3& wo) {
  const dvec3 mirrored(-wo.x, -wo.y, wo.z);
  if (std::holds_alternative<MirrorBsdf>(bsdf)) {
    return wo.z > 0.0 ? std::vector<DeltaLobe>{{ProbeLobe::delta_reflection, mirrored, 1.0, dvec3(1.0)}}
                      : std::vector<DeltaLobe>{};
  }
  if (std::holds_alternative<NullBsdf>(bsdf)) return {{ProbeLobe::delta_transmission, -wo, 1.0, dvec3(1.0)}};
  if (const auto* metal = std::get_if<ConductorBsdf>(&bsdf)) {
    if (wo.z <= 0.0) return {};
    dvec3 weight = metal->specular_reflectance.value;
    for (int c = 0; c < 3; ++c)
      weight[c] *= closed_form::fresnel_reflectance_of_metal(wo.z, metal->index.eta.value[c], metal->index.k.value[c]);
    return {{ProbeLobe::delta_reflection, mirrored, 1.0, weight}};
  }
  if (const auto* pane = std::get_if<ThinDielectricBsdf>(&bsdf)) {
    const double f = closed_form::fresnel_reflectance(std::abs(wo.z), pane->ext_ior, pane->int_ior);
    // F + (1 − F)² F (1 + F² + F⁴ + …): all that leaves after an odd number of reflections between the faces.
    const double reflected = f < 1.0 ? f + (1.0 - f) * (1.0 - f) * f / (1.0 - f * f) : 1.0;
    std::vector<DeltaLobe> lobes{{ProbeLobe::delta_reflection, mirrored, reflected, pane->specular_reflectance.value}};
    if (reflected < 1.0)
      lobes.push_back({ProbeLobe::delta_transmission, -wo, 1.0 - reflected, pane->specular_transmittance.value});
    return lobes;
  }
  if (const auto* plastic = std::get_if<PlasticBsdf>(&bsdf)) {
    if (wo.z <= 0.0) return {};
    const auto sum = [](const dvec3& c) { return c.x + c.y + c.z; };
    const double f = closed_form::fresnel_reflectance(wo.z, plastic->ext_ior, plastic->int_ior);
    const double coat = f * sum(plastic->specular_reflectance.value);
    const double share = coat / (coat + (1.0 - f) * sum(plastic->diffuse_reflectance.value));
    return {{ProbeLobe::delta_reflection, mirrored, share, plastic->specular_reflectance.value * (f / share)}};
  }
  const auto* glass = std::get_if<DielectricBsdf>(&bsdf);
  if (glass == nullptr || wo.z == 0.0) return {};
  const double n_o = wo.z > 0.0 ? glass->ext_ior : glass->int_ior, n_t = wo.z > 0.0 ? glass->int_ior : glass->ext_ior;
  const double f = closed_form::fresnel_reflectance(std::abs(wo.z), n_o, n_t), ratio = n_o / n_t;
  std::vector<DeltaLobe> lobes{{ProbeLobe::delta_reflection, mirrored, f, glass->specular_reflectance.value}};
  if (f < 1.0) {
    const double x = -ratio * wo.x, y = -ratio * wo.y;
    const double z = std::copysign(std::sqrt(1.0 - x * x - y * y), -wo.z);
    lobes.push_back(
        {ProbeLobe::delta_transmission, {x, y, z}, 1.0 - f, ratio * ratio * glass->specular_transmittance.value});
  }
  return lobes;
}

namespace {

/// Relative index n_i/n_o of what passes the surface; 1 where nothing does.
double relative_index(const Bsdf& bsdf, const dvec3& wo) {
  double index = 1.0;
  if (const auto* glass = std::get_if<RoughDielectricBsdf>(&bsdf)) index = glass->int_ior / glass->ext_ior;
  if (const auto* principled = std::get_if<PrincipledBsdf>(&bsdf)) index = principled->eta.value;
  if (const auto* gltf = std::get_if<GltfBsdf>(&bsdf)) index = gltf->thin ? 1.0 : std::max(1.001, gltf->ior.value);
  return wo.z > 0.0 ? index : 1.0 / index;
}

double largest_of(const dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

}  // namespace

// Half of a sphere is reflection, so that the normals of its facets need twice the rings.
SampleGrid::SampleGrid(const Bsdf& bsdf, const dvec3& wo, std::uint32_t resolution)
    : rings_(static_cast<int>(narrow_roughness(bsdf) ? 2 * resolution : resolution)),
      sectors_(static_cast<int>(2 * resolution)) {
  if (const std::optional<Roughness> narrow = narrow_roughness(bsdf))
    facets_.emplace(*narrow, wo, relative_index(bsdf, wo));
}

std::size_t SampleGrid::cell_of(const dvec3& wi) const {
  const FacetCell cell = facets_ ? facets_->cell_of(wi) : FacetCell{wi.z, std::atan2(wi.y, wi.x)};
  const double turn = cell.phi / (2.0 * std::numbers::pi);
  const int ring = std::clamp(static_cast<int>(0.5 * (cell.height + 1.0) * rings_), 0, rings_ - 1);
  const int sector = std::clamp(static_cast<int>((turn < 0.0 ? turn + 1.0 : turn) * sectors_), 0, sectors_ - 1);
  return static_cast<std::size_t>(ring) * sectors_ + sector;
}

/// The density per area of the grid, at places that are given as directions of a sphere.
SphereDensity SampleGrid::over_cells(const SphereDensity& density) const {
  return [this, &density](std::span<const dvec3> places) {
    std::vector<FacetCells::Direction> directions;
    std::vector<dvec3> wi;
    for (const dvec3& place : places) {
      directions.push_back(facets_->direction_of({place.z, std::atan2(place.y, place.x)}));
      wi.push_back(directions.back().solid_angle > 0.0 ? directions.back().wi : dvec3(0, 0, 1));
    }
    std::vector<double> values = density(wi);
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = directions[i].solid_angle > 0.0 ? values[i] * directions[i].solid_angle : 0.0;
    return values;
  };
}

// Cells of facets are quartered twice beforehand: the horizon cuts them anywhere, and a corner beyond it must not be
// missed.
std::vector<double> SampleGrid::integrate(const SphereDensity& density) const {
  if (!facets_) return integrate_cells(density, rings_, sectors_);
  constexpr int kParts = 4;
  const std::vector<double> parts = integrate_cells(over_cells(density), kParts * rings_, kParts * sectors_);
  const auto sectors = static_cast<std::size_t>(sectors_);
  std::vector<double> cells(cell_count(), 0.0);
  for (std::size_t i = 0; i < parts.size(); ++i)
    cells[i / (kParts * sectors) / kParts * sectors + i % (kParts * sectors) / kParts] += parts[i];
  return cells;
}

double SampleGrid::integrate_finely(const SphereDensity& density, std::size_t cell) const {
  constexpr int kPoints = 128;
  const auto ring = static_cast<double>(cell / static_cast<std::size_t>(sectors_)),
             sector = static_cast<double>(cell % static_cast<std::size_t>(sectors_));
  // Denser toward the edges, from where slivers reach into the cell.
  const auto angle = [](int i) { return std::numbers::pi * (i + 0.5) / kPoints; };
  const auto place = [&](int i) { return 0.5 - 0.5 * std::cos(angle(i)); };
  std::vector<dvec3> places;
  for (int i = 0; i < kPoints * kPoints; ++i) {
    const double z = (ring + place(i / kPoints)) / rings_, turn = (sector + place(i % kPoints)) / sectors_;
    places.push_back(spherical_direction(2.0 * z - 1.0, 2.0 * std::numbers::pi * turn));
  }
  const std::vector<double> values = facets_ ? over_cells(density)(places) : density(places);
  double sum = 0.0;
  for (int i = 0; i < kPoints * kPoints; ++i)
    sum += values[static_cast<std::size_t>(i)] * std::sin(angle(i / kPoints)) * std::sin(angle(i % kPoints));
  const double part = 0.5 * std::numbers::pi / kPoints;
  return sum * part * part * 4.0 * std::numbers::pi / static_cast<double>(cell_count());
}

void SampleCounts::add(const BsdfDraw& draw) {
  if (draw.pdf == 0.0 || draw.lobe == ProbeLobe::none || draw.lobe == ProbeLobe::passed) {
    ++counts_.back();
  } else if (is_delta(draw.lobe)) {
    add_delta(draw);
  } else {
    ++counts_[grid_.cell_of(draw.wi)];
  }
}

void SampleCounts::add_delta(const BsdfDraw& draw) {
  const auto lobe = std::find_if(lobes_.begin(), lobes_.end(), [&](const DeltaLobe& l) { return l.kind == draw.lobe; });
  if (lobe == lobes_.end()) {  // a lobe the material does not have
    delta_error_ = std::numeric_limits<double>::infinity();
    return;
  }
  ++counts_[grid_.cell_count() + static_cast<std::size_t>(lobe - lobes_.begin())];
  const double scale = largest_of(lobe->weight);
  const double error = std::max({largest_of(draw.wi - lobe->wi), std::abs(draw.pdf - lobe->prob),
                                 largest_of(draw.weight - lobe->weight) / (scale > 0.0 ? scale : 1.0)});
  delta_error_ = std::isnan(error) ? std::numeric_limits<double>::infinity() : std::max(delta_error_, error);
}

}  // namespace etendue
