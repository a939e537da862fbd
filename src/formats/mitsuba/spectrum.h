#pragma once
/// Spectra as linear Rec. 709 colours, the way Mitsuba's variants with RGB do it, so that a scene means the same here.

#include <vector>

#include <glm/glm.hpp>

namespace etendue {

/// What a spectrum is of. Reflectances and indices of refraction are seen under D65, so that flat ones are grey; a
/// reflectance has no component outside [0, 1]. Emission is seen as it is: where it is flat it has the colour of equal
/// energy, which is reddish next to D65.
enum class SpectrumUse { reflectance, emission, index };

struct SpectrumPoint {
  double wavelength;  ///< nm
  double value;
};

/// The colour of a spectrum that is linear between its points, ascending in wavelength, and zero outside them. Seen by
/// the CIE 1931 observer [CIE2018].
glm::dvec3 to_rec709(const std::vector<SpectrumPoint>& points, SpectrumUse use);

/// The colour of a spectrum that is `value` everywhere.
glm::dvec3 to_rec709(double value, SpectrumUse use);

/// Rec. 709 of a component in sRGB's encoding, in [0, 1] (IEC 61966-2-1).
double linear_of_srgb(double encoded);

}  // namespace etendue
