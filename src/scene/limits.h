#pragma once
/// Limits on scenes, whatever made them: a reader, a test, a program that uses the library.

#include <cstddef>
#include <cstdint>

namespace etendue {

/// Largest |coordinate| of a point in world space: beyond it, squared areas overflow single precision.
inline constexpr double kMaxCoordinate = 1e9;
/// Maximum number of samples of each kind that the integrator `direct` takes at a surface.
inline constexpr std::uint32_t kMaxDirectSamples = 1024;
/// Largest radiance component: leaves room for path weights in single precision.
inline constexpr double kMaxRadiance = 1e20;
/// Smallest non-zero emission: below it single precision loses digits and then the light.
inline constexpr double kMinRadiance = 1e-20;
/// Maximum half angle of a textured spot's cone, degrees; maximum slope of the edge of a projector's picture.
inline constexpr double kMaxTexturedCutoff = 89.0;
inline constexpr double kMaxSlope = 1000.0;
/// Largest width · height: the exact sums of this many pixels take 8 GiB.
inline constexpr std::int64_t kMaxPixels = std::int64_t{1} << 26;
/// Smallest roughness of microfacets: single precision resolves no narrower lobe.
inline constexpr double kMinRoughness = 1e-3;
/// Maximum number of nested adapters around a material.
inline constexpr std::uint32_t kMaxAdapterDepth = 16;
/// Smallest relative difference of the indices on both sides of a rough dielectric: without any, light is not
/// refracted.
inline constexpr double kMinIndexContrast = 1e-3;
/// Largest relative index of the coat of a plastic.
inline constexpr double kMaxCoatIndex = 10.0;
/// Smallest colour of a volume: its logarithm is finite.
inline constexpr double kMinAttenuation = 1e-6;
/// Largest factor for a reflectance at normal incidence.
inline constexpr double kMaxSpecularColor = 100.0;
/// Largest dispersion in glTF, 20 divided by the Abbe number: 20 / 1.
inline constexpr double kMaxDispersion = 20.0;
/// Largest index and thickness (nanometres) of an iridescent film.
inline constexpr double kMaxFilmIndex = 10.0;
inline constexpr double kMaxFilmThickness = 10000.0;
/// Largest textured index of refraction.
inline constexpr double kMaxTexturedIndex = 1000.0;
/// Largest part of a metal's complex index of refraction.
inline constexpr double kMaxConductorIndex = 1000.0;
/// Triangles and vertices, of one mesh and of all meshes of a scene together.
inline constexpr std::size_t kMaxTriangles = std::size_t{1} << 25;
inline constexpr std::size_t kMaxVertices = std::size_t{1} << 25;

/// Maximum number of textures in a scene; kernels store their indices in 24 bits.
inline constexpr std::size_t kMaxTextures = std::size_t{1} << 24;
/// Checkerboards and what stands in their squares, one in the other.
inline constexpr std::uint32_t kMaxNestedTextures = 8;
/// Largest |texture coordinate| of a mesh, and entry of a texture's transform: their products stay finite in single
/// precision.
inline constexpr double kMaxTextureCoordinate = 1e9;

/// Maximum number of lobes of a Lanczos filter: each of them is at most 1/32 of the table that is used for sampling.
inline constexpr std::uint32_t kMaxFilterLobes = 16;

}  // namespace etendue
