#pragma once
/// The scene description as plain, validated structs. Nothing here depends on how it is rendered. Both renderers start
/// from this type; positions are double-precision world space.

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <glm/glm.hpp>

#include "image/aov.h"
#include "image/bitmap.h"
#include "scene/adapters.h"
#include "scene/bsdfs.h"
#include "scene/camera_path.h"
#include "scene/sky.h"
#include "scene/source_position.h"
#include "scene/texture.h"
#include "scene/vector_list.h"

namespace etendue {

/// Lambertian reflection, one-sided. `albedo` in [0,1] per Rec. 709 component.
struct DiffuseBsdf {
  ColorParameter albedo{glm::dvec3(0.5)};
};
/// Perfect specular reflection with reflectance 1, one-sided.
struct MirrorBsdf {};
/// Smooth dielectric interface; the normal points to the exterior.
struct DielectricBsdf {
  double int_ior = 1.5046;
  double ext_ior = 1.000277;
  ColorParameter specular_reflectance{glm::dvec3(1.0)};
  ColorParameter specular_transmittance{glm::dvec3(1.0)};
};
using Bsdf = std::variant<DiffuseBsdf, MirrorBsdf, DielectricBsdf, MicrofacetBsdf, ConductorBsdf, RoughConductorBsdf,
                          RoughDielectricBsdf, ThinDielectricBsdf, PlasticBsdf, RoughPlasticBsdf, NullBsdf,
                          PrincipledBsdf, PrincipledThinBsdf, GltfBsdf>;

/// A material and its position in the file. Everything that scatters light at a surface is one of these.
struct Material {
  Bsdf bsdf;                       ///< ignored if there is an adapter
  std::optional<Adapter> adapter;  ///< chooses among earlier rows of the table
  std::string name;                ///< for messages: the id or type it has in the file
  SourcePosition position;         ///< its tag, or that of its instance if it is the default
};

/// Emits `radiance` (W·sr⁻¹·m⁻², Rec. 709) equally in all directions, on the side of the shading normal; with
/// `two_sided`, for meshes and disks, on both sides.
struct AreaEmitter {
  ColorParameter radiance;
  SourcePosition position;
  bool two_sided = false;
};

/// A light without extent: a point, or a direction. No ray hits it, so only light sampling reaches it. In its own frame
/// it is at the origin and emits toward +Z. docs/conventions.md, "Lights without extent".
struct DeltaLight {
  enum class Type : std::uint32_t {
    point,        ///< equally in all directions
    spot,         ///< into a cone about +Z
    projector,    ///< projects a picture onto the plane z = 1: a camera in reverse
    directional,  ///< from infinitely far away, along +Z
  };
  /// How a spot fades from its beam to the edge of its cone.
  enum class Falloff : std::uint32_t {
    linear,   ///< with the angle
    smooth,   ///< as a cubic of the cosine
    quartic,  ///< as the fourth power of the cosine
  };
  Type type = Type::point;
  /// For points and spots W·sr⁻¹; for a projector the irradiance of the plane z = 1 and for a directional light that of
  /// a surface facing it, W·m⁻². The texture of a spot is projected across its cone, that of a projector across its
  /// film.
  ColorParameter intensity;
  glm::dmat4 world_from_light{1.0};  ///< rotation, reflection, translation; uniform scale is ignored
  double cutoff = 20.0;              ///< spot: half angle of the cone, degrees; below 90 with a texture
  double beam_width = 15.0;          ///< spot: half angle of full intensity, degrees, at most `cutoff`
  Falloff falloff = Falloff::linear;
  glm::dvec2 slope{1.0};  ///< projector: half the width and height of its picture on the plane z = 1
  std::string name;       ///< for messages: its type in the file
  SourcePosition position;

  glm::dvec3 origin() const { return glm::dvec3(world_from_light[3]); }
  /// A unit axis of its frame in the world: 0 across, 1 up, 2 forward.
  glm::dvec3 axis(int i) const { return glm::normalize(glm::dvec3(world_from_light[i])); }
};

/// Indexed triangles in object space. `normals` is empty or as long as `positions` (unit vectors); so is each set of
/// texture coordinates, `vertex_colors`, `vertex_alphas` and `tangents`. `face_colors` is empty or as long as
/// `triangles`. Colours are linear Rec. 709.
struct TriangleMesh {
  VectorList positions;
  VectorList normals;
  std::vector<std::vector<glm::vec2>> uv_sets;
  std::vector<glm::vec3> vertex_colors;
  std::vector<float> vertex_alphas;  ///< if empty, the colours are opaque
  /// Toward increasing u, any length; 0 if there is none. If w < 0, v increases opposite to normal × tangent.
  std::vector<glm::vec4> tangents;
  std::vector<glm::vec3> face_colors;
  std::vector<glm::uvec3> triangles;
};
/// Analytic sphere in object space, radius > 0, normal outward.
struct Sphere {
  glm::dvec3 center{0.0};
  double radius = 1.0;
};
/// The disk x² + y² <= 1 in the plane z = 0 of object space, normal +z. An affine map turns it into an ellipse.
struct Disk {};
/// The side of a cylinder in object space, open at both ends, normal away from the axis. radius > 0, p0 and p1 apart.
struct Cylinder {
  glm::dvec3 p0{0.0};
  glm::dvec3 p1{0.0, 0.0, 1.0};
  double radius = 1.0;
};
/// What can be placed in a scene; shared by instances.
using Shape = std::variant<TriangleMesh, Sphere, Disk, Cylinder>;

/// One occurrence of a shape. Its normals are those of object space, transformed by the inverse transpose of
/// `world_from_object`: a mirror image of a lamp emits the mirror image of its light.
struct Instance {
  std::uint32_t shape = 0;               ///< index into Scene::shapes
  std::uint32_t material = 0;            ///< index into Scene::materials
  std::optional<std::uint32_t> emitter;  ///< index into Scene::emitters
  glm::dmat4 world_from_object{1.0};     ///< affine and invertible; for a sphere or cylinder a similarity
  bool flip_normals = false;             ///< reverses the normals
  std::string name;                      ///< for messages: the mesh's file name or the shape's type
  SourcePosition position;               ///< the tag that places it
};

/// Reconstruction filter; see docs/conventions.md for the exact functions.
struct ReconstructionFilter {
  enum class Type : std::uint32_t { box, tent, gaussian, mitchell, lanczos };
  Type type = Type::box;
  double radius = 2.0;      ///< pixels; gaussian and mitchell
  double stddev = 0.5;      ///< pixels; gaussian
  double b = 1.0 / 3.0;     ///< mitchell
  double c = 1.0 / 3.0;     ///< mitchell
  double stretch = 1.0;     ///< box and tent: width relative to a pixel, or to a tent of radius 1
  std::uint32_t lobes = 3;  ///< lanczos: radius in whole pixels
};

/// The rendered part of a film, and where the camera's axis crosses it; fractions of the whole film's width and height,
/// from its upper left corner.
struct FilmWindow {
  glm::dvec2 origin{0.0};
  glm::dvec2 size{1.0};
  glm::dvec2 principal_offset{0.0};  ///< the axis crosses the film at 1/2 minus this

  bool whole() const {
    return origin == glm::dvec2(0.0) && size == glm::dvec2(1.0) && principal_offset == glm::dvec2(0.0);
  }
};

/// The aperture of a thin lens.
struct Aperture {
  double radius = 0.0;          ///< camera units; for a polygon that of its circumscribed circle
  double focus_distance = 1.0;  ///< distance of the plane in focus along camera +Z, camera units
  std::uint32_t blades = 0;     ///< corners of a regular polygon, 0: a disk
  double rotation = 0.0;        ///< angle of its first corner, degrees from camera +X toward +Y
};

struct Camera {
  enum class Type : std::uint32_t {
    perspective,
    thin_lens,
    orthographic,      ///< the film is 2 camera units wide
    spherical,         ///< all directions: longitude across, polar angle down
    radiance_meter,    ///< every ray starts at the camera's position along +Z
    irradiance_meter,  ///< the film is a square of 2 by 2 camera units, lit from +Z
  };
  /// What `fov` measures: the film's width, its height, its diagonal, its shorter or its longer side.
  enum class FovAxis : std::uint32_t { x, y, diagonal, smaller, larger };
  Type type = Type::perspective;
  std::uint32_t width = 1280;  ///< pixels
  std::uint32_t height = 720;  ///< pixels
  double fov = 30.0;           ///< degrees, in (0, 180); perspective and thin lens
  FovAxis fov_axis = FovAxis::x;
  FilmWindow window;
  Aperture aperture;        ///< thin lens
  double near_clip = 1e-4;  ///< along camera +Z, in camera units
  double far_clip = 1e4;
  glm::dmat4 world_from_camera{1.0};  ///< affine; column-major (GLM)
  /// Keyframes of a moving camera; `world_from_camera` is its current position. Not part of the scene's hash: a picture
  /// shows one moment.
  CameraPath path;
  ReconstructionFilter filter;
  SourcePosition position;  ///< the <camera> tag
};

/// Height of the whole film divided by its width; pixels are square.
inline double film_aspect(const Camera& camera) {
  return (camera.height / camera.window.size.y) / (camera.width / camera.window.size.x);
}

/// Where random numbers come from; docs/conventions.md, "Random numbers" and "Sobol sets".
struct Sampler {
  enum class Type : std::uint32_t { independent, sobol };
  Type type = Type::independent;
  std::uint32_t sample_count = 1;  ///< paths per pixel
  std::uint32_t set_bits = 0;      ///< log2 of the paths of a set; 0 unless the type is sobol

  /// Number of paths of a pixel that depend on each other. Their mean is one sample of the film: samples of a film are
  /// independent, so its standard error is that of its mean.
  std::uint32_t set_size() const { return 1u << set_bits; }
  /// Film samples that hold at least `paths` paths.
  std::uint64_t sets_of(std::uint64_t paths) const { return (paths + set_size() - 1) >> set_bits; }
};

/// A point that emits equally in all directions: `energy` is its power Φ in W per Rec. 709 component. Only the
/// integrator `simple` uses it.
struct SimpleLight {
  glm::dvec3 position{0.0};
  glm::dvec3 energy{0.0};
};

/// What is computed for a camera ray; docs/conventions.md, "Integrators".
struct Integrator {
  enum class Type : std::uint32_t {
    path,
    normals,            ///< (n + 1)/2
    absolute_normals,   ///< |n| of each component
    direct,             ///< light that reaches the first surface from emitters, by several samples of each strategy
    whitted,            ///< the same, seen in mirrors and glass as well
    simple,             ///< a surface lit by a SimpleLight
    ambient_occlusion,  ///< unoccluded share of the cosine-weighted hemisphere up to `length`
    visibility,         ///< the same, with all directions of equal weight
    depth,              ///< 1 divided by the distance
    distance,           ///< distance of the first hit beyond the near clipping plane
    aov,                ///< an AOV
  };
  /// Light selected by how often it was scattered: at most once, or more often.
  enum class LightPart : std::uint32_t { all, direct, indirect };
  /// How a light is chosen: `power` by power alone, `tree` by its possible contribution to the point; `automatic` is
  /// `tree` for many lights.
  enum class LightSampler : std::uint32_t { automatic, power, tree };
  static constexpr std::uint32_t kUnlimitedDepth = 1u << 30;
  Type type = Type::path;
  std::uint32_t max_depth = 16;  ///< path segments, the camera ray is the first
  bool nee = true;
  bool mis = true;             ///< meaningless without nee
  std::uint32_t rr_depth = 5;  ///< Russian roulette from this segment on; 0 = off
  LightSampler light_sampler = LightSampler::automatic;
  std::uint32_t emitter_samples = 1;  ///< direct: light samples per camera ray, 0 … kMaxDirectSamples
  std::uint32_t bsdf_samples = 1;     ///< direct: material samples
  bool hide_emitters = false;         ///< path, direct, whitted, aov: camera rays pass through emitters and see no sky
  bool hide_background = false;       ///< path, direct, whitted: camera rays see no sky
  LightPart light_part = LightPart::all;                    ///< path, direct, whitted
  bool count_passes = true;                                 ///< path: passing a mask or null ends a segment
  double length = std::numeric_limits<double>::infinity();  ///< ambient_occlusion, visibility: scene units
  SimpleLight light;                                        ///< simple
  Aov aov = Aov::hit;                                       ///< aov: neither direct nor indirect
};

/// Whether an integrator gathers light from emitters and the sky: path, direct and whitted do.
bool gathers_light(const Integrator& integrator);
/// Whether it samples lights, and whether it combines them with material samples.
bool samples_lights(const Integrator& integrator);
bool weighs_strategies(const Integrator& integrator);

/// Whether passing a mask or null ends a segment: for path a setting, for whitted always, for direct never.
bool counts_passes(const Integrator& integrator);

/// How meshes with several instances are stored: `automatic` stores them once if that saves enough, `never` copies them
/// into the world, `always` keeps every mesh in object space, for tests. See sharing.h.
enum class Instancing : std::uint32_t { automatic, never, always };

/// Tables that refer to each other by index, and one of everything else. `invariants.h` lists the invariants.
struct Scene {
  std::string name;  ///< file name without folder and extension
  std::string file;  ///< path as given
  Camera camera;
  Sampler sampler;
  Integrator integrator;
  std::vector<Aov> aovs;  ///< to be rendered with the picture
  Sky sky;
  std::vector<Shape> shapes;
  std::vector<Material> materials;
  std::vector<Texture> textures;
  std::vector<std::shared_ptr<const Bitmap>> bitmaps;  ///< shared by copies of the scene, since they may be large
  std::vector<AreaEmitter> emitters;
  std::vector<Instance> instances;  ///< in file order; area lights follow from those with an emitter
  std::vector<DeltaLight> delta_lights;
  Instancing instancing = Instancing::automatic;
  /// Sentences about substitutions made by the reader, for the metadata of pictures.
  std::vector<std::string> approximations;
  SourcePosition position;  ///< the <scene> tag

  const Shape& shape_of(const Instance& instance) const { return shapes[instance.shape]; }
  const Bsdf& bsdf_of(const Instance& instance) const { return materials[instance.material].bsdf; }
  /// Null if the instance does not emit.
  const AreaEmitter* emitter_of(const Instance& instance) const {
    return instance.emitter ? &emitters[*instance.emitter] : nullptr;
  }
  /// Adds an instance of a new shape with its own material and, optionally, emitter; the caller may modify it.
  Instance& add(Shape shape, Bsdf bsdf = DiffuseBsdf{}, std::optional<AreaEmitter> emitter = std::nullopt);
};

/// Triangles of a mesh, 1 for any other shape.
std::size_t primitive_count(const Shape& shape);

/// 64-bit XXH3 of everything that can change the image's expectation or its samples except size, seed, sample
/// count and integrator settings (those are compared one by one when renders are merged).
std::uint64_t scene_hash(const Scene& scene);

/// What LightSampler::automatic means: a tree from this many emitting primitives, points and spots on, where it begins
/// to pay off.
inline constexpr std::size_t kManyLights = 10;
/// Whether lights are chosen by a tree; docs/conventions.md, "Light tree".
bool uses_light_tree(const Scene& scene);
/// Whether they would be if the integrator sampled lights: the scene's `lightSampler`.
bool wants_light_tree(const Scene& scene);

/// The film's unit, see docs/conventions.md, "Film".
int film_exponent(const Scene& scene);

}  // namespace etendue
