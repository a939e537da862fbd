#include "formats/nori/plugins.h"

#include <initializer_list>
#include <iterator>

namespace etendue {
namespace {

/// Words that courses and other renderers use for the same things; other spellings of them are read, too.
std::vector<TypeAliases> integrator_aliases() {
  return {
      {"integrator", "ao", {"ambient_occlusion"}},
      {"integrator", "av", {"average_visibility"}},
      {"integrator",
       "path_mis",
       {"path_tracer", "path_tracing", "path_trace", "mipath", "mi_path", "path_tracer_recursive", "repath", "path_ris",
        "path_ris_mis"}},
      {"integrator", "path_ems", {"path_nee", "vol_path_ems"}},
      {"integrator",
       "path_mats",
       {"path_brdf", "path_bsdf", "path_naive", "bsdf_path", "simple_path", "path_ris_mats"}},
      {"integrator",
       "path_vol",
       {"volumetric_path",
        "volume",
        "volume_pt",
        "vol_pt",
        "path_volume",
        "volpath_mis",
        "volumetric_path_tracer",
        "path_vol_mis",
        "path_mis_vol",
        "volumetric",
        "volume_path_tracer",
        "path_vol2",
        "path_mis_hpm",
        "vol_path_integrator",
        "volum1",
        "volum2",
        "volum3",
        "volum4",
        "volum5",
        "volum6",
        "volum7",
        "vol_path_mis_simple",
        "vol_path_simple"}},
      {"integrator", "vol_path_mats", {"volpath_mats", "path_vol_mats"}},
      {"integrator",
       "direct_ems",
       {"direct_light", "direct_lighting", "direct_illumination", "direct_nee", "direct_ris_ems"}},
      {"integrator", "direct_mats", {"direct_bsdf", "direct_ris_hemi", "direct_ris_mat"}},
      {"integrator", "direct_mis", {"mi_direct", "redirect", "direct_ris"}},
      {"integrator", "normals", {"normal"}},
      {"integrator",
       "photonmapper",
       {"photon_mapping", "photon_map", "pmap", "progressive_photon_mapper", "progressive_photon_mapping", "ppm",
        "sppm", "ppmap", "debiased_pm", "debiased_ppm", "photo_mapper", "probabilistic_ppm", "volumetric_photon_mapper",
        "vol_photon_mapper"}},
      {"integrator", "bdpt", {"bidirectional", "light_tracer", "particle_tracer"}},
      {"integrator", "mlt", {"metropolis", "pssmlt"}},
  };
}

/// Words for a picture that stands in a material or a mesh: by its name, <string name="texture_file" …>, or as a
/// texture.
std::vector<ParameterAlias> picture_aliases() {
  std::vector<ParameterAlias> all;
  const auto add = [&](std::initializer_list<const char*> words, std::initializer_list<const char*> names,
                       const char* tag, const char* element) {
    for (const char* word : words) {
      for (const char* name : names) all.push_back({word, name, tag, element});
    }
  };
  add({"texture", "texture_file", "texture_filename", "texture_map", "texture_path", "text_file", "path", "filename",
       "file", "image", "albedo_texture", "albedo_file", "diffuse_texture", "color_texture", "base_color_texture"},
      {"albedo", "kd", "base_color", "diffuse_reflectance"}, "bsdf", "string");
  add({"roughness_texture", "roughness_file"}, {"roughness"}, "bsdf", "string");
  add({"metallic_texture"}, {"metallic"}, "bsdf", "string");
  add({"subsurface_texture"}, {"flatness"}, "bsdf", "string");
  add({"alpha_texture", "alpha_map", "opacity_texture"}, {"opacity"}, "bsdf", "string");
  for (const char* tag : {"bsdf", "mesh"}) {
    add({"normal", "normal_map", "normal_texture", "normal_file", "normal_filename", "normal_path", "nmap"},
        {"normals"}, tag, "");
  }
  add({"roughness_map"}, {"roughness"}, "bsdf", "");
  add({"metallic_map", "metalness_map"}, {"metallic"}, "bsdf", "");
  add({"albedo_map", "diffuse_map", "base_color_map", "color_map"}, {"albedo", "kd", "base_color"}, "bsdf", "");
  add({"albedo", "color"}, {"texture"}, "mesh", "texture");
  return all;
}

std::vector<ParameterAlias> plain_aliases() {
  return {
      {"scale", "tile", "texture", "vector"},
      {"scalev2f", "tile", "texture", "vector"},
      {"lens_radius", "apertureRadius"},
      {"radius", "apertureRadius", "camera"},
      {"focal", "focusDistance", "camera"},
      {"aperture", "apertureRadius"},
      {"focal_distance", "focusDistance"},
      {"focus_dist", "focusDistance"},
      {"focal_dist", "focusDistance"},
      {"focal_plane", "focusDistance"},
      {"rr_start", "rrDepth"},
      {"max_bounces", "maxDepth"},
      {"depth", "maxDepth", "integrator"},
      {"rr_min_bounces", "rrDepth"},
      {"spp", "sampleCount"},
      {"samples", "sampleCount"},
      {"current_sample_count", "sampleCount"},
      {"brdf_samples", "bsdfSamples"},
      {"reflectance", "albedo"},
      {"albedo", "base_color"},
      {"albedo", "kd"},
      {"albedo", "diffuse_reflectance"},
      {"color", "albedo", "bsdf"},
      {"color", "base_color", "bsdf"},
      {"metal", "metallic", "bsdf"},
      {"albedo", "value", "texture"},
      {"color", "value", "texture"},
      {"kd", "diffuse_reflectance"},
      {"ks", "specular_reflectance"},
      {"material_name", "material"},
      {"cior", "material"},
      {"radiance", "intensity"},
      {"energy", "power"},
      {"power", "energy", "integrator"},
      {"base_colour", "base_color"},
      {"subsurface", "flatness"},
      {"specular_tint", "spec_tint"},
      {"specular_transmission", "spec_trans"},
      {"ior", "intIOR"},
      {"interpolation", "filter_type", "texture"},
      {"extension", "wrap_mode", "texture"},
      {"wrap", "wrap_mode", "texture"},
      {"ray_length", "length"},
      {"look_at", "target"},
  };
}

/// Of pictures and lights.
std::vector<ParameterAlias> light_aliases() {
  return {
      {"file", "filename"},
      {"path", "filename"},
      {"image", "filename"},
      {"image_name", "filename"},
      {"texture_path", "filename", "texture"},
      {"filepath", "filename"},
      {"exr_path", "filename"},
      {"openexr", "filename"},
      {"envfile", "filename", "emitter"},
      {"mapname", "filename", "emitter"},
      {"env_map_path", "filename", "emitter"},
      {"path2map", "filename", "emitter"},
      {"power", "irradiance", "emitter"},
      {"strength", "scale", "emitter"},
      {"radiance_scale", "scale", "emitter"},
      {"intensity", "scale", "emitter"},
      {"albedo", "radiance", "emitter"},
      {"envmap", "radiance", "emitter"},
      {"texture", "radiance", "emitter"},
      {"origin", "position", "emitter"},
  };
}

}  // namespace

std::vector<TypeAliases> nori_type_aliases() {
  std::vector<TypeAliases> all = integrator_aliases();
  const TypeAliases others[] = {
      {"camera",
       "thinlens",
       {"thin_lens", "lens", "depth_of_field", "dof", "advanced_camera", "perspective_depth", "perspective_dof",
        "thin_lens_perspective"}},
      {"camera", "spherical", {"panorama"}},
      {"camera", "orthographic", {"ortho"}},
      {"sampler",
       "sobol",
       {"stratified", "halton", "ldsampler", "low_discrepancy", "multijitter", "hammersley", "adaptive",
        "halton_decorr"}},
      {"sampler", "independent", {"random"}},
      {"bsdf", "diffuse", {"lambertian", "lambert", "disney_diffuse", "diffuse with texture"}},
      {"bsdf", "mirror", {"specular"}},
      {"bsdf", "dielectric", {"glass", "smooth_dielectric"}},
      {"bsdf", "thindielectric", {"thin_glass"}},
      {"bsdf", "roughdielectric", {"rough_glass", "microfacet_dielectric"}},
      {"bsdf", "conductor", {"metal", "smooth_conductor"}},
      {"bsdf", "roughconductor", {"rough_metal"}},
      {"bsdf", "null", {"null_bsdf", "passthrough", "transparent"}},
      {"bsdf", "normalmap", {"normal_map"}},
      {"bsdf", "bumpmap", {"bump_map"}},
      {"bsdf", "principled", {"disney", "disney_bsdf", "disney_brdf"}},
      {"bsdf", "blend", {"blend_bsdf", "mix"}},
      {"bsdf", "twosided", {"two_sided"}},
      {"emitter", "point", {"point_light"}},
      {"emitter", "spot", {"spot_light"}},
      {"emitter", "directional", {"directional_light", "distant_light", "parallel"}},
      {"emitter", "area", {"area_light", "mesh_light", "parallelogram_emitter"}},
      {"emitter",
       "envmap",
       {"environment", "environment_map", "environment_light", "env_light", "env", "env_mapper", "enviorement", "ibl",
        "infinite", "infinite_area", "png_env"}},
      {"emitter", "constant", {"constant_light"}},
      {"texture",
       "bitmap",
       {"image", "image_texture", "png_texture", "image_texture_legacy", "image_texture_simple", "imagetexture_color3f",
        "textmap", "texture_map", "bitmap_texture", "texture", "color_texture", "normal_map", "normal_texture",
        "image_texture_float", "image_normal"}},
      {"texture", "checkerboard", {"checkerboard_texture"}},
      {"texture", "constant_color", {"constant", "solid", "solid_color", "uniform"}},
      {"mesh", "rectangle", {"quad"}},
      {"mesh", "cube", {"box"}},
      {"mesh", "obj", {"wavefront"}},
  };
  all.insert(all.end(), std::begin(others), std::end(others));
  return all;
}

std::vector<ParameterAlias> nori_parameter_aliases() {
  std::vector<ParameterAlias> all = plain_aliases();
  for (const std::vector<ParameterAlias>& more : {light_aliases(), picture_aliases()})
    all.insert(all.end(), more.begin(), more.end());
  return all;
}

std::vector<IgnoredTag> nori_ignored_tags() {
  const char* faster = "acceleration structures do not change the picture";
  return {{"acceleration", faster, false},
          {"accel", faster, false},
          {"bvh", faster, false},
          {"rendermanager", "how the work is divided does not change the picture", false},
          {"denoiser", "rendering does not denoise; use `etendue denoise` afterwards", true}};
}

std::vector<IgnoredProperties> nori_ignored_properties() {
  const char* noise = "it changes the noise, not the picture";
  return {
      {"integrator",
       {},
       {"rr",
        "rr_prob",
        "rr_dynamic",
        "use_nee",
        "use_mis",
        "photon_count",
        "photon_radius",
        "surface_sampling",
        "mis_sampling",
        "strategy",
        "cosine_sampling",
        "sampling_method",
        "heuristic",
        "tracer_type",
        "termination",
        "termination_prob",
        "direct_sampling",
        "indirect_sampling",
        "prob_stop_query",
        "num_candidates",
        "media_direct_illum"},
       noise},
      {"integrator",
       {"path_mis", "path_mats", "path_ems", "path_vol", "vol_path_mis", "vol_path_mats", "photonmapper", "bdpt",
        "mlt"},
       {"nee", "mis", "emitter_samples", "bsdf_samples", "brdf_samples"},
       noise},
      {"integrator", {"photonmapper"}, {"iterations", "num_iterations", "k", "alpha", "photons"}, noise},
      {"sampler", {}, {"n_passes", "seed", "initial_uniform", "initial_samples", "threshold"}, noise},
      {"bsdf", {}, {"use_cosine"}, noise},
      {"bsdf",
       {"diffuse", "mirror", "dielectric"},
       {"metallic", "subsurface", "specular", "specular_tint", "roughness", "anisotropic", "sheen", "sheen_tint",
        "clearcoat", "clearcoat_gloss"},
       "it is a number of Disney's material, which this one is not"},
      {"bsdf", {"conductor"}, {"alpha"}, "this metal is smooth; for a rough one use roughconductor"},
      {"bsdf", {"mirror", "diffuse"}, {"int_ior", "ext_ior"}, "this material has no index of refraction"},
      {"mesh", {}, {"name"}, "a name means nothing"},
      {"emitter", {}, {"use_is", "light_weight"}, noise},
      {"emitter", {"envmap"}, {"interpolate"}, "pictures of the sky are interpolated"},
      {"emitter", {"envmap"}, {"rotate"}, "the course that has it does not turn its sky; use toWorld"},
      {"emitter", {}, {"sphere_texture"}, "the emitter takes the texture coordinates of its mesh"},
      {"texture", {}, {"id", "spherical_texture", "projection"}, "a texture takes the coordinates of its surface"},
      {"integrator", {"normals", "depth", "av", "ao"}, {"position", "energy"}, "there is no light in this picture"},
      {"scene", {}, {"save"}, "`render -o` names the picture"},
      {"scene", {}, {"ev_compensation"}, "it is about showing the picture; use `render --exposure`"},
  };
}

std::vector<UnsupportedProperties> nori_unsupported_properties() {
  return {
      {"camera",
       {"motion_blur", "motion_blur_velocity", "motion", "shutter_open", "shutter_close", "velocity"},
       "motion blur"},
      {"camera",
       {"distortion", "lens_distortion", "radial_distortion", "radial_distortion_coeff", "k1", "k2", "k3",
        "has_distortion"},
       "lens distortion"},
      {"camera",
       {"chromatic_aberration", "chromatic_aberration_weight", "aberration", "has_aberration", "chromatic_aberation"},
       "chromatic aberration"},
      {"camera", {"vignetting"}, "vignetting"},
      {"camera", {"bokeh"}, "lens of that shape"},
      {"integrator", {"radius"}, "light of that size"},
      {"integrator", {"sigma_s", "sigma_t", "sigma_a", "helios_coeff"}, "medium"},
      {"emitter", {"half1", "half2"}, "sky of two pictures"},
      {"emitter", {"rotation", "offset_y", "offset_z1", "offset_z2"}, "turn of a sky but by its transform toWorld"},
      {"emitter", {"angle", "cone"}, "light of that angle by this word"},
      {"emitter", {"base_color"}, "second colour of a light"},
      {"emitter", {"center", "radius"}, "emitter of that size"},
      {"texture", {"euler_angles"}, "turn of a picture but by to_uv"},
      {"texture", {"shift"}, "shift of a picture but by delta"},
      {"bsdf", {"r0"}, "metal given by its reflectance at normal incidence"},
      {"bsdf", {"if_normal_map"}, "normal map without its picture"},
      {"scene", {"bloom_intensity"}, "bloom"},
      {"scene", {"envmap_rotation"}, "turn of a sky but by toWorld of an emitter envmap"},
  };
}

}  // namespace etendue
