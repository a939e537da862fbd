#include "formats/model/model_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/text.h"
#include "formats/model/mtl_reader.h"
#include "formats/model/studio.h"
#include "formats/obj/obj_reader.h"
#include "formats/ply/ply_reader.h"
#include "scene/invariants.h"
#include "scene/limits.h"
#include "scene/parameters.h"

namespace etendue {
namespace {

namespace fs = std::filesystem;

std::string lower_extension(const std::string& path) {
  std::string extension = fs::path(path).extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return extension;
}

/// Cuts a mesh into the parts of each material, in time that depends on its size alone.
class Parts {
 public:
  Parts(const TriangleMesh& whole, const std::vector<std::uint32_t>& of_triangle, std::size_t materials)
      : whole_(whole),
        first_(materials + 1, 0),
        places_(whole.positions.size()),
        owners_(whole.positions.size(), kNone) {
    for (const std::uint32_t material : of_triangle) ++first_[material + 1];
    for (std::size_t i = 0; i < materials; ++i) first_[i + 1] += first_[i];
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    order_.resize(of_triangle.size());
    for (std::size_t i = 0; i < of_triangle.size(); ++i) order_[next[of_triangle[i]]++] = static_cast<std::uint32_t>(i);
  }

  bool empty(std::uint32_t material) const { return first_[material] == first_[material + 1]; }

  /// The triangles of one material, with the vertices that they use.
  TriangleMesh operator()(std::uint32_t material) {
    TriangleMesh part;
    part.uv_sets.resize(whole_.uv_sets.size());
    for (std::size_t i = first_[material]; i < first_[material + 1]; ++i) {
      glm::uvec3 triangle = whole_.triangles[order_[i]];
      for (int k = 0; k < 3; ++k) triangle[k] = place(triangle[k], material, part);
      part.triangles.push_back(triangle);
      if (!whole_.face_colors.empty()) part.face_colors.push_back(whole_.face_colors[order_[i]]);
    }
    return part;
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  std::uint32_t place(std::uint32_t vertex, std::uint32_t material, TriangleMesh& part) {
    if (owners_[vertex] == material) return places_[vertex];
    owners_[vertex] = material;
    places_[vertex] = static_cast<std::uint32_t>(part.positions.size());
    part.positions.push_back(whole_.positions[vertex]);
    if (!whole_.normals.empty()) part.normals.push_back(whole_.normals[vertex]);
    if (!whole_.vertex_colors.empty()) part.vertex_colors.push_back(whole_.vertex_colors[vertex]);
    for (std::size_t set = 0; set < whole_.uv_sets.size(); ++set)
      part.uv_sets[set].push_back(whole_.uv_sets[set][vertex]);
    return places_[vertex];
  }

  const TriangleMesh& whole_;
  std::vector<std::size_t> first_;              ///< of each material's triangles in `order_`
  std::vector<std::uint32_t> order_;            ///< triangles by material
  std::vector<std::uint32_t> places_, owners_;  ///< of vertices: in the part of the material that had them last
};

class ModelReader {
 public:
  ModelReader(const std::string& path, bool shows_uv, Diagnostics& diagnostics)
      : path_(path), shows_uv_(shows_uv), sink_(diagnostics) {
    scene_.name = fs::path(path).stem().string();
    scene_.file = path;
    scene_.position = {path, 0, 0};
  }

  std::optional<Scene> read() {
    lower_extension(path_) == ".obj" ? read_obj_parts() : read_ply_mesh();
    if (sink_.has_errors()) return std::nullopt;
    if (scene_.instances.empty()) {
      sink_.error(scene_.position, "the mesh has no faces; there is nothing to show");
      return std::nullopt;
    }
    frame_camera(scene_);
    add_studio_sky(scene_);
    set_viewer_sampling(scene_);
    sink_.warning(scene_.position,
                  "a mesh alone: it is seen from a camera framed on it, under a soft grey sky; --camera and "
                  "--environment give others");
    return std::move(scene_);
  }

 private:
  void read_ply_mesh() {
    std::optional<TriangleMesh> mesh = open([&] { return read_ply(path_, {.uv = shows_uv_, .colors = true}, sink_); });
    if (!mesh || mesh->triangles.empty()) return;
    add_part(std::move(*mesh), nullptr, fs::path(path_).filename().string());
  }

  void read_obj_parts() {
    ObjMaterials materials;
    std::optional<TriangleMesh> mesh =
        open([&] { return read_obj(path_, {.uv = true, .colors = true}, materials, sink_); });
    if (!mesh || mesh->triangles.empty()) return;
    read_libraries(materials);
    Parts parts(*mesh, materials.of_triangle, materials.names.size());
    for (std::uint32_t row = 0; row < materials.names.size(); ++row) {
      if (parts.empty(row)) continue;
      const std::string& name = materials.names[row];
      const auto found = library_.find(name);
      if (found == library_.end() && !name.empty())
        sink_.warning(scene_.position, fmt::format("no library has the material {}; it is grey", text::quoted(name)));
      add_part(parts(row), found == library_.end() ? nullptr : &found->second, name.empty() ? "mesh" : name);
    }
  }

  template <typename Open>
  std::optional<TriangleMesh> open(const Open& read) {
    try {
      return read();
    } catch (const Error& error) {
      sink_.error({}, error.what(), error.kind());
      return std::nullopt;
    }
  }

  /// Each library once: some programs name it again for every object.
  void read_libraries(const ObjMaterials& materials) {
    std::set<fs::path> known;
    std::uintmax_t bytes = 0;
    for (std::string name : materials.libraries) {
      std::ranges::replace(name, '\\', '/');
      const std::string library = (fs::path(path_).parent_path() / name).string();
      std::error_code unknown;
      if (!known.insert(fs::weakly_canonical(library, unknown)).second) continue;
      const std::uintmax_t size = fs::file_size(library, unknown);
      if (!unknown) bytes += size;
      if (bytes > MtlLimits::kMaxBytes) {
        return sink_.warning(scene_.position, fmt::format("with {} the libraries have {} bytes; at most {} are read: "
                                                          "its materials and those of later ones are grey",
                                                          text::quoted(name), bytes, MtlLimits::kMaxBytes));
      }
      try {
        read_mtl(library, library_, sink_);
      } catch (const Error& error) {
        sink_.warning(scene_.position, fmt::format("library {}; its materials are grey", error.what()));
      }
    }
  }

  void add_part(TriangleMesh mesh, const MtlMaterial* material, const std::string& name) {
    Bsdf bsdf = DiffuseBsdf{glm::dvec3(0.6)};
    std::optional<AreaEmitter> emitter;
    ScalarParameter opacity(1.0);
    const bool has_uv = !mesh.uv_sets.empty();
    if (material != nullptr) {
      bsdf = bsdf_of(*material, has_uv);
      emitter = emitter_of(*material, has_uv);
      if (!is_glass(*material)) opacity = opacity_of(*material, has_uv);
    } else if (!mesh.face_colors.empty() || !mesh.vertex_colors.empty()) {
      using Source = AttributeTexture::Source;
      const Source source = mesh.vertex_colors.empty() ? Source::face_color : Source::vertex_color;
      bsdf = DiffuseBsdf{ColorParameter(glm::dvec3(1.0), add({.source = AttributeTexture{source}, .name = "colours"}))};
    }
    const bool textured = is_textured(bsdf) || (emitter && is_textured(*emitter)) || opacity.texture;
    if (!textured && !shows_uv_) mesh.uv_sets.clear();
    if (!textured || material != nullptr) {
      mesh.vertex_colors.clear();
      mesh.face_colors.clear();
    }
    Instance& instance = scene_.add(std::move(mesh), std::move(bsdf), std::move(emitter));
    instance.name = name;
    instance.position = scene_.position;
    scene_.materials[instance.material].name = name;
    scene_.materials[instance.material].position = material != nullptr ? material->position : scene_.position;
    if (!opacity.texture && opacity.value == 1.0) return;
    Material mask{.bsdf = DiffuseBsdf{}, .adapter = MaskAdapter{opacity, instance.material}, .name = name};
    mask.position = material->position;
    instance.material = static_cast<std::uint32_t>(scene_.materials.size());
    scene_.materials.push_back(std::move(mask));
  }

  /// Refraction is asked for, and there is something to see through.
  static bool is_glass(const MtlMaterial& m) {
    const bool refracts = m.illumination == 4 || m.illumination == 6 || m.illumination == 7 || m.illumination == 9;
    return refracts && m.opacity < 1.0 && !m.opacity_map;
  }

  /// The alpha of its picture, or the luminance of one without.
  ScalarParameter opacity_of(const MtlMaterial& m, bool has_uv) {
    if (!m.opacity_map || !has_uv) return m.opacity;
    const auto row = texture(*m.opacity_map, m.position);
    if (!row) return m.opacity;
    auto& picture = std::get<BitmapTexture>(scene_.textures[*row].source);
    picture.color_space = ColorSpace::linear;  // numbers, no colours
    const bool alpha = scene_.bitmaps[picture.bitmap]->has_alpha();
    // What is 0 everywhere would hide the picture.
    return {m.opacity > 0.0 ? m.opacity : 1.0, *row, alpha ? TextureChannel::alpha : TextureChannel::luminance};
  }

  /// Phong's exponents as the roughness of microfacets whose lobe is as wide [Walter2007].
  static double roughness_of(const MtlMaterial& m) {
    if (m.roughness) return std::max(*m.roughness * *m.roughness, kMinRoughness);
    return std::clamp(std::sqrt(2.0 / (m.exponent + 2.0)), kMinRoughness, 1.0);
  }

  Bsdf bsdf_of(const MtlMaterial& m, bool has_uv) {
    const double index = m.index > 1.0 + kMinIndexContrast && m.index < kMaxCoatIndex ? m.index : 1.5;
    if (is_glass(m)) return DielectricBsdf{.int_ior = index};
    const double alpha = roughness_of(m);
    if (m.metallic && *m.metallic >= 0.5) {
      RoughConductorBsdf metal;
      metal.roughness = {Roughness::Distribution::ggx, alpha, alpha};
      if (assign(metal.specular_reflectance, m, has_uv)) return metal;
    }
    const bool mirror = (m.illumination == 3 || m.illumination == 5 || m.illumination == 8) && is_black(m.diffuse);
    if (mirror && !is_black(m.specular)) return ConductorBsdf{.index = {}, .specular_reflectance = m.specular};
    DiffuseBsdf diffuse;
    assign(diffuse.albedo, m, has_uv);
    const bool glossy = m.illumination >= 2 && !is_black(m.specular) && (m.exponent > 1.0 || m.roughness);
    if (!glossy) return diffuse;
    RoughPlasticBsdf plastic{.int_ior = index, .ext_ior = 1.0, .nonlinear = false};
    plastic.distribution = Roughness::Distribution::ggx;
    plastic.alpha = alpha;
    return assign(plastic.diffuse_reflectance, m, has_uv) ? Bsdf(plastic) : Bsdf(diffuse);
  }

  static bool is_black(const glm::dvec3& c) { return c == glm::dvec3(0.0); }

  /// The diffuse colour with its picture; false where the parameter cannot have one.
  bool assign(ColorParameter& field, const MtlMaterial& m, bool has_uv) {
    field.value = m.diffuse;
    field.texture.reset();
    if (!m.diffuse_map || !has_uv) return true;
    const auto row = texture(*m.diffuse_map, m.position);
    // A picture is the colour itself in most files, whose Kd is then 0 or 0.8 for no reason.
    if (row) field = ColorParameter(is_black(m.diffuse) ? glm::dvec3(1.0) : m.diffuse, *row);
    return true;
  }
  bool assign(glm::dvec3& field, const MtlMaterial& m, bool has_uv) {
    field = m.diffuse;
    return !m.diffuse_map || !has_uv;
  }

  std::optional<AreaEmitter> emitter_of(const MtlMaterial& m, bool has_uv) {
    if (is_black(m.emission) && !m.emission_map) return std::nullopt;
    AreaEmitter emitter{m.emission, m.position};
    if (m.emission_map && has_uv) {
      if (const auto row = texture(*m.emission_map, m.position))
        emitter.radiance = ColorParameter(is_black(m.emission) ? glm::dvec3(1.0) : m.emission, *row);
    }
    if (!emitter.radiance.texture && is_black(emitter.radiance.value)) return std::nullopt;
    return emitter;
  }

  std::optional<std::uint32_t> texture(const MtlMap& map, const SourcePosition& position) {
    const std::string path = (fs::path(position.file).parent_path() / map.filename).string();
    const auto [known, is_new] = bitmaps_.try_emplace(path);
    if (is_new) {
      try {
        auto bitmap = std::make_shared<Bitmap>(read_bitmap(path));
        known->second = static_cast<std::uint32_t>(scene_.bitmaps.size());
        scene_.bitmaps.push_back(std::move(bitmap));
      } catch (const Error& error) {
        sink_.warning(position, fmt::format("picture {}; the material is shown without it", error.what()));
      }
    }
    if (!known->second) return std::nullopt;
    const TextureWrap wrap = map.clamp ? TextureWrap::clamp : TextureWrap::repeat;
    return add({.source = BitmapTexture{.bitmap = *known->second, .wrap_u = wrap, .wrap_v = wrap, .color_space = {}},
                .uv_transform = {map.scale.x, 0.0, 0.0, 0.0, map.scale.y, 0.0, map.offset.x, map.offset.y, 1.0},
                .name = fs::path(path).filename().string(),
                .position = position});
  }

  std::uint32_t add(Texture texture) {
    scene_.textures.push_back(std::move(texture));
    return static_cast<std::uint32_t>(scene_.textures.size() - 1);
  }

  std::string path_;
  bool shows_uv_;
  Diagnostics& sink_;
  Scene scene_;
  std::map<std::string, MtlMaterial> library_;
  std::map<std::string, std::optional<std::uint32_t>> bitmaps_;  ///< by path
};

}  // namespace

bool is_model(const std::string& path) {
  const std::string extension = lower_extension(path);
  return extension == ".obj" || extension == ".ply";
}

std::optional<Scene> read_model(const std::string& path, const ReadOptions& options, Diagnostics& diagnostics) {
  const std::size_t errors_before = diagnostics.error_count();
  std::optional<Scene> scene = ModelReader(path, options.shows_uv, diagnostics).read();
  if (scene && diagnostics.error_count() == errors_before) check_invariants(*scene, diagnostics);
  if (diagnostics.error_count() > errors_before) return std::nullopt;
  return scene;
}

}  // namespace etendue
