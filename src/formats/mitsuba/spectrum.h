#pragma once
/// Converts spectra to linear Rec. 709 as Mitsuba's RGB variants do, so that a scene has the same colours here.

#include <vector>

#include <glm/glm.hpp>

namespace etendue {

/// What a spectrum describes. Reflectances and indices of refraction are converted under D65, so flat ones are grey;
/// reflectances are clamped to [0, 1]. Emission is converted as it is: a flat one has the colour of equal energy, which
/// is reddish compared with D65.
enum class SpectrumUse { reflectance, emission, index };

struct SpectrumPoint {
  double wavelength;  ///< nm
  double value;
};

/// The colour, for the CIE 1931 observer [CIE2018], of a spectrum that is linear between its points and zero outside
/// them. Wavelengths ascend.
glm::dvec3 to_rec709(const std::vector<SpectrumPoint>& points, SpectrumUse use);

/// The colour of a spectrum that is `value` everywhere.
glm::dvec3 to_rec709(double value, SpectrumUse use);

/// Decodes an sRGB component in [0, 1] to linear Rec. 709 (IEC 61966-2-1).
double linear_of_srgb(double encoded);

}  // namespace etendue
