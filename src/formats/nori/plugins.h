#pragma once
/// Everything a scene file of Nori's dialect can say, and what Etendue adds to it.

#include "formats/dialect/dialect.h"

namespace etendue {

const Dialect& nori_dialect();
/// The rows of lights without extent.
std::vector<Plugin> delta_light_plugins();
/// The rows of clear skies and their sun.
std::vector<Plugin> daylight_plugins();
/// The rows of materials.
std::vector<Plugin> bsdf_plugins();
/// The property for shading normals, of materials and meshes.
Parameter normals_parameter();
/// The rows of textures.
std::vector<Plugin> texture_plugins();
/// Other words for types and properties, most of them of courses.
std::vector<TypeAliases> nori_type_aliases();
std::vector<ParameterAlias> nori_parameter_aliases();
/// What courses' renderers have beside the properties of the tables.
std::vector<IgnoredTag> nori_ignored_tags();
std::vector<IgnoredProperties> nori_ignored_properties();
std::vector<UnsupportedProperties> nori_unsupported_properties();

}  // namespace etendue
