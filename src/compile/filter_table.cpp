#include "compile/filter_table.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "gpu_types.h"

namespace etendue {
namespace {

constexpr int kIntegrationSteps = 1 << 16;  // midpoint rule over the support: relative error below 1e-9

double filter_radius(const ReconstructionFilter& f) {
  switch (f.type) {
    case ReconstructionFilter::Type::box:
      return 0.5 * f.stretch;
    case ReconstructionFilter::Type::tent:
      return f.stretch;
    case ReconstructionFilter::Type::lanczos:
      return f.lobes;
    case ReconstructionFilter::Type::gaussian:
    case ReconstructionFilter::Type::mitchell:
      break;
  }
  return f.radius;
}

// Standard deviations beyond which a Gaussian is 0 to any precision.
constexpr double kGaussianReach = 39.0;

bool is_narrow_gaussian(const ReconstructionFilter& f) {
  return f.type == ReconstructionFilter::Type::gaussian && kGaussianReach * f.stddev < f.radius;
}

// The radius in pixels beyond which the filter is 0; a Gaussian may be far narrower than its nominal radius.
double filter_reach(const ReconstructionFilter& f) {
  return is_narrow_gaussian(f) ? kGaussianReach * f.stddev : filter_radius(f);
}

// exp(−x²/2σ²) − exp(−r²/2σ²), up to a factor, at x = u · reach: as a product, so that nothing cancels if σ is much
// larger than r.
double gaussian(const ReconstructionFilter& f, double u) {
  if (is_narrow_gaussian(f)) return std::exp(-0.5 * kGaussianReach * kGaussianReach * u * u);
  const double s = 0.5 * (f.radius / f.stddev) * (f.radius / f.stddev);
  return std::exp(-u * u * s) * (s > 0.0 ? -std::expm1((u * u - 1.0) * s) / s : 1.0 - u * u);
}

// [Mitchell1988, eq. 8] on [0, 2].
double mitchell(double x, double b, double c) {
  if (x < 1.0) return ((12 - 9 * b - 6 * c) * x * x * x + (-18 + 12 * b + 6 * c) * x * x + (6 - 2 * b)) / 6.0;
  if (x < 2.0)
    return ((-b - 6 * c) * x * x * x + (6 * b + 30 * c) * x * x + (-12 * b - 48 * c) * x + (8 * b + 24 * c)) / 6.0;
  return 0.0;
}

// The sinc function under the middle lobe of a wider one [Turkowski1990].
double lanczos(double x, double lobes) {
  const auto sinc = [](double t) { return t < 1e-9 ? 1.0 : std::sin(std::numbers::pi * t) / (std::numbers::pi * t); };
  return sinc(x) * sinc(x / lobes);
}

// The filter at u · reach, with u in [−1, 1], up to a factor.
double filter_value(const ReconstructionFilter& f, double u) {
  u = std::abs(u);
  switch (f.type) {
    case ReconstructionFilter::Type::tent:
      return 1.0 - u;
    case ReconstructionFilter::Type::gaussian:
      return gaussian(f, u);
    case ReconstructionFilter::Type::mitchell:
      return mitchell(2.0 * u, f.b, f.c);
    case ReconstructionFilter::Type::lanczos:
      return lanczos(u * f.lobes, f.lobes);
    case ReconstructionFilter::Type::box:
      return 1.0;
  }
  return 0.0;
}

// Where the filter becomes negative, as a fraction of its reach; 1 if it never does.
double find_zero(const ReconstructionFilter& f) {
  double positive = 0.0, negative = 1.0;
  for (int i = 1; i < kIntegrationSteps; ++i) {
    const double u = static_cast<double>(i) / kIntegrationSteps;
    if (filter_value(f, u) < 0.0) {
      negative = u;
      positive = static_cast<double>(i - 1) / kIntegrationSteps;
      break;
    }
  }
  if (negative == 1.0) return 1.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (positive + negative);
    (filter_value(f, middle) < 0.0 ? negative : positive) = middle;
  }
  return negative;
}

}  // namespace

FilterTable make_filter_table(const ReconstructionFilter& f) {
  FilterTable table;
  if (f.type == ReconstructionFilter::Type::box && f.stretch == 1.0) return table;
  const double reach = filter_reach(f);
  constexpr double kStep = 2.0 / kIntegrationSteps;
  std::vector<double> cdf(kIntegrationSteps + 1, 0.0);
  double signed_sum = 0.0;
  for (int i = 0; i < kIntegrationSteps; ++i) {
    const double value = filter_value(f, -1.0 + (i + 0.5) * kStep);
    cdf[i + 1] = cdf[i] + std::abs(value);
    signed_sum += value;
  }
  table.weight = cdf.back() / signed_sum;
  table.alternates = f.type == ReconstructionFilter::Type::lanczos;
  const double zero = table.alternates ? 1.0 : find_zero(f);
  table.zero = zero * reach;
  table.turns_negative = zero < 1.0;
  int cell = 0;
  for (gpu::uint i = 0; i <= gpu::kFilterSteps; ++i) {
    const double target = cdf.back() * i / gpu::kFilterSteps;
    while (cell + 1 < kIntegrationSteps && cdf[cell + 1] < target) ++cell;
    const double width = cdf[cell + 1] - cdf[cell];
    const double inside = width > 0.0 ? (target - cdf[cell]) / width : 0.0;
    table.knots.push_back(static_cast<float>(reach * (-1.0 + (cell + inside) * kStep)));
  }
  table.knots.front() = static_cast<float>(-reach);
  table.knots.back() = static_cast<float>(reach);
  return table;
}

}  // namespace etendue
