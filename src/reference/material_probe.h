#pragma once
/// The reference's materials for the tests of sampling.

#include "render/bsdf_probe.h"

namespace etendue {

std::unique_ptr<BsdfProbe> make_reference_bsdf_probe(const Scene& patch);

}  // namespace etendue
