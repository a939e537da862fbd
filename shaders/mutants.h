// Wrong variants of the renderer, numbered for C++ and GLSL: `etendue-mutate` renders with each of them and requires
// the tests to notice.
//
// The kernels that render pictures are built without ETENDUE_MUTANTS: MUTATE is empty there, and their SPIR-V is the same as if those lines
// did not exist. `etendue-mutate` has a second build of the same sources with a specialization constant that activates
// one of these lines.
#ifndef ETENDUE_MUTANTS_H
#define ETENDUE_MUTANTS_H

#include "gpu_types.h"

#ifdef __cplusplus
namespace etendue::gpu {
#endif

#if defined(__cplusplus) || defined(ETENDUE_MUTANTS)
const uint kMutantNone = 0u;
const uint kMutantCosineDropped = 1u;
const uint kMutantBsdfPdfScaled = 2u;
const uint kMutantLightPdfScaled = 3u;
const uint kMutantRouletteUncompensated = 4u;
const uint kMutantEmissionTwice = 5u;
const uint kMutantLightChoiceForgotten = 6u;
const uint kMutantFresnelSwapped = 7u;
const uint kMutantEtaOmitted = 8u;
const uint kMutantShadowRayTooLong = 9u;
const uint kMutantEmitterTwoSided = 10u;
const uint kMutantDepthOffByOne = 11u;
const uint kMutantDimensionReused = 12u;
const uint kMutantJitterMissing = 13u;
const uint kMutantEtaInverted = 14u;
const uint kMutantShadowsIgnored = 15u;
const uint kMutantSkyMirrored = 16u;
const uint kMutantBlackSideLit = 17u;
const uint kMutantMisChoiceForgotten = 18u;
const uint kMutantMisHeuristicsMixed = 19u;
const uint kMutantTriangleChoiceForgotten = 20u;
const uint kMutantTriangleRootDropped = 21u;
const uint kMutantDistanceNotSquared = 22u;
const uint kMutantConeTooWide = 23u;
const uint kMutantHemisphereUniform = 24u;
const uint kMutantMirrorHalfTurned = 25u;
const uint kMutantSnellIgnored = 26u;
const uint kMutantFilterSignDropped = 27u;
const uint kMutantNumbersEqual = 28u;
const uint kMutantSampleIndexIgnored = 29u;
const uint kMutantEmissionAfterDeltaLost = 30u;
const uint kMutantScramblingMissing = 31u;
const uint kMutantDimensionsPaired = 32u;
const uint kMutantTreeShareForgotten = 33u;
const uint kMutantTreeCullsTooMuch = 34u;
const uint kMutantTreeMisForgotten = 35u;
const uint kMutantPlaneTooWide = 36u;
const uint kMutantStretchForgotten = 37u;
const uint kMutantConductorNormalIncidence = 38u;
const uint kMutantShadowingForgotten = 39u;
const uint kMutantFacetFresnelAtNormal = 40u;
const uint kMutantFacetPdfUnmasked = 41u;
const uint kMutantSampleCountsForgotten = 42u;
const uint kMutantSimpleCosineDropped = 43u;
const uint kMutantOcclusionWarpsSwapped = 44u;
const uint kMutantOcclusionEndless = 45u;
const uint kMutantHiddenEmittersOpaque = 46u;
const uint kMutantInstanceNormalMatrix = 47u;
const uint kMutantInstanceAreaNotScaled = 48u;
const uint kMutantInstanceRayNormalised = 49u;
const uint kMutantInstanceSideLost = 50u;
const uint kMutantInstanceNotLeft = 51u;
const uint kMutantLensTooWide = 52u;
const uint kMutantBladesIgnored = 53u;
const uint kMutantPanoramaEven = 54u;
const uint kMutantEnvironmentSineForgotten = 55u;
const uint kMutantEnvironmentUpsideDown = 56u;
const uint kMutantEnvironmentShifted = 57u;
const uint kMutantEnvironmentTwice = 58u;
const uint kMutantEnvironmentChoiceForgotten = 59u;
const uint kMutantLightsShareForgotten = 60u;
const uint kMutantSkyTurnedBack = 61u;
const uint kMutantDiskSquare = 62u;
const uint kMutantDiskAreaOfASquare = 63u;
const uint kMutantCylinderHalfArea = 64u;
const uint kMutantCylinderOutsideOnly = 65u;
const uint kMutantHalfTexel = 66u;
const uint kMutantRowsSwapped = 67u;
const uint kMutantWrapOffByOne = 68u;
const uint kMutantUvTransformInverted = 69u;
const uint kMutantSrgbLeftOut = 70u;
const uint kMutantLightTextureIgnored = 71u;
const uint kMutantPaneReflectsOnce = 72u;
const uint kMutantRefractionJacobian = 73u;
const uint kMutantRoughEtaOmitted = 74u;
const uint kMutantInnerReflectionForgotten = 75u;
const uint kMutantTransmittanceOnce = 76u;
const uint kMutantDiskTurnReversed = 77u;
const uint kMutantCylinderUpsideDown = 78u;
const uint kMutantSideByWinding = 79u;
const uint kMutantTiesReversed = 80u;
const uint kMutantPointDistanceNotSquared = 81u;
const uint kMutantPointWeighed = 82u;
const uint kMutantSpotFadesByCosine = 83u;
const uint kMutantProjectorByIntensity = 84u;
const uint kMutantDistantChoiceForgotten = 85u;
const uint kMutantSidesSwapped = 86u;
const uint kMutantBlendSwapped = 87u;
const uint kMutantMaskShadowsAll = 88u;
const uint kMutantMaskSidesTogether = 89u;
const uint kMutantPassesFree = 90u;
const uint kMutantNormalMapMirrored = 91u;
const uint kMutantRetroReflectionLost = 92u;
const uint kMutantAovFilterIgnored = 93u;
const uint kMutantAovSetSummed = 94u;
const uint kMutantAovOtherSample = 95u;
const uint kMutantAovEndsAtMirror = 96u;
const uint kMutantAovPlaceNotMoved = 97u;
const uint kMutantLightPartLate = 98u;
const uint kMutantBackgroundSeen = 99u;
const uint kMutantSheetRoughnessUnscaled = 100u;
const uint kMutantSheetPassesTwice = 101u;
const uint kMutantGltfCoatAdded = 102u;
const uint kMutantGltfBaseUndimmed = 103u;
const uint kMutantVolumeClear = 104u;
const uint kMutantFilmShiftForgotten = 105u;
const uint kMutantBumpByTexel = 106u;
const uint kMutantMapsShineThrough = 107u;
const uint kMutantCoatUnmasked = 108u;
const uint kMutantMixtureHalfWhole = 109u;
const uint kMutantMixtureHalfDense = 110u;
const uint kMutantCoatInsideForgotten = 111u;
const uint kMutantTintOnce = 112u;
const uint kMutantSquaresSwapped = 113u;
const uint kMutantVertexTintLeftOut = 114u;
const uint kMutantAlphaNotMultiplied = 115u;
const uint kMutantCoatNormalsIgnored = 116u;
const uint kMutantLampBackDark = 117u;
const uint kMutantDispersionReversed = 118u;
const uint kMutantLooseMapsTied = 119u;
const uint kMutantPartAreaWhole = 120u;
const uint kMutantPartMisplaced = 121u;
const uint kMutantTurnOfTextureLost = 122u;
const uint kMutantCount = 123u;
#endif

#ifdef __cplusplus
}  // namespace etendue::gpu
#elif defined(ETENDUE_MUTANTS)
layout(constant_id = kConstantMutant) const uint kMutant = kMutantNone;
// Does `action` (one statement) in the mutant called `id` only.
#define MUTATE(id, action) if (kMutant == (id)) { action; }
#else
#define MUTATE(id, action)
#endif

#endif
