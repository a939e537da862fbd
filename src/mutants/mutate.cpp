#include "mutants/mutate.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <limits>
#include <map>
#include <memory>
#include <optional>

#include <fmt/format.h>
#include <glm/gtc/constants.hpp>

#include "core/errors.h"
#include "gpu/bsdf_probe.h"
#include "image/film.h"
#include "kernels_mutant.h"
#include "kernels_plain_mutant.h"
#include "mutants.h"
#include "reference/material_probe.h"
#include "reference/reference_renderer.h"
#include "scene/test_patch.h"
#include "validate/chi2.h"
#include "validate/closed_form.h"
#include "validate/image_tests.h"
#include "validate/sphere_quadrature.h"
#include "validate/statistics.h"

namespace etendue {
namespace {

constexpr std::array<Mutant, gpu::kMutantCount> kMutants{{
    {gpu::kMutantNone, "none", "no error: nothing may be found", ""},
    {gpu::kMutantCosineDropped, "cosine dropped",
     "a diffuse surface reflects f instead of f·cos θ when lights are sampled", "direct light, 0"},
    {gpu::kMutantBsdfPdfScaled, "material pdf 2 % off",
     "the density of diffuse sampling is 2 % too large, its weight follows", "furnace"},
    {gpu::kMutantLightPdfScaled, "light pdf 2 % off", "the density of light sampling is 2 % too large",
     "direct light, 0"},
    {gpu::kMutantRouletteUncompensated, "roulette uncompensated",
     "paths that survive roulette do not compensate for those that ended", "furnace"},
    {gpu::kMutantEmissionTwice, "emission counted twice",
     "emission hit by chance counts in full although lights are sampled", "direct light, 0"},
    {gpu::kMutantLightChoiceForgotten, "light choice forgotten",
     "the probability of choosing the light is missing from its density",
     "direct light, 3 polygon(s), 2 sphere(s), 1 turned away, 2 hidden, nee"},
    {gpu::kMutantFresnelSwapped, "Fresnel swapped", "glass reflects what it should refract", "refracting sheet"},
    {gpu::kMutantEtaOmitted, "η² omitted", "radiance is not scaled on refraction", "refracting sheet"},
    {gpu::kMutantShadowRayTooLong, "shadow ray too long", "the shadow ray reaches the light itself", "direct light, 0"},
    {gpu::kMutantEmitterTwoSided, "emitter two-sided", "lights shine from their backs too",
     "direct light, 3 polygon(s), 2 sphere(s), 1 turned away, 2 hidden, nee"},
    {gpu::kMutantDepthOffByOne, "depth off by one", "paths have one segment more than maxDepth", "furnace"},
    {gpu::kMutantDimensionReused, "dimension reused", "every vertex samples its material with the numbers of the first",
     "refracting sphere"},
    {gpu::kMutantJitterMissing, "jitter missing", "every camera ray goes through the pixel's centre", "rectangle"},
    {gpu::kMutantEtaInverted, "η² inverted", "radiance is scaled by the inverse of the right factor",
     "refracting sheet"},
    {gpu::kMutantShadowsIgnored, "shadows ignored", "sampled lights are never hidden",
     "direct light, 3 polygon(s), 2 sphere(s), 1 turned away, 2 hidden, nee"},
    {gpu::kMutantSkyMirrored, "sky upside down", "the sky's gradient is mirrored at the horizon", "mirroring"},
    {gpu::kMutantBlackSideLit, "black side lit", "a diffuse surface is lit from behind when lights are sampled",
     "direct light, 3 polygon(s), 2 sphere(s), 1 turned away, 2 hidden, nee"},
    {gpu::kMutantMisChoiceForgotten, "MIS forgets the choice",
     "the weight of light hit by chance leaves out the choice of the light",
     "direct light, 3 polygon(s), 2 sphere(s), 1 turned away, 2 hidden, mis"},
    {gpu::kMutantMisHeuristicsMixed, "MIS heuristics mixed",
     "one strategy is weighted by the balance heuristic, the other by the power heuristic",
     "direct light, 1 polygon(s), 0 sphere(s), 0 turned away, 0 hidden, mis"},
    {gpu::kMutantTriangleChoiceForgotten, "triangle choice forgotten",
     "the probability of the triangle within its mesh is missing",
     "direct light, 3 polygon(s), 2 sphere(s), 1 turned away, 2 hidden, nee"},
    {gpu::kMutantTriangleRootDropped, "triangle warp without root", "points crowd toward one corner of a triangle",
     "direct light, 1 polygon(s)"},
    {gpu::kMutantDistanceNotSquared, "distance not squared", "area turns into solid angle with d instead of d²",
     "direct light, 1 polygon(s)"},
    {gpu::kMutantConeTooWide, "cone 5 % too wide", "spheres are sampled in a cone wider than the one they subtend",
     "direct light, 0"},
    {gpu::kMutantHemisphereUniform, "uniform hemisphere",
     "directions are uniform over the hemisphere, weighted as if cosine-distributed", "chi2, diffuse"},
    {gpu::kMutantMirrorHalfTurned, "mirror half turned", "a mirror turns only one tangential component",
     "chi2, mirror"},
    {gpu::kMutantSnellIgnored, "no bending", "refracted rays go straight on", "chi2, dielectric"},
    {gpu::kMutantFilterSignDropped, "filter sign dropped", "negative lobes of a filter count as positive",
     "rectangle in a pixel, mitchell"},
    {gpu::kMutantNumbersEqual, "u equals v", "pairs of random numbers are the same number twice",
     "direct light, 1 polygon(s)"},
    {gpu::kMutantSampleIndexIgnored, "sample index ignored", "every sample of a pixel uses the same random numbers",
     "direct light, 3 polygon(s), 2 sphere(s), 1 turned away, 2 hidden, nee"},
    {gpu::kMutantEmissionAfterDeltaLost, "emission after mirror lost",
     "lights seen in mirrors are black when lights are sampled", "mirror sphere"},
    {gpu::kMutantScramblingMissing, "scrambling missing", "Sobol points are not scrambled", "crowd"},
    {gpu::kMutantDimensionsPaired, "Sobol dimensions equal", "all four numbers of a Sobol point are the first",
     "crowd"},
    {gpu::kMutantTreeShareForgotten, "tree forgets a turn",
     "the probability of the last turn in the light tree is missing", "crowd"},
    {gpu::kMutantTreeCullsTooMuch, "tree culls too much", "groups of lights near the horizon are left out", "crowd"},
    {gpu::kMutantTreeMisForgotten, "tree MIS by power",
     "the weight of light hit by chance forgets the tree's first turn", "crowd"},
    {gpu::kMutantPlaneTooWide, "plane too wide",
     "the plane on which rays of a distant camera begin is a tenth too wide", "far rectangle"},
    {gpu::kMutantStretchForgotten, "roughness forgotten",
     "normals of microfacets are sampled as if the roughness were 1", "chi2, roughconductor"},
    {gpu::kMutantConductorNormalIncidence, "metal by normal incidence",
     "a metal reflects the same at all angles as at normal incidence", "chi2, conductor"},
    {gpu::kMutantShadowingForgotten, "shadowing forgotten",
     "microfacets are masked toward the eye but not toward the light", "albedo, roughconductor"},
    {gpu::kMutantFacetFresnelAtNormal, "Fresnel at the surface's normal",
     "microfacets reflect by the angle to the normal of the surface instead of their own", "albedo, microfacet"},
    {gpu::kMutantFacetPdfUnmasked, "facet pdf unmasked",
     "the density is that of all microfacets, while only visible ones are sampled", "chi2, roughconductor"},
    {gpu::kMutantSampleCountsForgotten, "sample counts forgotten",
     "several light samples count as if each were the only one", "direct light, 3"},
    {gpu::kMutantSimpleCosineDropped, "cosine of simple dropped", "a surface lit by a point ignores its slope",
     "floor lit by a point"},
    {gpu::kMutantOcclusionWarpsSwapped, "ao and av swapped",
     "ambient occlusion weights all directions equally, average visibility by their cosine", "ao under"},
    {gpu::kMutantOcclusionEndless, "occlusion without end", "rays of ao and av are infinite", "av under"},
    {gpu::kMutantHiddenEmittersOpaque, "hidden emitters opaque", "emitters hidden from the camera are black",
     "floor seen"},
    {gpu::kMutantInstanceNormalMatrix, "instance normals as points",
     "vertex normals of instances are transformed by the matrix for positions", "picture of instances"},
    {gpu::kMutantInstanceAreaNotScaled, "instance areas not scaled",
     "the density of lights on instances is that of the mesh in its own space", "picture of instances"},
    {gpu::kMutantInstanceRayNormalised, "instance rays normalised",
     "the direction is normalised in object space, so distances are those of another space", "picture of instances"},
    {gpu::kMutantInstanceSideLost, "mirrored instance inside out",
     "vertex normals of mirrored instances are on the other side", "picture of instances"},
    {gpu::kMutantInstanceNotLeft, "instance not left",
     "behind an instance a ray hits the world as seen from object space", "picture of instances"},
    {gpu::kMutantLensTooWide, "lens too wide", "points of the lens are 2 % too far from its centre",
     "circle of confusion, 0"},
    {gpu::kMutantBladesIgnored, "blades ignored", "a polygonal aperture is a disk", "circle of confusion, 3"},
    {gpu::kMutantPanoramaEven, "panorama by the square", "the rows of a panorama crowd toward its upper edge",
     "panorama"},
    {gpu::kMutantEnvironmentSineForgotten, "sine forgotten",
     "the density of the environment is that of a picture whose rows all have the same solid angle", "picture sky"},
    {gpu::kMutantEnvironmentUpsideDown, "picture upside down", "the rows of the environment's picture are swapped",
     "picture sky"},
    {gpu::kMutantEnvironmentShifted, "picture shifted", "the environment's picture is shifted by half a texel",
     "picture sky"},
    {gpu::kMutantEnvironmentTwice, "environment counted twice",
     "light from outside hit by chance counts in full although it is sampled", "picture sky"},
    {gpu::kMutantEnvironmentChoiceForgotten, "environment's choice forgotten",
     "the probability of choosing the environment is missing from its density", "picture sky"},
    {gpu::kMutantLightsShareForgotten, "lights' share forgotten",
     "the probability of choosing a light, not the environment, is missing from its density", "picture sky"},
    {gpu::kMutantSkyTurnedBack, "sky turned back",
     "directions are transformed into the sky's frame by the wrong matrix", "picture sky"},
    {gpu::kMutantDiskSquare, "square disk", "rays meet a disk's corners, too, as if it were a square",
     "picture of round shapes"},
    {gpu::kMutantDiskAreaOfASquare, "disk area of a square", "the density on a disk is that of the square around it",
     "picture of round shapes"},
    {gpu::kMutantCylinderHalfArea, "half a cylinder", "the density on a cylinder is that of half of it",
     "picture of round shapes"},
    {gpu::kMutantCylinderOutsideOnly, "cylinder from outside only",
     "a ray that passes over the near wall of a cylinder does not meet the far one", "picture of round shapes"},
    {gpu::kMutantHalfTexel, "half a texel off", "bilinear filtering takes corners of texels for their centres",
     "textures, lamp bilinear"},
    {gpu::kMutantRowsSwapped, "rows swapped", "pictures stand on their heads", "textures, lamp bilinear"},
    {gpu::kMutantWrapOffByOne, "wrap off by one", "a repeated picture's last texel is filtered with itself",
     "textures, lamp bilinear"},
    {gpu::kMutantUvTransformInverted, "uv transform inverted",
     "textures are transformed by the inverse of their transform", "textures, lamp bilinear"},
    {gpu::kMutantSrgbLeftOut, "sRGB left out", "codes of sRGB are taken for light", "textures, lamp bilinear"},
    {gpu::kMutantLightTextureIgnored, "light's texture ignored", "a sampled lamp shines as if it had no texture",
     "textures, lamp bilinear"},
    {gpu::kMutantPaneReflectsOnce, "pane reflects once", "a thin pane reflects with one of its faces only",
     "chi2, thindielectric"},
    {gpu::kMutantRefractionJacobian, "refraction's solid angle", "the density of refraction lacks η²",
     "chi2, roughdielectric"},
    {gpu::kMutantRoughEtaOmitted, "η² omitted in rough glass", "radiance is not scaled on rough refraction",
     "albedo, roughdielectric"},
    {gpu::kMutantInnerReflectionForgotten, "inner reflection forgotten",
     "light that the coat of a plastic reflects back inside is lost", "albedo, plastic"},
    {gpu::kMutantTransmittanceOnce, "coat passed once", "light enters a rough coat without loss",
     "albedo, roughplastic"},
    {gpu::kMutantDiskTurnReversed, "disk turned round", "a texture runs around a disk the wrong way",
     "picture of round shapes"},
    {gpu::kMutantCylinderUpsideDown, "cylinder upside down", "textures on cylinders are upside down",
     "picture of round shapes"},
    {gpu::kMutantSideByWinding, "side by winding",
     "the winding of a triangle decides its side where its vertex normals say otherwise", "picture of twins"},
    {gpu::kMutantTiesReversed, "ties reversed", "of coincident surfaces, the last one is hit", "picture of twins"},
    {gpu::kMutantPointDistanceNotSquared, "point's distance not squared",
     "light from a point falls off with the distance instead of its square", "points, 2"},
    {gpu::kMutantPointWeighed, "points weighed",
     "light from points is weighted against material samples, which never find it", "points, 2"},
    {gpu::kMutantSpotFadesByCosine, "spot fades by cosine", "a spot fades linearly in the cosine, not in the angle",
     "picture under points"},
    {gpu::kMutantProjectorByIntensity, "projector by intensity",
     "a projector's picture is used as intensity instead of irradiance of a plane", "picture under points"},
    {gpu::kMutantDistantChoiceForgotten, "direction's choice forgotten",
     "the probability of choosing a directional light is missing", "points, 1"},
    {gpu::kMutantSidesSwapped, "sides swapped", "a two-sided material shows its back in front", "chi2, adapters"},
    {gpu::kMutantBlendSwapped, "blend swapped", "a mixture exchanges the shares of its materials", "chi2, adapters"},
    {gpu::kMutantMaskShadowsAll, "masks cast full shadows", "shadow rays end at surfaces that light may pass",
     "adapters, floor d"},
    {gpu::kMutantMaskSidesTogether, "mask decided once", "both walls of a masked ball pass the same rays",
     "adapters, floor d"},
    {gpu::kMutantPassesFree, "passes not counted", "shadow rays pass surfaces regardless of the path's limit",
     "adapters, floor m(d)"},
    {gpu::kMutantNormalMapMirrored, "normal map mirrored", "a normal map's green channel counts backward",
     "chi2, adapters"},
    {gpu::kMutantRetroReflectionLost, "retro-reflection lost", "a rough base has no retro-reflection",
     "albedo, principled"},
    {gpu::kMutantAovFilterIgnored, "coverage without filter",
     "samples of coverage have equal weights whatever the filter", "aov alpha"},
    {gpu::kMutantAovSetSummed, "numbers summed",
     "every path of a set adds the number of what it hits, not only the first", "aov instance"},
    {gpu::kMutantAovOtherSample, "depth of another sample", "distances are measured along the ray of the next sample",
     "aov depth"},
    {gpu::kMutantAovEndsAtMirror, "albedo of the mirror", "albedo ends at mirrors and glass", "aov albedo"},
    {gpu::kMutantAovPlaceNotMoved, "position about the middle", "positions are relative to the middle of the scene",
     "aov position"},
    {gpu::kMutantLightPartLate, "indirect light late",
     "light that was scattered twice is missing from the indirect light", "indirect light of a furnace"},
    {gpu::kMutantBackgroundSeen, "background seen", "the camera sees a sky that is hidden", "hidden sky"},
    {gpu::kMutantSheetRoughnessUnscaled, "sheet as rough as a mirror",
     "a thin sheet spreads transmitted light as much as reflected light", "albedo, principledthin"},
    {gpu::kMutantSheetPassesTwice, "sheet passes twice as much",
     "a thin sheet transmits all of diff_trans instead of half", "albedo, principledthin"},
    {gpu::kMutantGltfCoatAdded, "coat added", "a clear coat takes no light from the layers below", "albedo, gltf"},
    {gpu::kMutantGltfBaseUndimmed, "base not dimmed",
     "the diffuse base of glTF's material also gets the light that its boundary reflects", "albedo, gltf"},
    {gpu::kMutantVolumeClear, "volume clear", "a coloured solid absorbs nothing", "picture of volumes"},
    {gpu::kMutantFilmShiftForgotten, "film's phase forgotten", "light reflected within a thin film keeps its phase",
     "albedo, film"},
    {gpu::kMutantBumpByTexel, "bumps by the texel", "slopes of a bump map are differences between texels",
     "picture of maps"},
    {gpu::kMutantMapsShineThrough, "maps shine through",
     "light from below a surface reaches it through its turned normals", "picture of maps"},
    {gpu::kMutantCoatUnmasked, "coat unmasked", "the coat's microfacets do not hide each other", "albedo, coat"},
    {gpu::kMutantMixtureHalfWhole, "half of a mixture whole",
     "the half of a mixture that was chosen reflects all of a sampled light", "adapters, floor b(dd)"},
    {gpu::kMutantMixtureHalfDense, "half of a mixture dense",
     "a direction's density is that of the half of a mixture that was chosen", "chi2, adapters"},
    {gpu::kMutantCoatInsideForgotten, "varying coat's inside forgotten",
     "a coat whose roughness varies reflects nothing back inside", "picture of coats"},
    {gpu::kMutantTintOnce, "tint of the mirror", "tinted glass gives transmitted light the colour of reflected light",
     "chi2, tinted dielectric"},
    {gpu::kMutantSquaresSwapped, "squares swapped", "the textures in the squares of a checkerboard are exchanged",
     "picture of products"},
    {gpu::kMutantVertexTintLeftOut, "tint left out", "textures are not multiplied by the vertices' colours",
     "picture of products"},
    {gpu::kMutantAlphaNotMultiplied, "alpha not multiplied", "colours are not multiplied by their alpha",
     "picture of products"},
    {gpu::kMutantCoatNormalsIgnored, "coat's map ignored",
     "a clear coat has the normal of the surface, not that of its map", "picture of gleams"},
    {gpu::kMutantLampBackDark, "lamp's back dark", "a two-sided lamp emits only in front", "picture of gleams"},
    {gpu::kMutantDispersionReversed, "rainbow reversed", "glass bends red more than blue", "picture of gleams"},
    {gpu::kMutantLooseMapsTied, "loose maps tied", "turned normals are mirrored and shadow even where they should not",
     "picture of loose maps"},
    {gpu::kMutantPartAreaWhole, "part as large as its triangle",
     "the density of points in a part of a lamp is that of its whole triangle", "textures, lamp bilinear"},
    {gpu::kMutantPartMisplaced, "part misplaced", "a point met by chance counts as one of its triangle's first part",
     "textures, lamp bilinear"},
    {gpu::kMutantTurnOfTextureLost, "turned grain straight", "a texture does not turn the grain of brushed metal",
     "picture of gleams"},
}};
static_assert(std::ranges::is_sorted(kMutants, {}, &Mutant::id) && kMutants.back().id == gpu::kMutantCount - 1);

/// Numbers of samples to try, in this order, until a test is sure.
constexpr std::array<std::uint32_t, 4> kLooks{4096, 16384, 65536, 262144};

/// A test of the suite, which computes its p-value for a number of samples. Each mutant gets a new one.
class Trial {
 public:
  virtual ~Trial() = default;
  virtual double p_value(std::uint32_t samples) = 0;
};

struct SuiteTest {
  std::string name;
  std::function<std::unique_ptr<Trial>(const GpuOptions& gpu)> make;
};

/// Tests the mean luminance of a closed-form scene. Samples of earlier looks are kept.
class SceneTrial final : public Trial {
 public:
  SceneTrial(const ClosedFormScene& scene, const GpuOptions& gpu)
      : expected_(scene.expected),
        sampler_(scene.scene.sampler),
        renderer_(make_gpu_renderer(scene.scene, {.seed = 1, .quantity = FilmQuantity::luminance}, gpu)),
        film_(scene.scene.camera.width, scene.scene.camera.height, film_exponent(scene.scene)) {}

  double p_value(std::uint32_t samples) override {
    std::vector<RejectedSample> rejected;
    done_ = renderer_->render({done_, static_cast<std::uint32_t>(sampler_.sets_of(samples))}, film_, {}, rejected);
    const Moments m = film_moments(film_, 0);
    if (film_.rejected() > 0 || m.n < 2) return 0.0;
    return t_test(static_cast<double>(m.mean), static_cast<double>(m.variance), m.n, expected_).p_value;
  }

 private:
  double expected_;
  Sampler sampler_;
  std::unique_ptr<Renderer> renderer_;
  Film film_;
  std::uint32_t done_ = 0;
};

/// Tests the samples of a material against its density.
class MaterialTrial final : public Trial {
 public:
  MaterialTrial(const Bsdf& bsdf, const glm::dvec3& wo, const GpuOptions& gpu)
      : MaterialTrial(test_patch(bsdf), wo, gpu) {}
  MaterialTrial(Scene patch, const glm::dvec3& wo, const GpuOptions& gpu)
      : patch_(std::move(patch)), wo_(wo), probe_(make_gpu_bsdf_probe(patch_, gpu)) {}

  double p_value(std::uint32_t samples) override {
    const BsdfChi2 result = test_bsdf(*probe_, patch_, wo_, Chi2Test{}, samples, 1, 0.0);
    return result.fault.empty() ? result.test.p_value : 0.0;
  }

 private:
  Scene patch_;
  glm::dvec3 wo_;
  std::unique_ptr<BsdfProbe> probe_;
};

/// Compares how much uniform light a material scatters without its delta lobes: samples on the device against
/// quadrature of the reference's f cos.
class AlbedoTrial final : public Trial {
 public:
  AlbedoTrial(const Bsdf& bsdf, const glm::dvec3& wo, const GpuOptions& gpu)
      : wo_(wo), expected_(reference_albedo(bsdf, wo)), probe_(make_gpu_bsdf_probe(test_patch(bsdf), gpu)) {}

  double p_value(std::uint32_t samples) override {
    RunningMoments weight;
    for (const BsdfDraw& draw : probe_->sample(wo_, 1, 0, samples))
      weight.add(draw.pdf > 0.0 && !is_delta(draw.lobe) ? glm::dot(draw.weight, kEven) : 0.0);
    return t_test(weight.mean(), weight.variance(), samples, expected_).p_value;
  }

 private:
  static constexpr glm::dvec3 kEven{1.0 / 3.0};

  static double reference_albedo(const Bsdf& bsdf, const glm::dvec3& wo) {
    const std::unique_ptr<BsdfProbe> reference = make_reference_bsdf_probe(test_patch(bsdf));
    const SphereDensity value = [&](std::span<const glm::dvec3> wi) {
      std::vector<double> values;
      std::vector<BsdfQuery> queries;
      for (const glm::dvec3& w : wi) queries.push_back({w, 0});
      for (const BsdfValue& v : reference->evaluate(wo, 1, queries, BsdfProbe::Part::mixture))
        values.push_back(glm::dot(v.eval, kEven));
      return values;
    };
    double sum = 0.0;
    for (const double cell : integrate_cells(value, 20, 40)) sum += cell;
    return sum;
  }

  glm::dvec3 wo_;
  double expected_;
  std::unique_ptr<BsdfProbe> probe_;
};

/// A closed room with a mirror, a glass sphere and an open lamp. It has paths of every kind, but no closed form.
Scene room() {
  Scene scene;
  scene.name = scene.file = "room";
  const auto add_square = [&](glm::dvec3 corner, glm::dvec3 u, glm::dvec3 v, double albedo,
                              std::optional<AreaEmitter> emitter) {
    TriangleMesh mesh{.positions = {corner, corner + u, corner + u + v, corner + v},
                      .normals = {},
                      .triangles = {{0, 1, 2}, {0, 2, 3}}};
    const DiffuseBsdf bsdf{glm::dvec3(albedo, 0.8 * albedo, 0.6 * albedo)};
    scene.add(std::move(mesh), bsdf, std::move(emitter)).name = "square";
  };
  const auto add_sphere = [&](glm::dvec3 center, const Bsdf& bsdf) {
    scene.add(Sphere{center, 0.4}, bsdf).name = "sphere";
  };
  add_square({-1, -1, -1}, {0, 0, 2}, {2, 0, 0}, 0.7, {});
  add_square({-1, 1, -1}, {2, 0, 0}, {0, 0, 2}, 0.6, {});
  add_square({-1, -1, 1}, {0, 2, 0}, {2, 0, 0}, 0.5, {});
  add_square({-1, -1, -1}, {0, 2, 0}, {0, 0, 2}, 0.8, {});
  add_square({1, -1, -1}, {0, 0, 2}, {0, 2, 0}, 0.3, {});
  add_square({-0.4, 0.98, -0.3}, {0.8, 0, 0}, {0, 0, 0.6}, 0.0, AreaEmitter{glm::dvec3(8.0, 7.0, 5.0)});
  add_sphere({-0.45, -0.6, 0.3}, MirrorBsdf{});
  add_sphere({0.45, -0.6, -0.1}, DielectricBsdf{});
  scene.integrator.max_depth = 6;
  scene.integrator.rr_depth = 3;
  scene.camera.width = 12;
  scene.camera.height = 9;
  scene.camera.fov = 55.0;
  scene.camera.world_from_camera[3] = glm::dvec4(0, 0, -3.0, 1);
  return scene;
}

/// A ball of radius 1 with vertex normals, divided along latitude and longitude.
TriangleMesh smooth_ball() {
  constexpr std::uint32_t kRows = 5, kColumns = 8;
  TriangleMesh mesh;
  for (std::uint32_t row = 0; row <= kRows; ++row) {
    for (std::uint32_t column = 0; column < kColumns; ++column) {
      const double theta = glm::pi<double>() * row / kRows, phi = 2.0 * glm::pi<double>() * column / kColumns;
      const double y = row == 0 ? 1.0 : row == kRows ? -1.0 : std::cos(theta);
      const double around = row == 0 || row == kRows ? 0.0 : std::sin(theta);
      mesh.positions.emplace_back(around * std::cos(phi), y, around * std::sin(phi));
    }
  }
  mesh.normals = mesh.positions;
  for (std::uint32_t row = 0; row < kRows; ++row) {
    for (std::uint32_t column = 0; column < kColumns; ++column) {
      const std::uint32_t a = row * kColumns + column, b = row * kColumns + (column + 1) % kColumns;
      if (row + 1 < kRows) mesh.triangles.emplace_back(a, b + kColumns, a + kColumns);
      if (row > 0) mesh.triangles.emplace_back(a, b, b + kColumns);
    }
  }
  return mesh;
}

/// The room with instances of one mesh: a lamp scaled by three different factors, a mirrored body and a sheared one.
Scene room_of_instances() {
  Scene scene = room();
  scene.name = scene.file = "room of instances";
  scene.instances.resize(scene.instances.size() - 3);  // the lamp and the spheres
  scene.instancing = Instancing::always;
  const auto shape = static_cast<std::uint32_t>(scene.shapes.size());
  const auto material = static_cast<std::uint32_t>(scene.materials.size());
  scene.shapes.emplace_back(smooth_ball());
  scene.materials.push_back({.bsdf = DiffuseBsdf{glm::dvec3(0.8)}});
  const auto put = [&](glm::dvec4 x, glm::dvec4 y, glm::dvec4 z, glm::dvec4 at) -> Instance& {
    return scene.instances.emplace_back(
        Instance{.shape = shape, .material = material, .world_from_object = glm::dmat4(x, y, z, at)});
  };
  put({0.35, 0, 0.1, 0}, {0.1, 0.1, 0, 0}, {0, 0, 0.2, 0}, {0.1, 0.6, 0.1, 1}).emitter = 0;
  put({-0.5, 0, 0.1, 0}, {0, 0.2, 0.1, 0}, {0, 0.1, 0.3, 0}, {-0.35, -0.5, 0.2, 1});
  put({0.2, 0, 0, 0}, {0.3, 0.4, 0, 0}, {0, 0, 0.2, 0}, {0.5, -0.5, -0.2, 1});
  scene.integrator.max_depth = 4;
  return scene;
}

/// The room with disks and open cylinders as bodies and lamps, placed by affine maps and similarities.
Scene room_of_round_shapes() {
  Scene scene = room();
  scene.name = scene.file = "room of round shapes";
  scene.instances.resize(scene.instances.size() - 3);  // the lamp and the spheres
  // Two colours, each for half of the turn around a disk or half of the height of a cylinder.
  Texture squares{.source = CheckerboardTexture{glm::dvec3(1.0, 0.9, 0.7), glm::dvec3(0.1, 0.3, 0.2)}};
  squares.uv_transform = glm::dmat3(0.4, 0.0, 0.0, 0.0, 1.0, 0.0, 0.05, 0.02, 1.0);
  scene.textures = {squares};
  scene.emitters[0].radiance.texture = 0;
  const auto put = [&](Shape shape, glm::dvec4 x, glm::dvec4 y, glm::dvec4 z, glm::dvec4 at) -> Instance& {
    Instance& instance = scene.add(std::move(shape), DiffuseBsdf{ColorParameter(glm::dvec3(0.8), 0)});
    instance.world_from_object = glm::dmat4(x, y, z, at);
    return instance;
  };
  const glm::dvec4 x(1, 0, 0, 0), y(0, 1, 0, 0), z(0, 0, 1, 0);
  put(Disk{}, 0.4 * x, 0.2 * x + 0.2 * z, -0.3 * y, {-0.2, 0.9, 0.1, 1}).emitter = 0;  // shines down
  put(Cylinder{{0, 0, 0}, {0, 0, 0.8}, 0.15}, x, y, z, {0.55, 0.2, -0.3, 1}).emitter = 0;
  put(Disk{}, 0.5 * x, 0.3 * y - 0.2 * x, -z, {0.1, -0.3, 0.2, 1});
  put(Cylinder{{0, 0, 0}, {0, 1, 0}, 0.6}, -0.5 * x, 0.5 * y, 0.5 * z, {-0.5, -0.9, 0.0, 1});
  put(Cylinder{{0, 0, 0}, {0, 1, 0}, 0.6}, 0.49 * x, 0.49 * y, 0.49 * z, {-0.5, -0.9, 0.0, 1}).flip_normals = true;
  scene.integrator.max_depth = 4;
  return scene;
}

/// The room with a body and a lamp whose winding contradicts their vertex normals, and two bodies that coincide.
Scene room_of_twins() {
  Scene scene = room();
  scene.name = scene.file = "room of twins";
  scene.instances.resize(scene.instances.size() - 3);  // the lamp and the spheres
  const auto put = [&](double albedo, double radius, glm::dvec3 at, bool turned) -> Instance& {
    TriangleMesh ball = smooth_ball();
    if (turned)
      for (glm::uvec3& triangle : ball.triangles) std::swap(triangle.y, triangle.z);
    Instance& instance = scene.add(std::move(ball), DiffuseBsdf{glm::dvec3(albedo)});
    instance.world_from_object = glm::dmat4(glm::dmat3(radius));
    instance.world_from_object[3] = glm::dvec4(at, 1);
    return instance;
  };
  put(0.0, 0.2, {0.1, 0.6, 0.1}, true).emitter = 0;
  put(0.8, 0.35, {-0.45, -0.6, 0.3}, true);
  put(0.8, 0.4, {0.45, -0.55, -0.1}, false);
  put(0.1, 0.4, {0.45, -0.55, -0.1}, false);
  scene.integrator.max_depth = 4;
  return scene;
}

/// A picture of 8-bit codes that are linear light.
std::shared_ptr<Bitmap> raw_picture(std::uint32_t width, std::uint32_t channels, std::initializer_list<int> codes) {
  auto picture = std::make_shared<Bitmap>();
  picture->width = width;
  picture->channels = channels;
  picture->height = static_cast<std::uint32_t>(codes.size()) / (width * channels);
  picture->format = BitmapFormat::u8;
  for (const int code : codes) picture->texels.push_back(static_cast<std::byte>(code));
  return picture;
}

/// The room with two boards above the lit floor, one with a normal map and one with a bump map.
Scene room_of_maps() {
  Scene scene = room();
  scene.name = scene.file = "room of maps";
  scene.instances.resize(scene.instances.size() - 2);  // the spheres
  scene.bitmaps = {raw_picture(2, 3, {238, 128, 191, 128, 20, 195}),
                   raw_picture(3, 1, {0, 255, 90, 200, 30, 255, 120, 250, 0})};
  for (std::uint32_t i = 0; i < 2; ++i) scene.textures.push_back({.source = BitmapTexture{.bitmap = i}});
  const auto put = [&](double x, Adapter map) {
    TriangleMesh board{.positions = {{x, 0.0, -0.6}, {x, 0.0, 0.6}, {x + 0.8, 0.0, 0.6}, {x + 0.8, 0.0, -0.6}},
                       .uv_sets = {{{0, 0}, {0, 1}, {1, 1}, {1, 0}}},
                       .triangles = {{0, 1, 2}, {0, 2, 3}}};
    Instance& instance = scene.add(std::move(board), DiffuseBsdf{glm::dvec3(0.9)});
    std::visit(
        [&](auto& m) {
          if constexpr (requires { m.inner; }) m.inner = instance.material;
        },
        map);
    instance.material = static_cast<std::uint32_t>(scene.materials.size());
    scene.materials.push_back({.bsdf = DiffuseBsdf{}, .adapter = std::move(map)});
  };
  put(-0.9, NormalMapAdapter{.normals = ColorParameter(glm::dvec3(1.0), 0)});
  put(0.1, BumpMapAdapter{.height = ScalarParameter(0.3, 1, TextureChannel::red)});
  scene.camera.world_from_camera = glm::dmat4({1, 0, 0, 0}, {0, 0.8, 0.6, 0}, {0, -0.6, 0.8, 0}, {0, 0.9, -0.9, 1});
  scene.integrator.max_depth = 4;
  return scene;
}

/// Boards in the middle of the room with derived textures: tinted by vertex colours, multiplied by alpha, and inside a
/// checkerboard.
Scene room_of_products() {
  Scene scene = room();
  scene.name = scene.file = "room of products";
  scene.instances.resize(scene.instances.size() - 2);  // the spheres
  scene.bitmaps = {raw_picture(2, 4, {250, 60, 90, 40, 30, 240, 120, 250, 90, 90, 250, 90, 240, 230, 60, 160}),
                   raw_picture(2, 3, {250, 40, 40, 40, 250, 40})};
  scene.textures = {{.source = BitmapTexture{.bitmap = 0}},
                    {.source = BitmapTexture{.bitmap = 1}},
                    {.source = BitmapTexture{.bitmap = 0}, .vertex_tint = true},
                    {.source = BitmapTexture{.bitmap = 0}, .premultiplied = true}};
  CheckerboardTexture squares{glm::dvec3(0.9, 0.5, 0.7), glm::dvec3(0.4, 0.9, 0.9)};
  squares.texture0 = 0;
  squares.texture1 = 1;
  scene.textures.push_back({.source = squares, .uv_transform = glm::dmat3(1.5)});
  scene.textures.back().uv_transform[2][2] = 1.0;
  for (std::uint32_t i = 0; i < 3; ++i) {
    const double x = -0.95 + 0.65 * i, far = x + 0.6;
    TriangleMesh board{.positions = {{x, -0.2, -0.6}, {x, -0.2, 0.6}, {far, -0.2, 0.6}, {far, -0.2, -0.6}},
                       .uv_sets = {{{0, 0}, {0, 1}, {1, 1}, {1, 0}}},
                       .triangles = {{0, 1, 2}, {0, 2, 3}}};
    board.vertex_colors = {{0.2f, 0.9f, 0.5f}, {0.9f, 0.2f, 0.5f}, {0.5f, 0.5f, 0.1f}, {1.0f, 1.0f, 1.0f}};
    scene.add(std::move(board), DiffuseBsdf{ColorParameter(glm::dvec3(1.0), 2 + i)});
  }
  scene.camera.world_from_camera = glm::dmat4({1, 0, 0, 0}, {0, 0.8, 0.6, 0}, {0, -0.6, 0.8, 0}, {0, 0.9, -0.9, 1});
  scene.integrator.max_depth = 3;
  return scene;
}

/// A two-sided lamp in the middle of the room, above a board whose coat has its own normal map, a ball of dispersive
/// glass in front, and one of brushed metal.
Scene room_of_gleams() {
  Scene scene = room();
  scene.name = scene.file = "room of gleams";
  scene.instances.resize(scene.instances.size() - 2);  // the spheres
  const Instance& lamp = scene.instances.back();
  for (glm::dvec3& p : std::get<TriangleMesh>(scene.shapes[lamp.shape]).positions.edit()) p.y = 0.3;
  scene.emitters[0].two_sided = true;
  const glm::dvec3 tilted(0.85, 0.5, 0.8);
  scene.textures = {{.source = CheckerboardTexture{tilted, tilted}}};
  GltfBsdf coat{.base_color = glm::dvec3(0.3), .metallic = 0.0, .roughness = 1.0, .clearcoat = 1.0};
  coat.clearcoat_roughness = 0.5;
  coat.coat_keeps_normal = true;
  coat.coat_normals = ColorParameter(glm::dvec3(1.0), 0);
  TriangleMesh board{.positions = {{-0.9, -0.8, -0.7}, {-0.9, -0.8, 0.7}, {0.9, -0.8, 0.7}, {0.9, -0.8, -0.7}},
                     .uv_sets = {{{0, 0}, {0, 1}, {1, 1}, {1, 0}}},
                     .triangles = {{0, 1, 2}, {0, 2, 3}}};
  scene.add(std::move(board), coat);
  GltfBsdf glass{.metallic = 0.0, .roughness = 0.1, .transmission = 1.0, .thin = false};
  glass.dispersion = 8.0;
  scene.add(Sphere{{0.0, -0.2, -0.6}, 0.35}, glass);
  const glm::dvec3 quarter(0.5, 1.0, 0.5);
  scene.textures.push_back({.source = CheckerboardTexture{quarter, quarter}});
  GltfBsdf brushed{.base_color = glm::dvec3(0.9), .roughness = 0.3, .anisotropy = 0.9};
  brushed.anisotropy_directions = ColorParameter(glm::dvec3(1.0), 1);
  scene.add(Sphere{{-0.6, -0.5, -0.3}, 0.3}, brushed);
  scene.integrator.max_depth = 4;
  return scene;
}

/// The room of maps, with maps that neither mirror normals that face away nor compute shadowing.
Scene room_of_loose_maps() {
  Scene scene = room_of_maps();
  scene.name = scene.file = "room of loose maps";
  for (Material& material : scene.materials) {
    if (!material.adapter) continue;
    std::visit(
        [](auto& map) {
          if constexpr (requires { map.turned; }) map.turned = {.mirrored = false, .shadowed = false};
        },
        *material.adapter);
  }
  return scene;
}

/// The room with coloured solids of glTF's glass, smooth and rough, one of them around another body.
Scene room_of_volumes() {
  Scene scene = room();
  scene.name = scene.file = "room of volumes";
  scene.instances.resize(scene.instances.size() - 2);  // the spheres
  GltfBsdf glass{.metallic = 0.0, .roughness = 0.3, .transmission = 1.0, .thin = false};
  glass.attenuation_color = {0.2, 0.6, 0.4};
  glass.attenuation_distance = 0.3;
  scene.add(Sphere{{-0.45, -0.5, 0.2}, 0.45}, glass);
  scene.add(Sphere{{-0.45, -0.5, 0.2}, 0.2}, DiffuseBsdf{glm::dvec3(0.8)});
  glass.roughness = 0.6;
  glass.diffuse_transmission = 0.5;
  glass.transmission = 0.5;
  scene.add(Sphere{{0.45, -0.5, -0.1}, 0.45}, glass);
  return scene;
}

const ConductorIndex kGold{{0.143036, 0.375307, 1.44205}, {3.983, 2.38556, 1.60336}};
const RoughPlasticBsdf kRoughPlastic{.diffuse_reflectance = glm::dvec3(0.2, 0.5, 0.7), .alpha = 0.3};

/// The room with walls that are a mixture of matt and glossy.
Scene room_of_mixtures() {
  Scene scene = room();
  scene.name = scene.file = "room of mixtures";
  const auto mix = [&](Instance& instance, const Bsdf& other) {
    const auto rows = static_cast<std::uint32_t>(scene.materials.size());
    scene.materials.push_back({.bsdf = other});
    scene.materials.push_back({.bsdf = DiffuseBsdf{}, .adapter = BlendAdapter{0.5, instance.material, rows}});
    instance.material = rows + 1;
  };
  for (std::size_t i = 0; i < 5; ++i)  // floor, ceiling and walls
    mix(scene.instances[i], RoughConductorBsdf{kGold, {Roughness::Distribution::ggx, 0.1, 0.1}, glm::dvec3(1.0)});
  mix(scene.instances.back(), kRoughPlastic);
  scene.integrator.max_depth = 3;
  return scene;
}

/// The room with a board and a ball whose coat has a textured roughness.
Scene room_of_coats() {
  Scene scene = room();
  scene.name = scene.file = "room of coats";
  scene.instances.resize(scene.instances.size() - 2);  // the spheres
  scene.textures.push_back({.source = CheckerboardTexture{glm::dvec3(0.1), glm::dvec3(0.7)}});
  RoughPlasticBsdf plastic = kRoughPlastic;
  plastic.alpha = {1.0, 0, TextureChannel::luminance};
  TriangleMesh board{.positions = {{-0.9, -0.2, -0.6}, {-0.9, -0.2, 0.6}, {0.1, -0.2, 0.6}, {0.1, -0.2, -0.6}},
                     .uv_sets = {{{0, 0}, {0, 2}, {2, 2}, {2, 0}}},
                     .triangles = {{0, 1, 2}, {0, 2, 3}}};
  scene.add(std::move(board), plastic);
  scene.add(Sphere{{0.5, -0.5, 0.1}, 0.45}, plastic);
  scene.integrator.max_depth = 3;
  return scene;
}

/// The room with a point light, a spot that fades over its whole cone, and a projector instead of the lamp.
Scene room_under_points() {
  Scene scene = room();
  scene.name = scene.file = "room under points";
  for (Instance& instance : scene.instances) instance.emitter.reset();
  scene.emitters.clear();
  const auto put = [&](DeltaLight::Type type, const glm::dvec3& at, const glm::dvec3& intensity) -> DeltaLight& {
    DeltaLight& light = scene.delta_lights.emplace_back(DeltaLight{.type = type, .intensity = intensity});
    // Along −y.
    light.world_from_light = glm::dmat4({1, 0, 0, 0}, {0, 0, 1, 0}, {0, -1, 0, 0}, glm::dvec4(at, 1.0));
    return light;
  };
  put(DeltaLight::Type::point, {0.3, 0.5, 0.4}, glm::dvec3(0.5));
  DeltaLight& spot = put(DeltaLight::Type::spot, {-0.4, 0.8, 0.0}, {4.0, 2.0, 1.0});
  spot.cutoff = 50.0;
  spot.beam_width = 1.0;
  put(DeltaLight::Type::projector, {0.4, 0.8, 0.0}, {1.0, 2.0, 3.0}).slope = {1.2, 0.8};
  scene.integrator.max_depth = 3;
  return scene;
}

Image render_room(Renderer& renderer, const Scene& scene, std::uint32_t spp) {
  Film film(scene.camera.width, scene.camera.height, film_exponent(scene));
  std::vector<RejectedSample> rejected;
  renderer.render({0, spp}, film, {}, rejected);
  return image_from_film(film, {});
}

/// Compares pictures of a room by device and reference, with independent random numbers.
class PictureTrial final : public Trial {
 public:
  PictureTrial(Scene scene, const GpuOptions& gpu)
      : scene_(std::move(scene)),
        renderer_(make_gpu_renderer(scene_, {.seed = 1, .quantity = FilmQuantity::color}, gpu)) {}

  double p_value(std::uint32_t samples) override {
    const std::uint32_t spp = samples / (scene_.camera.width * scene_.camera.height) + 1;
    const Image device = render_room(*renderer_, scene_, spp);
    const ImageTests tests = test_images(device, reference(scene_), 0.01);
    double smallest = 1.0;
    for (const TestFamily& family : tests.families)
      smallest = std::min(smallest, family.tests > 0 ? family.family_p : 1.0);
    return smallest;
  }

 private:
  /// Rendered once, because it is the same for every mutant.
  static const Image& reference(const Scene& scene) {
    static std::map<std::string, Image> images;
    const auto [image, is_new] = images.try_emplace(scene.name);
    if (is_new) {
      const auto renderer = make_reference_renderer(scene, {.seed = 2, .quantity = FilmQuantity::color});
      image->second = render_room(*renderer, scene, 2048);
    }
    return image->second;
  }

  Scene scene_;
  std::unique_ptr<Renderer> renderer_;
};

/// A test of the first scene of a family whose description contains `words`.
SuiteTest scene_test(SceneFamily family, LightStrategy strategy, std::string_view words) {
  for (std::uint64_t seed = 1; seed < 10000; ++seed) {
    ClosedFormScene scene = make_closed_form(family, seed, strategy);
    if (scene.name.find(words) == std::string::npos) continue;
    return {scene.name,
            [scene = std::move(scene)](const GpuOptions& gpu) { return std::make_unique<SceneTrial>(scene, gpu); }};
  }
  throw std::logic_error(fmt::format("no closed-form scene is called '{}'", words));
}

SuiteTest material_test(std::string name, const Bsdf& bsdf, const glm::dvec3& wo) {
  return {std::move(name), [=](const GpuOptions& gpu) { return std::make_unique<MaterialTrial>(bsdf, wo, gpu); }};
}

SuiteTest albedo_test(std::string name, const Bsdf& bsdf, const glm::dvec3& wo) {
  return {std::move(name), [=](const GpuOptions& gpu) { return std::make_unique<AlbedoTrial>(bsdf, wo, gpu); }};
}

const RoughConductorBsdf kRoughGold{kGold, {Roughness::Distribution::ggx, 0.5, 0.3}, glm::dvec3(1.0)};
const MicrofacetBsdf kCoated{.kd = glm::dvec3(0.2, 0.4, 0.3), .alpha = 0.4};
const RoughDielectricBsdf kFrosted{
    .int_ior = 1.5, .ext_ior = 1.0, .roughness = {Roughness::Distribution::ggx, 0.3, 0.5}};
const PlasticBsdf kPlastic{.diffuse_reflectance = glm::dvec3(0.2, 0.5, 0.7), .nonlinear = true};
const PrincipledBsdf kPrincipled{.base_color = glm::dvec3(0.2, 0.5, 0.7),
                                 .roughness = 0.6,
                                 .metallic = 0.1,
                                 .anisotropic = 0.4,
                                 .spec_trans = 0.2,
                                 .spec_tint = 0.3,
                                 .sheen = 0.5,
                                 .clearcoat = 1.0,
                                 .sheen_tint = 0.5,
                                 .flatness = 0.2};
const PrincipledThinBsdf kSheet{.base_color = glm::dvec3(0.2, 0.5, 0.7),
                                .roughness = 0.6,
                                .anisotropic = 0.4,
                                .spec_trans = 0.4,
                                .sheen = 0.5,
                                .diff_trans = 0.8,
                                .eta = 1.3};
const GltfBsdf kGltf{.base_color = glm::dvec3(0.2, 0.5, 0.7),
                     .metallic = 0.2,
                     .roughness = 0.6,
                     .transmission = 0.3,
                     .diffuse_transmission = 0.3,
                     .clearcoat = 0.8,
                     .clearcoat_roughness = 0.5,
                     .sheen_color = glm::dvec3(0.6, 0.3, 0.3),
                     .sheen_roughness = 0.5,
                     .anisotropy = 0.5,
                     .anisotropy_rotation = 0.5,
                     .thin = false};
const GltfBsdf kFilm{.base_color = glm::dvec3(0.9, 0.6, 0.4), .metallic = 0.7, .roughness = 0.6, .iridescence = 0.9};
const PrincipledBsdf kLacquer{.base_color = glm::dvec3(0.0), .clearcoat = 1.0};
const glm::dvec3 kGrazing = glm::normalize(glm::dvec3(0.8, -0.3, 0.1));
const glm::dvec3 kSlanted = glm::normalize(glm::dvec3(0.8, -0.3, 0.4));

/// In front a mixture of metal and a tilted half mirror, behind matt.
Scene patch_of_adapters() {
  Scene scene;
  const glm::dvec3 tilt(0.75, 0.35, 0.9);
  scene.textures.push_back({.source = CheckerboardTexture{tilt, tilt}});
  scene.materials = {{.bsdf = kRoughGold}, {.bsdf = MirrorBsdf{}}, {.bsdf = DiffuseBsdf{glm::dvec3(0.8)}}};
  const auto adapt = [&](Adapter adapter) {
    scene.materials.push_back({.bsdf = DiffuseBsdf{}, .adapter = std::move(adapter)});
    return static_cast<std::uint32_t>(scene.materials.size() - 1);
  };
  const std::uint32_t half = adapt(BlendAdapter{0.6, 1, 2});
  const std::uint32_t map = adapt(NormalMapAdapter{.normals = ColorParameter(glm::dvec3(1.0), 0), .inner = half});
  adapt(TwoSidedAdapter{adapt(BlendAdapter{0.3, 0, map}), 2});
  add_test_patch(scene);
  return scene;
}

using enum LightStrategy;

/// Closed-form scenes: the first of a family whose description contains these words.
constexpr struct {
  SceneFamily family;
  LightStrategy strategy;
  std::string_view words;
} kSceneTests[] = {
    {SceneFamily::direct, nee, "1 polygon(s), 0 sphere(s), 0 turned away, 0 hidden"},
    {SceneFamily::direct, nee, "0 polygon(s), 1 sphere(s), 0 turned away, 0 hidden"},
    {SceneFamily::direct, mis, "1 polygon(s), 0 sphere(s), 0 turned away, 0 hidden"},
    {SceneFamily::direct, nee, "3 polygon(s), 2 sphere(s), 1 turned away, 2 hidden"},
    {SceneFamily::direct, naive, "3 polygon(s), 2 sphere(s), 1 turned away, 2 hidden"},
    {SceneFamily::direct, mis, "3 polygon(s), 2 sphere(s), 1 turned away, 2 hidden"},
    {SceneFamily::crowd, nee, "sobol sets of 8"},
    {SceneFamily::crowd, mis, "sobol sets of 4"},
    {SceneFamily::furnace, naive, "depth 3, roulette 2"},
    {SceneFamily::interior, mis, "mirror sphere"},
    {SceneFamily::sheet, naive, "refracting sheet from outside"},
    {SceneFamily::glass, naive, "refracting sphere from inside"},
    {SceneFamily::sky, naive, "diffuse square"},
    {SceneFamily::sky, naive, "mirroring square"},
    {SceneFamily::environment, naive, "bands"},
    {SceneFamily::environment, nee, "bands, with a lamp"},
    {SceneFamily::environment, mis, "circles, with a lamp"},
    {SceneFamily::coverage, naive, "box"},
    {SceneFamily::coverage, naive, "mitchell"},
    {SceneFamily::camera, naive, "far rectangle, gaussian"},
    {SceneFamily::camera, naive, "circle of confusion, 0"},
    {SceneFamily::camera, naive, "circle of confusion, 3"},
    {SceneFamily::camera, naive, "panorama"},
    {SceneFamily::integrator, mis, "as direct, 3 and 2"},
    {SceneFamily::integrator, nee, "as whitted"},
    {SceneFamily::integrator, mis, "floor lit by a point"},
    {SceneFamily::integrator, mis, "ao under"},
    {SceneFamily::integrator, mis, "av under"},
    {SceneFamily::integrator, mis, "floor seen"},
    {SceneFamily::texture, mis, "lamp bilinear repeat repeat sRGB"},
    {SceneFamily::texture, nee, "lamp nearest mirror clamp"},
    {SceneFamily::delta, mis, "points, 2 point(s), 0 spot(s), 0 projector(s), 0 directional, 0 hidden, a lamp"},
    {SceneFamily::delta, nee, "points, 1 point(s), 0 spot(s), 0 projector(s), 1 directional, 0 hidden"},
    {SceneFamily::adapter, nee, "floor t(dd) from behind"},
    {SceneFamily::adapter, mis, "floor b(dd) from the front, veil m(d), deep"},
    {SceneFamily::adapter, mis, "floor d from the front, ball m(d), deep,"},
    {SceneFamily::adapter, nee, "floor o(d) from the front, veil n, deep"},
    {SceneFamily::adapter, naive, "floor o(d) from the front"},
    {SceneFamily::adapter, nee, "floor u(d) from the front, veil n, deep"},
    {SceneFamily::adapter, nee, "floor m(d) from the front, veil m(d), shallow,"},
    {SceneFamily::aov, naive, "aov alpha of a rectangle in a pixel, mitchell"},
    {SceneFamily::aov, naive, "aov instance 3"},
    {SceneFamily::aov, naive, "aov depth"},
    {SceneFamily::aov, naive, "aov position"},
    {SceneFamily::aov, naive, "aov albedo"},
    {SceneFamily::aov, naive, "direct light of a furnace"},
    {SceneFamily::aov, mis, "indirect light of a furnace"},
    {SceneFamily::aov, naive, "hidden sky"},
};

/// Rooms that device and reference render with independent random numbers.
constexpr struct {
  std::string_view name;
  Scene (*scene)();
} kPictureTests[] = {
    {"picture against the reference", room},
    {"picture under points against the reference", room_under_points},
    {"picture of instances against the reference", room_of_instances},
    {"picture of round shapes against the reference", room_of_round_shapes},
    {"picture of maps against the reference", room_of_maps},
    {"picture of loose maps against the reference", room_of_loose_maps},
    {"picture of products against the reference", room_of_products},
    {"picture of gleams against the reference", room_of_gleams},
    {"picture of mixtures against the reference", room_of_mixtures},
    {"picture of coats against the reference", room_of_coats},
    {"picture of volumes against the reference", room_of_volumes},
    {"picture of twins against the reference", room_of_twins},
};

std::vector<SuiteTest> material_tests() {
  return {
      material_test("chi2, diffuse", DiffuseBsdf{{0.9, 0.5, 0.1}}, glm::normalize(glm::dvec3(0.3, -0.2, 0.6))),
      material_test("chi2, mirror", MirrorBsdf{}, glm::normalize(glm::dvec3(0.3, -0.2, 0.6))),
      material_test("chi2, dielectric", DielectricBsdf{}, glm::normalize(glm::dvec3(-0.5, 0.2, -0.8))),
      material_test("chi2, tinted dielectric",
                    DielectricBsdf{1.5, 1.0, glm::dvec3(0.9, 0.8, 0.7), glm::dvec3(0.2, 0.5, 0.8)}, kSlanted),
      material_test("chi2, conductor", ConductorBsdf{.index = kGold}, kSlanted),
      material_test("chi2, roughconductor", kRoughGold, kSlanted),
      material_test("chi2, microfacet", kCoated, kSlanted),
      material_test("chi2, roughdielectric", kFrosted, -kSlanted),
      material_test("chi2, thindielectric", ThinDielectricBsdf{}, kSlanted),
      material_test("chi2, plastic", kPlastic, kSlanted),
      material_test("chi2, roughplastic", kRoughPlastic, kSlanted),
      material_test("chi2, principled", kPrincipled, kSlanted),
      albedo_test("albedo, principled", kPrincipled, kSlanted),
      material_test("chi2, principledthin", kSheet, kSlanted),
      material_test("chi2, gltf", kGltf, kSlanted),
      {"chi2, adapters",
       [](const GpuOptions& gpu) { return std::make_unique<MaterialTrial>(patch_of_adapters(), kSlanted, gpu); }},
      albedo_test("albedo, coat", kLacquer, kGrazing),
      albedo_test("albedo, gltf", kGltf, kSlanted),
      albedo_test("albedo, film", kFilm, kSlanted),
      albedo_test("albedo, principledthin", kSheet, kSlanted),
      albedo_test("albedo, roughdielectric", kFrosted, kSlanted),
      albedo_test("albedo, plastic", kPlastic, kSlanted),
      albedo_test("albedo, roughplastic", kRoughPlastic, kSlanted),
      albedo_test("albedo, roughconductor", kRoughGold, kSlanted),
      albedo_test("albedo, microfacet", kCoated, kSlanted),
  };
}

/// The suite. Users can run all these kinds of tests themselves (ttest, chi2, validate, selftest).
std::vector<SuiteTest> make_suite() {
  std::vector<SuiteTest> suite;
  for (const auto& [family, strategy, words] : kSceneTests) suite.push_back(scene_test(family, strategy, words));
  for (SuiteTest& test : material_tests()) suite.push_back(std::move(test));
  for (const auto& [name, scene] : kPictureTests) {
    suite.push_back({std::string(name),
                     [scene = scene](const GpuOptions& gpu) { return std::make_unique<PictureTrial>(scene(), gpu); }});
  }
  return suite;
}

MutantFinding look(const SuiteTest& test, const GpuOptions& gpu, double level) {
  MutantFinding finding{.test = test.name};
  const std::unique_ptr<Trial> trial = test.make(gpu);
  for (const std::uint32_t samples : kLooks) {
    finding.samples = samples;
    finding.p_value = trial->p_value(samples);
    finding.caught = finding.p_value < level;
    if (finding.caught) break;
  }
  return finding;
}

MutantOutcome run_mutant(const Mutant& mutant, const std::vector<SuiteTest>& suite, const MutateOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  MutantOutcome outcome{.mutant = mutant, .findings = {}};
  GpuOptions gpu = options.gpu;
  gpu.kernels = std::make_shared<const KernelSet>(kernels_with(mutant.id));
  // The test that is known to notice comes first, so most mutants take a second; the others follow if it fails to
  // notice.
  std::vector<SuiteTest> order = suite;
  std::stable_partition(order.begin(), order.end(), [&](const SuiteTest& t) {
    return !mutant.try_first.empty() && t.name.starts_with(mutant.try_first);
  });
  for (const SuiteTest& test : order) {
    outcome.findings.push_back(look(test, gpu, options.level));
    if (outcome.findings.back().caught && !options.all_tests) break;
  }
  outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return outcome;
}

/// The finding that needed the fewest samples, if any test noticed.
const MutantFinding* best_finding(const MutantOutcome& outcome) {
  const MutantFinding* best = nullptr;
  for (const MutantFinding& f : outcome.findings) {
    if (f.caught && (best == nullptr || f.samples < best->samples)) best = &f;
  }
  return best;
}

std::string p_text(double p) {
  return p == 0.0 ? "0" : fmt::format("{:.0e}", p);
}

}  // namespace

std::span<const Mutant> mutants() {
  return kMutants;
}

KernelSet kernels_with(std::uint32_t mutant) {
  KernelSet set = kernel_set(TableLoads::texel_buffer);  // errors are to be found in pictures, not in counts
  set.render = kernels::render_mutant;
  set.trace_samples = kernels::trace_samples_mutant;
  set.trace_path = kernels::trace_path_mutant;
  set.trace_rays = kernels::trace_rays_mutant;
  set.bsdf_samples = kernels::bsdf_samples_mutant;
  set.render_plain = kernels::render_plain_mutant;
  set.trace_samples_plain = kernels::trace_samples_plain_mutant;
  set.trace_path_plain = kernels::trace_path_plain_mutant;
  set.constants = {{gpu::kConstantMutant, mutant}};
  return set;
}

bool MutantOutcome::caught() const {
  return std::any_of(findings.begin(), findings.end(), [](const MutantFinding& f) { return f.caught; });
}

bool MutateReport::passed() const {
  return std::all_of(mutants.begin(), mutants.end(), [](const MutantOutcome& m) { return m.passed(); });
}

MutateReport run_mutate(const MutateOptions& options) {
  for (const std::uint32_t id : options.only) {
    if (id >= kMutants.size())
      throw Error(ErrorKind::usage,
                  fmt::format("there is no mutant {}; they are numbered 0 to {}", id, kMutants.size() - 1));
  }
  const std::vector<SuiteTest> suite = make_suite();
  MutateReport report;
  report.level = options.level;
  const auto renderer = make_gpu_renderer(room(), {}, options.gpu);
  report.device = renderer->device_name();
  report.driver = renderer->driver_name();
  for (const Mutant& mutant : kMutants) {
    if (!options.only.empty() && std::ranges::find(options.only, mutant.id) == options.only.end()) continue;
    report.mutants.push_back(run_mutant(mutant, suite, options));
    if (options.progress) options.progress(report.mutants.back());
  }
  return report;
}

std::string mutate_text(const MutateReport& report) {
  std::string out =
      fmt::format("mutants on {} ({}); a test notices below p = {:g}\n", report.device, report.driver, report.level);
  out += fmt::format("{:>2}  {:<28} {:>5}  {:>8} {:>8}  {}\n", "id", "mutant", "tests", "samples", "p", "noticed by");
  std::size_t caught = 0;
  for (const MutantOutcome& m : report.mutants) {
    const MutantFinding* best = best_finding(m);
    caught += best != nullptr;
    out += fmt::format("{:>2}  {:<28} {:>5}  ", m.mutant.id, m.mutant.name, m.findings.size());
    if (best != nullptr)
      out += fmt::format("{:>8} {:>8}  {}{}\n", best->samples, p_text(best->p_value), best->test,
                         m.passed() ? "" : "  <- FALSE ALARM");
    else
      out += fmt::format("{:>8} {:>8}  {}\n", "-", "-",
                         m.passed() ? "nothing, as it should be" : "NOTHING: a test is missing");
  }
  return out +
         fmt::format("{}: {} of {} noticed\n", report.passed() ? "passed" : "FAILED", caught, report.mutants.size());
}

std::string mutate_markdown(const MutateReport& report) {
  std::string out =
      "| mutant | what is wrong | noticed first by | samples | p | tests that notice |\n|---|---|---|---|---|---|\n";
  for (const MutantOutcome& m : report.mutants) {
    const MutantFinding* best = best_finding(m);
    const auto noticing =
        std::count_if(m.findings.begin(), m.findings.end(), [](const MutantFinding& f) { return f.caught; });
    out +=
        fmt::format("| {} | {} | {} | {} | {} | {} of {} |\n", m.mutant.name, m.mutant.what,
                    best != nullptr ? best->test : "nothing", best != nullptr ? fmt::format("{}", best->samples) : "–",
                    best != nullptr ? p_text(best->p_value) : "–", noticing, m.findings.size());
  }
  return out;
}

Json mutate_json(const MutateReport& report) {
  Json list = Json::array();
  for (const MutantOutcome& m : report.mutants) {
    Json findings = Json::array();
    for (const MutantFinding& f : m.findings)
      findings.push_back({{"test", f.test}, {"caught", f.caught}, {"samples", f.samples}, {"p", f.p_value}});
    list.push_back({{"id", m.mutant.id},
                    {"name", m.mutant.name},
                    {"what", m.mutant.what},
                    {"caught", m.caught()},
                    {"passed", m.passed()},
                    {"seconds", m.seconds},
                    {"findings", findings}});
  }
  return {{"device", report.device},
          {"driver", report.driver},
          {"level", report.level},
          {"mutants", list},
          {"passed", report.passed()}};
}

std::vector<JunitCase> mutate_junit(const MutateReport& report) {
  std::vector<JunitCase> cases;
  for (const MutantOutcome& m : report.mutants) {
    const MutantFinding* best = best_finding(m);
    JunitCase c{.name = fmt::format("{}: {}", m.mutant.id, m.mutant.name)};
    c.seconds = m.seconds;
    c.failed = !m.passed();
    c.message = best != nullptr ? "false alarm of " + best->test : "no test notices this error";
    if (best != nullptr)
      c.details = fmt::format("{}: {} samples, p = {:.3g}", best->test, best->samples, best->p_value);
    cases.push_back(std::move(c));
  }
  return cases;
}

}  // namespace etendue
