#include "reference/filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace etendue::reference {
namespace {

/// Difference to the Gaussian's value at the radius, written as a product so that nothing cancels if stddev is much
/// larger than the radius, and nothing overflows if it is much smaller.
double gaussian(double x, double radius, double stddev) {
  if (std::abs(x) >= radius) return 0.0;
  const double scale = 1.0 / (2.0 * stddev * stddev);
  return std::exp(-x * x * scale) * -std::expm1((x * x - radius * radius) * scale);
}

/// Two-parameter family of piecewise cubics on [−2, 2]; source: [Mitchell1988], equation 8.
double mitchell(double x, double b, double c) {
  x = std::abs(x);
  if (x >= 2.0) return 0.0;
  if (x < 1.0) return ((12 - 9 * b - 6 * c) * x * x * x + (-18 + 12 * b + 6 * c) * x * x + (6 - 2 * b)) / 6;
  return ((-b - 6 * c) * x * x * x + (6 * b + 30 * c) * x * x + (-12 * b - 48 * c) * x + (8 * b + 24 * c)) / 6;
}

/// The sinc function sin(πx)/(πx), windowed by the central lobe of a wider one that ends at `lobes`; source:
/// [Turkowski1990].
double lanczos(double x, double lobes) {
  const double t = std::numbers::pi * std::abs(x);
  if (std::abs(x) >= lobes) return 0.0;
  return t < 1e-8 ? 1.0 : lobes * std::sin(t) * std::sin(t / lobes) / (t * t);
}

/// ∫ g over [a, b] by the five-point Gauss–Legendre rule: exact for polynomials up to degree 9.
template <class Function>
double integrate(const Function& g, double a, double b) {
  constexpr std::array<double, 3> node{0.0, 0.5384693101056831, 0.9061798459386640};
  constexpr std::array<double, 3> weight{0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
  const double middle = 0.5 * (a + b);
  const double half = 0.5 * (b - a);
  double sum = weight[0] * g(middle);
  for (std::size_t i = 1; i < node.size(); ++i)
    sum += weight[i] * (g(middle - half * node[i]) + g(middle + half * node[i]));
  return half * sum;
}

/// The position, to the last bit, where `holds` changes from true (at `a`) to false (at `b`).
template <class Predicate>
double bisect(double a, double b, const Predicate& holds) {
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (a + b);
    if (middle == a || middle == b) break;
    (holds(middle) ? a : b) = middle;
  }
  return b;
}

/// Ends of the cells on [0, radius] inside which |filter| is smooth and the quadrature accurate to rounding.
std::vector<double> cell_ends(const ReconstructionFilter& filter) {
  constexpr int kCells = 2048;
  const double radius = filter_radius(filter);
  // A Gaussian far narrower than its radius needs its cells where its mass is; at 39 standard deviations it is 1e-330.
  const bool narrow = filter.type == ReconstructionFilter::Type::gaussian && 39.0 * filter.stddev < radius;
  const double reach = narrow ? 39.0 * filter.stddev : radius;
  std::vector<double> ends;
  for (int i = 0; i <= kCells; ++i) ends.push_back(reach * i / kCells);
  if (narrow) ends.push_back(radius);
  // |filter| has a kink where the filter changes sign, so a cell ends there.
  for (int i = 0; i < kCells; ++i) {
    const bool positive = filter_value(filter, ends[i]) > 0.0;
    const auto same = [&](double x) { return (filter_value(filter, x) > 0.0) == positive; };
    if (!same(ends[i + 1])) ends.push_back(bisect(ends[i], ends[i + 1], same));
  }
  std::sort(ends.begin(), ends.end());
  return ends;
}

}  // namespace

double filter_radius(const ReconstructionFilter& filter) {
  switch (filter.type) {
    case ReconstructionFilter::Type::box:
      return 0.5 * filter.stretch;
    case ReconstructionFilter::Type::tent:
      return filter.stretch;
    case ReconstructionFilter::Type::lanczos:
      return filter.lobes;
    case ReconstructionFilter::Type::gaussian:
    case ReconstructionFilter::Type::mitchell:
      return filter.radius;
  }
  return 0.0;
}

double filter_value(const ReconstructionFilter& filter, double x) {
  switch (filter.type) {
    case ReconstructionFilter::Type::box:
      return std::abs(x) <= 0.5 * filter.stretch ? 1.0 : 0.0;
    case ReconstructionFilter::Type::tent:
      return std::max(0.0, 1.0 - std::abs(x) / filter.stretch);
    case ReconstructionFilter::Type::gaussian:
      return gaussian(x, filter.radius, filter.stddev);
    case ReconstructionFilter::Type::mitchell:
      return mitchell(2.0 * x / filter.radius, filter.b, filter.c);
    case ReconstructionFilter::Type::lanczos:
      return lanczos(x, filter.lobes);
  }
  return 0.0;
}

FilterSampler::FilterSampler(const ReconstructionFilter& filter) : filter_(filter) {
  if (is_pixel()) return;
  const auto value = [&](double x) { return filter_value(filter, x); };
  const auto magnitude = [&](double x) { return std::abs(filter_value(filter, x)); };
  const std::vector<double> ends = cell_ends(filter);

  // Mass of |f| between the centre and each cell's end; the filter is even, so half of it is enough.
  std::vector<double> mass{0.0};
  double signed_mass = 0.0;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    mass.push_back(mass.back() + integrate(magnitude, ends[i], ends[i + 1]));
    signed_mass += integrate(value, ends[i], ends[i + 1]);
  }
  const double half = mass.back();
  normalization_ = half / signed_mass;

  knots_.assign(kIntervals + 1, 0.0);
  for (int i = 1; i < kIntervals / 2; ++i) {
    // F(x) = 1/2 + mass(x) / (2 half) for x >= 0.
    const double target = half * (2.0 * i / kIntervals);
    const auto cell = static_cast<std::size_t>(std::upper_bound(mass.begin(), mass.end(), target) - mass.begin()) - 1;
    const auto below = [&](double x) { return mass[cell] + integrate(magnitude, ends[cell], x) < target; };
    const double x = bisect(ends[cell], ends[cell + 1], below);
    knots_[kIntervals / 2 + i] = x;
    knots_[kIntervals / 2 - i] = -x;
  }
  knots_.front() = -filter_radius(filter);
  knots_.back() = filter_radius(filter);
}

bool FilterSampler::is_pixel() const {
  return filter_.type == ReconstructionFilter::Type::box && filter_.stretch == 1.0;
}

FilterSampler::Sample FilterSampler::sample(double u) const {
  if (is_pixel()) return {u - 0.5, 1.0};
  const double scaled = u * kIntervals;
  const auto i = static_cast<std::size_t>(scaled);
  const double fraction = scaled - static_cast<double>(i);
  const double offset = knots_[i] + fraction * (knots_[i + 1] - knots_[i]);
  return {offset, filter_value(filter_, offset) < 0.0 ? -normalization_ : normalization_};
}

}  // namespace etendue::reference
