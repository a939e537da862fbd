#include "formats/dialect/daylight.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "formats/mitsuba/spectrum.h"
#include "image/vectors.h"

namespace etendue {
namespace {

/// cd/m² of a unit of radiance: lumens per watt times the integral of the CIE observer's ȳ in nm.
constexpr double kCandelas = 683.0 * 106.856895;
/// Half the angle that the sun subtends, in radians.
constexpr double kSunRadius = 0.2665 * kPi / 180.0;

/// Perez's coefficients are linear in the turbidity.
struct Perez {
  double a, b, c, d, e;

  double operator()(double cos_theta, double gamma) const {
    const double cos_gamma = std::cos(gamma);
    return (1.0 + a * std::exp(b / cos_theta)) * (1.0 + c * std::exp(d * gamma) + e * cos_gamma * cos_gamma);
  }
};

Perez luminance_of(double t) {
  return {0.17872 * t - 1.46303, -0.35540 * t + 0.42749, -0.02266 * t + 5.32505, 0.12064 * t - 2.57705,
          -0.06696 * t + 0.37027};
}
Perez x_of(double t) {
  return {-0.01925 * t - 0.25922, -0.06651 * t + 0.00081, -0.00041 * t + 0.21247, -0.06409 * t - 0.89887,
          -0.00325 * t + 0.04517};
}
Perez y_of(double t) {
  return {-0.01669 * t - 0.26078, -0.09495 * t + 0.00921, -0.00792 * t + 0.21023, -0.04405 * t - 1.65369,
          -0.01092 * t + 0.05291};
}

double zenith_luminance(double t, double theta_sun) {  // cd/m²
  const double chi = (4.0 / 9.0 - t / 120.0) * (kPi - 2.0 * theta_sun);
  return 1000.0 * ((4.0453 * t - 4.9710) * std::tan(chi) - 0.2155 * t + 2.4192);
}

/// Polynomials in the sun's angle, whose coefficients are polynomials in the turbidity.
double zenith_chromaticity(const std::array<std::array<double, 4>, 3>& m, double t, double theta) {
  const auto row = [&](const std::array<double, 4>& r) {
    return ((r[0] * theta + r[1]) * theta + r[2]) * theta + r[3];
  };
  return (row(m[0]) * t + row(m[1])) * t + row(m[2]);
}
constexpr std::array<std::array<double, 4>, 3> kZenithX{
    {{0.00166, -0.00375, 0.00209, 0.0}, {-0.02903, 0.06377, -0.03202, 0.00394}, {0.11693, -0.21196, 0.06052, 0.25886}}};
constexpr std::array<std::array<double, 4>, 3> kZenithY{
    {{0.00275, -0.00610, 0.00317, 0.0}, {-0.04214, 0.08970, -0.04153, 0.00516}, {0.15346, -0.26756, 0.06670, 0.26688}}};

/// IEC 61966-2-1; colours outside the gamut lose their negative parts.
glm::dvec3 rec709_of(double luminance, double x, double y) {
  const glm::dvec3 xyz(x / y * luminance, luminance, (1.0 - x - y) / y * luminance);
  const glm::dvec3 rgb(3.240479 * xyz.x - 1.537150 * xyz.y - 0.498535 * xyz.z,
                       -0.969256 * xyz.x + 1.875991 * xyz.y + 0.041556 * xyz.z,
                       0.055648 * xyz.x - 0.204043 * xyz.y + 1.057311 * xyz.z);
  return glm::max(rgb, glm::dvec3(0.0));
}

struct Entry {
  double wavelength, value;  ///< nm
};

/// Linear between entries, 0 outside.
double at(std::span<const Entry> table, double wavelength) {
  const auto next = std::ranges::upper_bound(table, wavelength, {}, &Entry::wavelength);
  if (next == table.begin() || next == table.end()) return 0.0;
  const Entry& a = *(next - 1);
  return a.value + (next->value - a.value) * (wavelength - a.wavelength) / (next->wavelength - a.wavelength);
}

/// Tables 2 of [Preetham1999]: radiance of the sun outside of the atmosphere, 100 W·m⁻²·sr⁻¹·nm⁻¹, from 380 nm on in
/// steps of 10 nm; absorption by ozone and water vapour, cm⁻¹, and by mixed gases, km⁻¹.
constexpr std::array<double, 38> kSun{165.5, 162.3, 211.2, 258.8, 258.2, 242.3, 267.6, 296.6, 305.4, 300.6,
                                      306.6, 288.3, 287.1, 278.2, 271.0, 272.3, 263.6, 255.0, 250.6, 253.1,
                                      253.5, 251.3, 246.3, 241.7, 236.8, 232.1, 228.2, 223.4, 219.7, 215.3,
                                      211.0, 207.3, 202.4, 198.7, 194.3, 190.7, 186.3, 182.6};
constexpr Entry kOzone[] = {
    {355, 0.0},   {445, 0.003}, {450, 0.003}, {455, 0.004}, {460, 0.006}, {465, 0.008}, {470, 0.009}, {475, 0.012},
    {480, 0.014}, {485, 0.017}, {490, 0.021}, {495, 0.025}, {500, 0.03},  {505, 0.035}, {510, 0.04},  {515, 0.045},
    {520, 0.048}, {525, 0.057}, {530, 0.063}, {535, 0.07},  {540, 0.075}, {545, 0.08},  {550, 0.085}, {555, 0.095},
    {560, 0.103}, {565, 0.110}, {570, 0.12},  {575, 0.122}, {580, 0.12},  {585, 0.118}, {590, 0.115}, {595, 0.12},
    {600, 0.125}, {605, 0.130}, {610, 0.12},  {620, 0.105}, {630, 0.09},  {640, 0.079}, {650, 0.067}, {660, 0.057},
    {670, 0.048}, {680, 0.036}, {690, 0.028}, {700, 0.023}, {710, 0.018}, {720, 0.014}, {730, 0.011}, {740, 0.010},
    {750, 0.009}, {760, 0.007}, {770, 0.004}, {780, 0.0}};
constexpr Entry kGases[] = {{759, 0.0}, {760, 3.0}, {770, 0.21}, {771, 0.0}};
constexpr Entry kWater[] = {{689, 0.0},  {690, 0.016}, {700, 0.024}, {710, 0.0125}, {720, 1.0},
                            {730, 0.87}, {740, 0.061}, {750, 0.001}, {760, 1e-5},   {770, 1e-5}};

/// Fraction of light of one wavelength, in micrometres for the powers, transmitted by `m` atmospheres.
double transmittance(double wavelength, double m, double turbidity) {
  const double micrometres = wavelength / 1000.0, beta = 0.04608 * turbidity - 0.04586;
  const double rayleigh = std::exp(-0.008735 * std::pow(micrometres, -4.08) * m);
  const double aerosol = std::exp(-beta * std::pow(micrometres, -1.3) * m);
  constexpr double kOzoneLength = 0.35, kWaterLength = 2.0;  // cm
  const double ozone = std::exp(-at(kOzone, wavelength) * kOzoneLength * m);
  const double g = at(kGases, wavelength), w = at(kWater, wavelength);
  const double gases = std::exp(-1.41 * g * m / std::pow(1.0 + 118.93 * g * m, 0.45));
  const double water = std::exp(-0.2385 * w * kWaterLength * m / std::pow(1.0 + 20.07 * w * kWaterLength * m, 0.45));
  return rayleigh * aerosol * ozone * gases * water;
}

/// The direction for a position in the picture, in texels from its upper left corner.
glm::dvec3 direction_at(double x, double y, std::uint32_t width, std::uint32_t height) {
  const double phi = 2.0 * kPi * x / width, theta = kPi * y / height;
  return {std::sin(theta) * std::sin(phi), std::cos(theta), -std::sin(theta) * std::cos(phi)};
}

double solid_angle(std::uint32_t row, std::uint32_t width, std::uint32_t height) {
  return 2.0 * kPi / width * (std::cos(kPi * row / height) - std::cos(kPi * (row + 1.0) / height));
}

/// Adds the sun, distributed over the texels by the area it covers in each, preserving its irradiance.
void add_sun(const Daylight& daylight, std::vector<glm::dvec3>& texels, std::uint32_t width, std::uint32_t height) {
  constexpr int kSteps = 16;  // positions tested in a texel, per axis
  const double radius = std::min(daylight.sun_radius * kSunRadius, 0.25 * kPi);
  const double reach = radius + 1.5 * kPi / height;
  std::vector<std::pair<std::size_t, double>> covered;  // texel, and how much of it
  double sum = 0.0;
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      if (glm::dot(direction_at(x + 0.5, y + 0.5, width, height), daylight.sun) < std::cos(reach)) continue;
      int inside = 0;
      for (int i = 0; i < kSteps * kSteps; ++i) {
        const double u = x + (i % kSteps + 0.5) / kSteps, v = y + (i / kSteps + 0.5) / kSteps;
        inside += glm::dot(direction_at(u, v, width, height), daylight.sun) > std::cos(radius) ? 1 : 0;
      }
      if (inside == 0) continue;
      covered.emplace_back(std::size_t{y} * width + x, static_cast<double>(inside) / (kSteps * kSteps));
      sum += covered.back().second * solid_angle(y, width, height);
    }
  }
  if (covered.empty()) {  // the sun is smaller than the spacing of the positions
    const double phi = std::atan2(daylight.sun.x, -daylight.sun.z), theta = std::acos(daylight.sun.y);
    const auto x = static_cast<std::uint32_t>((phi < 0.0 ? phi + 2.0 * kPi : phi) / (2.0 * kPi) * width) % width;
    const std::uint32_t y = std::min(static_cast<std::uint32_t>(theta / kPi * height), height - 1);
    covered.emplace_back(std::size_t{y} * width + x, 1.0);
    sum = solid_angle(y, width, height);
  }
  const glm::dvec3 radiance = daylight.sun_scale * sun_irradiance(daylight) / sum;
  for (const auto& [texel, share] : covered) texels[texel] += share * radiance;
}

/// Below the horizon there is a matt ground, lit by the sky and the sun.
void add_ground(const Daylight& daylight, std::vector<glm::dvec3>& texels, std::uint32_t width, std::uint32_t height) {
  glm::dvec3 irradiance(0.0);
  for (std::uint32_t y = 0; y < height / 2; ++y) {
    const double cosine = std::cos(kPi * (y + 0.5) / height);
    for (std::uint32_t x = 0; x < width; ++x)
      irradiance += texels[std::size_t{y} * width + x] * cosine * solid_angle(y, width, height);
  }
  std::fill(texels.begin() + std::size_t{height / 2} * width, texels.end(), daylight.ground_albedo / kPi * irradiance);
}

}  // namespace

glm::dvec3 sky_radiance(const Daylight& daylight, const glm::dvec3& w) {
  const double t = daylight.turbidity, theta_sun = std::acos(std::clamp(daylight.sun.y, 0.0, 1.0));
  const double gamma = std::acos(std::clamp(glm::dot(w, daylight.sun), -1.0, 1.0));
  // At the horizon, the model's exponent is unbounded.
  const double cosine = std::max(w.y, 1e-3);
  const auto value = [&](double zenith, const Perez& f) { return zenith * f(cosine, gamma) / f(1.0, theta_sun); };
  const double luminance = value(zenith_luminance(t, theta_sun), luminance_of(t)) / kCandelas;
  return rec709_of(std::max(luminance, 0.0), value(zenith_chromaticity(kZenithX, t, theta_sun), x_of(t)),
                   value(zenith_chromaticity(kZenithY, t, theta_sun), y_of(t)));
}

glm::dvec3 sun_radiance(const Daylight& daylight) {
  const double theta = std::acos(std::clamp(daylight.sun.y, 0.0, 1.0));
  const double m = 1.0 / (std::cos(theta) + 0.15 * std::pow(93.885 - theta * 180.0 / kPi, -1.253));
  std::vector<SpectrumPoint> points;
  for (std::size_t i = 0; i < kSun.size(); ++i) {
    const double wavelength = 380.0 + 10.0 * static_cast<double>(i);
    points.push_back({wavelength, 100.0 * kSun[i] * transmittance(wavelength, m, daylight.turbidity)});
  }
  return glm::max(to_rec709(points, SpectrumUse::emission), glm::dvec3(0.0));
}

glm::dvec3 sun_irradiance(const Daylight& daylight) {
  const double sine = std::sin(kSunRadius);
  return kPi * sine * sine * sun_radiance(daylight);
}

std::shared_ptr<const Bitmap> make_daylight(const Daylight& daylight) {
  const std::uint32_t width = daylight.width, height = width / 2;
  std::vector<glm::dvec3> texels(std::size_t{width} * height, glm::dvec3(0.0));
  if (daylight.sky_scale > 0.0) {
    parallel_for(height / 2, 8, [&](std::uint64_t begin, std::uint64_t end) {
      for (std::uint64_t y = begin; y < end; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
          const glm::dvec3 w = direction_at(x + 0.5, static_cast<double>(y) + 0.5, width, height);
          texels[y * width + x] = daylight.sky_scale * sky_radiance(daylight, w);
        }
      }
    });
  }
  if (daylight.sun_scale > 0.0) add_sun(daylight, texels, width, height);
  add_ground(daylight, texels, width, height);
  Bitmap bitmap{.width = width,
                .height = height,
                .channels = 3,
                .format = BitmapFormat::f32,
                .color_space = ColorSpace::linear,
                .texels = std::vector<std::byte>(texels.size() * sizeof(glm::vec3)),
                .notes = {}};
  for (std::size_t i = 0; i < texels.size(); ++i) {
    const glm::vec3 texel(texels[i]);
    std::memcpy(&bitmap.texels[i * sizeof texel], &texel, sizeof texel);
  }
  return std::make_shared<const Bitmap>(std::move(bitmap));
}

glm::dvec3 sun_direction(const PlaceAndTime& place) {
  const double degree = kPi / 180.0, j = place.day_of_year;
  // Degrees of longitude between the place and the middle of its time zone are four minutes each.
  const double solar_time = place.hour + 0.170 * std::sin(4.0 * kPi * (j - 80.0) / 373.0) -
                            0.129 * std::sin(2.0 * kPi * (j - 8.0) / 355.0) +
                            (place.longitude - 15.0 * place.timezone) / 15.0;
  const double declination = 0.4093 * std::sin(2.0 * kPi * (j - 81.0) / 368.0);
  const double hour_angle = kPi * (solar_time - 12.0) / 12.0, l = place.latitude * degree;
  const double east = -std::cos(declination) * std::sin(hour_angle);
  const double north = std::cos(l) * std::sin(declination) - std::sin(l) * std::cos(declination) * std::cos(hour_angle);
  const double up = std::sin(l) * std::sin(declination) + std::cos(l) * std::cos(declination) * std::cos(hour_angle);
  return glm::normalize(glm::dvec3(east, up, -north));
}

}  // namespace etendue
