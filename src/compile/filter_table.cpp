#include "compile/filter_table.h"

#include <cmath>

#include "gpu_types.h"

namespace etendue {
namespace {

constexpr int kIntegrationSteps = 1 << 16;  // midpoint rule over the support: relative error below 1e-9

double filter_radius(const ReconstructionFilter& f) {
  return f.type == ReconstructionFilter::Type::tent ? 1.0 : f.radius;
}

// [Mitchell1988, eq. 8] on [0, 2].
double mitchell(double x, double b, double c) {
  if (x < 1.0) return ((12 - 9 * b - 6 * c) * x * x * x + (-18 + 12 * b + 6 * c) * x * x + (6 - 2 * b)) / 6.0;
  if (x < 2.0)
    return ((-b - 6 * c) * x * x * x + (6 * b + 30 * c) * x * x + (-12 * b - 48 * c) * x + (8 * b + 24 * c)) / 6.0;
  return 0.0;
}

double filter_value(const ReconstructionFilter& f, double x) {
  x = std::abs(x);
  switch (f.type) {
    case ReconstructionFilter::Type::tent:
      return std::max(0.0, 1.0 - x);
    case ReconstructionFilter::Type::gaussian: {
      const double k = -1.0 / (2.0 * f.stddev * f.stddev);
      return std::max(0.0, std::exp(k * x * x) - std::exp(k * f.radius * f.radius));
    }
    case ReconstructionFilter::Type::mitchell:
      return mitchell(2.0 * x / f.radius, f.b, f.c);
    case ReconstructionFilter::Type::box:
      return x <= 0.5 ? 1.0 : 0.0;
  }
  return 0.0;
}

// Where the filter turns negative; its radius when it does not.
double find_zero(const ReconstructionFilter& f) {
  const double radius = filter_radius(f);
  double positive = 0.0, negative = radius;
  for (int i = 1; i < kIntegrationSteps; ++i) {
    const double x = radius * i / kIntegrationSteps;
    if (filter_value(f, x) < 0.0) {
      negative = x;
      positive = radius * (i - 1) / kIntegrationSteps;
      break;
    }
  }
  if (negative == radius) return radius;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (positive + negative);
    (filter_value(f, middle) < 0.0 ? negative : positive) = middle;
  }
  return negative;
}

}  // namespace

FilterTable make_filter_table(const ReconstructionFilter& f) {
  FilterTable table;
  if (f.type == ReconstructionFilter::Type::box) return table;
  const double radius = filter_radius(f);
  const double h = 2.0 * radius / kIntegrationSteps;
  std::vector<double> cdf(kIntegrationSteps + 1, 0.0);
  double signed_sum = 0.0;
  for (int i = 0; i < kIntegrationSteps; ++i) {
    const double value = filter_value(f, -radius + (i + 0.5) * h);
    cdf[i + 1] = cdf[i] + std::abs(value);
    signed_sum += value;
  }
  table.weight = cdf.back() / signed_sum;
  table.zero = find_zero(f);
  table.has_negative_lobes = table.zero < radius;
  int cell = 0;
  for (gpu::uint i = 0; i <= gpu::kFilterSteps; ++i) {
    const double target = cdf.back() * i / gpu::kFilterSteps;
    while (cell + 1 < kIntegrationSteps && cdf[cell + 1] < target) ++cell;
    const double width = cdf[cell + 1] - cdf[cell];
    const double inside = width > 0.0 ? (target - cdf[cell]) / width : 0.0;
    table.knots.push_back(static_cast<float>(-radius + (cell + inside) * h));
  }
  table.knots.front() = static_cast<float>(-radius);
  table.knots.back() = static_cast<float>(radius);
  return table;
}

}  // namespace etendue
