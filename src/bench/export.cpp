#include "bench/export.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <type_traits>

#include <fmt/core.h>

#include "core/errors.h"
#include "core/json.h"
#include "image/files.h"
#include "scene/materials.h"
#include "scene/parameters.h"
#include "scene/placed.h"

namespace etendue {
namespace {

static_assert(std::endian::native == std::endian::little, "the formats are little-endian");

// Bytes of a file in the making.
class Bytes {
 public:
  template <typename T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    append(std::as_bytes(std::span(&value, 1)));
  }
  void append(std::span<const std::byte> bytes) {
    const std::size_t end = bytes_.size();
    bytes_.resize(end + bytes.size());
    std::ranges::copy(bytes, bytes_.begin() + static_cast<std::ptrdiff_t>(end));
  }
  void text(const std::string& s) { append(std::as_bytes(std::span(s))); }
  /// Padded with zeros.
  void name(const std::string& s, std::size_t size) {
    std::string padded = s.substr(0, size);
    padded.resize(size, '\0');
    text(padded);
  }
  void vector(const glm::dvec3& v) { put(glm::vec3(v)); }
  const std::vector<std::byte>& get() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
};

Json json(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}

glm::dvec3 mirrored(const glm::dvec3& v, bool mirror) {
  return mirror ? glm::dvec3(-v.x, v.y, v.z) : v;
}

void write_ply(const PlacedMesh& mesh, bool mirror, const std::string& path) {
  const bool normals = mesh.has_normals();
  const std::size_t vertices = mesh.mesh().positions.size();
  Bytes out;
  out.text(fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty "
      "float z\n{}element face {}\nproperty list uchar int vertex_indices\nend_header\n",
      vertices, normals ? "property float nx\nproperty float ny\nproperty float nz\n" : "", mesh.triangle_count()));
  for (std::uint32_t i = 0; i < vertices; ++i) {
    out.vector(mirrored(mesh.position(i), mirror));
    if (normals) out.vector(mirrored(mesh.normal(i), mirror));
  }
  for (std::size_t i = 0; i < mesh.triangle_count(); ++i) {
    const glm::uvec3 t = mesh.indices(i);
    out.put(std::uint8_t{3});
    out.put(mirror ? glm::uvec3(t.x, t.z, t.y) : t);  // a mirror turns windings around
  }
  write_file_atomically(path, out.get());
}

Json bsdf_json(const Bsdf& bsdf) {
  if (const auto* diffuse = std::get_if<DiffuseBsdf>(&bsdf))
    return {{"type", "diffuse"}, {"albedo", json(diffuse->albedo.value)}};
  if (const auto* glass = std::get_if<DielectricBsdf>(&bsdf); glass != nullptr && !is_tinted(*glass))
    return {{"type", "dielectric"}, {"int_ior", glass->int_ior}, {"ext_ior", glass->ext_ior}};
  if (std::holds_alternative<MirrorBsdf>(bsdf)) return {{"type", "mirror"}};
  throw Error(
      ErrorKind::scene,
      "the comparison scenes support only diffuse, mirror and clear dielectric materials; this scene has another");
}

bool is_mirrored(const Camera& camera) {
  return glm::determinant(glm::dmat3(camera.world_from_camera)) < 0.0;
}

// A rigid camera: its axes of unit length, rows of the matrix, clipping distances in scene units.
Json camera_json(const Scene& scene) {
  const Camera& camera = scene.camera;
  glm::dmat3 axes(camera.world_from_camera);
  const double scale = glm::length(axes[2]);
  constexpr double kTolerance = 1e-6;
  for (int i = 0; i < 3; ++i) {
    const double along = glm::length(axes[i]) / scale - 1.0,
                 across = glm::dot(axes[i], axes[(i + 1) % 3]) / (scale * scale);
    if (std::abs(along) > kTolerance || std::abs(across) > kTolerance) {
      throw Error(
          ErrorKind::scene,
          fmt::format("{}:{}:{}: the camera's toWorld shears or scales its axes differently, which other programs "
                      "cannot do; export it without.",
                      camera.position.file, camera.position.line, camera.position.column));
    }
  }
  axes /= scale;
  glm::dvec3 origin(camera.world_from_camera[3]);
  if (is_mirrored(camera)) {
    for (int i = 0; i < 3; ++i) axes[i] = mirrored(axes[i], true);
    origin = mirrored(origin, true);
  }
  auto rows = Json::array();
  for (int r = 0; r < 3; ++r) rows.push_back({axes[0][r], axes[1][r], axes[2][r], origin[r]});
  rows.push_back({0.0, 0.0, 0.0, 1.0});
  return {{"width", camera.width},
          {"height", camera.height},
          {"fov", camera.fov},
          {"near", camera.near_clip * scale},
          {"far", camera.far_clip * scale},
          {"world_from_camera", rows}};
}

Json instance_json(const Scene& scene, const Instance& instance, bool mirror, const std::string& ply) {
  if (scene.materials[instance.material].adapter)
    throw Error(ErrorKind::scene, "the comparison scenes do not support adapters around materials; this scene has one");
  Json out = {{"name", instance.name}, {"bsdf", bsdf_json(scene.bsdf_of(instance))}, {"radiance", nullptr}};
  if (const AreaEmitter* emitter = scene.emitter_of(instance)) out["radiance"] = json(emitter->radiance.value);
  if (const auto* sphere = std::get_if<Sphere>(&scene.shape_of(instance))) {
    const Sphere placed = placed_sphere(*sphere, instance);
    out["sphere"] = {{"center", json(mirrored(placed.center, mirror))}, {"radius", placed.radius}};
  } else if (!std::holds_alternative<TriangleMesh>(scene.shape_of(instance))) {
    throw Error(ErrorKind::scene, fmt::format("{} is neither mesh nor sphere; others are not exported", instance.name));
  } else {
    const auto& mesh = std::get<TriangleMesh>(scene.shape_of(instance));
    out["mesh"] = {{"file", ply}, {"triangles", mesh.triangles.size()}, {"normals", !mesh.normals.empty()}};
  }
  return out;
}

/// The files know constants alone: what is textured would silently be another scene.
void refuse_textures(const Scene& scene) {
  const auto refuse = [&](const std::string& what) {
    throw Error(ErrorKind::scene,
                fmt::format("{}: {} has a texture, which the comparison scenes do not support; write the "
                            "scene with etendue convert --to mitsuba",
                            scene.file, what));
  };
  for (const Instance& instance : scene.instances) {
    if (is_textured(scene.bsdf_of(instance))) refuse(scene.materials[instance.material].name);
    const AreaEmitter* emitter = scene.emitter_of(instance);
    if (emitter != nullptr && is_textured(*emitter)) refuse(instance.name);
  }
}

void make_folder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw Error(ErrorKind::file, fmt::format("{}: cannot make the folder: {}", folder, error.message()));
}

}  // namespace

void export_scene(const Scene& scene, const std::string& folder) {
  const Integrator::Type type = scene.integrator.type;
  if (type != Integrator::Type::path && type != Integrator::Type::normals)
    throw Error(
        ErrorKind::usage,
        fmt::format("{}: the integrator is neither path nor normals, which are the only ones for other renderers",
                    scene.file));
  if (scene.camera.type != Camera::Type::perspective || scene.camera.fov_axis != Camera::FovAxis::x ||
      !scene.camera.window.whole())
    throw Error(ErrorKind::usage,
                fmt::format("{}: only plain perspective cameras are exported to other renderers", scene.file));
  if (scene.sky.picture || scene.sky.world_from_sky != glm::dmat3(1.0))
    throw Error(ErrorKind::usage, fmt::format("{}: skies that are pictures or turned are not exported; use sky_top and "
                                              "sky_horizon",
                                              scene.file));
  refuse_textures(scene);
  if (!scene.delta_lights.empty())
    throw Error(ErrorKind::usage,
                fmt::format("{}: lights without extent are not exported; use lamps that have one", scene.file));
  make_folder(folder);
  const bool mirror = is_mirrored(scene.camera);
  const Integrator& i = scene.integrator;
  Json out = {{"name", scene.name},
              {"camera", camera_json(scene)},
              {"integrator",
               {{"type", i.type == Integrator::Type::path ? "path" : "normals"},
                {"max_depth", i.max_depth},
                {"rr_depth", i.rr_depth},
                {"nee", i.nee},
                {"mis", i.mis}}},
              {"samples", scene.sampler.sample_count},
              {"sky", {{"top", json(scene.sky.top)}, {"horizon", json(scene.sky.horizon)}}},
              {"shapes", Json::array()}};
  for (std::size_t k = 0; k < scene.instances.size(); ++k) {
    const Instance& instance = scene.instances[k];
    const std::string ply = fmt::format("shape-{}.ply", k);
    if (const auto* mesh = std::get_if<TriangleMesh>(&scene.shape_of(instance)))
      write_ply(PlacedMesh(*mesh, instance), mirror, (std::filesystem::path(folder) / ply).string());
    out["shapes"].push_back(instance_json(scene, instance, mirror, ply));
  }
  const std::string text = out.dump(1) + "\n";
  write_file_atomically((std::filesystem::path(folder) / "scene.json").string(), std::as_bytes(std::span(text)));
}

void export_rays(const Scene& scene, const Placement& placement, const std::vector<RaySet>& sets,
                 const std::vector<std::vector<CastHit>>& hits, const std::string& path) {
  Bytes triangles, spheres;
  const auto place = [&](const glm::dvec3& p) { return (p - placement.center) * placement.scale; };
  for (const Instance& instance : scene.instances) {
    if (const auto* sphere = std::get_if<Sphere>(&scene.shape_of(instance))) {
      const Sphere placed = placed_sphere(*sphere, instance);
      spheres.vector(place(placed.center));
      spheres.put(static_cast<float>(placed.radius * placement.scale));
      continue;
    }
    const PlacedMesh mesh(std::get<TriangleMesh>(scene.shape_of(instance)), instance);
    for (std::size_t i = 0; i < mesh.triangle_count(); ++i) {
      for (const glm::dvec3& p : mesh.triangle(i)) triangles.vector(place(p));
    }
  }
  Bytes out;
  out.text("ETDRAYS1");
  out.put(std::uint64_t{triangles.get().size() / (9 * sizeof(float))});
  out.put(std::uint64_t{spheres.get().size() / (4 * sizeof(float))});
  out.put(std::uint64_t{sets.size()});
  out.append(triangles.get());
  out.append(spheres.get());
  for (std::size_t i = 0; i < sets.size(); ++i) {
    const bool any = sets[i].query == RayQuery::any;
    out.name(sets[i].kind, 16);
    out.put(std::uint32_t{sets[i].shuffled});
    out.put(std::uint32_t{any});
    out.put(std::uint64_t{sets[i].rays.size()});
    out.append(std::as_bytes(std::span(sets[i].rays)));
    for (const CastHit& hit : hits[i])
      out.put(hit.instance == CastHit::kNone ? std::numeric_limits<float>::infinity() : any ? 0.0f : hit.t);
  }
  write_file_atomically(path, out.get());
}

}  // namespace etendue
